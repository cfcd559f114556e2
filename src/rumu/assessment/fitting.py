"""Marks -> a calibration: weights from a panel's marks, anchored on the scale from 0 to 100."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from rumu.assessment.calibration import Scale
from rumu.assessment.features import FEATURE_GROUPS, FEATURE_NAMES, SIGNED_FEATURES, Features, Residuals
from rumu.errors import CalibrationError
from rumu.values import BoolArray, FloatArray

Evidence = Mapping[str, float]
"""Groups of features that a scale rests on, each with its shrinkage, in units of one standardised copy."""

WHOLE: Evidence = {"form": 200.0, "edge": 500.0, "outline": 200.0, "fullness": 200.0}
"""What the mark rests on; how it was chosen is in `rumu experiments run nested`."""
PARTS: Mapping[str, Evidence] = {
    "structure": {"plane": 500.0, "form": 200.0},
    "brushwork": {"height": 500.0, "direction": 500.0, "edge": 500.0, "outline": 200.0},
}
"""What each part of the mark rests on."""
FEWEST = 8
"""Copies of one master from which their mean is trusted."""
OTHER_CHARACTER = 10.0
"""Score at which the middle one of other characters' copies is anchored."""
HUMAN_RANGE = (30.0, 80.0)
"""Between these the scale is the panel's own; beyond, it is stretched to reach the anchors."""


def fit_scale(
    vectors: FloatArray,
    marks: FloatArray,
    groups: Sequence[str],
    *,
    names: tuple[str, ...],
    shrinkage: float | Sequence[float] = 500.0,
) -> Scale:
    """Weights from what differs within a master's copies, with what differs between masters as noise.

    vectors: (N, len(FEATURE_NAMES)); marks: (N,) 0-100; groups: (N,) the master of each; names: what to use.
    Copies of one master differ in how well they are written; how they differ on the whole from another
    master's copies says more of the master, so a weight pays for the scatter of the masters' means. Ridge,
    with weights that are not positive except for SIGNED_FEATURES ones.
    shrinkage: of all features, or one for each of the names; strong, since characters are few.
    Raises CalibrationError for fewer than 20 marks.
    """
    if len(marks) < 20:
        raise CalibrationError(f"expected at least 20 marks to fit a scale, got {len(marks)}")
    chosen = vectors[:, [FEATURE_NAMES.index(name) for name in names]]
    centre, spread = chosen.mean(axis=0), np.maximum(chosen.std(axis=0), 1e-9)
    z = (chosen - centre) / spread
    within, left = _subtract_group_means(z, groups), _subtract_group_means(np.asarray(marks, float), groups)
    n = len(marks)
    normal = within.T @ within / n + _scatter(z, groups) + np.diag(np.broadcast_to(shrinkage, len(names)) / n)
    weights = _signed_least_squares(normal, within.T @ left / n, free=np.isin(names, SIGNED_FEATURES))
    numbers = [tuple(map(float, values)) for values in (centre, spread, weights)]
    return Scale(names, numbers[0], numbers[1], numbers[2], mean=float(np.mean(marks)))


def fit_evidence(
    vectors: FloatArray, marks: FloatArray, groups: Sequence[str], *, evidence: Evidence
) -> Scale:
    """`fit_scale` on groups of features, each with its own shrinkage."""
    names = names_of(evidence)
    shrinkage = [evidence[group] for group in evidence for _ in FEATURE_GROUPS[group]]
    return fit_scale(vectors, marks, groups, names=names, shrinkage=shrinkage)


def names_of(evidence: Evidence) -> tuple[str, ...]:
    """The features of all its groups."""
    return tuple(name for group in evidence for name in FEATURE_GROUPS[group])


def _scatter(z: FloatArray, groups: Sequence[str]) -> FloatArray:
    """(K, K) covariance of the groups' means, of the groups that are large enough to have one."""
    own = [np.array([g == group for g in groups]) for group in sorted(set(groups))]
    means = np.array([z[mine].mean(axis=0) for mine in own if np.count_nonzero(mine) >= FEWEST])
    if len(means) < 2:
        return np.zeros((z.shape[1], z.shape[1]))
    return np.asarray(np.cov(means, rowvar=False))


def _signed_least_squares(normal: FloatArray, right: FloatArray, *, free: BoolArray) -> FloatArray:
    """Least w' N w / 2 - w' r with w <= 0 where not free, as nonnegative least squares on the root of N."""
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls

    root = cholesky(normal)  # upper: N = root' root
    target = solve_triangular(root, right, trans="T")
    parts, _ = nnls(np.hstack([-root, root[:, free]]), target, maxiter=100 * len(normal))
    weights = -parts[: len(normal)]
    weights[free] += parts[len(normal) :]
    return np.asarray(weights)


def _subtract_group_means(values: FloatArray, groups: Sequence[str]) -> FloatArray:
    """(N, ...) values less the mean of their group."""
    left = values.copy()
    for group in set(groups):
        own = np.array([g == group for g in groups])
        left[own] -= left[own].mean(axis=0)
    return left


def anchor_scale(
    scale: Scale,
    *,
    others: Sequence[Features] | None = None,
    reach: tuple[float, float] = HUMAN_RANGE,
) -> Scale:
    """A scale that is the marks' own within `reach`, stretched above it to reach 100 for a perfect copy.

    reach: the marks that are common enough to trust. others: features of other characters; with them the
        scale is stretched below `reach` too, so that the middle one reads OTHER_CHARACTER. A part alone
        cannot tell characters apart, so it goes without.
    Raises CalibrationError when the anchors would not rise.
    """
    low, high = reach
    nothing = 0.0
    if others:
        wrong = float(np.median([scale.weighted_sum(features.vector()) for features in others]))
        nothing = wrong - OTHER_CHARACTER * (low - wrong) / (low - OTHER_CHARACTER)
    perfect = scale.weighted_sum(Features(Residuals(), lean=0.0, offset=0.0, size=0.0, weight=0.0).vector())
    if not nothing < low < high < perfect:
        raise CalibrationError(f"expected anchors that rise, got {nothing}, {low}, {high}, {perfect}")
    return replace(scale, anchors=((nothing, 0.0), (low, low), (high, high), (perfect, 100.0)))
