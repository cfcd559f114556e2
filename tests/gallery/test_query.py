"""What the words of a search mean, on SQLite and on PostgreSQL."""

from __future__ import annotations

import pytest

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.catalog import change_work, update_search, work, works
from rumu.gallery.filters import Filters, count_facets
from rumu.gallery.metadata import (
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_works,
    work_digest,
    work_row,
)
from rumu.gallery.pinyin import split_pinyin
from rumu.gallery.search_text import SEARCH_VERSION, split_words
from rumu.values import Bilingual

# id: character, title, hand, script, dynasty
CATALOGUE = {
    "a1": ("天", "真草千字文「天」", "智永", "regular", "Sui"),
    "a2": ("永", "真草千字文「永」", "智永", "regular", "Sui"),
    "a3": ("書", "真草千字文「書」", "智永", "regular", "Sui"),
    "b1": ("永", "蘭亭序 神龍本「永」", "馮承素", "running", "Tang"),
    "b2": ("行", "蘭亭序 神龍本「行」", "馮承素", "running", "Tang"),
    "c1": ("爲", "多寶塔碑「爲」", "顏真卿", "regular", "Tang"),
    "c2": ("唐", "多寶塔碑「唐」", "顏真卿", "regular", "Tang"),
    "c3": ("女", "顏真卿楷書「女」", "顏真卿", "regular", "Tang"),
    "c4": ("髮", "顏真卿楷書「髮」", "顏真卿", "regular", "Tang"),
    "d1": ("", "永樂大典一頁", "", "", "Ming"),
    "d2": ("", "書譜", "孫過庭", "cursive", "Tang"),
    "d3": ("", "自書詩 🐉 سلام", "", "", ""),
}


@pytest.fixture
def few(database, tmp_path):
    from rumu.gallery.store import Gallery, Store

    gallery = Gallery(database, Store.open(tmp_path / "few"))
    room = CollectionMetadata(id="room", title=Bilingual("書法", "Calligraphy"))
    rows = []
    for position, (name, (character, title, hand, script, dynasty)) in enumerate(CATALOGUE.items()):
        metadata = WorkMetadata(
            title=Bilingual(title, ""),
            character=character,
            hand=Bilingual(hand, ""),
            script=script,
            dynasty=dynasty,
        )
        files = StoredFiles(
            picture=f"pictures/{work_digest(name)[:2]}/{work_digest(name)}.png",
            digest=work_digest(name),
            width=8,
            height=8,
        )
        rows.append(work_row(metadata, files, collection=room, position=position, work_id=name))
    with database.writing() as session:
        insert_works(session, room, rows)
    return gallery


def found(gallery, query: str) -> list[str]:
    return [one.id for one in works(gallery, query=query).items]


@pytest.mark.parametrize(
    ("query", "expected"),
    [
        ("永", "a2 b1 d1"),  # works of the character, then a title; not the name 智永
        ("书", "a3 d2 d3"),  # not 楷書 of titles, not the collection 書法
        ("書", "a3 d2 d3"),
        ("為", "c1"),
        ("为", "c1"),
        ("发", "c4"),
        ("發", ""),  # 發 and 髮 are two characters, though both are 发 today
        ("yong", "a2 b1 d1"),  # the reading, then 永樂大典; not everything by 智永
        ("yǒng", "a2 b1 d1"),
        ("yong3", "a2 b1 d1"),
        ("yong4", "a2 b1 d1"),
        ("zhi", "a1 a2 a3"),  # as a surname would be
        ("zhiyong", "a1 a2 a3"),
        ("yan", "c1 c2 c3 c4"),
        ("sun", "d2"),
        ("a", ""),
        ("hang", "b2"),  # another reading of 行
        ("nü", "c3"),
        ("nv", "c3"),
        ("nǚ", "c3"),
        ("ｎｖ３", "c3"),
        ("shu", "a3 d2 d3"),
        ("Lanting", "b1 b2"),
        ("lán tíng xù", "b1 b2"),
        ("LANTINGXU", "b1 b2"),
        ("Orchid Pavilion", "b1 b2"),
        ("兰亭", "b1 b2"),
        ("Wang Xizhi", "b1 b2"),  # 蘭亭序 is his, whoever copied it
        ("xizhi wang", "b1 b2"),
        ("王羲之", "b1 b2"),
        ("Yan Zhenqing", "c1 c2 c3 c4"),
        ("yanzhenqing", "c1 c2 c3 c4"),
        ("Zhenqing Yan", "c1 c2 c3 c4"),
        ("颜鲁公", "c1 c2 c3 c4"),
        ("颜真卿 女", "c3"),
        ("顏真卿楷書", "c3 c4"),  # a title as a whole
        ("颜真卿草书", ""),
        ("孙过庭草书", "d2"),
        ("yanlugong", "c1 c2 c3 c4"),
        ("王羲之永", "b1"),
        ("永字", "a2 b1 d1"),
        ("楷書", "c3 c4 a1 a2 a3 c1 c2"),
        ("kaishu", "a1 a2 a3 c1 c2 c3 c4"),
        ("regular script", "a1 a2 a3 c1 c2 c3 c4"),
        ("草書", "d2"),
        ("楷", ""),
        ("唐", "c2 b1 b2 c1 c3 c4 d2"),
        ("Tang dynasty", "b1 b2 c1 c2 c3 c4 d2"),
        ("唐代 女", "c3"),
        ("永 行書", "b1"),
        ("🐉", "d3"),
        ("سلام", "d3"),
        ("Treatise on Calligraphy", "d2"),
        ("%", ""),
        ("_", ""),
        ("\\", ""),
        ("'", ""),
        ("' OR 1=1 --", ""),
        ("nowhere", ""),
    ],
)
def test_a_search_finds_what_it_means_the_nearest_first(few, query, expected):
    assert found(few, query) == expected.split(), query
    assert works(few, query=query).total == len(expected.split())
    facets = count_facets(few, Filters(query=query))
    assert sum(value.count for value in facets["collection"]) == len(expected.split())


def test_an_empty_search_is_no_filter_and_a_very_long_one_is_refused(few):
    assert works(few, query="").total == works(few, query="  　").total == len(CATALOGUE)
    assert works(few, query="永 " * 66).total == 3
    assert works(few, query=" ".join("abcdefghijklmnopqrstuvwxyz0123456789")).total == 0
    with pytest.raises(GalleryError, match="at most 200 characters, got 201") as refused:
        works(few, query="永" * 201)
    assert "200" in refused.value.zh


def test_a_search_says_what_it_understood(few):
    page = works(few, query="永")
    assert [(one.word, one.meaning, one.works) for one in page.understood] == [
        ("永", "character", 2),
        ("永", "title", 1),
    ]
    assert page.meanings == {"a2": ("character",), "b1": ("character",), "d1": ("title",)}
    page = works(few, query="Wang Xi Zhi yong", limit=1)
    assert [(one.word, one.meaning, one.works) for one in page.understood] == [
        ("wang xi zhi", "hand", 1),
        ("yong", "reading", 1),
    ]


def test_pages_of_a_search_hold_every_work_once(few):
    pages = [works(few, query="yan zhenqing", offset=at, limit=3) for at in (0, 3, 6)]
    assert [one.id for page in pages for one in page.items] == ["c1", "c2", "c3", "c4"]
    assert {page.total for page in pages} == {4}


def test_texts_are_made_again_when_their_rules_change(few):
    before = work(few, "b1").changed
    with few.database.writing() as session:
        row = session.get_one(Work, "b1")
        row.search_title, row.search_version = "", 0
    changed = work(few, "b1").changed
    assert found(few, "lanting") == ["b2"]
    assert update_search(few) == 1 and found(few, "lanting") == ["b1", "b2"]
    assert work(few, "b1").search_version == SEARCH_VERSION and work(few, "b1").changed == changed >= before


def test_a_changed_work_is_searched_by_what_it_is_now(few):
    change_work(few, "a1", {"hand_zh": "米芾", "title_zh": "蜀素帖"})
    assert found(few, "Mi Fu") == ["a1"] == found(few, "shusu") == found(few, "Sichuan silk")
    assert found(few, "zhiyong") == ["a2", "a3"]


@pytest.mark.parametrize(
    ("word", "ways"),
    [
        ("xian", (("xian",), ("xi", "an"))),
        ("xi'an", (("xi", "an"),)),
        ("lǚ", (("lv3",),)),
        ("lu:4", (("lv4",),)),
        ("nüe", (("nve",), ("nv", "e"))),
        ("wang2xi1zhi1", (("wang2", "xi1", "zhi1"),)),
        ("pavilion", ()),
        ("", ()),
    ],
)
def test_pinyin_as_people_type_it(word, ways):
    assert split_pinyin(word) == ways


def test_long_words_that_are_no_pinyin_take_no_time():
    assert split_pinyin("xian" * 19 + "q") == () and split_pinyin("a" * 5000) == ()


def test_words_are_parted_where_the_writing_changes():
    words = split_words("Wang Xi-zhi《蘭亭序》永a  xi’an ＹＯＮＧ 🐉\u200d")
    assert [word.text for word in words] == ["wang", "xi", "zhi", "兰亭序", "永", "a", "xian", "yong", "🐉"]
