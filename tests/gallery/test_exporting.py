"""What is exported can be put in again and is the same gallery."""

from __future__ import annotations

import csv
import json

import pytest

from rumu.errors import GalleryError, OutputError
from rumu.gallery.annotations import add_annotation
from rumu.gallery.catalog import change_work, delete_work, works
from rumu.gallery.exporting import export_gallery
from rumu.gallery.importing import import_folder
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
    assert export_gallery(gallery, out, progress=lambda *at: told.append(at)) == 37
    assert told[-1] == (37, 37)
    done = import_folder(bare, out)
    assert (done.added, done.there, done.left_out) == (37, 0, ())
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
    assert len(masters) == 30 and all(master.path.is_file() for master in masters)
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
