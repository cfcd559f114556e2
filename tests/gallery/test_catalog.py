"""Works found, changed and forgotten, on SQLite and on PostgreSQL."""

from __future__ import annotations

import dataclasses
import threading

import pytest
from tests.gallery.conftest import surface

from rumu.errors import GalleryError
from rumu.gallery.annotations import add_annotation
from rumu.gallery.catalog import (
    change_collection,
    change_work,
    collection,
    collections,
    delete_collection,
    delete_work,
    neighbours,
    open_gallery,
    work,
    works,
)
from rumu.gallery.starter import find_work


def ids(page) -> list[str]:
    return [work.id for work in page.items]


def test_the_starter_works_are_there_as_they_came(gallery):
    page = works(gallery)
    assert (page.total, len(page.items)) == (39, 39)
    assert {row.id: count for row, count in collections(gallery)} == {
        "starter": 30,
        "starter-brush": 8,
        "starter-stele": 1,
    }
    kept, shipped = work(gallery, "regular-shui"), find_work("regular-shui")
    assert gallery.store.read(kept.picture) == shipped.path.read_bytes()
    for name in ("title", "hand", "period", "material"):
        told = getattr(shipped, name)
        assert (getattr(kept, f"{name}_zh"), getattr(kept, f"{name}_en")) == (told.zh, told.en)
    assert (kept.licence, kept.height_source, kept.dynasty) == (shipped.licence, "inflation", "contemporary")


def test_works_can_be_chosen(gallery):
    assert ids(works(gallery, script="seal", character="書")) == ["seal-shu"]
    assert ids(works(gallery, character="书")) == ids(works(gallery, character="書")) != []
    assert (
        works(gallery, hand="青柳衡山").total == works(gallery, hand="Aoyagi Kouzan (青柳衡山)").total == 18
    )
    assert works(gallery, collection="starter", dynasty="contemporary").total == 30
    assert works(gallery, dynasty="none").total == works(gallery, script="none").total == 0


@pytest.mark.parametrize(
    ("query", "total"),
    [
        ("水", 5),
        ("SHUI", 5),
        ("楷書 天", 1),
        ("楷书 天", 1),
        ("入門 seal", 6),
        ("當代", 39),
        ("当代", 39),
        ("  ", 39),
        ("100%", 0),
        ("_", 0),
        ("\\", 0),
        ("'; DROP TABLE works; --", 0),
    ],
)
def test_a_search_takes_words_in_any_script(gallery, query, total):
    assert works(gallery, query=query).total == total


def test_pages_hold_every_work_once_in_one_order(gallery):
    pages = [ids(works(gallery, offset=at, limit=7)) for at in range(0, 42, 7)]
    assert [name for page in pages for name in page] == ids(works(gallery))
    assert ids(works(gallery, limit=0)) == [] == ids(works(gallery, offset=99))
    with pytest.raises(GalleryError, match="0 or more"):
        works(gallery, offset=-1)


def test_an_unknown_script_is_refused(gallery):
    with pytest.raises(GalleryError, match=r"expected a script among seal, .* got 'roman'"):
        works(gallery, script="roman")


def test_a_work_that_is_not_there_is_answered_with_near_ones(gallery):
    with pytest.raises(GalleryError, match=r"did you mean .*regular-shui"):
        work(gallery, "regular-shiu")
    with pytest.raises(GalleryError, match=r"did you mean seal-shu"):
        work(gallery, "書")
    with pytest.raises(GalleryError, match="no collection 'x'"):
        collection(gallery, "x")


def test_a_changed_work_is_found_by_its_new_facts(gallery):
    before = work(gallery, "seal-ri")
    change_work(gallery, "seal-ri", {"title_en": "The Sun itself", "dynasty": "Qin", "script": ""})
    assert ids(works(gallery, query="sun ITSELF 秦")) == ["seal-ri"] == ids(works(gallery, dynasty="Qin"))
    after = work(gallery, "seal-ri")
    assert after.changed > before.changed and after.created == before.created
    for changes in ({"id": "x"}, {"script": "roman"}, {"picture": "pictures/x"}):
        with pytest.raises(GalleryError, match="expected"):
            change_work(gallery, "seal-ri", changes)
    with pytest.raises(GalleryError, match="no work"):
        change_work(gallery, "nothing", {})


def test_a_changed_collection_is_found_by_its_new_title(gallery):
    old = collection(gallery, "starter").title
    change_collection(
        gallery, "starter", {"title_zh": "蘭亭", "title_en": "Orchid pavilion", "note_zh": "序"}
    )
    after = collection(gallery, "starter")
    assert (after.title.zh, after.title.en, after.note.zh) == ("蘭亭", "Orchid pavilion", "序")
    assert works(gallery, query="ORCHID").total == 30
    assert works(gallery, query=old.en).total == 0
    with pytest.raises(GalleryError, match="one language at least") as refused:
        change_collection(gallery, "starter", {"title_zh": " ", "title_en": ""})
    assert refused.value.zh
    assert collection(gallery, "starter").title.zh == "蘭亭"
    for changes in ({"id": "x"}, {"created": "now"}):
        with pytest.raises(GalleryError, match="expected"):
            change_collection(gallery, "starter", changes)
    with pytest.raises(GalleryError, match="no collection"):
        change_collection(gallery, "nothing", {})


def test_neighbours_are_those_of_the_collection(gallery):
    order = ids(works(gallery, collection="starter"))
    assert neighbours(gallery, order[0]) == (None, order[1])
    assert neighbours(gallery, order[12]) == (order[11], order[13])
    assert neighbours(gallery, order[-1]) == (order[-2], None)


def test_a_forgotten_work_takes_its_files_and_words_along(gallery):
    from rumu.database.tables import Annotation
    from rumu.gallery.assets import assets_of, derived_folder
    from rumu.gallery.derived import derived_file

    gone = work(gallery, "seal-ri")
    said = add_annotation(gallery, "seal-ri", {"x": 0.5, "y": 0.5, "text_en": "here"})
    derived_file(gallery, "seal-ri", "thumb")
    before = set(gallery.store.keys("derived"))
    folder = derived_folder(assets_of(gallery.store, gone).digest)
    own = {key for key in before if key.startswith(f"{folder}/")}
    delete_work(gallery, "seal-ri")
    assert works(gallery).total == 38 and not gallery.store.exists(gone.picture)
    assert own and set(gallery.store.keys("derived")) == before - own
    with gallery.database.reading() as session:
        assert session.get(Annotation, said.id) is None
    with pytest.raises(GalleryError, match="no work"):
        delete_work(gallery, "seal-ri")


def test_a_file_that_another_work_shares_stays(gallery):
    from rumu.gallery.add_work import add_stored_work
    from rumu.gallery.metadata import CollectionMetadata, StoredFiles, WorkMetadata, work_digest
    from rumu.values import Bilingual

    first = work(gallery, "seal-ri")
    kept = StoredFiles(picture=first.picture, digest=work_digest("other label"), width=512, height=512)
    room = CollectionMetadata(id="more", title=Bilingual("更多", "More"))
    second = add_stored_work(gallery, WorkMetadata(title=Bilingual("日", "sun")), kept, collection=room).id
    delete_work(gallery, "seal-ri")
    assert gallery.store.exists(first.picture)
    assert delete_collection(gallery, "more") == 1
    assert not gallery.store.exists(first.picture)
    with pytest.raises(GalleryError, match="no work"):
        work(gallery, second)


def test_many_works_are_deleted_with_few_questions(gallery):
    from sqlalchemy import event

    asked = []
    event.listen(gallery.database.engine, "before_cursor_execute", lambda *told: asked.append(told[2]))
    assert delete_collection(gallery, "starter") == 30
    assert len(asked) < 15
    assert set(gallery.store.keys("pictures")) == {one.picture for one in works(gallery).items}


def test_many_threads_may_open_one_gallery_at_once(database_url, tmp_path):
    opened, errors = [], []

    def begin() -> None:
        try:
            opened.append(open_gallery(database=database_url, files=tmp_path / "f"))
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=begin) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert {works(one).total for one in opened} == {39}
    for one in opened:
        one.database.close()


def test_the_gallery_lies_where_the_settings_say(own_home, tmp_path, monkeypatch):
    open_gallery().database.close()
    assert (own_home / "rumu.sqlite").is_file() and (own_home / "files" / "pictures").is_dir()
    monkeypatch.setenv("RUMU_DATABASE", f"sqlite:///{tmp_path / 'elsewhere.sqlite'}")
    monkeypatch.setenv("RUMU_FILES", "memory://elsewhere")
    there = open_gallery()
    assert (tmp_path / "elsewhere.sqlite").is_file() and there.store.folder is None
    assert surface(there, "regular-shui").height.shape == (512, 512)
    there.database.close()


def test_an_empty_gallery_can_stay_empty(tmp_path):
    empty = open_gallery(database=tmp_path / "e.sqlite", files=tmp_path / "f", starter=False)
    assert works(empty).total == 0
    assert dataclasses.is_dataclass(empty)
    empty.database.close()
