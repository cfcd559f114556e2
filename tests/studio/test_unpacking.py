"""Zips that would leave their folder, or burst it."""

from __future__ import annotations

import stat
import zipfile

import pytest

from rumu.studio.errors import Unusable
from rumu.studio.unpacking import ZipLimits, folder_name, unpack


@pytest.fixture
def zipped(tmp_path):
    def make(files, **settings):
        path = tmp_path / "sent.zip"
        with zipfile.ZipFile(path, "w", **settings) as archive:
            for name, data in files.items():
                archive.writestr(name, data)
        return path

    return make


def unpacked(path, tmp_path, **limits):
    folder = tmp_path / "inside" / "folder"
    folder.mkdir(parents=True)
    return unpack(path, folder, limits=ZipLimits(**limits))


def test_files_come_out_as_they_went_in_and_one_folder_around_them_is_seen_through(zipped, tmp_path):
    path = zipped(
        {"字帖/labels.csv": "file\n", "字帖/圖 1.png": b"1", "__MACOSX/字帖/._x": b"", "字帖/.DS_Store": b""}
    )
    folder = unpacked(path, tmp_path)
    assert folder.name == "字帖"
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == {"labels.csv": b"file\n", "圖 1.png": b"1"}


BAD = [
    "../out.txt",
    "a/../../out.txt",
    "/out.txt",
    "..\\out.txt",
    "C:\\out.txt",
    "C:out",
    "a/\x01b",
    "a" * 200,
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


def test_a_damaged_zip(zipped, tmp_path):
    path = zipped({"a.txt": b"hello hello"})
    data = bytearray(path.read_bytes())
    data[data.index(b"hello")] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(Unusable):
        unpacked(path, tmp_path)


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
