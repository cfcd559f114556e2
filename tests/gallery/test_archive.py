"""What is exported can be put in again and is the same gallery."""

from __future__ import annotations

import csv
import json

import pytest

from rumu.errors import GalleryError, OutputError
from rumu.gallery.annotations import add_annotation, annotations_of
from rumu.gallery.archive import export_gallery
from rumu.gallery.archive_import import holds_starter
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import change_work, delete_work, work, works
from rumu.gallery.seed import add_starter_works
from rumu.gallery.tours import add_tour


def test_a_gallery_comes_back_the_same(gallery, bare, labelled, tmp_path, everything):
    import_folder(gallery, labelled(8))
    change_work(gallery, "regular-shui", {"title_zh": "改過的題目", "spacing": 0.2})
    add_annotation(
        gallery, "seal-ri", {"x": 0.25, "y": 0.75, "title_zh": "日", "text_en": "a 'quoted' \n line"}
    )
    add_tour(gallery, {"title_zh": "一遊", "steps": [{"work": "seal-ri", "view": "tilt=90"}]})
    delete_work(gallery, "cursive-yue")
    told = []
    out = tmp_path / "out"
    assert export_gallery(gallery, out, progress=lambda *at: told.append(at)) == 46
    assert told[-1] == (46, 46)
    done = import_folder(bare, out)
    assert (done.added, done.existing, done.left_out) == (46, 0, ())
    assert everything(bare) == everything(gallery)
    for row in everything(gallery)["works"]:
        assert bare.store.read(row["picture"]) == gallery.store.read(row["picture"])
    assert works(bare, query="改過的題目").total == 1
    assert import_folder(bare, out).added == 0
    assert everything(bare) == everything(gallery)


def test_what_was_exported_again_is_byte_for_byte_the_same(gallery, bare, tmp_path):
    export_gallery(gallery, tmp_path / "one")
    import_folder(bare, tmp_path / "one")
    export_gallery(bare, tmp_path / "two")
    for file in ("gallery.json", "works.jsonl", "labels.csv"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


def test_one_collection_can_go_alone(gallery, bare, labelled, tmp_path):
    import_folder(gallery, labelled(3))
    assert export_gallery(gallery, tmp_path / "out", collections=["set"]) == 3
    facts = json.loads((tmp_path / "out" / "gallery.json").read_text(encoding="utf-8"))
    assert [room["id"] for room in facts["collections"]] == ["set"] and facts["tours"] == []
    import_folder(bare, tmp_path / "out")
    assert works(bare).total == 3
    with pytest.raises(GalleryError, match="no collection 'none'"):
        export_gallery(gallery, tmp_path / "other", collections=["none"])


def test_the_labels_are_for_other_programs(gallery, tmp_path):
    from rumu.gallery.masters import read_masters

    export_gallery(gallery, tmp_path / "out")
    masters = read_masters(tmp_path / "out")
    assert len(masters) == 39 and all(master.path.is_file() for master in masters)
    with (tmp_path / "out" / "labels.csv").open(encoding="utf-8", newline="") as stream:
        assert {row["licence"] for row in csv.DictReader(stream)} == {w.licence for w in works(gallery).items}


def test_a_strangers_folder_is_not_touched(gallery, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds other things"):
        export_gallery(gallery, tmp_path / "out")
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["mine.txt"]


def test_a_file_that_is_gone_stops_the_export_and_leaves_nothing(gallery, tmp_path):
    gallery.store.delete(works(gallery, query="seal 水").items[0].picture)
    with pytest.raises(GalleryError, match="cannot be read"):
        export_gallery(gallery, tmp_path / "out")
    assert list(tmp_path.glob("*out*")) == []


@pytest.fixture
def exported(gallery, tmp_path):
    change_work(gallery, "seal-ri", {"title_en": "renamed before the export"})
    add_annotation(gallery, "seal-ri", {"x": 0, "y": 0, "text_en": "said before"})
    export_gallery(gallery, tmp_path / "out")
    return tmp_path / "out"


def test_a_work_that_nobody_changed_takes_the_exported_facts(bare, exported):
    add_starter_works(bare)
    done = import_folder(bare, exported)
    assert (done.added, done.existing, done.left_out) == (0, 39, ())
    assert work(bare, "seal-ri").title_en == "renamed before the export"
    assert [one.text_en for one in annotations_of(bare, "seal-ri")] == ["said before"]


def test_a_work_that_was_changed_here_keeps_its_facts(bare, exported):
    add_starter_works(bare)
    change_work(bare, "seal-ri", {"title_en": "renamed here"})
    import_folder(bare, exported)
    assert work(bare, "seal-ri").title_en == "renamed here"


def test_another_work_of_the_same_id_is_left_alone_and_told(bare, exported):
    import_folder(bare, exported)
    lines = (exported / "works.jsonl").read_text(encoding="utf-8").splitlines()
    entry = json.loads(lines[0]) | {"digest": "f" * 64, "title_en": "a stranger"}
    (exported / "works.jsonl").write_text("\n".join([json.dumps(entry), *lines[1:]]) + "\n", encoding="utf-8")
    done = import_folder(bare, exported)
    assert (done.added, done.left_out) == (
        0,
        ((entry["id"], ("別的作品已用這個編號。", "another work has this id")),),
    )
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
        ("outside", "line 1: expected the files of this work"),
        ("elsewhere", "line 1: expected the files of this work"),
        ("no work", "line 1: collection_id"),
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
    with pytest.raises(GalleryError, match="expected a gallery of format 2"):
        import_folder(bare, exported)
