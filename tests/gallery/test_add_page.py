"""A page with its text becomes a whole work and the characters within it, all of them or nothing."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from sqlalchemy import func, select
from tests.gallery.pages import CHARACTERS, COLUMNS, ROWS, draw_page, page_text

from rumu.database.tables import Attempt, Work
from rumu.errors import GalleryError, RefusedImage
from rumu.gallery import catalog
from rumu.gallery.add_page import add_page
from rumu.gallery.add_work import add_picture, named_collection
from rumu.gallery.assets import assets_of
from rumu.gallery.derived import stored_file
from rumu.gallery.filters import Filters, count_facets
from rumu.gallery.hands import hands_of
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.whole_works import characters_within, text_lines
from rumu.values import Bilingual

METADATA = WorkMetadata(
    title=Bilingual("習字卷", "Practice scroll"),
    script="regular",
    hand=Bilingual("書者", "A Writer"),
    dynasty="Tang",
    licence="CC0-1.0",
)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "leaf.png"
    draw_page().save(path)
    return path


@pytest.fixture
def scroll(bare, page):
    return add_page(bare, page, text=page_text(), metadata=METADATA, collection=named_collection("scrolls"))


def test_every_character_is_a_work_under_its_name_at_its_place(bare, scroll, page):
    within = characters_within(bare, scroll.id)
    assert (scroll.new, scroll.characters, scroll.named) == (True, COLUMNS * ROWS, COLUMNS * ROWS)
    lines = ["".join(one.character for one in line) for line in text_lines(within)]
    assert "\n".join(lines) == page_text()
    picture = np.asarray(Image.open(page).convert("L"), dtype=float)
    height, width = picture.shape
    first = within[0]
    left, top = np.array(first.place["polygon"]).min(axis=0) * [width, height]
    assert left > width / 2 and top < height / 4  # the upper right, where one begins to read
    row = catalog.work(bare, first.id)
    cut = Image.open(io.BytesIO(bare.store.read(row.picture)))
    assert cut.size == (row.width, row.height)
    pixels = np.asarray(cut.convert("L"), dtype=float)
    x, y = max(0, int(left) - 12), max(0, int(top) - 12)
    around = picture[y : y + 24 + row.height, x : x + 24 + row.width]
    windows = np.lib.stride_tricks.sliding_window_view(around, pixels.shape)
    assert np.abs(windows - pixels).max(axis=(2, 3)).min() == 0  # the page's own pixels


def test_a_character_takes_what_is_known_of_its_page(bare, scroll):
    row = catalog.work(bare, characters_within(bare, scroll.id)[2].id)
    assert (row.character, row.script, row.hand_zh, row.dynasty) == ("水", "regular", "書者", "Tang")
    assert (row.licence, row.title_zh, row.title_en) == ("CC0-1.0", "習字卷「水」", "水, Practice scroll")
    assert assets_of(bare.store, row).surface().height.max() > 0  # it opens as a surface


def test_every_database_holds_a_page_with_its_characters(gallery, page):
    """On SQLite and on PostgreSQL: added once, found, counted, changed, deleted."""
    before = catalog.works(gallery).total
    masters = catalog.works(gallery, masters=True).total
    added = add_page(gallery, page, text=page_text(), metadata=METADATA)
    again = add_page(gallery, page, text=page_text(), metadata=METADATA)
    assert (again.id, again.new, again.characters, again.named) == (
        added.id,
        False,
        added.characters,
        added.named,
    )
    assert catalog.works(gallery).total == before + 1
    assert catalog.works(gallery, query="書者 水").total == 1
    assert catalog.works(gallery, masters=True).total == masters + len(CHARACTERS)
    assert (
        dict((one.value, one.count) for one in count_facets(gallery, Filters(query="水"))["script"])[
            "regular"
        ]
        == 2
    )
    assert hands_of(gallery, "水").total == page_text().count("水") + 5
    first = characters_within(gallery, added.id)[0].id
    catalog.change_work(gallery, first, {"character": "龍"})
    catalog.delete_work(gallery, added.id)
    assert catalog.works(gallery, masters=True).total == masters


def test_small_characters_are_cut_large_enough_to_be_opened(bare, tmp_path):
    small = draw_page()
    small = small.resize((round(small.width * 0.4), round(small.height * 0.4)), Image.Resampling.LANCZOS)
    small.save(tmp_path / "small.png")
    added = add_page(bare, tmp_path / "small.png", text=page_text(), metadata=METADATA)
    rows = catalog.works(bare, within=added.id, limit=100).items
    assert len(rows) >= COLUMNS * ROWS * 0.9
    assert min(min(row.width, row.height) for row in rows) >= 32


def test_whole_works_are_not_drowned_beneath_their_characters(bare, scroll):
    assert [work.id for work in catalog.works(bare).items] == [scroll.id]
    assert [work.id for work in catalog.works(bare, query="習字卷").items] == [scroll.id]
    assert [work.id for work in catalog.works(bare, query="Tang").items] == [scroll.id]
    found = catalog.works(bare, query="水")
    assert [(work.character, work.occurrence) for work in found.items] == [("水", 0)]
    both = catalog.works(bare, query="書者 shui3")
    assert [(work.parent_id, work.character) for work in both.items] == [(scroll.id, "水")]
    assert [work.id for work in catalog.works(bare, query="天人水").items] == [scroll.id]  # its text
    assert catalog.works(bare, within=scroll.id, limit=200).total == COLUMNS * ROWS
    assert catalog.works(bare, within=scroll.id, character="水").total == page_text().count("水")
    assert {work.character for work in catalog.works(bare, masters=True).items} == set(CHARACTERS)


def test_facets_count_what_the_list_shows(bare, scroll):
    alone = count_facets(bare, Filters())
    assert [(one.value, one.count) for one in alone["hand"]] == [("書者", 1)]
    assert {one.value: one.count for one in alone["character"]} == dict.fromkeys(CHARACTERS, 1)
    searched = count_facets(bare, Filters(query="水"))
    assert [(one.value, one.count) for one in searched["collection"]] == [("scrolls", 1)]


def test_the_next_character_is_the_one_that_is_read_next(bare, scroll):
    ids = [one.id for one in characters_within(bare, scroll.id)]
    assert catalog.neighbours(bare, ids[0]) == (None, ids[1])
    assert catalog.neighbours(bare, ids[5]) == (ids[4], ids[6])
    assert catalog.neighbours(bare, scroll.id) == (None, None)


def test_it_is_added_once(bare, scroll, page):
    again = add_page(bare, page, text=page_text(), metadata=METADATA, collection=named_collection("scrolls"))
    assert (again.id, again.new, again.characters) == (scroll.id, False, COLUMNS * ROWS)
    assert [count for _, count in catalog.collections(bare)] == [1]


def test_a_page_that_was_a_single_picture_is_cut(bare, page, monkeypatch):
    """And as a page it gets the maps that it is shown by, if their first visitor would have to wait."""
    monkeypatch.setattr("rumu.gallery.add_page.SLOW", 0)
    before = add_picture(bare, page, metadata=METADATA)
    after = add_page(bare, page, text=page_text(), metadata=METADATA)
    assert (after.id, after.new, after.named) == (before.id, False, COLUMNS * ROWS)
    assert catalog.work(bare, before.id).text == page_text()
    assets = assets_of(bare.store, catalog.work(bare, after.id))
    for kind in ("thumb", "facts", "heights", "normals"):
        assert stored_file(bare.store, assets, kind) is not None, kind


def test_what_is_changed_on_the_page_is_changed_on_its_characters(bare, scroll):
    ids = [one.id for one in characters_within(bare, scroll.id)]
    catalog.change_work(bare, ids[1], {"hand_zh": "別人"})
    catalog.change_work(bare, scroll.id, {"hand_zh": "王羲之", "title_zh": "蘭亭序"})
    first, second = catalog.work(bare, ids[0]), catalog.work(bare, ids[1])
    assert (first.hand_zh, first.title_zh) == ("王羲之", "蘭亭序「天」")
    assert (second.hand_zh, second.title_zh) == ("別人", "蘭亭序「人」")
    assert ids[0] in {work.id for work in catalog.works(bare, query="王羲之 天").items}


def test_a_character_that_is_named_anew_counts_under_its_new_name(bare, scroll):
    ids = [one.id for one in characters_within(bare, scroll.id)]
    catalog.change_work(bare, ids[0], {"character": "水"})
    found = catalog.works(bare, query="水").items
    assert [work.id for work in found] == [ids[0]]
    assert catalog.work(bare, ids[2]).occurrence == 1
    assert [work.id for work in catalog.works(bare, query="天").items if work.parent_id] == [ids[6]]


def test_with_a_page_its_characters_go_and_their_files(bare, scroll):
    one = characters_within(bare, scroll.id)[0].id
    with bare.database.writing() as session:
        session.add(Attempt(work_id=one, kind="photo", picture="p", version="1"))
    catalog.delete_work(bare, scroll.id)
    with bare.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(Work)) == 0
        assert session.scalar(select(func.count()).select_from(Attempt)) == 0
    assert list(bare.store.keys("pictures")) == []


def test_a_character_can_be_deleted_alone(bare, scroll):
    within = characters_within(bare, scroll.id)
    catalog.delete_work(bare, within[0].id)
    left = characters_within(bare, scroll.id)
    assert [one.id for one in left] == [one.id for one in within[1:]]
    assert catalog.work(bare, within[6].id).occurrence == 0  # the next 天 is the first now


def test_with_a_collection_all_of_it_goes(bare, scroll):
    assert catalog.delete_collection(bare, "scrolls") == 1
    with bare.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(Work)) == 0


@pytest.mark.parametrize("text", ["", " \n\ufeff", "永" * 20_001])
def test_a_text_that_is_none_is_refused(bare, page, text):
    with pytest.raises(GalleryError, match="expected"):
        add_page(bare, page, text=text, metadata=METADATA)
    assert list(bare.store.keys("pictures")) == []


def test_a_picture_without_characters_is_refused_and_nothing_stays(bare, tmp_path):
    Image.new("RGB", (600, 400), (230, 225, 210)).save(tmp_path / "blank.png")
    with pytest.raises(RefusedImage):
        add_page(bare, tmp_path / "blank.png", text="永", metadata=METADATA)
    assert catalog.works(bare).total == 0 and list(bare.store.keys("pictures")) == []
