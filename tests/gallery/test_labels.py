"""Rows of labels.csv as works, in the columns of three real sets."""

from __future__ import annotations

import json

import pytest

from rumu.errors import GalleryError
from rumu.gallery.labels import SharedMetadata, collection_of, read_description, read_labels
from rumu.values import Bilingual


def rows(folder, text: str, told: SharedMetadata | None = None):
    (folder / "labels.csv").write_text(text, encoding="utf-8")
    return read_labels(folder, told or SharedMetadata())


def test_the_columns_of_the_steles(tmp_path):
    (row,) = rows(
        tmp_path,
        "file,character,calligrapher,calligrapher_zh,work,dynasty,script,label_confidence\n"
        "a/1.png,天,yu_shinan_attr,虞世南(傳),演連珠,Tang (attributed),regular,1.0\n",
    )
    entry = row.metadata
    assert (row.file, entry.character, entry.script, entry.dynasty) == ("a/1.png", "天", "regular", "Tang")
    assert entry.title == Bilingual("演連珠「天」", "天, 演連珠")
    assert entry.hand == Bilingual("虞世南(傳)", "Yu Shinan (attributed)")
    assert entry.period == Bilingual("唐（傳）", "Tang (attributed)")
    assert (entry.licence, entry.source, entry.origin) == ("none stated", "", "a/1.png")


def test_the_columns_of_the_lantingxu(tmp_path):
    (row,) = rows(tmp_path, "file,character,script,medium\nd/1.jpg,永,running,rubbing(white on black)\n")
    assert row.metadata.material == Bilingual("拓本（黑底白字）", "rubbing (white on black)")


def test_the_columns_of_the_cursive_characters(tmp_path):
    (row,) = rows(
        tmp_path,
        "file,character,calligrapher_zh,script,polarity_guess\n1.webp,一,王铎,cursive,light_on_dark\n",
    )
    assert row.metadata.title == Bilingual("王铎草書「一」", "一, 王铎, cursive script")
    assert row.metadata.hand == Bilingual("王铎", "王铎")
    assert "guessed" in row.metadata.material.en and row.metadata.dynasty == ""


def test_a_description_says_what_no_row_says(tmp_path):
    held = {"id": "Six Steles!", "title": {"zh": "六碑", "en": "Six steles"}, "source": "x", "dynasty": "唐"}
    (tmp_path / "collection.json").write_text(json.dumps(held), encoding="utf-8")
    told = SharedMetadata({"source": "y"}).with_defaults(read_description(tmp_path))
    one, two = rows(tmp_path, "file,dynasty,licence\n1.png,Sui,CC0-1.0\n2.png,,\n", told)
    assert (one.metadata.dynasty, one.metadata.licence, one.metadata.source) == ("Sui", "CC0-1.0", "y")
    assert (two.metadata.dynasty, two.metadata.licence, two.metadata.period.en) == (
        "Tang",
        "none stated",
        "Tang",
    )
    room = collection_of(tmp_path, told)
    assert (room.id, room.title.zh, room.source) == ("six-steles", "六碑", "y")


def test_a_folder_of_any_name_is_a_collection(tmp_path):
    (tmp_path / "草書").mkdir()
    room = collection_of(tmp_path / "草書", SharedMetadata())
    assert room.id.startswith("collection-") and room.id.isascii() and room.title.zh == "草書"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("character\n天\n", "expected a column 'file', found character"),
        ("file,script\n1.png,regular\n2.png,roman\n", "row 2: expected a script among .* got 'roman'"),
        ("file,script\n,regular\n", "row 1: expected a file"),
        ("", "found nothing"),
    ],
)
def test_a_table_that_is_none_is_refused(tmp_path, text, words):
    with pytest.raises(GalleryError, match=words):
        rows(tmp_path, text)


@pytest.mark.parametrize("text", ["[", "[]", '{"stray": 1}', '{"title": 5}'])
def test_a_description_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "collection.json").write_text(text, encoding="utf-8")
    with pytest.raises(GalleryError, match=r"collection\.json: expected"):
        read_description(tmp_path)


def test_labels_of_a_spreadsheet_with_chinese_names(tmp_path):
    text = "檔名;字;書體;書家;朝代;題名\r\n張三.png;水;楷書;顏真卿;唐;多寶塔碑\r\n"
    for encoding in ("cp950", "gb18030", "utf-16", "utf-8-sig"):
        (tmp_path / "labels.csv").write_bytes(text.encode(encoding))
        (label,) = read_labels(tmp_path, SharedMetadata())
        metadata = label.metadata
        assert (label.file, metadata.character, metadata.script, metadata.dynasty) == (
            *("張三.png", "水", "regular", "Tang"),
        )
        assert metadata.hand.zh == "顏真卿" and metadata.title.zh.startswith("多寶塔碑")
