"""Iterative closest points on ink: position, height and stroke direction (Besl and McKay 1992).

Neighbours are sought in five dimensions, (x, y, z, w cos 2t, w sin 2t), so that a horizontal stroke is not
laid on a vertical one that happens to be near; the pose is that of the paper, rigid. Pairs run both ways,
which makes a stroke that the copy lacks count, and swapped roles give the inverse pose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rumu.errors import RegistrationError
from rumu.registration.quaternion import Pose, Rotation, closed_form_pose, rotation_matrix, unit_quaternion
from rumu.values import FloatArray, IntArray, PointSet, Registration

Search = Callable[[FloatArray], tuple[IntArray, FloatArray]]
"""(N, d) -> (N,) index of the nearest point, (N,) a lower bound of the distance to the second nearest."""

_SMALL_CLOUD = 512
"""Points of a cloud up to which all distances are computed."""
_MULTIPLICATIONS = 2**18
"""Of one matrix product of distances: OpenBLAS spreads larger ones over threads, which takes longer here."""
_FLOAT32_ERROR = 1e-5
"""Largest error of a distance computed in float32, in rms radii."""


@dataclass(frozen=True, slots=True)
class IcpSettings:
    """How points are laid on points.

    rotation: 'z' turns the sheet in its plane; 'full' also tilts it, for true 3-D scans.
    direction_weight: w, what opposite stroke directions are worth in rms radii.
    start_angles: degrees; the loop is run from each and the best is kept, since one start has a small basin
        of convergence.
    point_counts: about how many points the starts use, and the loop; a pose of three numbers needs no more.
        The distances of the result are measured on all points.
    start_iterations: how long each start may run before the best is chosen.
    start_overlap: share of the pairs that the starts rest on.
    max_rescalings: how often the size may be estimated anew from the pairs that are kept: a stroke left out
        changes the rms radius of what was written, and would shrink or grow the rest. The best fit is kept.
    min_rescaling: natural logarithm of a ratio of sizes below which the size is not changed any more.
    complete_overlap: share of kept pairs above which no stroke seems to be left out, so that the size stays
        as it was written.
    tolerance: tau; the loop stops when the error falls by less than tau * tr Sigma, the mean of both
        clouds. The error is a squared length, so it is the trace, not its root, that makes tau free of
        units.
    max_iterations: when reached, the result says that it did not converge.
    trim_power: lambda of trimmed ICP (Chetverikov et al. 2002); min_overlap: the least share kept.
    """

    rotation: Rotation = "z"
    direction_weight: float = 0.7
    start_angles: tuple[float, ...] = (-20.0, -10.0, 0.0, 10.0, 20.0)
    point_counts: tuple[int, int] = (300, 1200)
    start_iterations: int = 4
    start_overlap: float = 0.8
    max_rescalings: int = 5
    min_rescaling: float = 0.01
    complete_overlap: float = 0.93
    tolerance: float = 1e-5
    max_iterations: int = 40
    trim_power: float = 2.0
    min_overlap: float = 0.4

    def __post_init__(self) -> None:
        if self.rotation not in ("z", "full"):
            raise RegistrationError(f"rotation: expected 'z' or 'full', got {self.rotation!r}")
        if not self.start_angles:
            raise RegistrationError("expected at least one starting angle, got none")


class NearestPoint:
    """A cloud of points, (M, d), to be searched for the point nearest to each of others.

    small_steps: the same points will ask again and again, each time moved a little, as in ICP. Then the
    nearest of a point is kept while nothing else can have come nearer: all others were at least as far as
    the second, so as long as the nearest is nearer than that less what the point has moved since, it stays
    the nearest, and only the rest is searched again (Greenspan and Godin 2001).
    The nearest is exact to float32: of two points that are equally far to that precision either is given.
    Small clouds are searched by one matrix product, which takes the first of two that are equally far.
    """

    def __init__(self, points: FloatArray, *, small_steps: bool = False) -> None:
        self._points = np.ascontiguousarray(points)
        self._small_steps = small_steps and len(points) > _SMALL_CLOUD
        if len(points) <= _SMALL_CLOUD:
            self._search = all_distances(self._points)
        else:
            self._search = kd_tree(self._points, with_second=small_steps)
        self._asked: FloatArray | None = None

    def __call__(self, queries: FloatArray) -> tuple[FloatArray, IntArray]:
        """(N, d) points -> (N,) squared distances to the nearest, (N,) which one it is."""
        asked = self._asked
        if asked is None or len(asked) != len(queries):
            index, second = self._search(queries)
            if self._small_steps:
                self._asked, self._index, self._second = queries.copy(), index.copy(), second
            return _squared_lengths(queries - self._points.take(index, axis=0)), index
        moved = np.sqrt(_squared_lengths(queries - asked))
        squared = _squared_lengths(queries - self._points.take(self._index, axis=0))
        doubtful = np.flatnonzero(np.sqrt(squared) + moved > self._second)
        if len(doubtful):
            asked[doubtful] = again = queries.take(doubtful, axis=0)
            index, self._second[doubtful] = self._search(again)
            self._index[doubtful] = index
            squared[doubtful] = _squared_lengths(again - self._points.take(index, axis=0))
        return squared, self._index.copy()


def all_distances(points: FloatArray) -> Search:
    """A search for the nearest of `points`, (M, d), among all distances; it bounds the second by 0.

    |q - x|^2 / 2 less |q|^2 / 2 is |x|^2 / 2 - q . x: one product with a column of ones.
    """
    table = np.vstack([-points.T, 0.5 * _squared_lengths(points)]).astype(np.float32)
    d = points.shape[1]

    rows = max(_MULTIPLICATIONS // table.size, 1)

    def search(queries: FloatArray) -> tuple[IntArray, FloatArray]:
        with_one = np.ones((len(queries), d + 1), np.float32)
        with_one[:, :d] = queries
        nearest = np.empty(len(queries), np.intp)
        for k in range(0, len(queries), rows):
            (with_one[k : k + rows] @ table).argmin(axis=1, out=nearest[k : k + rows])
        return nearest, np.zeros(len(queries))

    return search


def kd_tree(points: FloatArray, *, with_second: bool) -> Search:
    """A search for the nearest of `points`, (M > 1, d), in a k-d tree; bounds the second where it is wanted.

    OpenCV's tree, because registration takes at least 1.6 times as long with SciPy's cKDTree, whether one
    thread searches it or two; `python benchmarks/registration.py` prints all three.
    """
    import cv2

    tree = cv2.flann.Index(  # type: ignore[attr-defined]
        np.ascontiguousarray(points, dtype=np.float32), {"algorithm": 4, "leaf_max_size": 15}
    )
    count = 2 if with_second else 1

    def search(queries: FloatArray) -> tuple[IntArray, FloatArray]:
        index, squared = tree.knnSearch(queries.astype(np.float32), count, params={"checks": -1})
        if count == 1:
            return index[:, 0].astype(np.intp), np.zeros(len(queries))
        return index[:, 0].astype(np.intp), np.sqrt(squared[:, 1]).astype(float) - _FLOAT32_ERROR

    return search


def _squared_lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ij,ij->i", vectors, vectors))


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Nearest neighbours both ways under one pose: squared distances in the five-dimensional space.

    forward: (N,) of each point of the probe to the reference, forward_index: (N,) to which of its points;
    backward: (M,) and backward_index: (M,) of each point of the reference to the probe.
    """

    forward: FloatArray
    forward_index: IntArray
    backward: FloatArray
    backward_index: IntArray

    @property
    def squared(self) -> FloatArray:
        """(N + M,) squared distances both ways."""
        return np.concatenate([self.forward, self.backward])

    def closest(self, overlap: float) -> IntArray:
        """Indices of the closest `overlap` share of the pairs, at least three, in no order."""
        squared = self.squared
        count = max(round(overlap * len(squared)), 3)
        if count >= len(squared):
            return np.arange(len(squared))
        return np.argpartition(squared, count - 1)[:count]


class Neighbours:
    """Both clouds in the matching space, each ready to be searched.

    A pose is an isometry of that space (positions turn by a, doubled directions by 2a), so the backward
    search moves the reference by the inverse pose instead of building the probe's tree anew.
    step: take every step-th point. small_steps: the poses asked for come one near the other.
    """

    def __init__(
        self, P: PointSet, X: PointSet, *, direction_weight: float, step: int = 1, small_steps: bool = False
    ) -> None:
        self.P, self.X = P.xyz[::step], X.xyz[::step]
        self._P_all, self._X_all = (_homogeneous(cloud, direction_weight, step) for cloud in (P, X))
        self._to_P, self._to_X = (
            NearestPoint(space[:, :5], small_steps=small_steps) for space in (self._P_all, self._X_all)
        )
        self._numbers = np.arange(max(len(self.P), len(self.X)))
        self.spread = (_spread(self.P) + _spread(self.X)) / 2

    def pairs(self, pose: Pose) -> Pairs:
        """The nearest point to each, both ways."""
        R = rotation_matrix(pose.quaternion)
        a = 2.0 * np.arctan2(R[1, 0], R[0, 0])
        there, back = np.zeros((6, 5)), np.zeros((6, 5))
        there[:3, :3] = R.T
        there[3:5, 3:] = (np.cos(a), np.sin(a)), (-np.sin(a), np.cos(a))
        there[5, :3] = pose.translation
        back[:5] = there[:5].T
        back[5] = -there[5] @ back[:5]
        return Pairs(*self._to_X(self._P_all @ there), *self._to_P(self._X_all @ back))

    def matched(self, pairs: Pairs, *, chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        """The chosen pairs of both ways as matched points (n, 3), (n, 3)."""
        P = np.concatenate([self._numbers[: len(self.P)], pairs.backward_index]).take(chosen)
        X = np.concatenate([pairs.forward_index, self._numbers[: len(self.X)]]).take(chosen)
        return self.P.take(P, axis=0), self.X.take(X, axis=0)


def _homogeneous(cloud: PointSet, direction_weight: float, step: int) -> FloatArray:
    """(n, 6): x, y, z, w cos 2t, w sin 2t, 1."""
    rows = np.ones((len(cloud.xyz[::step]), 6))
    rows[:, :3] = cloud.xyz[::step]
    rows[:, 3:5] = direction_weight * cloud.direction[::step]
    return rows


def _spread(cloud: FloatArray) -> float:
    """Trace of the covariance, tr Sigma."""
    centre = np.einsum("ij->j", cloud) / len(cloud)
    return float(np.vdot(cloud, cloud) / len(cloud) - centre @ centre)


def register_points(
    probe: PointSet, reference: PointSet, *, settings: IcpSettings | None = None
) -> Registration:
    """Lay the probe on the reference. Several starts, then the loop, then the loop on trimmed pairs.

    Raises RegistrationError for point sets that cannot be compared; not converging is a field.
    """
    settings = settings or IcpSettings()
    fits = []
    start = None
    for _ in range(settings.max_rescalings):
        fit = _fit_trimmed(probe, reference, start=start, settings=settings)
        fits.append((fit.psi, probe, fit))
        if fit.overlap > settings.complete_overlap or abs(np.log(fit.ratio)) < settings.min_rescaling:
            break
        # the same ink in a unit that makes it `ratio` times as large
        probe = replace(
            probe,
            xyz=probe.xyz * fit.ratio,
            radius=probe.radius / fit.ratio,
            pixel=probe.pixel * fit.ratio,
        )
        start = fit.result.pose
    _, probe, best = min(fits, key=lambda fit: fit[0])
    pairs = best.pairs
    if pairs is None:
        every = Neighbours(probe, reference, direction_weight=settings.direction_weight)
        pairs = every.pairs(best.result.pose)
    return _registration(probe, reference, result=best.result, pairs=pairs, overlap=best.overlap)


@dataclass(frozen=True, slots=True, eq=False)
class _TrimmedFit:
    """A pose with the share of pairs it rests on, how good that is, and the size those pairs ask for.

    pairs: all pairs under that pose, when all points took part; else None.
    """

    result: IcpResult
    overlap: float
    psi: float
    ratio: float
    pairs: Pairs | None


def _fit_trimmed(
    probe: PointSet, reference: PointSet, *, start: Pose | None, settings: IcpSettings
) -> _TrimmedFit:
    longer = max(len(probe.xyz), len(reference.xyz))  # of both, so that swapped roles rest on the same points
    steps = [max(longer // count, 1) for count in settings.point_counts]
    weight = settings.direction_weight
    coarse, loop = (
        Neighbours(probe, reference, direction_weight=weight, step=step, small_steps=step == steps[-1])
        for step in steps
    )
    starts = [] if start is None else [start]
    if start is None:
        for half in np.deg2rad(settings.start_angles) / 2:
            turn = unit_quaternion(np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))
            starts.append(Pose(turn, np.zeros(3), np.inf))
    run = partial(closest_points, coarse, overlap=settings.start_overlap, settings=settings)
    best = min(
        (run(start=pose, limit=settings.start_iterations) for pose in starts),
        key=lambda result: result.error,
    )
    overlap, _ = trimmed_share(loop.pairs(best.pose).squared, settings=settings)
    result = closest_points(loop, start=best.pose, overlap=overlap, settings=settings)
    pairs = loop.pairs(result.pose)
    overlap, psi = trimmed_share(pairs.squared, settings=settings)
    P, X = (
        _spread(np.ascontiguousarray(side[:, :2]))
        for side in loop.matched(pairs, chosen=pairs.closest(overlap))
    )
    return _TrimmedFit(result, overlap, psi, float(np.sqrt(X / P)), pairs if steps[-1] == 1 else None)


@dataclass(frozen=True, slots=True, eq=False)
class IcpResult:
    """Where the loop ended. error: mean squared distance of the pairs it kept, before its last pose."""

    pose: Pose
    error: float
    converged: bool
    iterations: int


def closest_points(
    neighbours: Neighbours, *, start: Pose, overlap: float, settings: IcpSettings, limit: int | None = None
) -> IcpResult:
    """Eq. (25): Y = closest points, (q, d_ms) = Q(P, Y), again until d_ms stops falling.

    Of the pairs, both ways, only the closest `overlap` share moves the pose.
    """
    threshold = settings.tolerance * neighbours.spread  # of both, so that swapped roles stop alike
    pose, best, last = start, start, np.inf
    limit = limit or settings.max_iterations
    for iteration in range(limit):
        pairs = neighbours.pairs(pose)
        chosen = pairs.closest(overlap)
        error = float(pairs.squared.take(chosen).mean())
        if last - error < threshold:
            return IcpResult(pose if error < last else best, min(error, last), True, iteration)
        last, best = error, pose
        P, X = neighbours.matched(pairs, chosen=chosen)
        pose = closed_form_pose(P, X, rotation=settings.rotation)
    return IcpResult(best, last, False, limit)


def trimmed_share(squared: FloatArray, *, settings: IcpSettings) -> tuple[float, float]:
    """Share xi of pairs that minimises psi = e(xi) xi^-(1 + lambda), and psi; e the mean of the least xi N.

    squared: (N,) squared distances. All shares are tried at once from the sorted sums, so no search is
    needed. Source: Chetverikov et al. 2002.
    """
    n = len(squared)
    share = np.arange(1, n + 1) / n
    e = np.cumsum(np.sort(squared)) / np.arange(1, n + 1)
    psi = np.where(share >= settings.min_overlap, e * share ** -(1.0 + settings.trim_power), np.inf)
    best = n - 1 if e[-1] < 1e-12 else int(np.argmin(psi))
    return float(share[best]), float(psi[best])


def _registration(
    probe: PointSet, reference: PointSet, *, result: IcpResult, pairs: Pairs, overlap: float
) -> Registration:
    T = result.pose.matrix
    residual = probe.xyz @ T[:3, :3].T + T[:3, 3] - reference.xyz[pairs.forward_index]
    # where the reference's centroid lies in the probe's cell, so that a lost stroke does not count as shift
    origin = -(T[:3, :3].T @ T[:3, 3])[:2]
    return Registration(
        probe=probe,
        reference=reference,
        T_reference_probe=T,
        scale=probe.radius / reference.radius,
        angle=float(np.rad2deg(np.arctan2(T[1, 0], T[0, 0]))),
        shift=probe.centre - reference.centre + origin * probe.radius,
        overlap=overlap,
        d_ms=float(np.mean(np.sum(residual * residual, axis=1))),
        forward=np.sqrt(pairs.forward),
        forward_index=pairs.forward_index,
        backward=np.sqrt(pairs.backward),
        backward_index=pairs.backward_index,
        converged=result.converged,
        iterations=result.iterations,
    )


def pose_probe(registration: Registration) -> FloatArray:
    """(N, 3) float64, the probe's points laid on the reference."""
    T = registration.T_reference_probe
    return np.asarray(registration.probe.xyz @ T[:3, :3].T + T[:3, 3])
