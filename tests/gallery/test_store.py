"""Files by key: whole or not at all, in a folder or wherever fsspec reaches."""

from __future__ import annotations

import io
import threading
import uuid

import pytest

from rumu.errors import GalleryError
from rumu.gallery.store import Store


@pytest.fixture(params=["folder", "file", "memory"])
def store(request, tmp_path) -> Store:
    places = {
        "folder": tmp_path / "a folder",
        "file": (tmp_path / "by url").as_uri(),
        "memory": f"memory://{uuid.uuid4().hex}",
    }
    return Store.open(places[request.param])


def test_what_is_written_is_read(store):
    store.write("pictures/ab/one.png", b"1")
    store.write("pictures/ab/one.png", b"2")
    assert store.read("pictures/ab/one.png") == b"2"
    assert store.exists("pictures/ab/one.png") and store.exists("pictures/ab")
    assert not store.exists("pictures/cd")
    assert list(store.keys("pictures")) == ["pictures/ab/one.png"]


def test_a_stream_is_written_as_its_bytes_would_be(store):
    sent = bytes(range(256)) * 9000  # more than one piece
    store.write("uploads/one.zip", io.BytesIO(sent))
    assert store.read("uploads/one.zip") == sent


def test_a_stream_that_breaks_leaves_what_was_there(tmp_path):
    class Broken(io.BytesIO):
        def read(self, size=-1):
            raise OSError("the line is cut")

    store = Store.open(tmp_path)
    store.write("uploads/one.zip", b"old")
    with pytest.raises(GalleryError, match="cannot be written"):
        store.write("uploads/one.zip", Broken())
    assert store.read("uploads/one.zip") == b"old"
    assert list(store.keys("uploads")) == ["uploads/one.zip"]


def test_a_file_that_is_not_there(store):
    with pytest.raises(GalleryError, match=r"pictures/none\.png: expected a file"):
        store.read("pictures/none.png")
    store.delete("pictures/none.png")
    assert list(store.keys("pictures")) == []


def test_a_folder_goes_with_all_that_is_in_it(store):
    for key in ("a/b/1", "a/b/2", "a/c"):
        store.write(key, b"x")
    store.delete("a/b")
    assert list(store.keys("a")) == ["a/c"]
    store.delete("a/c")
    assert list(store.keys("a")) == []


def test_a_folder_can_be_read_as_one_of_this_machine(store):
    store.write("surfaces/s/mask.png", b"m")
    store.write("surfaces/s/deep/er.txt", b"e")
    with store.local("surfaces/s") as folder:
        assert (folder / "mask.png").read_bytes() == b"m"
        assert (folder / "deep" / "er.txt").read_bytes() == b"e"
    with store.local("surfaces/s/mask.png") as file:
        assert file.read_bytes() == b"m"
    assert (store.path("surfaces/s") is None) == (store.folder is None)


@pytest.mark.parametrize(
    "key", ["", "/etc/passwd", "../up", "a/../b", "a//b", "a/./b", ".hidden", "a b", "永", "a\\b", "a/"]
)
def test_only_keys_of_the_program_are_taken(store, key):
    for act in (store.read, store.exists, store.delete, lambda k: store.write(k, b"")):
        with pytest.raises(GalleryError, match="expected a key"):
            act(key)


def test_old_files_are_told_from_new_ones(store):
    store.write("a/b", b"x")
    assert list(store.keys("a", older_than=60)) == []
    assert list(store.keys("a", older_than=-1)) == ["a/b"]


def test_a_reader_never_sees_half_a_file(tmp_path):
    store, seen = Store.open(tmp_path), set()
    stop = threading.Event()
    store.write("a/b", b"0" * 500_000)

    def read() -> None:
        while not stop.is_set():
            data = store.read("a/b")
            seen.add((len(data), data[:1] * len(data) == data))

    reader = threading.Thread(target=read)
    reader.start()
    for number in range(60):
        store.write("a/b", str(number % 10).encode() * 500_000)
    stop.set()
    reader.join()
    assert seen == {(500_000, True)}
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["b"]


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(GalleryError, match="cannot be written"):
        Store.open(tmp_path / "file").write("a/b", b"x")


def test_a_url_that_nothing_reaches():
    with pytest.raises(GalleryError, match="expected a folder or a URL"):
        Store.open("nonsense://somewhere")


def test_errors_name_the_key_and_not_where_it_lies(tmp_path):
    (tmp_path / "files").write_text("in the way")
    store = Store.open(tmp_path / "files")
    for act in (lambda: store.write("pictures/a.png", b"1"), lambda: store.read("pictures/a.png")):
        with pytest.raises(GalleryError, match=r"pictures/a\.png") as refused:
            act()
        assert str(tmp_path) not in str(refused.value) + str(refused.value.zh)
