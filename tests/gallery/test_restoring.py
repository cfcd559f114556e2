"""Putting an exported folder into a gallery that is not empty, or that is not whole."""

from __future__ import annotations

import json

import pytest

from rumu.errors import GalleryError
from rumu.gallery.annotations import add_annotation, said_of
from rumu.gallery.catalog import change_work, work, works
from rumu.gallery.exporting import export_gallery
from rumu.gallery.importing import import_folder
from rumu.gallery.restoring import holds_starter
from rumu.gallery.starting import put_starter


@pytest.fixture
def exported(gallery, tmp_path):
    change_work(gallery, "seal-ri", {"title_en": "renamed before the export"})
    add_annotation(gallery, "seal-ri", {"x": 0, "y": 0, "text_en": "said before"})
    export_gallery(gallery, tmp_path / "out")
    return tmp_path / "out"


def test_a_work_that_nobody_changed_takes_the_exported_facts(bare, exported):
    put_starter(bare)
    done = import_folder(bare, exported)
    assert (done.added, done.there, done.left_out) == (0, 30, ())
    assert work(bare, "seal-ri").title_en == "renamed before the export"
    assert [one.text_en for one in said_of(bare, "seal-ri")] == ["said before"]


def test_a_work_that_was_changed_here_keeps_its_facts(bare, exported):
    put_starter(bare)
    change_work(bare, "seal-ri", {"title_en": "renamed here"})
    import_folder(bare, exported)
    assert work(bare, "seal-ri").title_en == "renamed here"


def test_another_work_of_the_same_id_is_left_alone_and_told(bare, exported):
    import_folder(bare, exported)
    lines = (exported / "works.jsonl").read_text(encoding="utf-8").splitlines()
    entry = json.loads(lines[0]) | {"digest": "f" * 64, "title_en": "a stranger"}
    (exported / "works.jsonl").write_text("\n".join([json.dumps(entry), *lines[1:]]) + "\n", encoding="utf-8")
    done = import_folder(bare, exported)
    assert (done.added, done.left_out) == (0, ((entry["id"], "another work has this id"),))
    assert work(bare, entry["id"]).title_en != "a stranger"


def test_the_starter_gallery_in_an_export_is_told(exported, labelled):
    assert holds_starter(exported)
    assert not holds_starter(labelled(1))


def broken(folder, how: str) -> None:
    works_file = folder / "works.jsonl"
    first, *rest = works_file.read_text(encoding="utf-8").splitlines()
    entry = json.loads(first)
    picture = folder / "files" / entry["picture"]
    if how == "missing":
        picture.unlink()
    elif how == "other":
        picture.write_bytes(picture.read_bytes() + b"x")
    elif how == "outside":
        entry["files"] = ["pictures/../../../../etc/passwd"]
    elif how == "elsewhere":
        entry["files"] = ["attempts/x"]
    elif how == "no work":
        entry = {"id": entry["id"]}
    elif how == "room":
        entry["collection_id"] = "nowhere"
    works_file.write_text("\n".join([json.dumps(entry), *rest]) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("missing", "expected a file of the export"),
        ("other", "its content is not what its name says"),
        ("outside", "expected a file in pictures"),
        ("elsewhere", "expected a file in pictures"),
        ("no work", "line 1: expected a work"),
        ("room", "expected a collection"),
    ],
)
def test_an_export_that_is_not_whole_is_refused(bare, exported, how, words):
    broken(exported, how)
    with pytest.raises(GalleryError, match=words):
        import_folder(bare, exported)
    assert works(bare).total == 0


def test_another_format_is_refused(bare, exported):
    facts = json.loads((exported / "gallery.json").read_text(encoding="utf-8"))
    (exported / "gallery.json").write_text(json.dumps(facts | {"format": 99}), encoding="utf-8")
    with pytest.raises(GalleryError, match="expected a gallery of format 1"):
        import_folder(bare, exported)
