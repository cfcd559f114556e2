"""Copies at four degrees: each further from the master than the one before, on any seed."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.errors import SurfaceError
from rumu.gallery.starter import find_work
from rumu_lab.simulation.copies import DEGREES, RECIPES, copy_at
from rumu_lab.simulation.faults import FAULTS


def master(work: str) -> np.ndarray:
    return np.asarray(Image.open(find_work(work).path).resize((192, 192), Image.Resampling.BOX)) < 128


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


@pytest.mark.parametrize("work", ["regular-tian", "clerical-shui", "seal-yue"])
def test_each_degree_is_further_from_the_master(work: str) -> None:
    mask = master(work)
    likeness = [
        float(np.mean([iou(copy_at(mask, degree, seed=seed).mask, mask) for seed in range(4)]))
        for degree in DEGREES
    ]
    assert likeness == sorted(likeness, reverse=True)
    assert likeness[0] > 0.8
    assert likeness[-1] < 0.5


def test_a_copy_says_what_was_done_to_it() -> None:
    copy = copy_at(master("regular-tian"), "bad", seed=5)
    assert [(f.fault, f.severity) for f in copy.faults] == list(RECIPES["bad"])
    assert all(f.description and f.description_zh for f in copy.faults)
    assert copy.degree == "bad"
    again = copy_at(master("regular-tian"), "bad", seed=5)
    np.testing.assert_array_equal(copy.ink, again.ink)


def test_a_single_stroke_is_cut_short_rather_than_left_out() -> None:
    bar = np.zeros((192, 192), dtype=bool)
    bar[90:102, 20:170] = True
    copy = copy_at(bar, "bad", seed=1)
    assert copy.mask.any()
    assert "missing" not in [fault.fault for fault in copy.faults]


def test_recipes_name_known_faults() -> None:
    assert {fault for recipe in RECIPES.values() for fault, _ in recipe} <= set(FAULTS)


def test_an_unknown_degree_is_refused() -> None:
    with pytest.raises(SurfaceError, match="excellent, good, medium, bad"):
        copy_at(master("regular-tian"), "perfect")  # type: ignore[arg-type]
