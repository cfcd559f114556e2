"""Cosine of oriented gradients of placed cells."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.hog import describe, raw


def test_itself_is_one_and_another_character_is_far_below(cell) -> None:
    master = cell("regular-shu")
    assert raw(master, master).raw > 0.99
    assert raw(cell("regular-yue"), master).raw < 0.65


def test_a_turned_cell_has_a_turned_description(cell) -> None:
    master = cell("regular-tian")
    turned = type(master)(np.rot90(master.ink).copy(), np.rot90(master.density).copy())
    blocks = describe(master).reshape(7, 7, 2, 2, 9).sum(axis=(0, 1, 2, 3))
    # nine bins of 20 degrees: a quarter turn lies half-way between two bins
    there = describe(turned).reshape(7, 7, 2, 2, 9).sum(axis=(0, 1, 2, 3))
    assert there.argmax() != blocks.argmax()


@pytest.mark.parametrize("fault", ["shift", "angle", "thin", "thick", "squeeze", "missing", "extra", "lean"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-shu", fault)
    assert (np.diff(grades) < 0).all(), grades
