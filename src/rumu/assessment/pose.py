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


@dataclass(frozen=True, slots=True)
class PoseSettings:
    """What makes a pose.

    reach: rms radii beyond which a point hardly counts. simpler: a pose with fewer parts is taken when it
        leaves at most so many times what the best leaves, and `slack` rms radii more.
    """

    reach: float = 0.15
    simpler: float = 1.3
    slack: float = 0.012


@dataclass(frozen=True, slots=True)
class SqueezeSettings:
    """What makes a squeeze.

    least: smallest ratio between the widths of the two parts. each: how far each must be from the master's
        when one is too wide and the other too narrow. gain: share of what the pose leaves that it explains.
    strokes: in a part that alone is wrong.
    """

    least: float = 1.12
    each: float = 0.04
    gain: float = 0.4
    strokes: int = 2


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


def robust_pose(master: FloatArray, copy: FloatArray, *, settings: PoseSettings | None = None) -> Pose:
    """The pose that most points agree upon; (n, 2) points of the master and where the copy has them."""
    s = settings or PoseSettings()
    none = Pose(np.eye(2), np.zeros(2))
    if len(master) < 4:
        return none
    poses = [none] + [_fitted(master, copy, turn, size, s) for turn, size in _PARTS]
    left = [_cost(p, master, copy, s) for p in poses]
    enough = s.simpler * min(left) + s.slack
    return next(p for p, cost in zip(poses, left, strict=True) if cost <= enough)


_PARTS = ((False, False), (True, False), (False, True), (True, True))
"""Whether a pose turns and whether it changes the size, from simple to rich; all of them shift."""


def _cost(pose: Pose, master: FloatArray, copy: FloatArray, s: PoseSettings) -> float:
    return float(np.minimum(np.hypot(*(pose.undone(copy) - master).T), 2 * s.reach).mean())


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
    master: FloatArray, copy: FloatArray, *, owner: IntArray, settings: SqueezeSettings | None = None
) -> Squeeze | None:
    """The clearer of left against right and top against bottom; None when neither is squeezed.

    master, copy: (n, 2) the same points, pose taken out. owner: (n,) number of the stroke.
    """
    s = settings or SqueezeSettings()
    found = [_squeeze(master, copy, axis) for axis in ("across", "down")]
    clear = [q for q in found if q and _is_clear(q, master, owner, s)]
    return max(clear, key=lambda q: q.gain) if clear else None


def _is_clear(q: Squeeze, master: FloatArray, owner: IntArray, s: SqueezeSettings) -> bool:
    if max(q.first / q.second, q.second / q.first) < s.least or q.gain < s.gain:
        return False
    if (q.first - 1.0) * (q.second - 1.0) < 0 and min(abs(q.first - 1), abs(q.second - 1)) >= s.each:
        return True
    # one part alone is wide or narrow: a single stroke that is long or short would look like that
    k = 0 if q.axis == "across" else 1
    odd = abs(q.first - 1.0) > abs(q.second - 1.0)
    side = master[:, k] < q.parting if odd else master[:, k] > q.parting
    counts = np.bincount(owner[side])
    return bool(
        (counts > 0.6 * np.bincount(owner, minlength=len(counts))[: len(counts)]).sum() >= s.strokes + 1
    )


def squeezed(points: FloatArray, squeeze: Squeeze | None) -> FloatArray:
    """Points of the master, (n, 2), where a squeeze puts them."""
    if squeeze is None:
        return points
    k = 0 if squeeze.axis == "across" else 1
    out = points.copy()
    away = points[:, k] - squeeze.parting
    out[:, k] = squeeze.moved + np.where(away < 0, squeeze.first, squeeze.second) * away
    return out


def _squeeze(master: FloatArray, copy: FloatArray, axis: Axis) -> Squeeze | None:
    k = 0 if axis == "across" else 1
    x, y = master[:, k], copy[:, k]
    low, high = x.min(), x.max()
    straight, _ = _l1(np.column_stack([np.ones_like(x), x]), y)
    best: Squeeze | None = None
    least = np.inf
    for share in np.linspace(0.3, 0.7, 9):
        at = low + share * (high - low)
        if min((x < at).mean(), (x > at).mean()) < 0.15:
            continue
        left, (c, a, b) = _l1(
            np.column_stack([np.ones_like(x), np.minimum(x - at, 0), np.maximum(x - at, 0)]), y
        )
        if left < least and a > 0.1 and b > 0.1:
            least = left
            best = Squeeze(axis, float(at), float(c), float(a), float(b), 1.0 - left / max(straight, 1e-9))
    return best if best and straight > 0.012 else None


def _l1(A: FloatArray, y: FloatArray) -> tuple[float, FloatArray]:
    """Least absolute deviations by reweighting: mean of what is left, and the coefficients."""
    weight = np.ones(len(y))
    for _ in range(5):
        B = A * weight[:, None]
        coefficients = np.linalg.solve(B.T @ A + 1e-9 * np.eye(A.shape[1]), B.T @ y)
        left = np.abs(y - A @ coefficients)
        weight = 1.0 / np.maximum(left, 0.02)
    return float(left.mean()), np.asarray(coefficients)
