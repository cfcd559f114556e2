"""The IGLS-based grader: what it sees, what it does not, and its rules."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.igls import (
    BAD,
    EXCELLENT,
    GRADES,
    MEDIUM,
    IglsSettings,
    measure,
    quantise,
    raw,
    rules,
)


def bar(left: int, width: int) -> np.ndarray:
    ink = np.zeros((SIDE, SIDE), bool)
    ink[100:140, left : left + width] = True
    return ink


def test_itself_is_at_the_ceiling_and_other_characters_at_the_floor(cell) -> None:
    master = cell("regular-shu")
    assert raw(master, master).raw == pytest.approx(1.0)
    assert raw(cell("regular-yue"), master).raw < 0.3
    assert raw(cell("regular-shui"), master).raw < 0.5


def test_a_known_offset_and_a_known_size_have_known_scores() -> None:
    settings = IglsSettings()
    moved = measure(cell_from(bar(60 + 19, 80)), cell_from(bar(60, 80)), settings=settings)
    assert moved["centre"] == pytest.approx(1 - (19 / SIDE) / 0.15, abs=1e-6)
    assert moved["size"] == moved["projections"] == 1.0
    wide = measure(cell_from(bar(50, 100)), cell_from(bar(60, 80)), settings=settings)
    assert wide["size"] == pytest.approx(1 - np.log(100 / 80) / np.log(1.6), abs=1e-6)
    assert wide["centre"] == pytest.approx(1.0)


def test_the_earth_mover_s_distance_of_two_blocks_that_part() -> None:
    together, apart = bar(100, 56), bar(100, 56)
    apart[:, 128:] = np.roll(apart[:, 128:], 60, axis=1)
    score = measure(cell_from(apart), cell_from(together), settings=IglsSettings(projection=1.0))[
        "projections"
    ]
    # by SciPy, on places of one spread
    from scipy.stats import wasserstein_distance

    x, there = (np.nonzero(ink)[1] / SIDE for ink in (apart, together))
    x = (x - x.mean()) * there.std() / x.std()
    expected = wasserstein_distance(x, there - there.mean()) / 2  # none along y
    assert 1 - score == pytest.approx(expected, abs=0.004)


def test_there_are_27_rules_and_low_projections_are_never_above_medium() -> None:
    table = rules()
    assert set(table) == set(product(range(3), repeat=3))
    assert max(grade for levels, grade in table.items() if levels[2] == 0) == MEDIUM
    assert table[0, 0, 0] == BAD
    assert table[2, 2, 2] == EXCELLENT
    better = [
        table[tuple(level + (k == i) for k, level in enumerate(levels))] - grade
        for levels, grade in table.items()
        for i in range(3)
        if levels[i] < 2
    ]
    assert min(better) >= 0
    assert set(table.values()) == set(range(len(GRADES)))


def test_features_are_quantised_to_what_is_said() -> None:
    assert quantise(0.33, steps=5) == pytest.approx(0.4)
    assert quantise(0.33, steps=20) == pytest.approx(0.35)
    assert quantise(0.33, steps=0) == 0.33


@pytest.mark.parametrize("fault", ["off_centre", "small", "squeeze"])
def test_place_size_and_proportion_never_pay_and_cost_when_gross(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-shu", fault, severities=(0, 2, 3, 4, 5), seeds=(1,))
    assert (np.diff(grades) <= 0.01).all(), (
        grades
    )  # its rules forgive one middling feature; see its docstring
    assert grades[-1] < 0.8


@pytest.mark.parametrize("work", ["regular-tian", "clerical-tian"])
def test_a_missing_stroke_costs(ladder, work: str) -> None:
    assert max(ladder(raw, work, "missing")[1:]) < 0.8


def test_a_mirrored_character_of_one_projection_fools_it(cell) -> None:
    """What its users should know: it sees no stroke."""
    master = cell("regular-tian")
    both_ways = cell_from(master.ink | master.ink[:, ::-1])
    assert raw(cell_from(both_ways.ink[:, ::-1].copy()), both_ways).raw == pytest.approx(1.0)
