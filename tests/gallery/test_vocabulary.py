"""Words of the catalogue in both languages."""

from __future__ import annotations

import pytest

from rumu.gallery.vocabulary import (
    HEIGHT_SOURCES,
    dynasty_key,
    dynasty_name,
    file_in_other_characters,
    fold,
    period_name,
    script_name,
    variants,
)
from rumu.values import SOURCES


@pytest.mark.parametrize(
    ("told", "key", "zh"),
    [
        ("Tang", "Tang", "唐"),
        ("唐", "Tang", "唐"),
        ("Tang (attributed)", "Tang", "唐（傳）"),
        ("Tang/Song copy", "Tang/Song", "唐／宋摹本"),
        ("Northern Wei", "Northern Wei", "北魏"),
        ("somewhen", "somewhen", "somewhen"),
        ("", "", ""),
    ],
)
def test_a_period_and_its_dynasty(told, key, zh):
    assert dynasty_key(told) == key
    assert period_name(told).zh == zh


def test_several_dynasties_have_a_name():
    assert (dynasty_name("Tang/Song").zh, dynasty_name("").zh) == ("唐／宋", "未詳")


def test_every_source_of_a_height_is_told():
    assert set(HEIGHT_SOURCES) == set(SOURCES)
    for source in ("inflation", "density"):
        assert "not measured" in HEIGHT_SOURCES[source].en and "並非量得" in HEIGHT_SOURCES[source].zh
    assert script_name("seal").zh == "篆書"


@pytest.mark.parametrize(
    ("one", "other"), [("書", "书"), ("蘭亭序", "兰亭序"), ("ＴＡＮＧ", "tang"), ("顏真卿", "颜真卿")]
)
def test_both_forms_are_one(one, other):
    assert fold(one) == fold(other)


def test_different_characters_stay_different():
    assert len({fold(character) for character in "天人水書日月永"}) == 7


def test_the_forms_of_a_character():
    assert variants("书") == ("书", "書")
    assert variants("書") == ("書", "书")
    assert variants("水") == ("水",)
    assert set(variants("后")) == {"后", "後"}


def test_a_file_is_found_in_other_characters_within_its_folder_alone(tmp_path):
    folder = tmp_path / "class"
    (folder / "more").mkdir(parents=True)
    for name in ("张三.png", "more/书.png", "發.png", "髮.png"):
        (folder / name).touch()
    (tmp_path / "出.png").touch()
    expected = {
        "張三.png": folder / "张三.png",
        "more/書.png": folder / "more" / "书.png",
        "more\\書.PNG": folder / "more" / "书.png",
        "发.png": None,  # of two it is not clear which
        "../出.png": None,
        "/出.png": None,
        "none/a.png": None,
        "李四.png": None,
    }
    assert {name: file_in_other_characters(folder, name) for name in expected} == expected
    (folder / "李四.png").touch()
    assert file_in_other_characters(folder, "李四.PNG") == folder / "李四.png"  # not what stood there before
