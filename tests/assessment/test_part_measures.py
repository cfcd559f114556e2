"""Of the parts of a character only those are spoken of that its structure has."""

from __future__ import annotations

import csv
from functools import lru_cache

import numpy as np
import pytest

from rumu import pipeline
from rumu.assessment.part_measures import AXES, measure_parts
from rumu.assessment.remarks import write_remarks
from rumu.characters.stroke_data import CanonicalCharacter, Structure, find_character
from rumu.strokes.correspondence import CopyStrokes
from rumu.strokes.placement import stroke_numbers

PART_KINDS = {"squeeze", "part_place", "inner"}


def bar(ink, top, left, height, width):
    ink[top : top + height, left : left + width] = True


def halves(*, left=100, gap=50, right=150, lower=0) -> np.ndarray:
    """Two parts side by side, each of two horizontals and a vertical; lower: of the left one, pixels."""
    ink = np.zeros((512, 512), bool)
    for start, width, down in ((80, left, lower), (80 + left + gap, right, 0)):
        for row in (130, 250):
            bar(ink, row + down, start, 22, width)
        bar(ink, 130 + down, start + width // 2 - 11, 240, 22)
    return ink


def enclosure(inner: int) -> np.ndarray:
    """A frame open below, and in it a cross of this size."""
    ink = np.zeros((512, 512), bool)
    bar(ink, 100, 110, 24, 290)
    for column in (110, 376):
        bar(ink, 100, column, 320, 24)
    bar(ink, 250 - 11, 255 - inner // 2, 22, inner)
    bar(ink, 250 - inner // 2, 255 - 11, inner, 22)
    return ink


@pytest.fixture(scope="module")
def said(measured):
    def write(copy, master, structure: Structure | None, **options):
        m = measured(copy, master)
        known = None if structure is None else CanonicalCharacter("?", (), structure)
        found = write_remarks(
            CopyStrokes(m.copy, m.registration, m.master.stroke_model), character=known, **options
        )
        return [remark for remark in (*found.remarks, *found.untold) if remark.kind in PART_KINDS]

    return write


WIDE_LEFT = {"left": 150, "gap": 50, "right": 100}


def test_a_left_part_that_is_too_wide_is_told_of_a_left_right_character(said):
    found = said(halves(**WIDE_LEFT), halves(), "left-right")
    (squeeze,) = [r for r in found if r.kind == "squeeze"]
    assert "左旁太寬" in squeeze.zh and "left part is too wide" in squeeze.en
    assert squeeze.outline and squeeze.master_outline


@pytest.mark.parametrize("structure", ["single", "top-bottom", "enclosed", "half-enclosed"])
def test_of_left_and_right_nothing_is_said_where_there_is_no_such_part(said, structure):
    for remark in said(halves(**WIDE_LEFT), halves(), structure):
        assert "左旁" not in remark.zh and "右旁" not in remark.zh


def test_of_an_unknown_character_only_what_is_overwhelming_is_said(said):
    assert said(halves(left=115, gap=50, right=135), halves(), None) == []


def test_of_upper_and_lower_parts_nothing_is_said_of_a_left_right_character(said):
    turned = [np.ascontiguousarray(np.rot90(halves(**w), -1)) for w in (WIDE_LEFT, {})]
    assert not [r for r in said(*turned, "left-right") if "上部" in r.zh or "下部" in r.zh]
    (squeeze,) = [r for r in said(*turned, "top-bottom") if r.kind == "squeeze"]
    assert "上部太高" in squeeze.zh and "upper part is too tall" in squeeze.en


@pytest.mark.parametrize(
    ("change", "zh", "en"),
    [({"gap": 90}, "離得太遠", "too far apart"), ({"lower": 40}, "左旁對右旁偏下", "too low beside")],
)
def test_how_the_parts_stand_to_each_other_is_told(said, change, zh, en):
    found = said(halves(**change), halves(), "left-right")
    (place,) = [r for r in found if r.kind == "part_place"]
    assert zh in place.zh and en in place.en


def test_of_a_part_out_of_place_its_strokes_are_not_told_one_by_one(measured):
    m = measured(halves(lower=40), halves())
    known = CanonicalCharacter("?", (), "left-right")
    found = write_remarks(CopyStrokes(m.copy, m.registration, m.master.stroke_model), character=known)
    assert "displaced" not in [r.kind for r in (*found.remarks, *found.untold)]


@pytest.mark.parametrize(("size", "zh", "en"), [(90, "太小", "too small"), (200, "太大", "too large")])
def test_what_is_enclosed_is_told_by_its_size(said, size, zh, en):
    found = said(enclosure(size), enclosure(150), "half-enclosed")
    (inner,) = [r for r in found if r.kind == "inner"]
    assert zh in inner.zh and en in inner.en
    assert said(enclosure(size), enclosure(150), "single") == []


def test_a_copy_in_proportion_is_not_blamed(said):
    for structure in ("left-right", "top-bottom", "half-enclosed", None):
        assert said(halves(), halves(), structure) == []


def test_of_learners_copies_no_part_is_named_that_the_character_does_not_have(data):
    template = lru_cache(pipeline.prepare_master)
    with (data / "e3c" / "scores.csv").open(encoding="utf-8-sig") as stream:
        rows = list(csv.DictReader(stream))[::40]
    for row in rows:
        mark = pipeline.assess(
            data / "e3c" / row["image"],
            template(data / "e3c" / row["template"]),
            character=row["character"],
            framed=True,
        )
        structure = find_character(row["character"]).structure
        told = "".join(remark.zh for remark in (*mark.remarks, *mark.untold))
        words = {"across": ("左旁", "右旁"), "down": ("上部太", "下部太", "上部與", "上部對")}
        for axis, parts in words.items():
            if AXES.get(structure) != axis:
                assert not any(part in told for part in parts), (row["image"], told)
        if structure not in ("enclosed", "half-enclosed"):
            assert "框內" not in told, row["image"]
        assert len(mark.remarks) <= 3
        ends = [remark.zh.rstrip("。").rpartition("。")[2] for remark in mark.remarks]
        assert len(set(ends)) == len(ends), ends


def master_of(data, character):
    """The master of the learners' copies of a character, measured in itself."""
    with (data / "e3c" / "scores.csv").open(encoding="utf-8", newline="") as stream:
        row = next(row for row in csv.DictReader(stream) if row["character"] == character)
    return pipeline.prepare_master(data / "e3c" / row["template"], character=character).stroke_model.itself


@pytest.mark.parametrize(("character", "border"), [("當", 8), ("銘", 8), ("傳", 2)])
def test_parts_meet_where_the_radical_ends_or_begins(data, character, border):
    itself = master_of(data, character)
    numbers, known = stroke_numbers(itself.master), find_character(character)
    parts = measure_parts(itself, known.structure, radical_border=known.radical_border)
    assert known.radical_border == border
    assert set(numbers[parts.first & (numbers > 0)]) == set(range(1, border + 1))


def test_a_radical_that_is_no_part_does_not_part_a_character(data):
    """As 耳 in 聖, 口 beside it: the strokes up to 德's 目 do not all lie to the left of the others."""
    itself = master_of(data, "德")
    wrong, none = (measure_parts(itself, "left-right", radical_border=border) for border in (10, None))
    assert (wrong.first == none.first).all()


@pytest.mark.parametrize(("character", "last"), [("德", 3), ("讀", 7), ("銘", 8)])
def test_a_dot_that_reaches_over_the_border_stays_with_its_part(data, character, last):
    """The left dot of 德's 心 lies under 彳, 讀's left vertical under 言: they are of the right part."""
    itself = master_of(data, character)
    parts = measure_parts(itself, "left-right")
    numbers = stroke_numbers(itself.master)
    assert set(numbers[parts.first & (numbers > 0)]) == set(range(1, last + 1))


def test_a_stroke_of_a_narrow_part_is_as_heavy_as_it_is_written(measured):
    """Who writes a part narrow writes its strokes as wide as the others."""
    m = measured(halves(left=60, gap=50, right=190), halves(left=110, gap=50, right=140))
    strokes = CopyStrokes(m.copy, m.registration, m.master.stroke_model)
    found = write_remarks(strokes, character=CanonicalCharacter("?", (), "left-right"))
    assert not [r for r in (*found.remarks, *found.untold) if "heavy" in r.kind]
