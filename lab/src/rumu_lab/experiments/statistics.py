"""Intervals, tests and rank statistics, each a few lines above scipy or statsmodels.

A cluster is what is drawn as a whole when one asks how a figure would come out elsewhere: a character for
human marks, a work for simulated copies. Copies of one character are no independent witnesses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from rumu.values import FloatArray, IntArray

Labels = Sequence[Any] | np.ndarray


def exact_interval(right: int, total: int) -> tuple[float, float]:
    """Clopper and Pearson's 95 % interval of a share, in [0, 1]; total: 1 or more."""
    from scipy.stats import binomtest

    interval = binomtest(right, total).proportion_ci(method="exact")
    return float(interval.low), float(interval.high)


def weighted_kappa(truth: Sequence[int], given: Sequence[int], *, levels: int) -> float:
    """Quadratic weighted kappa of two gradings into 0 .. levels - 1; NaN where both use a single level."""
    from statsmodels.stats.inter_rater import cohens_kappa

    if len({*truth, *given}) == 1:
        return float("nan")
    seen = np.zeros((levels, levels))
    np.add.at(seen, (np.asarray(truth), np.asarray(given)), 1.0)
    kappa = float(cohens_kappa(seen, wt="quadratic", return_results=False))
    return round(kappa, 12)  # its last digits depend on the order of the sums, and .1875 would print as .187


def quick_kappa(truth: IntArray, given: IntArray) -> float:
    """The same in closed form, 2 cov / (var + var + difference of means squared); 0 where it has none."""
    a, b = np.asarray(truth, float), np.asarray(given, float)
    apart = a.var() + b.var() + (a.mean() - b.mean()) ** 2
    return float(2.0 * ((a - a.mean()) * (b - b.mean())).mean() / apart) if apart > 0 else 0.0


def level_numbers(scores: FloatArray, cuts: Sequence[float]) -> IntArray:
    """(N,) 0 for scores below all cut-offs, which rise, 1 from the first on, and so forth."""
    return np.asarray(np.searchsorted(np.asarray(cuts), scores, side="right"))


def choose_cuts(scores: FloatArray, truth: IntArray, *, least_share: float = 0.05) -> tuple[float, ...]:
    """Rising cut-offs, whole points, at which levels of the scores agree best with the true ones, 0 to 3.

    least_share: of the scores in each level, so that all are in use. Starts where the shares are those of
    the true levels and moves one cut-off at a time while quadratic weighted kappa grows.
    """
    shares = np.cumsum(np.bincount(truth, minlength=4))[:3] / len(truth)
    cuts = [float(np.round(v)) for v in np.quantile(scores, shares)]
    best = quick_kappa(truth, level_numbers(scores, cuts))
    moved = True
    while moved:
        moved = False
        for k, step in product(range(3), (-2.0, -1.0, 1.0, 2.0)):
            tried = [*cuts[:k], cuts[k] + step, *cuts[k + 1 :]]
            levels = level_numbers(scores, tried)
            if np.bincount(levels, minlength=4).min() < least_share * len(scores) or tried != sorted(tried):
                continue
            kappa = quick_kappa(truth, levels)
            if kappa > best:
                best, cuts, moved = kappa, tried, True
    return tuple(cuts)


def cluster_interval(
    values: FloatArray, clusters: Labels, *, resamples: int, seed: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Bootstrap interval of the mean of (N,) values when whole clusters are drawn with replacement."""
    names, index = np.unique(np.asarray(clusters), return_inverse=True)
    sums = np.bincount(index, weights=np.asarray(values, float))
    counts = np.bincount(index)
    k = len(names)
    drawn = np.random.default_rng(seed).multinomial(k, np.full(k, 1.0 / k), size=resamples)
    means = (drawn @ sums) / (drawn @ counts)
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(means, (tail, 100.0 - tail))
    return float(low), float(high)


def cluster_means(values: FloatArray, clusters: Labels) -> FloatArray:
    """(K,) mean of the values of each cluster, in the order of the clusters' names."""
    _, index = np.unique(np.asarray(clusters), return_inverse=True)
    return np.asarray(np.bincount(index, weights=np.asarray(values, float)) / np.bincount(index))


def paired_p(first: FloatArray, second: FloatArray) -> float:
    """Two-sided p of the Wilcoxon signed rank test on pairs; 1 where they do not differ at all."""
    from scipy.stats import wilcoxon

    difference = np.asarray(first) - np.asarray(second)
    return 1.0 if not np.any(difference) else float(wilcoxon(difference).pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """The p values corrected for their number (Holm 1979), in the order they came."""
    from statsmodels.stats.multitest import multipletests

    return [float(value) for value in multipletests(p, method="holm")[1]] if p else []


def spearman(a: FloatArray, b: FloatArray) -> float:
    """Rank correlation; 0 where either is constant, since it then orders nothing."""
    from scipy.stats import spearmanr

    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return 0.0
    return float(spearmanr(a, b)[0])


def kendall(a: FloatArray, b: FloatArray) -> float:
    """Kendall's tau-b; 0 where either is constant."""
    from scipy.stats import kendalltau

    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return 0.0
    return float(kendalltau(a, b)[0])


def order_accuracy(given: FloatArray, truth: FloatArray) -> float:
    """Share of the pairs with different truth that are ordered rightly; a tie counts half."""
    i, j = np.triu_indices(len(truth), k=1)
    expected = np.sign(np.asarray(truth)[i] - np.asarray(truth)[j])
    actual = np.sign(np.asarray(given)[i] - np.asarray(given)[j])
    different = expected != 0
    if not different.any():
        return 0.5
    return float(np.mean(0.5 + 0.5 * (expected * actual)[different]))


def rising_steps(falling: FloatArray) -> float:
    """Share of the steps of a series, which should fall, that rise instead."""
    return float(np.mean(np.diff(falling) > 0))


def within(
    statistic: Callable[[FloatArray, FloatArray], float],
    given: FloatArray,
    truth: FloatArray,
    clusters: Labels,
    *,
    fewest: int = 2,
) -> dict[str, float]:
    """Cluster -> statistic(given, truth) of its members, for clusters of at least `fewest`."""
    labels = np.asarray(clusters)
    found = {}
    for name in np.unique(labels):
        own = labels == name
        if np.count_nonzero(own) >= fewest:
            found[str(name)] = statistic(given[own], truth[own])
    return found
