"""No name leads out of its folder, and names that people write are found in it."""

from __future__ import annotations

import unicodedata

import pytest

from rumu.containment import FolderFiles, leads_out, safe_name

OUTSIDE = [
    "",
    ".",
    "..",
    "../secret.png",
    "a/../../secret.png",
    "..\\secret.png",
    "a\\..\\..\\secret.png",
    ".. /secret.png",
    ".../secret.png",
    "/etc/passwd",
    "//server/share/x",
    "\\\\server\\share\\x",
    "\\windows\\x",
    "\\\\?\\C:\\x",
    "C:\\x",
    "c:/x",
    "C:x",
    "~/x",
    "~root/x",
    "~",
    "file:///etc/passwd",
    "FILE:/etc/passwd",
    "http://host/x.png",
    "a\0b",
    "a\nb",
    "\ud800",
    "/".join("a" * 50),
]


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_name_that_leads_out_finds_nothing(tmp_path, name):
    (tmp_path / "secret.png").write_bytes(b"1")
    folder = tmp_path / "folder"
    (folder / "a").mkdir(parents=True)
    assert leads_out(name)
    assert FolderFiles(folder).find(name) is None


def test_a_path_of_this_machine_finds_nothing(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a.png").write_bytes(b"1")
    assert FolderFiles(tmp_path / "folder").find(str(tmp_path / "folder" / "a.png")) is None


def test_neither_a_link_nor_a_folder_is_found(tmp_path):
    (tmp_path / "secret.png").write_bytes(b"1")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "b.png").write_bytes(b"1")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    (folder / "linked").symlink_to(tmp_path / "elsewhere")
    (folder / "a.png").write_bytes(b"1")
    (folder / "within.png").symlink_to(folder / "a.png")
    files = FolderFiles(folder)
    assert files.find("link.png") is None and files.find("linked/b.png") is None
    assert files.find("linked") is None and files.find("a.png/b") is None
    assert files.find("within.png") is not None


NAMES = [
    ("永 一.png", "永 一.png"),
    (unicodedata.normalize("NFD", "é水.png"), "é水.png"),
    ("é水.png", unicodedata.normalize("NFD", "é水.png")),
    ("sub\\a.png", "sub/a.png"),
    ("./sub//a.png", "sub/a.png"),
    ("水:一?.png", "水_一_.png"),
    ("水_一.png", "水:一.png"),
    ("NUL", "_NUL"),
    ("con.png", "_con.png"),
    ("A.PNG", "a.png"),
    ("end.", "end"),
    ("~$ notes.png", "~$ notes.png"),
    ("永" * 120 + ".png", safe_name("永" * 120 + ".png")),
]


@pytest.mark.parametrize(("asked", "there"), NAMES)
def test_a_name_is_found_however_it_is_written(tmp_path, asked, there):
    path = tmp_path / there
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(b"1")
    assert not leads_out(asked)
    assert FolderFiles(tmp_path).find(asked).samefile(path)


def test_of_two_files_that_differ_in_case_the_one_that_was_named_is_found(tmp_path):
    for name in ("A.png", "a.png"):
        (tmp_path / name).write_text(name)
    files = FolderFiles(tmp_path)
    if files.find("A.png").read_text() != "A.png":
        pytest.skip("names differ in more than case on this file system")
    assert files.find("a.png").read_text() == "a.png"
    assert files.find("A.PNG") is None


def test_a_name_beside_a_folder_within_may_go_up_to_the_top_and_no_further(tmp_path):
    (tmp_path / "secret.png").write_bytes(b"1")
    top = tmp_path / "top"
    (top / "lamps").mkdir(parents=True)
    (top / "a.png").write_bytes(b"1")
    files = FolderFiles(top)
    assert files.find("../a.png", beside=top / "lamps").samefile(top / "a.png")
    assert files.find("..\\a.png", beside=top / "lamps").samefile(top / "a.png")
    assert files.find("../../secret.png", beside=top / "lamps") is None
    assert files.find("../../top/a.png", beside=top / "lamps") is None
    assert files.find("secret.png", beside=tmp_path) is None


def test_a_safe_name_is_one_that_every_system_takes_and_stays_as_it_is():
    for name in (*(name for pair in NAMES for name in pair), *OUTSIDE, "a<b>|c*.png", "LPT1.txt", "com¹"):
        safe = safe_name(name)
        assert safe_name(safe) == safe
        for part in filter(None, safe.split("/")):
            assert len(part.encode()) <= 255 and not set(part) & set('<>:"|?*\\')
            assert part[-1] not in " ."
    assert safe_name("a" * 300 + ".png") != safe_name("a" * 301 + ".png")
    assert safe_name("a" * 300 + ".png").endswith(".png")
