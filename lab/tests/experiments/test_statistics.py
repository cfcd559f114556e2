"""Each statistic against a figure from the literature, another implementation, or what must follow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import beta

from rumu_lab.experiments import statistics as s


@pytest.mark.parametrize(("right", "total"), [(6, 6), (5, 6), (29, 30), (0, 9), (17, 40)])
def test_exact_intervals_are_quantiles_of_the_beta_distribution(right, total):
    low, high = s.exact_interval(right, total)
    assert low == pytest.approx(beta.ppf(0.025, right, total - right + 1) if right else 0.0)
    assert high == pytest.approx(beta.ppf(0.975, right + 1, total - right) if right < total else 1.0)


def test_kappa():
    assert s.weighted_kappa([0, 1, 2, 3], [0, 1, 2, 3], levels=4) == 1.0
    assert s.weighted_kappa([0, 1, 2, 3], [3, 2, 1, 0], levels=4) == -1.0
    assert s.weighted_kappa([0, 0, 3, 3], [0, 3, 0, 3], levels=4) == 0.0
    near = s.weighted_kappa([0, 1, 2, 3, 0, 1, 2, 3], [1, 1, 2, 2, 0, 2, 3, 3], levels=4)
    far = s.weighted_kappa([0, 1, 2, 3, 0, 1, 2, 3], [3, 1, 2, 0, 0, 2, 3, 3], levels=4)
    assert far < near < 1
    assert np.isnan(s.weighted_kappa([2, 2], [2, 2], levels=4))


def test_quick_kappa_is_kappa():
    rng = np.random.default_rng(0)
    truth = rng.integers(0, 4, 60)
    given = np.clip(truth + rng.integers(-1, 2, 60), 0, 3)
    assert s.quick_kappa(truth, given) == pytest.approx(s.weighted_kappa(truth, given, levels=4))
    assert s.quick_kappa(np.ones(3, int), np.ones(3, int)) == 0.0


def test_cuts_are_where_levels_agree_and_leave_no_level_empty():
    rng = np.random.default_rng(1)
    truth = np.repeat([0, 1, 2, 3], (30, 80, 60, 30))
    scores = 40.0 + 8.0 * truth + rng.normal(0, 2.0, len(truth))
    cuts = s.choose_cuts(scores, truth)
    np.testing.assert_allclose(cuts, (44, 52, 60), atol=2)
    unsure = np.full(len(truth), 50.0) + rng.normal(0, 3.0, len(truth))
    shares = np.bincount(s.level_numbers(unsure, s.choose_cuts(unsure, truth)), minlength=4) / len(truth)
    assert shares.min() >= 0.05
    np.testing.assert_array_equal(s.level_numbers(np.array([43.9, 44.0, 99.0]), (44, 52, 60)), (0, 1, 3))


def test_whole_clusters_are_drawn():
    """Two clusters that differ: single values would be a hundred witnesses, clusters are only two."""
    values = np.repeat([0.0, 1.0], 50)
    assert s.cluster_interval(values, np.repeat(["a", "b"], 50), resamples=500, seed=1) == (0.0, 1.0)
    low, high = s.cluster_interval(values, np.arange(100), resamples=500, seed=1)
    assert 0.35 < low < 0.45 and 0.55 < high < 0.65


def test_holm():
    assert s.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert s.holm([0.9, 0.8]) == pytest.approx([1.0, 1.0])
    assert s.holm([]) == []


def test_pairs_that_do_not_differ():
    assert s.paired_p(np.ones(9), np.ones(9)) == 1.0
    assert s.paired_p(np.arange(9.0), np.arange(9.0) + 1.0) < 0.01


def test_ranks():
    marks = np.array([10.0, 20.0, 20.0, 40.0])
    assert s.order_accuracy(marks, marks) == 1.0
    assert s.order_accuracy(-marks, marks) == 0.0
    assert s.order_accuracy(np.zeros(4), marks) == 0.5
    assert s.spearman(np.zeros(4), marks) == 0.0 == s.kendall(np.zeros(4), marks)
    assert s.rising_steps(np.array([5.0, 4.0, 4.5, 3.0, 3.0])) == 0.25


def test_within_leaves_small_clusters_out():
    given, truth = np.array([1.0, 2.0, 3.0, 9.0]), np.array([1.0, 2.0, 3.0, 0.0])
    assert s.within(s.spearman, given, truth, ["a", "a", "a", "b"], fewest=3) == {"a": pytest.approx(1.0)}
