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
    """What makes a pose. Lengths in rms radii.

    reach: distance beyond which a point hardly counts in the end; schedule: the reach of each round of the
        fit, as multiples of it. agree_distance: distance within which a point agrees with a pose.
    simpler_share: a pose with fewer parts is taken from this share of the points that agree with the best.
    small_shift, small_turn, small_size: shift, degrees and logarithm of size up to which the best is too
        small to be spoken of; small_share stands for simpler_share then, so that not every stroke is blamed.
    in_place_share: how well all strokes but one must agree with no pose at all: then that one is out of
        place. The few strokes of a short character could all be explained by a pose that suits none of them.
    slide_weight: weight of how far a stroke lies along itself, where its place is hardly seen, when it is
        asked whether it is in its place; out_share: how well one may agree at most that is out of its place
        by that measure.
    min_scale: scale of a pose at least.
    lean_share: share of a pose's turn by which level strokes, and upright ones, must each have turned, too;
        lean_ink: share of the points that such strokes must hold to be asked. Where the horizontals climb and
        the verticals stand plumb, or the other way round, the character does not lean.
    """

    reach: float = 0.15
    schedule: tuple[float, ...] = (8.0, 4.0, 2.0, 1.0, 1.0, 0.5, 0.5)
    agree_distance: float = 0.045
    simpler_share: float = 0.6
    small_shift: float = 0.1
    small_turn: float = 3.0
    small_size: float = 0.05
    small_share: float = 0.95
    in_place_share: float = 0.8
    slide_weight: float = 0.3
    out_share: float = 0.3
    min_scale: float = 0.2
    lean_share: float = 0.4
    lean_ink: float = 0.12


@dataclass(frozen=True, slots=True)
class SqueezeSettings:
    """What makes a squeeze. Lengths in rms radii.

    min_ratio: ratio between the widths of the two parts. min_change: how far each must be from the master's
        when one is too wide and the other too narrow. min_gain: share of what the pose leaves that it
        explains; min_gain_opposed: the same where one is too wide, the other too narrow, and twice
        min_strokes say so.
    min_strokes: how many it must put in their place; two more where both parts err in the same way.
    min_stroke_share: share of the strokes, besides, that it must put in their place: a middle stroke that is
        out of place alone would put the others wrong.
    in_place_distance: distance within which a point is in its place. off_distance, improved_share: mean
        distance from which a stroke is not in its place, and share of it below which a squeeze puts it there.
    along_weight: weight of a point that lies along its own stroke, where its place cannot be seen.
    min_residual: mean distance left without a squeeze from which one is looked for at all.
    borders, candidates: shares of the extent between which the parts may meet, and how many are tried.
    min_part_share: share of the points that each part must hold. min_width: of a part, over the master's.
    rounds, floor: of the reweighting, and the distance below which weights grow no more.
    """

    min_ratio: float = 1.12
    min_change: float = 0.04
    min_gain: float = 0.5
    min_gain_opposed: float = 0.2
    min_strokes: int = 2
    min_stroke_share: float = 0.08
    in_place_distance: float = 0.06
    off_distance: float = 0.03
    improved_share: float = 0.6
    along_weight: float = 0.03
    min_residual: float = 0.012
    borders: tuple[float, float] = (0.3, 0.7)
    candidates: int = 9
    min_part_share: float = 0.15
    min_width: float = 0.1
    rounds: int = 5
    floor: float = 0.02


POSE, SQUEEZE = PoseSettings(), SqueezeSettings()


@dataclass(frozen=True, slots=True, eq=False)
class CharacterPose:
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

    def undo(self, points: FloatArray) -> FloatArray:
        """Points of the copy where they would be in an upright copy of the master's size and place."""
        return np.asarray((points - self.shift) @ np.linalg.inv(self.linear).T)


NO_POSE = CharacterPose(np.eye(2), np.zeros(2))


@dataclass(frozen=True, slots=True)
class Squeeze:
    """One part too wide (or tall) for the other.

    axis: 'across' for left and right, 'down' for top and bottom. border: where the master's parts meet, rms
        radii; border_in_copy: where the copy's do.
    first, second: width of the left (top) and of the right (bottom) part over the master's.
    gain: share of what was unexplained that this explains.
    """

    axis: Axis
    border: float
    border_in_copy: float
    first: float
    second: float
    gain: float

    def apply(self, points: FloatArray) -> FloatArray:
        """Points of the master, (n, 2), where the squeeze puts them."""
        k = 0 if self.axis == "across" else 1
        away = points[:, k] - self.border
        squeezed = points.copy()
        squeezed[:, k] = self.border_in_copy + np.where(away < 0, self.first, self.second) * away
        return squeezed


def find_pose(master: FloatArray, copy: FloatArray, *, owner: IntArray, double: FloatArray) -> CharacterPose:
    """The pose that most points agree upon; (n, 2) points of the master and where the copy has them.

    owner: (n,) number of the stroke. double: (n, 2) (cos 2t, sin 2t) of its direction.
    """
    left = copy - master
    if len(master) < 4 or _is_one_out_of_place(left, owner):
        return NO_POSE
    if _is_one_out_of_place(_without_slide(left, double), owner, out_share=POSE.out_share):
        return NO_POSE
    poses = [NO_POSE] + [_fit_robust(master, copy, turn, size) for turn, size in _PARTS]
    agreed = []
    for pose in poses:
        left = pose.undo(copy) - master
        agreed.append(float(np.exp(-0.5 * (left * left).sum(axis=1) / POSE.agree_distance**2).mean()))
    turns = _turns_by_direction(master, copy, owner, double)
    agreed = [
        share if _is_lean(pose.angle, turns) else 0.0 for pose, share in zip(poses, agreed, strict=True)
    ]
    best = poses[int(np.argmax(agreed))]
    is_small = (
        float(np.hypot(*best.shift)) < POSE.small_shift
        and abs(best.angle) < POSE.small_turn
        and abs(np.log(best.scale)) < POSE.small_size
    )
    enough = (POSE.small_share if is_small else POSE.simpler_share) * max(agreed)
    return next(pose for pose, share in zip(poses, agreed, strict=True) if share >= enough)


def _turns_by_direction(
    master: FloatArray, copy: FloatArray, owner: IntArray, double: FloatArray
) -> tuple[float, ...]:
    """Degrees, clockwise, by which most level strokes have turned, and most upright ones, where there are."""
    level, turns, weight = [], [], []
    for k in np.unique(owner):
        a, b = (at[owner == k] - at[owner == k].mean(axis=0) for at in (master, copy))
        cross, dot = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()
        level.append(float(double[owner == k, 0].mean()))
        turns.append(float(np.degrees(np.arctan2(cross, dot))))
        weight.append(float(len(a)))
    found = []
    for chosen in (np.array(level) > 0.5, np.array(level) < -0.5):
        own, w = np.array(turns)[chosen], np.array(weight)[chosen]
        if w.sum() >= POSE.lean_ink * len(master):
            order = np.argsort(own)
            found.append(float(own[order][np.argmax(np.cumsum(w[order]) >= 0.5 * w.sum())]))
    return tuple(found)


def _is_lean(angle: float, turns: tuple[float, ...]) -> bool:
    """Whether a pose hardly turns, or the strokes of each direction turn with it."""
    return abs(angle) < POSE.small_turn or all(
        turn * np.sign(angle) >= POSE.lean_share * abs(angle) for turn in turns
    )


def _without_slide(left: FloatArray, double: FloatArray) -> FloatArray:
    """(n, 2): how far points are off, less some of what lies along their strokes."""
    c, s = double.T
    half = np.arctan2(s, c) / 2
    along = np.column_stack([np.cos(half), np.sin(half)]) * np.hypot(c, s)[:, None]
    return np.asarray(left - (1.0 - POSE.slide_weight) * (left * along).sum(axis=1)[:, None] * along)


def _is_one_out_of_place(left: FloatArray, owner: IntArray, *, out_share: float = 1.0) -> bool:
    """Whether, of two strokes or more, all stand in their place but one; a long one counts more.

    left: (n, 2) how far points are off. out_share: how well that one may agree with its place at most.
    """
    count = np.bincount(owner)
    there = np.bincount(owner, np.exp(-0.5 * (left * left).sum(axis=1) / POSE.agree_distance**2))[count > 0]
    weight = np.sqrt(count[count > 0])
    if len(weight) < 2:
        return False
    there = there / weight**2
    rest = ((weight * there).sum() - weight * there) / (weight.sum() - weight)
    return bool(((rest >= POSE.in_place_share) & (there <= out_share)).any())


_PARTS = ((False, False), (True, False), (False, True), (True, True))
"""Whether a pose turns and whether it changes the size, from simple to rich; all of them shift."""


def _fit_robust(master: FloatArray, copy: FloatArray, turn: bool, size: bool) -> CharacterPose:
    """A pose fitted with Geman and McClure's weights, which downweight outliers; their reach shrinks."""
    pose = _fit_weighted(master, copy, np.ones(len(master)), turn, size)
    for share in POSE.schedule:
        reach, left = share * POSE.reach, copy - master @ pose.linear.T - pose.shift
        weight = (reach**2 / (reach**2 + (left * left).sum(axis=1))) ** 2
        pose = _fit_weighted(master, copy, weight, turn, size)
    return pose


def _fit_weighted(
    master: FloatArray, copy: FloatArray, weight: FloatArray, turn: bool, size: bool
) -> CharacterPose:
    """The pose of least weighted squares."""
    w = weight / weight.sum()
    a, b = w @ master, w @ copy
    m, c = master - a, copy - b
    S = (c * w[:, None]).T @ m
    angle = np.arctan2(S[1, 0] - S[0, 1], S[0, 0] + S[1, 1]) if turn else 0.0
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    scale = float(np.sum(R * S) / max(float(w @ (m * m).sum(axis=1)), 1e-9)) if size else 1.0
    linear = max(scale, POSE.min_scale) * R
    return CharacterPose(linear, b - linear @ a)


def find_squeeze(
    master: FloatArray, copy: FloatArray, *, owner: IntArray, double: FloatArray
) -> Squeeze | None:
    """The clearer of left against right and top against bottom; None when neither is squeezed.

    master, copy: (n, 2) the same points, pose taken out. owner: (n,) number of the stroke. double: (n, 2)
    (cos 2t, sin 2t) of the direction: where a point lies along its own stroke cannot be seen.
    """
    ends = np.concatenate([[True], np.diff(owner) != 0]) | np.concatenate([np.diff(owner) != 0, [True]])
    found = []
    for axis, sign in (("across", -1.0), ("down", 1.0)):
        seen = np.where(ends, 1.0, (1.0 + sign * double[:, 0]) / 2 + SQUEEZE.along_weight)
        squeeze = _fit_squeeze(master, copy, axis, seen)  # type: ignore[arg-type]
        if squeeze and _is_clear(squeeze, _count_explained(squeeze, master, copy, owner)):
            before, after = (share_in_place(copy - to, owner) for to in (master, squeeze.apply(master)))
            if after - before >= SQUEEZE.min_stroke_share:
                found.append(squeeze)
    return max(found, key=lambda q: q.gain) if found else None


def _is_clear(q: Squeeze, strokes: int) -> bool:
    """Whether both parts are wrong, the one too wide and the other too narrow, in enough strokes."""
    s = SQUEEZE
    if max(q.first / q.second, q.second / q.first) < s.min_ratio:
        return False
    opposed = (q.first - 1.0) * (q.second - 1.0) < 0 and min(
        abs(q.first - 1), abs(q.second - 1)
    ) >= s.min_change
    if strokes >= s.min_strokes + (0 if opposed else 2) and q.gain >= s.min_gain:
        return True
    return opposed and strokes >= 2 * s.min_strokes and q.gain >= s.min_gain_opposed


def share_in_place(left: FloatArray, owner: IntArray) -> float:
    """Share of the strokes that are where they should be, softly counted, a short one like a long one.

    left: (n, 2) how far each point is off.
    """
    count = np.bincount(owner)
    there = np.bincount(owner, np.exp(-0.5 * (left * left).sum(axis=1) / SQUEEZE.in_place_distance**2))
    return float((there[count > 0] / count[count > 0]).mean())


def _count_explained(q: Squeeze, master: FloatArray, copy: FloatArray, owner: IntArray) -> int:
    """How many strokes it explains; with one stroke only, that stroke is displaced instead."""
    k = 0 if q.axis == "across" else 1
    count = np.maximum(np.bincount(owner), 1)
    before, after = (np.bincount(owner, np.abs(copy - to)[:, k]) / count for to in (master, q.apply(master)))
    return int(((before > SQUEEZE.off_distance) & (after < SQUEEZE.improved_share * before)).sum())


def _fit_squeeze(master: FloatArray, copy: FloatArray, axis: Axis, seen: FloatArray) -> Squeeze | None:
    """The best squeeze along one axis; None where nothing is left to explain or no part is large enough."""
    s, k = SQUEEZE, 0 if axis == "across" else 1
    x, y = master[:, k], copy[:, k]
    straight = float(_fit_least_absolute(np.column_stack([np.ones_like(x), x])[None], y, seen)[0][0])
    if straight <= s.min_residual:
        return None
    at = x.min() + np.linspace(*s.borders, s.candidates) * (x.max() - x.min())
    away = x - at[:, None]
    smaller = np.minimum((away < 0) @ seen, (away > 0) @ seen)
    large = smaller >= s.min_part_share * seen.sum()
    at, away = at[large], away[large]
    bent = np.stack([np.ones_like(away), np.minimum(away, 0), np.maximum(away, 0)], axis=-1)
    left, coefficients = _fit_least_absolute(bent, y, seen)
    left = np.where((coefficients[:, 1:] > s.min_width).all(axis=1), left, np.inf)
    if len(left) == 0 or not np.isfinite(left.min()):
        return None
    best = int(left.argmin())
    c, a, b = (float(v) for v in coefficients[best])
    return Squeeze(axis, float(at[best]), c, a, b, 1.0 - float(left[best]) / max(straight, 1e-9))


def _fit_least_absolute(A: FloatArray, y: FloatArray, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least absolute deviations by reweighting, of p designs (p, n, c) at a time.

    (p,) means of what is left, and (p, c) coefficients.
    """
    weight = np.broadcast_to(seen, A.shape[:2])
    left: FloatArray = np.zeros(A.shape[:2])
    coefficients: FloatArray = np.zeros((len(A), A.shape[2]))
    for _ in range(SQUEEZE.rounds):
        B = (A * weight[:, :, None]).transpose(0, 2, 1)
        coefficients = np.linalg.solve(B @ A + 1e-9 * np.eye(A.shape[2]), (B @ y)[:, :, None])[:, :, 0]
        left = np.abs(y - (A @ coefficients[:, :, None])[:, :, 0])
        weight = seen / np.maximum(left, SQUEEZE.floor)
    return (left @ seen) / seen.sum(), coefficients
