"""Iterative closest points in the plane with a similarity: turning, shifting and one scale.

That candidates are checked by ICP on the skeleton, so that size, place and slant do not matter, is known from
VICP's abstract. The step is Umeyama's closed form. Ours is that pairs are taken both ways: from the copy
alone, a free scale would shrink it onto any single stroke.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.errors import RegistrationError
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class SimilarityIcpSettings:
    """Where the iterations start and when they end.

    starts: angles tried, degrees. coarse: of so many points one is used to choose among them, for `scout`
    iterations. iterations: most for the best one, with all points. still: change of scale, of angle in
    radians and of shift in radii below which it has come to rest. scales: least and greatest.
    """

    starts: tuple[float, ...] = (-45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0)
    coarse: int = 5
    scout: int = 6
    iterations: int = 30
    still: float = 1e-4
    scales: tuple[float, float] = (0.2, 5.0)


@dataclass(frozen=True, slots=True, eq=False)
class Similarity:
    """A similarity transform, q = scale * rotation @ p + shift.

    rotation: (2, 2), determinant +1. residual: rms of both directions,
    in the unit of the reference. converged: False when the iterations ran out.
    """

    scale: float
    rotation: FloatArray
    shift: FloatArray
    residual: float = 0.0
    iterations: int = 0
    converged: bool = True

    def __call__(self, points: FloatArray) -> FloatArray:
        """(n, 2) points moved."""
        return np.asarray(self.scale * points @ self.rotation.T + self.shift)

    @property
    def angle(self) -> float:
        """Degrees from x towards y."""
        return float(np.degrees(np.arctan2(self.rotation[1, 0], self.rotation[0, 0])))


def umeyama(source: FloatArray, target: FloatArray) -> Similarity:
    """The similarity that takes (n, 2) points nearest to their partners in the mean square; never a mirror.

    Umeyama, IEEE PAMI 13(4), 1991. Raises RegistrationError when the source is a single place.
    """
    p, q = source.mean(axis=0), target.mean(axis=0)
    a, b = source - p, target - q
    spread = float((a**2).sum())
    if not spread > 0:
        raise RegistrationError("expected points that are not all in one place, got one place")
    u, s, vt = np.linalg.svd(b.T @ a)
    flip = np.array([1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = (u * flip) @ vt
    scale = float((s * flip).sum()) / spread
    return Similarity(scale, rotation, q - scale * rotation @ p)


def similarity_icp(
    probe: FloatArray, reference: FloatArray, *, settings: SimilarityIcpSettings | None = None
) -> Similarity:
    """Lay (n, 2) points on (m, 2) points; centres and sizes are made equal before the first step.

    Raises RegistrationError when either is fewer than 3 points, not finite or a single place.
    """
    settings = settings or SimilarityIcpSettings()
    for name, points in (("probe", probe), ("reference", reference)):
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3 or not np.isfinite(points).all():
            raise RegistrationError(f"expected 3 or more finite {name} points (n, 2), got {points.shape}")
    radius = _radius(reference)
    if not (_radius(probe) > 0 and radius > 0):
        raise RegistrationError("expected points that are not all in one place, got one place")
    few, few_reference = probe[:: settings.coarse], reference[:: settings.coarse]
    if min(len(few), len(few_reference)) < 3:
        few, few_reference = probe, reference
    scouted = [
        _iterate(few, few_reference, _start(probe, reference, angle), settings.scout, settings)
        for angle in settings.starts
    ]
    best = min(scouted, key=lambda pose: pose.residual)
    return _iterate(probe, reference, best, settings.iterations, settings)


def _radius(points: FloatArray) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _start(probe: FloatArray, reference: FloatArray, angle: float) -> Similarity:
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    rotation = np.array([[c, -s], [s, c]])
    scale = _radius(reference) / _radius(probe)
    return Similarity(scale, rotation, reference.mean(axis=0) - scale * rotation @ probe.mean(axis=0))


def _iterate(
    probe: FloatArray, reference: FloatArray, pose: Similarity, limit: int, settings: SimilarityIcpSettings
) -> Similarity:
    from scipy.spatial import cKDTree

    tree, own_tree, radius = cKDTree(reference), cKDTree(probe), _radius(reference)
    for iteration in range(limit + 1):
        onto, forward, back, backward = _pairs(probe, reference, pose, tree, own_tree)
        residual = float(np.sqrt(0.5 * (np.mean(forward**2) + np.mean(backward**2))))
        if iteration == limit:
            break
        source = np.concatenate([probe, probe[back]])
        target = np.concatenate([reference[onto], reference])
        fresh = umeyama(source, target)
        fresh = _limit_scale(fresh, source, target, settings.scales, _radius(reference) / _radius(probe))
        moved = _difference(pose, fresh, probe, radius)
        if moved < settings.still:
            return Similarity(pose.scale, pose.rotation, pose.shift, residual, iteration, True)
        pose = fresh
    return Similarity(pose.scale, pose.rotation, pose.shift, residual, limit, False)


def _pairs(
    probe: FloatArray, reference: FloatArray, pose: Similarity, tree: object, own_tree: object
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Nearest reference point of each probe point with its distance, and the nearest the other way.

    The way back is sought in the probe's own frame, so that its tree need not be made anew.
    """
    forward, onto = tree.query(pose(probe))  # type: ignore[attr-defined]
    unmoved = (reference - pose.shift) @ pose.rotation / pose.scale
    backward, back = own_tree.query(unmoved)  # type: ignore[attr-defined]
    return onto, forward, back, backward * pose.scale


def _limit_scale(
    pose: Similarity, source: FloatArray, target: FloatArray, scales: tuple[float, float], equal: float
) -> Similarity:
    """The scale kept within bounds around that of equal size; centres stay on each other."""
    scale = float(np.clip(pose.scale, scales[0] * equal, scales[1] * equal))
    shift = target.mean(axis=0) - scale * pose.rotation @ source.mean(axis=0)
    return Similarity(scale, pose.rotation, shift)


def _difference(a: Similarity, b: Similarity, probe: FloatArray, radius: float) -> float:
    between = a.rotation.T @ b.rotation
    turned = abs(float(np.arctan2(between[1, 0], between[0, 0])))
    centre = probe.mean(axis=0)[None]
    shifted = float(np.linalg.norm(a(centre) - b(centre))) / radius
    return max(abs(float(np.log(b.scale / a.scale))), turned, shifted)
