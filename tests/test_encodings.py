"""Encodings: a short text is told by what it says, whatever program wrote it."""

from __future__ import annotations

import pytest

from rumu.encodings import decode_text

HEADER = "copy,reference\r\n"
SIMPLIFIED = [
    *(
        "水",
        "永",
        "学校",
        "张三 水",
        "李小明",
        "王芳",
        "陈伟",
        "颜真卿多宝塔",
        "欧阳询",
        "兰亭序",
        "九成宫醴泉铭",
        "第一课",
    ),
    *("梓涵", "浩宇", "苏轼寒食帖", "邓石如", "作业 3", "刘建国，楷书", "诸葛亮", "周杰伦"),
]
TRADITIONAL = [
    *(
        "張三 水",
        "李小明",
        "陳怡君",
        "林志豪",
        "顏真卿多寶塔",
        "歐陽詢",
        "蘭亭序",
        "九成宮醴泉銘",
        "第一課",
        "黃庭堅",
    ),
    *("冠宇", "曾雅婷", "蘇軾寒食帖", "鄧石如", "劉建國，楷書", "龍門二十品", "詩涵", "周杰倫"),
]


@pytest.mark.parametrize("text", SIMPLIFIED)
def test_simplified_chinese_in_gb18030(text):
    found = decode_text(f"{HEADER}{text}.png,x\r\n".encode("gb18030"))
    assert (found.text, found.encoding) == (f"{HEADER}{text}.png,x\r\n", "GB 18030")


@pytest.mark.parametrize("text", TRADITIONAL)
@pytest.mark.parametrize(("codec", "name"), [("cp950", "Big5"), ("gb18030", "GB 18030")])
def test_traditional_chinese_in_both_standards(text, codec, name):
    found = decode_text(f"{HEADER}{text}.png,x\r\n".encode(codec))
    assert (found.text, found.encoding) == (f"{HEADER}{text}.png,x\r\n", name)


@pytest.mark.parametrize(
    ("codec", "mark", "name"),
    [
        ("utf-8", b"", "UTF-8"),
        ("utf-8", b"\xef\xbb\xbf", "UTF-8"),
        ("utf-16-le", b"\xff\xfe", "UTF-16"),
        ("utf-16-be", b"\xfe\xff", "UTF-16"),
        ("utf-16-le", b"", "UTF-16"),
        ("utf-16-be", b"", "UTF-16"),
        ("utf-32-le", b"\xff\xfe\0\0", "UTF-32"),
    ],
)
@pytest.mark.parametrize("text", ["水", "学校", "plain", "Müller", "août", "Привет", "Ελλάδα", "12 €", "𠮷"])
def test_unicode_in_every_form(text, codec, mark, name):
    found = decode_text(mark + f"{HEADER}{text},x\n".encode(codec))
    assert (found.text, found.encoding) == (f"{HEADER}{text},x\n", name)


def test_western_names_from_a_spreadsheet_in_europe():
    text = "image;reference;mark\r\nMüller.png;Übung;87,5\r\nZoë.png;Café;90\r\n"
    assert decode_text(text.encode("cp1252")).text == text


def test_words_that_are_known_decide():
    """All that stands in the table are rare characters, but for the name of a column."""
    text = "範本,x\r\n嚭,1\r\n"
    assert decode_text(text.encode("cp950"), words=["範本", "范本"]).text == text
    assert decode_text(text.encode("gb18030"), words=["範本", "范本"]).text == text


@pytest.mark.parametrize("data", [b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\1\0", bytes(range(256)), b"\xff\xfea"])
def test_what_is_no_text(data):
    assert decode_text(data) is None


def test_an_empty_file_is_an_empty_text():
    assert decode_text(b"").text == ""
