"""Distances between outlines, where they are known."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE
from rumu_lab.baselines.hausdorff import directed_distance, outline, raw


def square(left: int) -> np.ndarray:
    ink = np.zeros((SIDE, SIDE), bool)
    ink[80:140, left : left + 60] = True
    return ink


def test_an_outline_is_one_pixel_wide_and_closed_at_the_border() -> None:
    assert np.count_nonzero(outline(square(60))) == 4 * 59
    assert np.count_nonzero(outline(np.ones((10, 10), bool))) == 4 * 9


def test_a_moved_square_is_as_far_as_it_was_moved() -> None:
    assert directed_distance(square(60), square(72)) == pytest.approx(12.0)


def test_one_stray_pixel_does_not_count() -> None:
    stray = square(60)
    stray[10, 10] = True
    assert directed_distance(stray, square(60)) == 0.0


def test_missing_ink_shows_backward_and_strange_ink_forward(cell) -> None:
    master = cell("regular-tian")
    lost = raw(cell("regular-tian", "missing", 3), master).features
    assert lost["backward"] > lost["forward"]
    more = raw(master, cell("regular-tian", "missing", 3)).features
    assert more["forward"] > more["backward"]


def test_itself_is_one_and_another_character_is_far_below(cell) -> None:
    master = cell("regular-shu")
    assert raw(master, master).raw > 0.95
    assert raw(cell("regular-yue"), master).raw < 0.6


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault: str) -> None:
    assert max(ladder(raw, "regular-tian", fault)[1:]) < 0.3


@pytest.mark.parametrize("fault", ["shift", "angle", "thick", "squeeze"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-tian", fault)
    assert (np.diff(grades) < 0).all(), grades
