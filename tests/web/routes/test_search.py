"""Searching over HTTP as people do: characters, readings, names and titles, the nearest first."""

from __future__ import annotations

import time

import pytest

from rumu.gallery.catalog import delete_collection
from rumu.gallery.metadata import (
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_works,
    work_digest,
    work_row,
)
from rumu.values import Bilingual

# id: character, title in Chinese and English, hand in Chinese and English, script
ADDED = {
    "lan-yong": ("永", "蘭亭序 神龍本「永」", "", "馮承素", "", "running"),
    "lan-xing": ("行", "蘭亭序 神龍本「行」", "", "馮承素", "", "running"),
    "yong": ("永", "真草千字文「永」", "", "智永", "", "regular"),
    "tian": ("天", "真草千字文「天」", "", "智永", "", "regular"),
    "shu-zhi": ("書", "真草千字文「書」", "", "智永", "", "regular"),
    "shu-simple": ("书", "硬筆「书」", "", "", "", "regular"),
    "dadian": ("", "永樂大典一頁", "A page of the Yongle Encyclopedia", "", "", ""),
    "wang": ("雪", "快雪時晴帖「雪」", "", "", "Wang Xizhi", "running"),
    "long": ("", "長" * 150, "A title " + "of very many words " * 9, "", "", ""),
}


@pytest.fixture(scope="module")
def visitor(world):
    """A browser of a gallery with the thirty starter works, the stele and ADDED."""
    delete_collection(world.service.gallery, "starter-brush")  # there 永 is found without what is added here
    room = CollectionMetadata(id="room", title=Bilingual("書法", "Calligraphy"))
    rows = []
    for position, (name, (character, zh, en, hand_zh, hand_en, script)) in enumerate(ADDED.items()):
        digest = work_digest(name)
        metadata = WorkMetadata(
            title=Bilingual(zh, en), character=character, hand=Bilingual(hand_zh, hand_en), script=script
        )
        files = StoredFiles(picture=f"pictures/{digest[:2]}/{digest}.png", digest=digest, width=8, height=8)
        rows.append(work_row(metadata, files, collection=room, position=position, work_id=name))
    with world.service.gallery.database.writing() as session:
        insert_works(session, room, rows)
    return world.browser()


def asked(visitor, query: str, **more):
    answer = visitor.client.get("/api/works", params={"q": query, "limit": 200} | more)
    assert answer.status_code == 200, answer.text
    page = answer.json()
    assert page["total"] >= len(page["items"])
    return page


def ids(page) -> list[str]:
    return [work["id"] for work in page["items"]]


def test_a_character_is_found_as_itself_and_then_in_its_other_forms(visitor):
    shu = {"seal-shu", "clerical-shu", "regular-shu", "running-shu", "cursive-shu", "shu-zhi"}
    for query, first, then in (("書", shu, {"shu-simple"}), ("书", {"shu-simple"}, shu)):
        page = asked(visitor, query)
        meanings = [work["meanings"] for work in page["items"]]
        assert set(ids(page)[: len(first)]) == first, query
        assert set(ids(page)[len(first) :]) == then, "nothing that is merely in 楷書, or in a collection 書法"
        assert meanings == [["character"]] * len(first) + [["form"]] * len(then)
        assert [(u["word"], u["meaning"], u["works"]) for u in page["understood"]] == [
            (query, "character", len(first)),
            (query, "form", len(then)),
        ]


def test_a_character_stands_before_the_titles_that_hold_it_and_not_with_a_name(visitor):
    page = asked(visitor, "永")
    assert ids(page) == ["lan-yong", "yong", "dadian"], "not all of 智永"
    assert [work["meanings"] for work in page["items"]] == [["character"], ["character"], ["title"]]


@pytest.mark.parametrize("query", ["yong", "Yǒng", "YONG3"])
def test_a_reading_finds_its_characters_first_and_ends(visitor, query):
    page = asked(visitor, query)
    assert ids(page) == ["lan-yong", "yong", "dadian"]
    assert [u["meaning"] for u in page["understood"]] == ["reading", "title"]


@pytest.mark.parametrize("query", ["Lanting", "lantingxu", "Orchid Pavilion", "兰亭", "蘭亭序"])
def test_a_famous_work_is_found_by_any_of_its_names(visitor, query):
    page = asked(visitor, query)
    assert ids(page) == ["lan-yong", "lan-xing"]
    assert [u["meaning"] for u in page["understood"]] == ["title"]


@pytest.mark.parametrize("query", ["Wang Xizhi", "xizhi wang", "王羲之", "王右军", "wang xi zhi"])
def test_a_calligrapher_is_found_by_any_name_with_the_copies_of_his_works(visitor, query):
    page = asked(visitor, query)
    assert set(ids(page)) == {"wang", "lan-yong", "lan-xing"}
    assert [(u["meaning"], u["works"]) for u in page["understood"]] == [("hand", 3)]


def test_words_narrow_each_other_and_other_filters_narrow_them(visitor):
    assert ids(asked(visitor, "王羲之 永")) == ["lan-yong"] == ids(asked(visitor, "yong lanting"))
    assert ids(asked(visitor, "王羲之蘭亭序永")) == ["lan-yong"]
    assert ids(asked(visitor, "永", script="regular")) == ["yong"]
    assert ids(asked(visitor, "永", masters="true")) == ["lan-yong", "yong"]
    assert asked(visitor, "永", script="seal")["total"] == 0
    found = visitor.client.get("/api/facets", params={"q": "永"}).json()
    assert {value["value"]: value["count"] for value in found["script"]} == {
        "running": 1,
        "regular": 1,
        "none": 1,
    }


def test_titles_are_found_in_both_languages_and_by_the_beginning_of_words(visitor):
    assert ids(asked(visitor, "快雪時晴"))[:1] == ["wang"] == ids(asked(visitor, "快雪时晴帖"))[:1]
    assert ids(asked(visitor, "Encyclopedia")) == ["dadian"] == ids(asked(visitor, "yongle encyclo"))
    assert "long" in ids(asked(visitor, "very many words"))
    assert ids(asked(visitor, "長長長")) == ["long"]


def test_a_page_of_a_search_is_a_part_of_the_same_order(visitor):
    whole = ids(asked(visitor, "shu"))
    parts = [ids(asked(visitor, "shu", offset=at, limit=3)) for at in range(0, len(whole), 3)]
    assert [one for part in parts for one in part] == whole
    assert asked(visitor, "shu", offset=3, limit=3)["understood"] == asked(visitor, "shu")["understood"]


@pytest.mark.parametrize(
    "query", ["", " 　", "%", "_", "'", "\\", "' OR 1=1 --", "?", "nowhere", "\u200d", "🐉", "a'" * 99]
)
def test_odd_searches_are_answered(visitor, query):
    page = asked(visitor, query)
    assert page["total"] == (31 + len(ADDED) if not query.strip("　 ") else 0)
    assert bool(page["understood"]) is False


def test_a_search_that_is_too_long_is_refused_in_both_languages(visitor):
    answer = visitor.client.get("/api/works", params={"q": "永" * 201})
    assert answer.status_code == 422
    assert answer.json()["error"]["zh"] and answer.json()["error"]["en"]


def test_the_longest_search_takes_no_longer_than_others(visitor):
    began = time.process_time()  # of this process alone, however busy the machine is
    for query in ("xian" * 50, "xi'an " * 33, "永 " * 100, "lan" * 66, "%" * 200):
        asked(visitor, query)
    assert time.process_time() - began < 10
