"""The VICP-based grader: pose taken out, and the faults it sees."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rumu.errors import RumuError
from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.vicp import raw

NAMES = ("shu", "tian", "yue", "shui", "ren", "ri")


@pytest.mark.parametrize("work", ["regular-shu", "regular-tian", "clerical-tian", "seal-ren"])
def test_itself_is_one(cell, work):
    assert raw(cell(work), cell(work)).raw > 0.98


@pytest.mark.parametrize("other", [f"regular-{name}" for name in NAMES[1:]])
def test_another_character_is_near_the_floor(cell, other):
    assert raw(cell(other), cell("regular-shu")).raw < 0.45


@pytest.mark.parametrize(
    "fault",
    [
        "shift",
        "angle",
        "short",
        "stroke_thin",
        "stroke_thick",
        "thin",
        "thick",
        "squeeze",
        "uneven",
        "wobble",
    ],
)
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 5), seeds=(1, 2))
    assert grades[0] > grades[1] > grades[2], grades


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 3))
    assert grades[0] - 0.05 > grades[1] > grades[2], grades


def test_slant_size_and_place_are_reported_and_not_charged(cell, moved):
    copy = raw(moved("regular-shu", lean=12.0, scale=0.8, shift=(8, 5)), cell("regular-shu"))
    assert copy.raw > 0.8
    assert copy.features["lean"] == pytest.approx(12.0, abs=1.0)
    assert copy.features["size"] == pytest.approx(np.log(0.8), abs=0.03)


def test_thickness_is_seen_in_the_strokes(cell):
    fine = raw(cell("regular-shu", "thin", 5), cell("regular-shu")).features
    same = raw(cell("regular-shu"), cell("regular-shu")).features
    assert fine["thickness"] < same["thickness"] - 0.2
    assert fine["position"] > 0.75


def bar():
    ink = np.zeros((SIDE, SIDE), bool)
    ink[120:136, 40:216] = True
    return cell_from(ink)


def test_a_single_stroke_can_be_graded():
    assert raw(bar(), bar()).raw > 0.98


def test_without_ink_there_is_one_clear_error():
    with pytest.raises(RumuError, match="ink"):
        cell_from(np.zeros((SIDE, SIDE), bool))


@given(st.integers(0, 2**32 - 1), st.floats(0.002, 0.6), st.floats(2.0, 10.0))
@example(167, 0.28125, 7.5)  # ink that smoothing once spilled over the rim
@settings(max_examples=20, deadline=None)
def test_any_ink_has_a_finite_grade(seed, share, blur):
    field = np.random.default_rng(seed).random((SIDE, SIDE)).astype(np.float32)
    field = cv2.GaussianBlur(field, (0, 0), blur)
    blobs = cell_from(field > np.quantile(field, 1.0 - share))
    for probe, reference in ((blobs, bar()), (bar(), blobs)):
        assert 0.0 <= raw(probe, reference).raw <= 1.0
