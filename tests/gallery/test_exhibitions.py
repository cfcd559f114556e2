"""The cover, the tour and the order of a collection."""

from __future__ import annotations

import pytest
from sqlalchemy import update

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery import catalog, tours
from rumu.gallery.archive import export_gallery
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.exhibitions import exhibition, order_works


def ids(gallery) -> list[str]:
    return [work.id for work in catalog.works(gallery, collection="starter", limit=100).items]


def test_a_collection_shows_its_first_work_until_a_cover_is_chosen(gallery):
    shown = exhibition(gallery, "starter")
    assert (shown.cover.id, shown.chosen, shown.tour) == (ids(gallery)[0], False, None)
    tour = tours.add_tour(gallery, {"title_en": "A walk", "steps": [{"work": "regular-shui"}]})
    catalog.change_collection(gallery, "starter", {"cover_id": "regular-shui", "tour_id": tour.id})
    shown = exhibition(gallery, "starter")
    assert (shown.cover.id, shown.chosen, shown.tour.id) == ("regular-shui", True, tour.id)
    catalog.delete_work(gallery, "regular-shui")
    tours.delete_tour(gallery, tour.id)
    shown = exhibition(gallery, "starter")
    assert (shown.cover.id, shown.chosen, shown.tour) == (ids(gallery)[0], False, None)


@pytest.mark.parametrize(
    "changes", [{"cover_id": "stele-ru-mu-san-fen"}, {"cover_id": "x"}, {"tour_id": "x"}]
)
def test_covers_of_other_collections_and_tours_that_there_are_not_are_refused(gallery, changes):
    with pytest.raises(GalleryError) as refused:
        catalog.change_collection(gallery, "starter", {"title_en": "Other"} | changes)
    assert refused.value.zh
    assert exhibition(gallery, "starter").collection.title.en != "Other"


def test_works_that_are_named_come_first_and_the_others_keep_their_order(gallery):
    before = ids(gallery)
    order_works(gallery, "starter", [before[7], before[2]])
    after = ids(gallery)
    assert after[:2] == [before[7], before[2]]
    assert after[2:] == [name for name in before if name not in after[:2]]
    assert exhibition(gallery, "starter").cover.id == before[7]
    order_works(gallery, "starter", [])
    assert ids(gallery) == after


def test_only_works_that_moved_count_as_changed(gallery):
    before = ids(gallery)
    changed = {name: catalog.work(gallery, name).changed for name in before}
    order_works(gallery, "starter", [before[0], before[2]])
    moved = [name for name in before if catalog.work(gallery, name).changed != changed[name]]
    assert moved == [before[1], before[2]]


@pytest.mark.parametrize("first", [["none"], ["stele-ru-mu-san-fen"], ["regular-shui", "regular-shui"]])
def test_an_order_of_other_works_changes_nothing(gallery, first):
    before = ids(gallery)
    with pytest.raises(GalleryError) as refused:
        order_works(gallery, "starter", first)
    assert refused.value.zh
    assert ids(gallery) == before


def test_characters_on_a_page_are_no_works_to_order_and_keep_their_places(gallery):
    names = ids(gallery)
    with gallery.database.writing() as session:
        session.execute(update(Work).where(Work.id == names[3]).values(parent_id=names[2], position=9))
    with pytest.raises(GalleryError):
        order_works(gallery, "starter", [names[3]])
    order_works(gallery, "starter", [names[5]])
    assert catalog.work(gallery, names[3]).position == 9


def test_an_export_takes_cover_tour_and_order_along(gallery, bare, tmp_path):
    tour = tours.add_tour(gallery, {"title_en": "A walk", "steps": [{"work": "regular-shui"}]})
    catalog.change_collection(gallery, "starter", {"cover_id": "regular-shui", "tour_id": tour.id})
    order_works(gallery, "starter", ["regular-shui"])
    export_gallery(gallery, tmp_path / "out", collections=["starter"])
    import_folder(bare, tmp_path / "out")
    shown = exhibition(bare, "starter")
    assert (shown.cover.id, shown.chosen, shown.tour.id) == ("regular-shui", True, tour.id)
    assert ids(bare) == ids(gallery)
