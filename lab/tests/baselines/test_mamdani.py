"""Fuzzy inference, against results worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import RegistrationError
from rumu_lab.baselines.mamdani import FuzzySystem, trapezoid

LOW, HIGH = (0.0, 0.0, 0.2, 0.6), (0.4, 0.8, 1.0, 1.0)
LEFT, RIGHT = (0.0, 0.0, 20.0, 40.0), (60.0, 80.0, 100.0, 100.0)


def both() -> FuzzySystem:
    rules = {(0, 0): 0, (0, 1): 0, (1, 0): 0, (1, 1): 1}
    return FuzzySystem((LOW, HIGH), (LEFT, RIGHT), rules)


def test_a_trapezoid_and_its_shoulders() -> None:
    x = np.array([0.0, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
    np.testing.assert_allclose(trapezoid(x, LOW), [1, 0.75, 0.5, 0.25, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(trapezoid(x, HIGH), [0, 0, 0, 0.25, 0.5, 1, 1], atol=1e-12)
    np.testing.assert_allclose(trapezoid(x, (0.3, 0.5, 0.5, 0.6)), [0, 0, 0.5, 1, 0, 0, 0], atol=1e-12)


def test_a_rule_holds_as_far_as_its_least_condition() -> None:
    np.testing.assert_allclose(both().strengths((1.0, 0.5)), [0.25, 0.25])
    np.testing.assert_allclose(both().strengths((0.9, 0.6)), [0.0, 0.5])


def test_the_centroid_of_one_uncut_set() -> None:
    # area 20 at 10 and a triangle of area 10 at 26 2/3
    assert both().infer((0.0, 0.0)) == pytest.approx((20 * 10 + 10 * (20 + 20 / 3)) / 30, abs=0.2)


def test_sets_cut_alike_on_both_sides_balance_in_the_middle() -> None:
    assert both().infer((0.5, 0.5)) == pytest.approx(50.0, abs=1e-6)


def test_no_rule_is_no_answer() -> None:
    with pytest.raises(RegistrationError, match="some rule"):
        FuzzySystem((LOW, HIGH), (LEFT, RIGHT), {(1, 1): 1}).infer((0.0, 0.0))
