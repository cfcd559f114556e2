"""The control that sees the amount of ink and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.ink_ratio import raw


def square(side: int) -> np.ndarray:
    ink = np.zeros((SIDE, SIDE), bool)
    ink[50 : 50 + side, 50 : 50 + side] = True
    return ink


@pytest.mark.parametrize(("copy", "master"), [(40, 80), (80, 40)])
def test_a_quarter_of_the_ink_is_a_quarter_either_way(copy: int, master: int) -> None:
    answer = raw(cell_from(square(copy)), cell_from(square(master)))
    assert answer.raw == pytest.approx(0.25)
    assert answer.features["log_ratio"] == pytest.approx(np.log((copy / master) ** 2))


def test_a_mirrored_character_is_perfect_to_it(cell) -> None:
    master = cell("regular-shu")
    assert raw(cell_from(master.ink[:, ::-1].copy()), master).raw == 1.0


@pytest.mark.parametrize("fault", ["thin", "thick", "missing", "extra"])
def test_more_and_less_ink_cost(ladder, fault: str) -> None:
    assert (np.diff(ladder(raw, "regular-shu", fault)) < 0).all()
