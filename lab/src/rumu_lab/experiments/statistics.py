"""Intervals, tests and rank statistics, each a few lines above scipy.

A cluster is what is drawn as a whole when one asks how a figure would come out elsewhere: a character for
human marks, a work for simulated copies. Copies of one character are no independent witnesses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from rumu.errors import CalibrationError
from rumu.values import FloatArray

Labels = Sequence[Any] | np.ndarray


def clopper_pearson(right: int, total: int, *, confidence: float = 0.95) -> tuple[float, float]:
    """Exact interval of a share, (low, high) in [0, 1]. Raises CalibrationError for an empty total."""
    from scipy.stats import beta

    if not 0 <= right <= total or total == 0:
        raise CalibrationError(f"expected 0 <= right <= total and total > 0, got {right} of {total}")
    tail = (1.0 - confidence) / 2
    low = 0.0 if right == 0 else float(beta.ppf(tail, right, total - right + 1))
    high = 1.0 if right == total else float(beta.ppf(1 - tail, right + 1, total - right))
    return low, high


def weighted_kappa(truth: Sequence[int], given: Sequence[int], *, levels: int) -> float:
    """Quadratic weighted kappa of two gradings into 0 .. levels - 1; NaN where both use a single level."""
    seen = np.zeros((levels, levels))
    np.add.at(seen, (np.asarray(truth), np.asarray(given)), 1.0)
    apart = np.subtract.outer(np.arange(levels), np.arange(levels)) ** 2.0
    chance = np.outer(seen.sum(axis=1), seen.sum(axis=0)) / seen.sum()
    expected = float((apart * chance).sum())
    return float("nan") if expected == 0 else 1.0 - float((apart * seen).sum()) / expected


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
    """p values corrected for their number (Holm 1979), in the order they came."""
    order = np.argsort(p)
    worst, corrected = 0.0, [0.0] * len(p)
    for rank, k in enumerate(order):
        worst = max(worst, min(1.0, (len(p) - rank) * float(p[k])))
        corrected[int(k)] = worst
    return corrected


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
    told = np.sign(np.asarray(truth)[i] - np.asarray(truth)[j])
    said = np.sign(np.asarray(given)[i] - np.asarray(given)[j])
    real = told != 0
    if not real.any():
        return 0.5
    return float(np.mean(0.5 + 0.5 * (told * said)[real]))


def violations(falling: FloatArray) -> float:
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
