"""Intersection over union: known overlaps, and what placing forgives."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.overlap import raw, raw_aligned


def square(left: int, *, side: int = 60) -> np.ndarray:
    ink = np.zeros((SIDE, SIDE), bool)
    ink[80 : 80 + side, left : left + side] = True
    return ink


def test_half_moved_squares_share_a_third() -> None:
    assert raw(cell_from(square(60)), cell_from(square(90))).raw == pytest.approx(1 / 3)


def test_itself_is_one_and_apart_is_zero(cell) -> None:
    assert raw(cell("regular-shu"), cell("regular-shu")).raw == 1.0
    assert raw_aligned(cell("regular-shu"), cell("regular-shu")).raw > 0.99
    assert raw(cell_from(square(0)), cell_from(square(150))).raw == 0.0


def test_another_character_is_far_below_a_copy(cell) -> None:
    for method in (raw, raw_aligned):
        assert method(cell("regular-yue"), cell("regular-shu")).raw < 0.35
        assert method(cell("regular-shu", "wobble", 2), cell("regular-shu")).raw > 0.7


@pytest.mark.parametrize("fault", ["shift", "angle", "short", "thin", "thick", "squeeze"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault: str) -> None:
    for method in (raw, raw_aligned):
        grades = ladder(method, "regular-shu", fault)
        assert (np.diff(grades) < 0).all(), grades


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault: str) -> None:
    assert (np.diff(ladder(raw, "regular-shu", fault)) < 0).all()
    assert max(ladder(raw_aligned, "regular-shu", fault)[1:]) < 0.7


@pytest.mark.parametrize("fault", ["off_centre", "small"])
def test_place_and_size_cost_in_the_cell_and_are_told_when_placed(cell, ladder, fault: str) -> None:
    assert (np.diff(ladder(raw, "regular-shu", fault, seeds=(1,))) < -0.03).all()
    answer = raw_aligned(cell("regular-shu", fault, 3), cell("regular-shu"))
    assert answer.raw > 0.85
    told = answer.features
    assert abs(told["log_size"]) > 0.1 if fault == "small" else np.hypot(told["right"], told["up"]) > 0.03
