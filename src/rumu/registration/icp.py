"""Iterative closest points on ink: position, height and stroke direction (Besl and McKay 1992).

Neighbours are sought in five dimensions, (x, y, z, w cos 2t, w sin 2t), so that a horizontal stroke is not
laid on a vertical one that happens to be near; the pose is that of the paper, rigid. Pairs run both ways,
which makes a stroke that the copy lacks count, and swapped roles give the inverse pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.errors import RegistrationError
from rumu.registration.nearest import Nearest
from rumu.registration.quaternion import Pose, Rotation, closed_form_pose, rotation_matrix, unit_quaternion
from rumu.values import FloatArray, IntArray, PointSet, Registration


@dataclass(frozen=True, slots=True)
class IcpSettings:
    """How points are laid on points.

    rotation: 'z' turns the sheet in its plane; 'full' also tilts it, for true 3-D scans.
    direction_weight: w, what opposite stroke directions are worth in rms radii.
    starts: degrees; the loop is run from each and the best is kept, since one start has a small basin of
        convergence.
    thinning: about how many points the starts use, and the loop; a pose of three numbers needs no more.
        What is left between copy and master is measured on all.
    tolerance: tau; the loop stops when the error falls by less than tau * tr Sigma, the mean of both
        clouds. The error is a squared length, so it is the trace, not its root, that makes tau free of
        units.
    start_iterations: how long each start may run before the best is chosen.
    start_overlap: share of the pairs that the starts rest on.
    scalings: how often the size may be taken anew from the pairs that are kept: a stroke left out changes
        the rms radius of what was written, and would shrink or grow the rest. The best fit is kept.
    same_size: natural logarithm of size below which it is settled; whole: share of kept pairs above which
        nothing seems to be left out, so that the size stands as it was written.
    max_iterations: when reached, the result says that it did not converge.
    trim_power: lambda of trimmed ICP (Chetverikov et al. 2002); min_overlap: the least share kept.
    """

    rotation: Rotation = "z"
    direction_weight: float = 0.7
    starts: tuple[float, ...] = (-20.0, -10.0, 0.0, 10.0, 20.0)
    thinning: tuple[int, int] = (300, 1200)
    start_iterations: int = 4
    start_overlap: float = 0.8
    scalings: int = 5
    same_size: float = 0.01
    whole: float = 0.93
    tolerance: float = 1e-5
    max_iterations: int = 40
    trim_power: float = 2.0
    min_overlap: float = 0.4

    def __post_init__(self) -> None:
        if self.rotation not in ("z", "full"):
            raise RegistrationError(f"rotation: expected 'z' or 'full', got {self.rotation!r}")
        if not self.starts:
            raise RegistrationError("expected at least one starting angle, got none")


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
        return np.concatenate([self.forward, self.backward])


class Neighbours:
    """Both clouds in the matching space, each ready to be searched.

    A pose is an isometry of that space (positions turn by a, doubled directions by 2a), so the backward
    search moves the reference by the inverse pose instead of building the probe's tree anew.
    step: take every step-th point. follows: the poses asked for come one near the other.
    """

    def __init__(
        self, P: PointSet, X: PointSet, *, direction_weight: float, step: int = 1, follows: bool = False
    ) -> None:
        self.P, self.X = P.xyz[::step], X.xyz[::step]
        self._P_all, self._X_all = (_homogeneous(cloud, direction_weight, step) for cloud in (P, X))
        self._to_P, self._to_X = (
            Nearest(space[:, :5], follows=follows) for space in (self._P_all, self._X_all)
        )
        self._own = np.arange(max(len(self.P), len(self.X)))
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

    def matched(self, pairs: Pairs, *, kept: IntArray) -> tuple[FloatArray, FloatArray]:
        """The kept of the pairs, both ways, as matched points (n, 3), (n, 3)."""
        P = np.concatenate([self._own[: len(self.P)], pairs.backward_index]).take(kept)
        X = np.concatenate([pairs.forward_index, self._own[: len(self.X)]]).take(kept)
        return self.P.take(P, axis=0), self.X.take(X, axis=0)


def _homogeneous(cloud: PointSet, direction_weight: float, step: int) -> FloatArray:
    """(n, 6): x, y, z, w cos 2t, w sin 2t, 1."""
    rows = np.ones((len(cloud.xyz[::step]), 6))
    rows[:, :3] = cloud.xyz[::step]
    rows[:, 3:5] = direction_weight * cloud.direction[::step]
    return rows


def _spread(cloud: FloatArray) -> float:
    """tr Sigma."""
    centre = np.einsum("ij->j", cloud) / len(cloud)
    return float(np.vdot(cloud, cloud) / len(cloud) - centre @ centre)


def closest(squared: FloatArray, overlap: float) -> IntArray:
    """Indices of the closest `overlap` share of the pairs, at least three, in no order."""
    count = max(round(overlap * len(squared)), 3)
    if count >= len(squared):
        return np.arange(len(squared))
    return np.argpartition(squared, count - 1)[:count]


def register_points(
    probe: PointSet, reference: PointSet, *, settings: IcpSettings | None = None
) -> Registration:
    """Lay the probe on the reference. Several starts, then the loop, then the loop on trimmed pairs.

    Raises RegistrationError for point sets that cannot be compared; not converging is a field.
    """
    settings = settings or IcpSettings()
    candidates = []
    start = None
    for _ in range(settings.scalings):
        candidate = _trimmed_fit(probe, reference, start=start, settings=settings)
        candidates.append((candidate.psi, probe, candidate))
        if candidate.overlap > settings.whole or abs(np.log(candidate.ratio)) < settings.same_size:
            break
        probe, start = _resized(probe, candidate.ratio), candidate.found.pose
    _, probe, best = min(candidates, key=lambda c: c[0])
    pairs = best.pairs
    if pairs is None:
        every = Neighbours(probe, reference, direction_weight=settings.direction_weight)
        pairs = every.pairs(best.found.pose)
    return _registration(probe, reference, found=best.found, pairs=pairs, overlap=best.overlap)


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """A pose with the share of pairs it rests on, how good that is, and the size those pairs ask for.

    pairs: what is left under that pose, when all points took part; else None.
    """

    found: Outcome
    overlap: float
    psi: float
    ratio: float
    pairs: Pairs | None


def _trimmed_fit(probe: PointSet, reference: PointSet, *, start: Pose | None, settings: IcpSettings) -> _Fit:
    longer = max(len(probe.xyz), len(reference.xyz))  # of both, so that swapped roles rest on the same points
    steps = [max(longer // count, 1) for count in settings.thinning]
    coarse, loop = (
        Neighbours(
            probe, reference, direction_weight=settings.direction_weight, step=step, follows=step == steps[-1]
        )
        for step in steps
    )
    starts = [_turned(angle) for angle in settings.starts] if start is None else [start]
    best = min(
        (
            closest_points(
                coarse,
                start=s,
                overlap=settings.start_overlap,
                settings=settings,
                limit=settings.start_iterations,
            )
            for s in starts
        ),
        key=lambda outcome: outcome.error,
    )
    overlap, _ = trimmed_share(loop.pairs(best.pose).squared, settings=settings)
    found = closest_points(loop, start=best.pose, overlap=overlap, settings=settings)
    pairs = loop.pairs(found.pose)
    overlap, psi = trimmed_share(pairs.squared, settings=settings)
    P, X = (
        _spread(np.ascontiguousarray(side[:, :2]))
        for side in loop.matched(pairs, kept=closest(pairs.squared, overlap))
    )
    return _Fit(found, overlap, psi, float(np.sqrt(X / P)), pairs if steps[-1] == 1 else None)


def _resized(points: PointSet, ratio: float) -> PointSet:
    """The same ink in a unit that makes it `ratio` times as large."""
    return replace(points, xyz=points.xyz * ratio, radius=points.radius / ratio, pixel=points.pixel * ratio)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Where the loop ended. error: mean squared distance of the pairs it kept, before its last pose."""

    pose: Pose
    error: float
    converged: bool
    iterations: int


def closest_points(
    neighbours: Neighbours, *, start: Pose, overlap: float, settings: IcpSettings, limit: int | None = None
) -> Outcome:
    """Eq. (25): Y = closest points, (q, d_ms) = Q(P, Y), again until d_ms stops falling.

    Of the pairs, both ways, only the closest `overlap` share moves the pose.
    """
    threshold = settings.tolerance * neighbours.spread  # of both, so that swapped roles stop alike
    pose, best, last = start, start, np.inf
    limit = limit or settings.max_iterations
    for iteration in range(limit):
        pairs = neighbours.pairs(pose)
        squared = pairs.squared
        kept = closest(squared, overlap)
        error = float(squared.take(kept).mean())
        if last - error < threshold:
            return Outcome(pose if error < last else best, min(error, last), True, iteration)
        last, best = error, pose
        P, X = neighbours.matched(pairs, kept=kept)
        pose = closed_form_pose(P, X, rotation=settings.rotation)
    return Outcome(best, last, False, limit)


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


def _turned(angle: float) -> Pose:
    half = np.deg2rad(angle) / 2
    return Pose(unit_quaternion(np.array([np.cos(half), 0.0, 0.0, np.sin(half)])), np.zeros(3), np.inf)


def _registration(
    probe: PointSet, reference: PointSet, *, found: Outcome, pairs: Pairs, overlap: float
) -> Registration:
    T = found.pose.matrix
    left = probe.xyz @ T[:3, :3].T + T[:3, 3] - reference.xyz[pairs.forward_index]
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
        d_ms=float(np.mean(np.sum(left * left, axis=1))),
        forward=np.sqrt(pairs.forward),
        forward_index=pairs.forward_index,
        backward=np.sqrt(pairs.backward),
        backward_index=pairs.backward_index,
        converged=found.converged,
        iterations=found.iterations,
    )


def pose_probe(registration: Registration) -> FloatArray:
    """(N, 3) float64, the probe's points laid on the reference."""
    T = registration.T_reference_probe
    return np.asarray(registration.probe.xyz @ T[:3, :3].T + T[:3, 3])
