"""The MBSE-based grader: its correspondence, its ceiling and floor, and the faults it sees."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rumu.errors import RumuError
from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.mbse import match_strokes, raw


@pytest.mark.parametrize("work", ["regular-shu", "regular-tian", "regular-shui", "clerical-tian", "seal-ren"])
def test_itself_is_near_one(cell, work):
    assert raw(cell(work), cell(work)).raw > 0.9


def test_itself_matches_each_stroke_with_itself(cell):
    match = match_strokes(cell("regular-tian"), cell("regular-tian"))
    assert not match.extra and match.missing == 0.0 and match.bounded
    for pair in match.pairs:
        assert pair.copy is not None
        shares = np.linspace(0, 1, 9)
        apart = np.linalg.norm(pair.copy.at(shares) - pair.reference.at(shares), axis=1)
        assert apart.max() < 12.0


@pytest.mark.parametrize(
    "other", ["regular-yue", "regular-shui", "regular-tian", "regular-ren", "regular-ri"]
)
def test_another_character_is_near_the_floor(cell, other):
    assert raw(cell(other), cell("regular-shu")).raw < 0.35


@pytest.mark.parametrize("fault", ["shift", "angle", "short", "lean", "squeeze", "uneven"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 5))
    assert grades[0] > grades[1] > grades[2], grades


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 3))
    assert grades[0] - 0.02 > grades[1] > grades[2], grades


def plus(*, bar: bool = True, extra: bool = False) -> np.ndarray:
    """A standing stroke with two bars through it, or one, or three."""
    ink = np.zeros((SIDE, SIDE), bool)
    ink[30:226, 120:136] = True
    ink[70:84, 50:206] = True
    if bar:
        ink[130:144, 30:226] = True
    if extra:
        ink[186:200, 60:196] = True
    return ink


def test_the_missing_stroke_is_named():
    match = match_strokes(cell_from(plus(bar=False)), cell_from(plus()))
    (lost,) = [pair for pair in match.pairs if pair.copy is None]
    assert lost.kind == "H" and lost.reference.middle[1] == pytest.approx(136.5, abs=3)
    assert match.missing == pytest.approx(196 / (196 + 196 + 156), abs=0.05)


def test_the_extra_stroke_is_named():
    match = match_strokes(cell_from(plus(extra=True)), cell_from(plus()))
    assert all(pair.copy is not None for pair in match.pairs)
    assert sum(line.length for line in match.extra) == pytest.approx(136 - 14, abs=25)
    assert all(line.middle[1] == pytest.approx(192.5, abs=4) for line in match.extra)


def test_a_broken_stroke_is_followed_across_the_gap():
    broken = plus()
    broken[:, 170:178] = False
    match = match_strokes(cell_from(broken), cell_from(plus()))
    assert match.missing == 0.0 and match.surplus < 0.02


def test_place_is_not_seen_and_size_hardly(cell, moved):
    master = cell("regular-shu")
    assert raw(moved("regular-shu", shift=(9, -7)), master).raw > 0.9
    assert raw(moved("regular-shu", scale=0.85), master).raw > 0.65


def test_without_ink_there_is_one_clear_error():
    with pytest.raises(RumuError, match="ink"):
        cell_from(np.zeros((SIDE, SIDE), bool))


@given(st.integers(0, 2**32 - 1), st.floats(0.002, 0.6), st.floats(2.0, 10.0))
@example(167, 0.28125, 7.5)  # ink that smoothing once spilled over the rim
@settings(max_examples=8, deadline=None)
def test_any_ink_has_a_finite_grade(seed, share, blur):
    field = np.random.default_rng(seed).random((SIDE, SIDE)).astype(np.float32)
    field = cv2.GaussianBlur(field, (0, 0), blur)
    blobs, master = cell_from(field > np.quantile(field, 1.0 - share)), cell_from(plus())
    for probe, reference in ((blobs, master), (master, blobs)):
        assert 0.0 <= raw(probe, reference).raw <= 1.0
