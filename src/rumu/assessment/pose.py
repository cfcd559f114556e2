"""How the copy stands in its cell, and which part of it is too wide: what the strokes agree upon.

The registration rests on all ink; a stroke that was moved, left out or put in pulls it along. Here the pose
is what most of the strokes say, and the simplest one that explains them: a character is taken to stand
where its master stands until its strokes say otherwise together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.values import FloatArray, IntArray

Axis = Literal["across", "down"]

_PLACE = 0.06
"""Rms radii within which a point of a squeezed part is in its place."""


@dataclass(frozen=True, slots=True)
class PoseSettings:
    """What makes a pose.

    reach: rms radii beyond which a point hardly counts. agree: rms radii within which a point agrees with a
        pose. simpler: a pose with fewer parts is taken when so many times as few points agree with it as with
        the best. still: rms radii (and half of it in size, 3 degrees) up to which the best is too small to be
        spoken of; `same` stands for `simpler` then, so that every stroke is not blamed for it.
    in_place: how well all strokes but one must agree with no pose at all: then that one is out of place. The
        few strokes of a short character could all be explained by a pose that suits none of them.
    """

    reach: float = 0.15
    agree: float = 0.045
    simpler: float = 0.6
    still: float = 0.1
    same: float = 0.95
    in_place: float = 0.8


@dataclass(frozen=True, slots=True)
class SqueezeSettings:
    """What makes a squeeze.

    least: smallest ratio between the widths of the two parts. each: how far each must be from the master's
        when one is too wide and the other too narrow. gain: share of what the pose leaves that it explains.
    strokes: how many it must put in their place; with twice as many less gain will do. better:
        share of the strokes, besides, that it must put in their place: a middle stroke that is out of place
        alone would put the others wrong.
    """

    least: float = 1.12
    each: float = 0.04
    gain: float = 0.5
    strokes: int = 2
    better: float = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """x -> linear x + shift, from the master's place in the cell to the copy's; y down.

    angle: degrees, positive clockwise. scale: of the copy, 1 is the same.
    """

    linear: FloatArray
    shift: FloatArray

    @property
    def scale(self) -> float:
        return float(np.sqrt(np.linalg.det(self.linear)))

    @property
    def angle(self) -> float:
        return float(np.degrees(np.arctan2(self.linear[1, 0], self.linear[0, 0])))

    def undone(self, points: FloatArray) -> FloatArray:
        """Points of the copy where they would be in an upright copy of the master's size and place."""
        return np.asarray((points - self.shift) @ np.linalg.inv(self.linear).T)


@dataclass(frozen=True, slots=True)
class Squeeze:
    """One part too wide (or tall) for the other.

    axis: 'across' for left and right, 'down' for top and bottom. parting: where the master's meet, rms
        radii; moved: where the copy's do.
    first, second: width of the left (top) and of the right (bottom) part over the master's.
    gain: share of what was unexplained that this explains.
    """

    axis: Axis
    parting: float
    moved: float
    first: float
    second: float
    gain: float


def robust_pose(
    master: FloatArray, copy: FloatArray, *, owner: IntArray, settings: PoseSettings | None = None
) -> Pose:
    """The pose that most points agree upon; (n, 2) points of the master and where the copy has them.

    owner: (n,) number of the stroke.
    """
    s = settings or PoseSettings()
    none = Pose(np.eye(2), np.zeros(2))
    if len(master) < 4 or _all_but_one(copy - master, owner, s):
        return none
    poses = [none] + [_fitted(master, copy, turn, size, s) for turn, size in _PARTS]
    agreed = [_agreement(p, master, copy, s) for p in poses]
    best = poses[int(np.argmax(agreed))]
    enough = (s.same if _is_small(best, s) else s.simpler) * max(agreed)
    return next(p for p, share in zip(poses, agreed, strict=True) if share >= enough)


def _all_but_one(left: FloatArray, owner: IntArray, s: PoseSettings) -> bool:
    """Whether, of two strokes or more, all stand in their place but one; a long one counts more."""
    count = np.bincount(owner)
    there = np.bincount(owner, np.exp(-0.5 * (left * left).sum(axis=1) / s.agree**2))[count > 0]
    weight = np.sqrt(count[count > 0])
    if len(weight) < 2:
        return False
    there = there / weight**2
    rest = ((weight * there).sum() - weight * there) / (weight.sum() - weight)
    return bool(rest.max() >= s.in_place)


def _is_small(pose: Pose, s: PoseSettings) -> bool:
    """Whether nobody would speak of it: then it may as well be taken out."""
    still = float(np.hypot(*pose.shift)) < s.still
    return still and abs(pose.angle) < 30.0 * s.still and abs(np.log(pose.scale)) < s.still / 2


_PARTS = ((False, False), (True, False), (False, True), (True, True))
"""Whether a pose turns and whether it changes the size, from simple to rich; all of them shift."""


def _agreement(pose: Pose, master: FloatArray, copy: FloatArray, s: PoseSettings) -> float:
    """Share of the points that a pose brings to their place, softly counted."""
    left = pose.undone(copy) - master
    return float(np.exp(-0.5 * (left * left).sum(axis=1) / s.agree**2).mean())


def _fitted(master: FloatArray, copy: FloatArray, turn: bool, size: bool, s: PoseSettings) -> Pose:
    """Geman and McClure's weights, which forget what lies far off; their reach shrinks to its own."""
    weight = np.ones(len(master))
    pose = _least_squares(master, copy, weight, turn, size)
    for reach in (8 * s.reach, 4 * s.reach, 2 * s.reach, s.reach, s.reach, s.reach / 2, s.reach / 2):
        left = copy - master @ pose.linear.T - pose.shift
        weight = (reach**2 / (reach**2 + (left * left).sum(axis=1))) ** 2
        pose = _least_squares(master, copy, weight, turn, size)
    return pose


def _least_squares(master: FloatArray, copy: FloatArray, weight: FloatArray, turn: bool, size: bool) -> Pose:
    w = weight / weight.sum()
    a, b = w @ master, w @ copy
    m, c = master - a, copy - b
    S = (c * w[:, None]).T @ m
    angle = np.arctan2(S[1, 0] - S[0, 1], S[0, 0] + S[1, 1]) if turn else 0.0
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    scale = float(np.sum(R * S) / max(float(w @ (m * m).sum(axis=1)), 1e-9)) if size else 1.0
    linear = max(scale, 0.2) * R
    return Pose(linear, b - linear @ a)


def find_squeeze(
    master: FloatArray,
    copy: FloatArray,
    *,
    owner: IntArray,
    double: FloatArray,
    settings: SqueezeSettings | None = None,
) -> Squeeze | None:
    """The clearer of left against right and top against bottom; None when neither is squeezed.

    master, copy: (n, 2) the same points, pose taken out. owner: (n,) number of the stroke. double: (n, 2)
    (cos 2t, sin 2t) of the direction: where a point lies along its own stroke cannot be seen.
    """
    s = settings or SqueezeSettings()
    ends = np.concatenate([[True], np.diff(owner) != 0]) | np.concatenate([np.diff(owner) != 0, [True]])
    found = []
    for axis, sign in (("across", -1.0), ("down", 1.0)):
        seen = np.where(ends, 1.0, (1.0 + sign * double[:, 0]) / 2 + 0.03)
        squeeze = _squeeze(master, copy, axis, seen)  # type: ignore[arg-type]
        if squeeze and _is_clear(squeeze, _explains(squeeze, master, copy, owner), s):
            before, after = (in_place(copy - to, owner) for to in (master, squeezed(master, squeeze)))
            if after - before >= s.better:
                found.append(squeeze)
    return max(found, key=lambda q: q.gain) if found else None


def _is_clear(q: Squeeze, strokes: int, s: SqueezeSettings) -> bool:
    """Whether both parts are wrong, the one too wide and the other too narrow, in enough strokes."""
    if max(q.first / q.second, q.second / q.first) < s.least:
        return False
    opposed = (q.first - 1.0) * (q.second - 1.0) < 0 and min(abs(q.first - 1), abs(q.second - 1)) >= s.each
    few = strokes >= s.strokes + (0 if opposed else 2) and q.gain >= s.gain
    return few or (opposed and strokes >= 2 * s.strokes and q.gain >= s.gain / 2.5)


def in_place(left: FloatArray, owner: IntArray) -> float:
    """Share of the strokes that are where they should be, softly counted, a short one like a long one."""
    count = np.bincount(owner)
    there = np.bincount(owner, np.exp(-0.5 * (left * left).sum(axis=1) / _PLACE**2))
    return float((there[count > 0] / count[count > 0]).mean())


def _explains(q: Squeeze, master: FloatArray, copy: FloatArray, owner: IntArray) -> int:
    """How many strokes it puts in their place: one alone is rather out of place itself."""
    k = 0 if q.axis == "across" else 1
    count = np.maximum(np.bincount(owner), 1)
    before, after = (
        np.bincount(owner, np.abs(copy - to)[:, k]) / count for to in (master, squeezed(master, q))
    )
    return int(((before > 0.03) & (after < 0.6 * before)).sum())


def squeezed(points: FloatArray, squeeze: Squeeze | None) -> FloatArray:
    """Points of the master, (n, 2), where a squeeze puts them."""
    if squeeze is None:
        return points
    k = 0 if squeeze.axis == "across" else 1
    out = points.copy()
    away = points[:, k] - squeeze.parting
    out[:, k] = squeeze.moved + np.where(away < 0, squeeze.first, squeeze.second) * away
    return out


def _squeeze(master: FloatArray, copy: FloatArray, axis: Axis, seen: FloatArray) -> Squeeze | None:
    k = 0 if axis == "across" else 1
    x, y = master[:, k], copy[:, k]
    straight = float(_least_absolute(np.column_stack([np.ones_like(x), x])[None], y, seen)[0][0])
    if straight <= 0.012:
        return None
    at = x.min() + np.linspace(0.3, 0.7, 9) * (x.max() - x.min())
    away = x - at[:, None]
    both = np.minimum((away < 0) @ seen, (away > 0) @ seen)
    at, away = at[both >= 0.15 * seen.sum()], away[both >= 0.15 * seen.sum()]
    bent = np.stack([np.ones_like(away), np.minimum(away, 0), np.maximum(away, 0)], axis=-1)
    left, coefficients = _least_absolute(bent, y, seen)
    left = np.where((coefficients[:, 1:] > 0.1).all(axis=1), left, np.inf)
    if len(left) == 0 or not np.isfinite(left.min()):
        return None
    best = int(left.argmin())
    c, a, b = (float(v) for v in coefficients[best])
    return Squeeze(axis, float(at[best]), c, a, b, 1.0 - float(left[best]) / max(straight, 1e-9))


def _least_absolute(A: FloatArray, y: FloatArray, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least absolute deviations by reweighting, of p designs (p, n, c) at a time.

    (p,) means of what is left, and (p, c) coefficients.
    """
    weight = np.broadcast_to(seen, A.shape[:2])
    left: FloatArray = np.zeros(A.shape[:2])
    coefficients: FloatArray = np.zeros((len(A), A.shape[2]))
    for _ in range(5):
        B = (A * weight[:, :, None]).transpose(0, 2, 1)
        coefficients = np.linalg.solve(B @ A + 1e-9 * np.eye(A.shape[2]), (B @ y)[:, :, None])[:, :, 0]
        left = np.abs(y - (A @ coefficients[:, :, None])[:, :, 0])
        weight = seen / np.maximum(left, 0.02)
    return (left @ seen) / seen.sum(), coefficients
