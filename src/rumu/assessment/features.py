"""Registration and the ink's edge -> a few numbers, each with a meaning.

What registration leaves is measured untrimmed and both ways. Two similarities are printed beside the mark and
are no part of it: the paper's, and one that a missing stroke cannot fool.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass

import numpy as np

from rumu.assessment.edges import EDGE_NUMBERS, PATCH_NUMBERS, PLAIN
from rumu.registration.icp import pose_probe
from rumu.strokes.correspondence import CopyStrokes
from rumu.strokes.omissions import MasterInk, Region, find_regions
from rumu.values import FloatArray, IntArray, Registration

RESIDUALS = (
    "position",
    "plane_mean",
    "plane_extra",
    "plane_missing",
    "height",
    "direction",
    "whole",
    "whole_mean",
    "extra",
    "missing",
    "bent",
    "warped",
    "proportions",
    "directions",
)
"""What registration leaves, in this order."""

FEATURE_GROUPS: Mapping[str, tuple[str, ...]] = {
    "plane": RESIDUALS[:4],
    "height": ("height",),
    "direction": ("direction",),
    "whole": RESIDUALS[6:10],
    "form": RESIDUALS[10:],
    "edge": tuple(f"edge_{k}" for k in range(PATCH_NUMBERS)),
    "outline": PLAIN,
    "fullness": ("fullness",),
}
"""All features that a calibration may weigh, in the order of `Features.vector`, by what they rest on."""
FEATURE_NAMES: tuple[str, ...] = tuple(name for group in FEATURE_GROUPS.values() for name in group)
SIGNED_FEATURES: tuple[str, ...] = (*FEATURE_GROUPS["edge"], *FEATURE_GROUPS["fullness"])
"""Features that may speak for a copy as well as against it; more of any other never raises a mark."""

SOFTENING = 0.05
"""Residual, in rms radii, below which differences hardly count: a pixel and a half of the common canvas."""
DIRECTIONS = 24
"""Sectors of half a turn in which the ink's directions are counted."""
FARTHEST = 0.4
"""Distance in the plane, in rms radii, beyond which a point counts no farther for `bent` and `warped`: the
nearest point of the same direction lies on another stroke then, and which one it is a pixel may decide."""
LEAN_RANGE = 40
"""Degrees, either way, within which a lean is looked for in the ink's directions."""
LEAN_BLUR = 5.0
"""Standard deviation, in degrees, by which they are blurred there."""
FULLNESS_RANGE = 0.3
"""Natural logarithm of size, either way, up to which the human marks at hand speak."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """What registration leaves between copy and master, both ways, in rms radii of the ink unless said.

    position: rms distance in the plane; plane_mean: its mean; plane_extra, plane_missing: its upper quartile
        from the copy's points to the master, and from the master's to the copy.
    height: rms difference of normalised height: stroke width for an inflated height.
    direction: rms difference of the doubled stroke direction, from 0 to 2.
    whole: rms distance in all five dimensions; whole_mean, extra, missing: as in the plane.
    bent, warped: rms distance in the plane that is left when the copy is moved as the best affine map and the
        best cubic one would move it: small where only the whole is stretched, or bent evenly. No distance
        counts for more than FARTHEST.
    proportions: difference of how far, and which way, the ink spreads, as a share.
    directions: difference of how much of the ink runs in each direction, from 0 to 2.
    """

    position: float = 0.0
    plane_mean: float = 0.0
    plane_extra: float = 0.0
    plane_missing: float = 0.0
    height: float = 0.0
    direction: float = 0.0
    whole: float = 0.0
    whole_mean: float = 0.0
    extra: float = 0.0
    missing: float = 0.0
    bent: float = 0.0
    warped: float = 0.0
    proportions: float = 0.0
    directions: float = 0.0

    def logarithms(self) -> FloatArray:
        """(len(RESIDUALS),) natural logarithms in the order of RESIDUALS, softened near zero."""
        return np.log(np.array(astuple(self)) + SOFTENING)


@dataclass(frozen=True, slots=True)
class Features:
    """All that a mark is made of.

    residuals: see Residuals.
    lean: degrees, positive clockwise, see `lean_of`. offset: distance from the master's place, fraction of
        the cell.
    size: natural logarithm of the copy's size over the master's; 0 is the same.
    weight: natural logarithm of the copy's mean normalised height over the master's; for an inflated
        height above 0 means heavier strokes.
    regions: where copy and master part.
    edges: the copy's description of its edge less the master's, as `describe_edge` orders it.
    """

    residuals: Residuals
    lean: float
    offset: float
    size: float
    weight: float
    regions: tuple[Region, ...] = ()
    edges: tuple[float, ...] = (0.0,) * EDGE_NUMBERS

    def vector(self) -> FloatArray:
        """(len(FEATURE_NAMES),) float64: log residuals, edge (signed), outline (how much), fullness."""
        edges = np.array(self.edges)
        full = np.clip(self.size, -FULLNESS_RANGE, FULLNESS_RANGE)
        patches, plain = edges[:PATCH_NUMBERS], np.abs(edges[PATCH_NUMBERS:])
        return np.concatenate([self.residuals.logarithms(), patches, plain, [full]])


def measure_features(
    registration: Registration,
    *,
    edges: FloatArray,
    ink: MasterInk,
    strokes: CopyStrokes | None = None,
) -> Features:
    """Features of one registration.

    edges: (EDGE_NUMBERS,) description of the copy's edge less the master's. ink: the master's. strokes:
    the master's on the copy where its character is known, see `find_regions`.
    """
    return Features(
        residuals=residuals(registration),
        lean=lean_of(registration),
        offset=float(np.hypot(*registration.shift)),
        size=float(np.log(registration.scale)),
        weight=ink_weight(registration),
        regions=find_regions(registration, ink, strokes=strokes),
        edges=tuple(edges.tolist()),
    )


def ink_weight(registration: Registration) -> float:
    """Natural logarithm of the copy's mean normalised height over the master's: above 0 is heavier."""
    copy, master = (points.xyz[:, 2].mean() for points in (registration.probe, registration.reference))
    return float(np.log(max(copy, 1e-6) / max(master, 1e-6)))


def lean_of(registration: Registration) -> float:
    """Degrees by which a copy leans, positive clockwise: what its pose and its directions agree upon.

    Where parts stand elsewhere than in the master, the best pose may turn by ten degrees what does not lean
    at all; the strokes' directions then stay as they are. So the lesser of both counts, and nothing where
    they contradict.
    """
    turned = _turn_of_directions(registration.probe.direction, registration.reference.direction)
    if turned * registration.angle <= 0.0:
        return 0.0
    return float(np.copysign(min(abs(turned), abs(registration.angle)), turned))


def _turn_of_directions(double: FloatArray, master: FloatArray) -> float:
    """Degrees, clockwise, by which (N, 2) doubled directions of a copy are turned against (M, 2) of a master.

    The peak of the circular correlation of both's counts, in degrees of half a turn.
    """
    steps = np.arange(180)
    blur = np.exp(-0.5 * (np.minimum(steps, 180 - steps) / LEAN_BLUR) ** 2)
    of_copy, of_master = (
        np.fft.rfft(np.bincount(_sectors(directions, 180), minlength=180)) for directions in (double, master)
    )
    alike = np.fft.irfft(np.conj(of_copy) * of_master * np.fft.rfft(blur) ** 2, 180)
    turns = np.arange(-LEAN_RANGE, LEAN_RANGE + 1)
    at = alike[turns]
    best = int(np.clip(np.argmax(at), 1, len(turns) - 2))
    before, peak, after = at[best - 1 : best + 2]
    bend = before - 2.0 * peak + after  # of the parabola through the three
    return float(turns[best] + (np.clip(0.5 * (before - after) / bend, -1.0, 1.0) if bend < 0.0 else 0.0))


def _sectors(double: FloatArray, count: int) -> IntArray:
    """(N,) which of `count` equal sectors of half a turn (N, 2) doubled directions lie in."""
    turns = np.arctan2(double[:, 1], double[:, 0]) / (2.0 * np.pi) + 0.5
    return np.asarray((turns * count).astype(np.intp) % count)


def residuals(registration: Registration) -> Residuals:
    """The residuals of one registration."""
    p, x = pose_probe(registration), registration.reference.xyz
    a = 2 * np.deg2rad(registration.angle)
    d = registration.probe.direction @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    e = registration.reference.direction
    i, j = registration.forward_index, registration.backward_index
    space = np.vstack([p - x[i], p[j] - x])
    turn = np.vstack([d - e[i], d[j] - e])
    flat = np.hypot(space[:, 0], space[:, 1])
    whole = np.concatenate([registration.forward, registration.backward])
    near = space[:, :2] * (FARTHEST / np.maximum(flat, FARTHEST))[:, None]
    bent, warped = _unexplained(np.vstack([p[:, :2], p[j, :2]]), near)
    return Residuals(
        position=_rms(space[:, :2]),
        plane_mean=float(flat.mean()),
        plane_extra=float(np.percentile(flat[: len(p)], 75)),
        plane_missing=float(np.percentile(flat[len(p) :], 75)),
        height=_rms(space[:, 2:]),
        direction=_rms(turn),
        whole=float(np.sqrt(np.mean(whole * whole))),
        whole_mean=float(whole.mean()),
        extra=float(np.percentile(registration.forward, 75)),
        missing=float(np.percentile(registration.backward, 75)),
        bent=bent,
        warped=warped,
        proportions=float(np.linalg.norm(_spread(p) - _spread(x))),
        directions=float(np.abs(_direction_shares(d) - _direction_shares(e)).sum()),
    )


def _unexplained(at: FloatArray, moved: FloatArray) -> tuple[float, float]:
    """Rms length of (N, 2) displacements that the best affine map, and the best cubic one, leaves."""
    x, y = at.T
    xx, yy = x * x, y * y
    terms = np.stack([np.ones_like(x), x, y, xx, x * y, yy, xx * x, xx * y, x * yy, yy * y])
    square, right = terms @ terms.T, terms @ moved
    total = float(np.sum(moved * moved))
    left = []
    for order in (3, 10):
        known = np.linalg.lstsq(square[:order, :order], right[:order], rcond=None)[0]
        left.append(max(total - float(np.sum(known * right[:order])), 0.0))
    return float(np.sqrt(left[0] / len(at))), float(np.sqrt(left[1] / len(at)))


def _spread(points: FloatArray) -> FloatArray:
    """(2, 2) covariance of points in the plane, of trace 1."""
    covariance = np.cov(points[:, :2], rowvar=False)
    return np.asarray(covariance / max(float(np.trace(covariance)), 1e-9))


def _direction_shares(double: FloatArray) -> FloatArray:
    """(DIRECTIONS,) share of the points, (N, 2) doubled directions, that run each way; smoothed."""
    share = np.bincount(_sectors(double, DIRECTIONS), minlength=DIRECTIONS) / len(double)
    return np.asarray((share + np.roll(share, 1) + np.roll(share, -1)) / 3.0)


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference * difference, axis=1))))


def sim_paper(registration: Registration) -> float:
    """Eq. (26): SIM = (1 - d_ms / ||X||_F) * 100 %, as printed; X the reference's points, in rms radii.

    Kept for comparison and never used as the mark: d_ms is a squared length and ||X||_F a length, so the
    unit decides; ||X||_F grows with the number of points, so any two characters read above 99; and
    d_ms is one-sided, so a copy of a single stroke reads 100.
    """
    return float((1.0 - registration.d_ms / np.linalg.norm(registration.reference.xyz)) * 100.0)


def similarity(registration: Registration) -> float:
    """Two-sided similarity (ours): 1 - max(E_f, E_b) / r_X; 1 is identical, unrelated shapes about 0.7.

    E_f, E_b: rms distance in (x, y, z) from copy to master and from master to copy after registration;
    r_X: rms distance of the master's points from their mean. Free of unit, origin and number of points.
    """
    p, x = pose_probe(registration), registration.reference.xyz
    forward = p - x[registration.forward_index]
    backward = x - p[registration.backward_index]
    error = max(float(np.mean(np.sum(d * d, axis=1))) for d in (forward, backward))
    spread = float(np.var(x, axis=0).sum())
    return 1.0 - float(np.sqrt(error / spread))
