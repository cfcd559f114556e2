"""Zips that would leave their folder, or burst it, and zips as people make them."""

from __future__ import annotations

import contextlib
import itertools
import shutil
import stat
import struct
import unicodedata
import zipfile
import zlib

import pytest

from rumu.errors import DiskFull
from rumu.studio.errors import Unusable
from rumu.studio.unpacking import ZipLimits, check_zip, folder_name, unpack


@pytest.fixture
def zipped(tmp_path):
    def make(files, **settings):
        path = tmp_path / "sent.zip"
        with zipfile.ZipFile(path, "w", **settings) as archive:
            for name, data in files.items():
                archive.writestr(name, data)
        return path

    return make


_runs = itertools.count()


def unpacked(path, tmp_path, **limits):
    return unpack(path, tmp_path / "inside" / f"folder{next(_runs)}", limits=ZipLimits(**limits)).folder


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_files_come_out_as_they_went_in_without_what_systems_add(zipped, tmp_path):
    added = (
        "__MACOSX/字帖/._x",
        "字帖/.DS_Store",
        "字帖/Thumbs.db",
        "字帖/._圖 1.png",
        "desktop.ini",
        "Icon\r",
    )
    files = {"字帖/labels.csv": b"file\n", "字帖/圖 1.png": b"1", "字帖/空/": b""}
    path = zipped(files | dict.fromkeys(added, b""))
    assert contents(unpacked(path, tmp_path)) == {"字帖/labels.csv": b"file\n", "字帖/圖 1.png": b"1"}


BAD = [
    "../out.txt",
    "a/../../out.txt",
    "/out.txt",
    "..\\out.txt",
    "C:\\out.txt",
    "C:out",
    "a/\x01b",
    "//server/share/out.txt",
    "\\\\server\\share\\out.txt",
    "\\out.txt",
    "~/out.txt",
    "file:///out.txt",
    "a/..\\../out.txt",
    ".. /out.txt",
]


@pytest.mark.parametrize("name", BAD)
def test_no_name_leads_out(zipped, tmp_path, name):
    path = zipped({"fine.txt": b"1", name: b"2"})
    with pytest.raises(Unusable) as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "zip_names"
    assert not any(
        p.is_file() for p in (tmp_path / "inside").rglob("*")
    )  # nothing was written, not even the fine
    assert not list(tmp_path.glob("out*"))


def test_no_links(zipped, tmp_path):
    link = zipfile.ZipInfo("link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with pytest.raises(Unusable):
        unpacked(zipped({link: "/etc/passwd"}), tmp_path)


def test_a_bomb_is_stopped_while_it_bursts(zipped, tmp_path):
    path = zipped({"a.bin": b"\0" * 40_000_000}, compression=zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 100_000
    with pytest.raises(Unusable) as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "zip_bomb"
    assert sum(p.stat().st_size for p in tmp_path.rglob("*.bin")) <= 17 * 2**20


def test_a_size_that_lies_does_not_help(zipped, tmp_path):
    """The directory says 10 bytes; the data says 40 million."""
    path = zipped({"a.bin": b"\0" * 40_000_000}, compression=zipfile.ZIP_DEFLATED)
    data = path.read_bytes().replace((40_000_000).to_bytes(4, "little"), (10).to_bytes(4, "little"))
    path.write_bytes(data)
    with pytest.raises(Unusable):
        unpacked(path, tmp_path)


def test_many_files_and_large_ones(zipped, tmp_path):
    with pytest.raises(Unusable, match="at most 3"):
        unpacked(zipped({str(k): b"" for k in range(4)}), tmp_path, files=3)
    with pytest.raises(Unusable):
        unpack(zipped({"a": b"12345"}), tmp_path / "inside", limits=ZipLimits(file_bytes=4))


@pytest.mark.parametrize("data", [b"", b"PK", b"PK\x03\x04" + b"x" * 100, b"no zip at all"])
def test_what_is_no_zip(tmp_path, data):
    path = tmp_path / "sent.zip"
    path.write_bytes(data)
    with pytest.raises(Unusable) as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "no_zip"


def test_a_damaged_file_is_named(zipped, tmp_path):
    for settings in ({}, {"compression": zipfile.ZIP_DEFLATED}, {"compression": zipfile.ZIP_LZMA}):
        path = zipped({"一.txt": bytes(k * k % 251 for k in range(400))}, **settings)
        data = bytearray(path.read_bytes())
        for at in range(60, 75):
            data[at] ^= 0xFF
        path.write_bytes(data)
        with pytest.raises(Unusable) as refused:
            unpacked(path, tmp_path)
        assert refused.value.code == "zip_damaged" and "一.txt" in refused.value.zh
        assert "一.txt" in refused.value.en and str(tmp_path) not in refused.value.en + refused.value.zh


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.999])
def test_a_zip_that_ends_too_soon_is_told_so(zipped, tmp_path, share):
    path = zipped({f"{k}.txt": b"hello" * 1000 for k in range(20)})
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(Unusable, match="the end of this one is missing") as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "no_zip"


def test_a_zip_with_a_password_is_told_so(zipped, tmp_path):
    path = zipped({"a.txt": b"secret"})
    data = bytearray(path.read_bytes())
    data[6] |= 1  # flags of the local and of the central header
    data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(data)
    with pytest.raises(Unusable) as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "zip_password"


def test_an_unusual_compression_is_named(zipped, tmp_path):
    path = zipped({"a.txt": b"1"})
    data = bytearray(path.read_bytes())
    data[8] = data[data.index(b"PK\x01\x02") + 10] = 9
    path.write_bytes(data)
    with pytest.raises(Unusable, match="deflate64") as refused:
        unpacked(path, tmp_path)
    assert refused.value.code == "zip_method"


def test_a_list_of_entries_too_long_to_be_read_is_refused_before_it_is(zipped, tmp_path, monkeypatch):
    path = zipped({f"{k:05}" * 10: b"" for k in range(300)})
    monkeypatch.setattr(zipfile, "ZipFile", None)
    with pytest.raises(Unusable) as refused:
        unpacked(path, tmp_path, directory_bytes=20_000)
    assert refused.value.code == "zip_bomb"


def test_zip64_is_read(tmp_path):
    path = tmp_path / "sent.zip"
    with zipfile.ZipFile(path, "w") as archive, archive.open("a.txt", "w", force_zip64=True) as entry:
        entry.write(b"1")
    data = path.read_bytes()
    end = data.index(b"PK\x05\x06")
    count, size, at = struct.unpack_from("<HII", data, end + 10)
    far = struct.pack("<4sQHHIIQQQQ", b"PK\x06\x06", 44, 45, 45, 0, 0, count, count, size, at)
    locator = struct.pack("<4sIQI", b"PK\x06\x07", 0, end, 1)
    last = struct.pack("<4sHHHHIIH", b"PK\x05\x06", 0, 0, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    path.write_bytes(data[:end] + far + locator + last)
    assert contents(unpacked(path, tmp_path)) == {"a.txt": b"1"}
    with pytest.raises(Unusable):
        unpacked(path, tmp_path, directory_bytes=10)


@pytest.mark.parametrize(
    ("head", "kind"),
    [(b"Rar!\x1a\x07", "RAR"), (b"7z\xbc\xaf\x27\x1c", "7z"), (b"\0" * 257 + b"ustar", "tar")],
)
def test_another_archive_is_called_by_its_name(head, kind):
    with pytest.raises(Unusable, match=kind):
        check_zip(head)


# --- names as people's programs write them ---------------------------------------------------------


def raw_named(path, files):
    """A zip whose names are these bytes, without a word on how they are encoded."""
    with zipfile.ZipFile(path, "w") as archive:
        for number, data in enumerate(files.values()):
            archive.writestr(f"{number:02}".ljust(len(list(files)[number]), "x"), data)
    data = path.read_bytes()
    for number, name in enumerate(files):
        data = data.replace(f"{number:02}".ljust(len(name), "x").encode(), name)
    path.write_bytes(data)
    return path


GBK = ("gb18030", ["永一.png", "书二.png", "王羲之 兰亭序/之.png"])
BIG5 = ("cp950", ["蘭亭序/永.png", "書法 功課.png"])
SHIFT_JIS = ("cp932", ["書道/一年生の作品.png", "表.png"])


@pytest.mark.parametrize(
    ("encoding", "names", "known_as"),
    [(*GBK, "GBK"), (*BIG5, "Big5"), (*SHIFT_JIS, "Shift-JIS"), ("gb18030", ["水.png"], "GBK")],
)
def test_names_of_old_programs_are_read_and_what_was_assumed_is_said(tmp_path, encoding, names, known_as):
    path = raw_named(tmp_path / "sent.zip", {name.encode(encoding): b"1" for name in names})
    done = unpack(path, tmp_path / "inside")
    assert set(contents(done.folder)) == set(names)
    assert known_as in done.assumed.en and known_as in done.assumed.zh


@pytest.mark.parametrize("text", ["永一.png", "é.png", "e\u0301.png"])
def test_names_in_utf8_without_the_flag_are_read(tmp_path, text):
    path = raw_named(tmp_path / "sent.zip", {text.encode(): b"1"})
    done = unpack(path, tmp_path / "inside")
    assert (set(contents(done.folder)), done.assumed) == ({unicodedata.normalize("NFC", text)}, None)


def test_a_table_that_names_the_files_decides_how_they_are_read(tmp_path):
    """These bytes are common characters in Big5 and in GBK; the table has the ones of the other reading."""
    name = "一乙.png"
    raw = name.encode("cp950")
    alone = unpack(raw_named(tmp_path / "a.zip", {raw: b"1"}), tmp_path / "alone")
    for encoding in ("cp950", "gb18030"):
        table = f"file,character\n{raw.decode(encoding)},水\n".encode()
        path = raw_named(tmp_path / "b.zip", {raw: b"1", b"labels.csv": table})
        folder = unpack(path, tmp_path / encoding).folder
        assert set(contents(folder)) == {raw.decode(encoding), "labels.csv"}
    assert alone.assumed is not None


def test_a_second_name_in_unicode_wins(tmp_path):
    raw = "永.png".encode("cp950")
    entry = zipfile.ZipInfo("x" * len(raw))
    entry.extra = struct.pack("<HHBI", 0x7075, 5 + len("別名.png".encode()), 1, zlib.crc32(raw))
    entry.extra += "別名.png".encode()
    path = tmp_path / "sent.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(entry, b"1")
    path.write_bytes(path.read_bytes().replace(b"x" * len(raw), raw))
    done = unpack(path, tmp_path / "inside")
    assert (set(contents(done.folder)), done.assumed) == ({"別名.png"}, None)


def test_a_hostile_name_in_another_encoding_is_refused_like_any_other(tmp_path):
    for name in ("../書.png".encode("cp950"), b"a.png\0../b.png"):
        path = raw_named(tmp_path / "sent.zip", {name: b"1"})
        with pytest.raises(Unusable) as refused:
            unpacked(path, tmp_path)
        assert refused.value.code == "zip_names"


def test_backslashes_part_folders(zipped, tmp_path):
    path = zipped({"字帖\\labels.csv": b"1", "字帖\\圖\\": b"", "字帖\\圖\\一.png": b"2"})
    assert contents(unpacked(path, tmp_path)) == {"字帖/labels.csv": b"1", "字帖/圖/一.png": b"2"}


def test_characters_that_windows_forbids_are_replaced(zipped, tmp_path):
    path = zipped({"水:一?.png": b"1", "aux.txt": b"2", "a|b/c*.png": b"3", "長" * 100 + ".png": b"4"})
    names = set(contents(unpacked(path, tmp_path)))
    assert {"水_一_.png", "_aux.txt", "a_b/c_.png"} < names and len(names) == 4


def test_the_same_file_twice_is_one_and_two_files_of_one_name_are_refused(tmp_path):
    path = tmp_path / "sent.zip"
    for second, name in ((b"1", "a.png"), (b"2", "a.png"), (b"2", "A\u0301.png"), (b"2", "a:.png")):
        first = {"A\u0301.png": "\u00c1.png", "a:.png": "a_.png"}.get(name, name)
        doubled = pytest.warns() if first == name else contextlib.nullcontext()
        with doubled, zipfile.ZipFile(path, "w") as archive:
            archive.writestr(first, b"1")
            archive.writestr(name, second)
        if second == b"1":
            assert contents(unpacked(path, tmp_path)) == {"a.png": b"1"}
            continue
        with pytest.raises(Unusable, match="two different files") as refused:
            unpacked(path, tmp_path)
        assert refused.value.code == "zip_names"


def test_a_name_of_a_file_and_of_a_folder_is_refused(zipped, tmp_path):
    with pytest.raises(Unusable) as refused:
        unpacked(zipped({"a": b"1", "a/b": b"2"}), tmp_path)
    assert refused.value.code == "zip_names"


def test_the_zips_that_went_wrong(cases, tmp_path):
    done = unpack(cases / "zips" / "gbk-names.zip", tmp_path / "gbk")
    assert set(contents(done.folder)) == {"字帖/labels.csv", "字帖/永一.png", "字帖/书二.png"}
    assert done.assumed.en.endswith("read as GBK.")
    assert set(contents(unpack(cases / "zips" / "nfd.zip", tmp_path / "nfd").folder)) == {
        "labels.csv",
        "é水1.png",
    }


@pytest.mark.parametrize(
    ("sent", "folder"),
    [
        ("課堂 一.zip", "課堂 一"),
        ("C:\\of\\me.zip", "me"),
        ("../../etc.zip", "etc"),
        ("..", "collection"),
        ("\0.zip", "collection"),
    ],
)
def test_the_name_of_a_zip_is_fit_for_a_folder(sent, folder):
    assert folder_name(sent) == folder


def test_a_zip_for_which_there_is_no_room_is_not_begun(zipped, tmp_path, monkeypatch):
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage._replace(free=3))
    with pytest.raises(DiskFull):
        unpacked(zipped({"a.txt": b"hello"}), tmp_path)
    assert not [path for path in (tmp_path / "inside").rglob("*") if path.is_file()]
