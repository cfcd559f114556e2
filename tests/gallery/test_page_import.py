"""Pages with texts in a folder, and pages in an export."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest
from tests.gallery.pages import COLUMNS, ROWS, draw_page, page_text

from rumu.database.engine import open_database
from rumu.errors import GalleryError
from rumu.gallery import catalog
from rumu.gallery.archive import export_gallery
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.store import Gallery, Store
from rumu.gallery.whole_works import characters_within

COUNT = COLUMNS * ROWS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two pages with texts, one in GB 18030, and a picture without."""
    made = tmp_path_factory.mktemp("album")
    draw_page().save(made / "leaf-1.png")
    (made / "leaf-1.txt").write_text(page_text(), encoding="utf-8")
    draw_page(paper=(222, 218, 210)).save(made / "leaf-2.jpg", quality=95)
    (made / "leaf-2.txt").write_bytes(page_text().encode("gb18030"))
    draw_page(paper=(200, 200, 200)).save(made / "cover.png")
    return made


def test_pictures_with_a_text_beside_them_are_pages(bare, folder):
    steps = []
    shared = SharedMetadata({"script": "regular", "id": "album"})
    done = import_folder(bare, folder, shared=shared, progress=lambda n, of: steps.append((n, of)))
    assert (done.collections, done.added, done.existing, done.left_out) == (("album",), 2, 0, ())
    assert steps == [(1, 2), (2, 2)]
    pages = catalog.works(bare).items
    assert [page.title_zh for page in pages] == ["leaf-1", "leaf-2"]
    assert [len(characters_within(bare, page.id)) for page in pages] == [COUNT, COUNT]
    again = import_folder(bare, folder, shared=shared)
    assert (again.added, again.existing) == (0, 2)


def test_rows_of_labels_may_be_pages(bare, folder, tmp_path):
    target = tmp_path / "set"
    shutil.copytree(folder, target)
    (target / "leaf-1.txt").rename(target / "words.txt")
    with (target / "labels.csv").open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["檔案", "字", "釋文", "work"])
        table.writerows(
            [["leaf-1.png", "", "words.txt", "第一葉"], ["leaf-2.jpg", "", page_text(), "第二葉"]]
        )
        table.writerows([["cover.png", "永", "", "單字"], ["lost.png", "", "水", "沒有"]])
    done = import_folder(bare, target)
    assert (done.added, [name for name, _ in done.left_out]) == (3, ["lost.png"])
    found = {work.title_zh: len(characters_within(bare, work.id)) for work in catalog.works(bare).items}
    assert found == {"第一葉": COUNT, "第二葉": COUNT, "單字「永」": 0}


def test_a_text_outside_the_folder_is_not_read(bare, folder, tmp_path):
    (tmp_path / "secret.txt").write_text(page_text(), encoding="utf-8")
    target = tmp_path / "set"
    target.mkdir()
    shutil.copy(folder / "leaf-1.png", target)
    (target / "labels.csv").write_text("file,text\nleaf-1.png,../secret.txt\n", encoding="utf-8")
    with pytest.raises(GalleryError, match="expected the text of leaf-1"):
        import_folder(bare, target)
    assert catalog.works(bare).total == 0


@pytest.fixture(scope="module")
def album(folder, tmp_path_factory):
    """(A gallery with both pages, the folder that it was exported to); tests change neither."""
    home = tmp_path_factory.mktemp("album-gallery")
    opened = open_database(home / "rumu.sqlite")
    made = Gallery(opened, Store.open(home / "files"))
    import_folder(made, folder, shared=SharedMetadata({"script": "regular", "id": "album"}))
    export_gallery(made, home / "out")
    yield made, home / "out"
    opened.close()


@pytest.fixture
def exported(album, tmp_path):
    return Path(shutil.copytree(album[1], tmp_path / "out"))


@pytest.mark.parametrize("only_add", [False, True])
def test_an_export_brings_pages_with_their_characters(gallery, album, exported, everything, only_add):
    done = import_folder(gallery, exported, only_add=only_add)
    assert (done.added, done.left_out) == (2 * (COUNT + 1), ())
    again = import_folder(gallery, exported, only_add=only_add)
    assert (again.added, again.existing) == (0, 2 * (COUNT + 1))
    keys = ("id", "parent_id", "occurrence", "place", "position", "character", "text", "picture")
    there = {row["id"]: row for row in everything(gallery)["works"]}
    for row in everything(album[0])["works"]:
        same = [key for key in keys if there[row["id"]][key] != row[key]]
        assert same == (
            [] if not only_add or row["parent_id"] else [key for key in same if key == "position"]
        )


def test_a_character_whose_page_is_missing_is_refused(gallery, exported):
    lines = (exported / "works.jsonl").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if json.loads(line)["title_zh"] != "leaf-1"]
    (exported / "works.jsonl").write_text("\n".join(kept) + "\n", encoding="utf-8")
    facts = json.loads((exported / "gallery.json").read_text(encoding="utf-8")) | {"works": len(kept)}
    (exported / "gallery.json").write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(GalleryError, match="that it stands on"):
        import_folder(gallery, exported)


@pytest.mark.parametrize(
    "change", [{"place": None}, {"parent_id": None}, {"place": {"polygon": [[0, 0]]}}, {"occurrence": -1}]
)
def test_a_place_that_is_none_is_refused(gallery, exported, change):
    rows = [json.loads(line) for line in (exported / "works.jsonl").read_text(encoding="utf-8").splitlines()]
    child = next(row for row in rows if row["parent_id"])
    child |= change
    lines = "".join(json.dumps(row) + "\n" for row in rows)
    (exported / "works.jsonl").write_text(lines, encoding="utf-8")
    with pytest.raises(GalleryError):
        import_folder(gallery, exported)


def test_characters_of_a_page_that_another_work_is_are_left_out(gallery, exported):
    """The id of the page is taken here by another work, so that its characters have no page."""
    rows = [json.loads(line) for line in (exported / "works.jsonl").read_text(encoding="utf-8").splitlines()]
    page = next(row for row in rows if row["parent_id"] is None)
    taken = {"id": page["id"], "title_zh": "別的", "title_en": "other", "picture": "p", "digest": "d"}
    from rumu.database.tables import Work

    with gallery.database.writing() as session:
        session.add(Work(**taken, collection_id="starter", width=1, height=1))
    done = import_folder(gallery, exported)
    assert done.added == COUNT + 1
    assert (
        len(done.left_out) == COUNT + 1 and dict(done.left_out)[page["id"]].en == "another work has this id"
    )
