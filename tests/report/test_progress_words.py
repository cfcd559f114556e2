"""What became of a fault, in two languages."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rumu.assessment.progress import STATUSES, FaultChange, NumberChange
from rumu.report.progress_words import FAULTS, describe_fault, describe_mark, stroke_name
from rumu.report.wording import KINDS
from rumu.values import Remark

LINE = (((0.1, 0.1), (0.3, 0.2)),)
SHORT = Remark("stroke_short", -0.18, "of the master", 3.0, None, "短", "Short.", LINE, LINE, stroke=3)


def said(status, before=SHORT, after=SHORT, character="水"):
    return describe_fault(FaultChange(status, before, after), character=character)


def test_the_stroke_has_its_number_and_name():
    text = said("smaller", after=replace(SHORT, size=-0.09))
    assert text.zh == "第三筆「撇」：仍太短，但好些了：18% → 9%。"
    assert text.en == "Stroke 3, left-falling stroke: still too short, but less so: 18% → 9%."


@pytest.mark.parametrize("character", ["", "水水", "𰻞"])
def test_without_its_number_it_is_named_by_its_place(character):
    assert stroke_name(SHORT, character=character) == ("左上部的一筆", "The stroke at the top left")
    assert stroke_name(replace(SHORT, stroke=None), character="水").zh == "左上部的一筆"
    assert stroke_name(replace(SHORT, stroke=99), character="水").zh == "左上部的一筆"
    whole = replace(SHORT, stroke=None, outline=(), master_outline=())
    assert stroke_name(whole, character="水") == ("整字", "The whole")
    several = replace(SHORT, stroke=None, outline=LINE * 2, master_outline=())
    assert stroke_name(several, character="水") == ("幾筆", "Several strokes")


def test_every_kind_can_be_said_in_every_way():
    assert set(FAULTS) >= set(KINDS)
    for kind in (*FAULTS, "a_kind_of_tomorrow"):
        remark = replace(SHORT, kind=kind)
        for status in STATUSES:
            before, after = (None if status == "new" else remark), (None if status == "gone" else remark)
            text = describe_fault(FaultChange(status, before, after), character="水")
            assert text.zh.endswith("。") and text.en.endswith(".")
            assert "{" not in text.zh + text.en and "_" not in text.en


def test_a_stroke_that_was_missing_is_written_now():
    text = said("gone", replace(SHORT, kind="missing"), None)
    assert text.en == "Stroke 3, left-falling stroke: missing last time, written this time."


def test_from_too_short_to_too_long():
    text = said("turned", after=replace(SHORT, kind="stroke_long", size=0.12))
    assert text.en.endswith("too short last time (18%), now too long (12%).")
    lean = replace(SHORT, kind="lean", unit="degrees", size=5.0, outline=(), master_outline=(), stroke=None)
    text = said("turned", lean, replace(lean, size=-4.0))
    assert text.en == "The whole: still leaning, but to the other side: 5.0° → 4.0°."


def test_a_mark_that_hardly_changed_is_called_the_same():
    assert "About as before, as a whole: 50 → 53" in describe_mark(NumberChange(50, 53, "same")).en
    assert describe_mark(NumberChange(50, 70, "better")) == (
        "整體比上一張好：50 → 70。",
        "Better as a whole: 50 → 70.",
    )
    assert "不如上一張" in describe_mark(NumberChange(50, 30, "worse")).zh


def test_two_parts_are_told_as_two_parts():
    parts = replace(SHORT, kind="part_place", unit="of the cell", size=0.083, stroke=None, outline=LINE * 2)
    text = said("same", parts, replace(parts, size=0.04))
    assert text.zh == "兩部：仍位置不合，與上次差不多（4%）。"
    assert text.en == "The two parts: still not in place beside each other, about as before (4%)."
