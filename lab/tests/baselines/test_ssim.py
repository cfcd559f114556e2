"""Structural similarity of placed cells."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.ssim import raw


def test_itself_is_one_and_another_character_is_far_below(cell) -> None:
    master = cell("regular-shu")
    assert raw(master, master).raw > 0.97
    assert raw(cell("regular-yue"), master).raw < 0.75


@pytest.mark.parametrize("fault", ["shift", "angle", "thin", "thick", "squeeze", "extra", "blot"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-shu", fault)
    assert (np.diff(grades) < 0).all(), grades


def test_a_missing_stroke_costs(ladder) -> None:
    grades = ladder(raw, "regular-shu", "missing")
    assert max(grades[1:]) < 0.85, grades


def test_pale_ink_costs(cell) -> None:
    master = cell("regular-tian")
    pale = type(master)(master.ink, master.density * np.float32(0.5))
    assert raw(pale, master).raw < raw(master, master).raw - 0.02
