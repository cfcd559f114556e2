"""Words of the catalogue in both languages."""

from __future__ import annotations

import pytest

from rumu.gallery.terms import HEIGHT_SOURCES, dynasty_key, dynasty_name, period_in_words, script_name
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
    assert period_in_words(told).zh == zh


def test_several_dynasties_have_a_name():
    assert (dynasty_name("Tang/Song").zh, dynasty_name("").zh) == ("唐／宋", "未詳")


def test_every_source_of_a_height_is_told():
    assert set(HEIGHT_SOURCES) == set(SOURCES)
    for source in ("inflation", "density"):
        assert "not measured" in HEIGHT_SOURCES[source].en and "並非量得" in HEIGHT_SOURCES[source].zh
    assert script_name("seal").zh == "篆書"
