"""Instructions name the fault that was made."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import cell_from
from rumu_lab.baselines.igls_instructions import instructions


def test_a_perfect_copy_gets_none(cell) -> None:
    assert instructions(cell("regular-shu"), cell("regular-shu")) == ()


@pytest.mark.parametrize(
    ("shift", "zh", "en"),
    [
        ((20.0, 0.0), "重心偏右 8%，往左寫。", "further left"),
        ((-20.0, 0.0), "重心偏左 8%，往右寫。", "further right"),
        ((0.0, 20.0), "重心偏下 8%，往上寫。", "further up"),
        ((0.0, -20.0), "重心偏上 8%，往下寫。", "further down"),
    ],
)
def test_a_shift_is_told_back(cell, moved, shift, zh: str, en: str) -> None:
    (one,) = instructions(moved("regular-tian", shift=shift), cell("regular-tian"))
    assert one.feature == "centre"
    assert one.zh == zh
    assert en in one.en


@pytest.mark.parametrize(("scale", "words"), [(0.8, ("太窄", "太矮")), (1.15, ("太寬", "太高"))])
def test_a_wrong_size_is_told_back_both_ways(cell, moved, scale: float, words) -> None:
    found = [
        i
        for i in instructions(moved("regular-tian", scale=scale), cell("regular-tian"))
        if i.feature == "size"
    ]
    assert len(found) == 2
    for instruction, word in zip(found, words, strict=True):
        assert word in instruction.zh
        assert instruction.amount == pytest.approx(scale - 1, abs=0.03)


@pytest.mark.parametrize(("side", "place"), [(0, "左邊"), (1, "右邊")])
def test_a_heavy_side_is_told_back(cell, side: int, place: str) -> None:
    master = cell("regular-shu")
    ink = master.ink.copy()
    rows, columns = np.nonzero(ink)
    third = np.ptp(columns) // 4
    where = (
        slice(columns.min(), columns.min() + third)
        if side == 0
        else slice(columns.max() - third, columns.max())
    )
    ink[rows.min() : rows.max(), where] = True
    told = [i for i in instructions(cell_from(ink), master) if i.feature == "projections"]
    assert any(place in i.zh and "太密" in i.zh for i in told), told
