"""How a copy stands and what it is too wide in: a part of it for the other, or the whole for its height.

Both are looked for in what the pose leaves (see `pose`): no stroke is blamed for what all do together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.strokes.pose import NO_POSE, CharacterPose, find_pose
from rumu.values import FloatArray, IntArray

Axis = Literal["across", "down"]


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
    well: share of the strokes in their place from which none is looked for in the copy as it stands.
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
    well: float = 0.9


@dataclass(frozen=True, slots=True)
class AspectSettings:
    """What makes a character too wide, or too narrow, for its height.

    least: natural logarithm of its width over its height, over the same of the master, from which it is.
    strokes: that the master must have; min_stroke_share: share of them that it must put in their place.
    left_share: share of the mean distance, of all points, that it may leave.
    slim: the master's narrower extent over its wider one at least, since the height of 一 says nothing.
    spread: share of that of all points that must be left without one of the strokes.
    """

    least: float = 0.12
    strokes: int = 3
    min_stroke_share: float = 0.05
    left_share: float = 0.85
    slim: float = 0.4
    spread: float = 0.5


SQUEEZE, ASPECT = SqueezeSettings(), AspectSettings()


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


def find_stance(
    master: FloatArray, copy: FloatArray, *, owner: IntArray, double: FloatArray
) -> tuple[CharacterPose, Squeeze | None]:
    """Pose and squeeze of the whole; (n, 2) points of the master and where the copy has them.

    owner: (n,) number of the stroke. double: (n, 2) (cos 2t, sin 2t) of its direction.
    A squeeze keeps the outer edges and draws the middle along, so that a pose may take most of it for its
    own: it is looked for in the copy as it stands, too. Where there is none, the whole may be too wide or too
    narrow for its height; then the pose has that aspect.
    """
    pose = find_pose(master, copy, owner=owner, double=double)
    upright = pose.undo(copy)
    squeeze = _find_squeeze(master, upright, owner=owner, double=double)
    if squeeze is not None:
        return pose, squeeze
    well = _share_in_place(upright - master, owner)
    if pose.shift.any() and well < SQUEEZE.well:
        squeeze = _find_squeeze(master, copy, owner=owner, double=double)
        if squeeze is not None and _share_in_place(copy - squeeze.apply(master), owner) > well:
            return NO_POSE, squeeze
    aspect = _measure_aspect(master, upright, owner)
    if aspect:
        shape = np.exp(np.array([0.5, -0.5]) * aspect)
        found = find_pose(master * shape, copy, owner=owner, double=double)
        shaped = CharacterPose(found.linear * shape, found.shift)
        left = shaped.undo(copy) - master
        # neither one stroke that is too short nor two parts too close together make a character narrow
        in_place = _share_in_place(left, owner) - well >= ASPECT.min_stroke_share
        most = min(ASPECT.left_share * _mean_length(upright - master), _left_by_gap(master, upright, owner))
        if in_place and _mean_length(left) < most:
            return shaped, None
    return pose, None


def _left_by_gap(master: FloatArray, copy: FloatArray, owner: IntArray) -> float:
    """Mean distance that is left when two parts of a character stand too close together, or too far apart.

    Of left and right, and of top and bottom, wherever they may meet: the least.
    """
    left, least = copy - master, _mean_length(copy - master)
    middles = np.stack([np.bincount(owner, each) for each in master.T]) / np.maximum(np.bincount(owner), 1)
    for at, middle in zip(master.T, middles, strict=True):
        for border in at.min() + np.linspace(*SQUEEZE.borders, SQUEEZE.candidates) * np.ptp(at):
            first = middle[owner] < border
            if not first.any() or first.all():
                continue
            apart = np.where(first[:, None], np.median(left[first], axis=0), np.median(left[~first], axis=0))
            least = min(least, _mean_length(left - apart))
    return least


def _mean_length(vectors: FloatArray) -> float:
    return float(np.hypot(*vectors.T).mean())


def _measure_aspect(master: FloatArray, copy: FloatArray, owner: IntArray) -> float:
    """Natural logarithm of the copy's width over its height, over the master's; 0 where it is about the same.

    The points' spread without any one of the strokes, that of all points and the extent must all say so. The
    middle one of the three is given.
    """
    extents = np.ptp(master, axis=0)
    if len(np.unique(owner)) < ASPECT.strokes or extents.min() < ASPECT.slim * extents.max():
        return 0.0
    across, down = (np.log(widening(master[:, k], copy[:, k], owner)) for k in (0, 1))
    spread = np.log(np.maximum(copy.std(axis=0), 1e-6) / master.std(axis=0))
    extent = np.log(np.maximum(np.ptp(copy, axis=0), 1e-6) / extents)
    readings = sorted([float(across - down), float(spread[0] - spread[1]), float(extent[0] - extent[1])])
    return readings[1] if min(readings) >= ASPECT.least or max(readings) <= -ASPECT.least else 0.0


def widening(master: FloatArray, copy: FloatArray, owner: IntArray) -> float:
    """Width of some strokes over the master's; master, copy: (n,) their points along an axis, by stroke.

    One stroke that is too long does not make them wide: of the widths without any one of the strokes, and
    of that from edge to edge, the one counts that is nearest to the master's.
    """
    extent = np.ptp(copy) / max(float(np.ptp(master)), 1e-6)
    own, all_but_one = (_spread_without(values, owner) for values in (master, copy))
    enough = own >= ASPECT.spread * own[0]
    logs = np.log(np.append(all_but_one[enough] / np.maximum(own[enough], 1e-6), extent) + 1e-9)
    if logs.min() < 0 < logs.max():
        return 1.0
    return float(np.exp(logs[np.abs(logs).argmin()]))


def _spread_without(values: FloatArray, owner: IntArray) -> FloatArray:
    """(1 + k,) standard deviation of (n,) values, of all and without each of k strokes; -1 of none."""
    values = values - values.mean()
    count, total, squares = (
        np.concatenate([[0.0], np.bincount(owner, weights)[np.bincount(owner) > 0]])
        for weights in (None, values, values * values)
    )
    left = [each.sum() - each for each in (count, total, squares)]
    mean = left[1] / np.maximum(left[0], 1.0)
    variance = np.maximum(left[2] / np.maximum(left[0], 1.0) - mean * mean, 0.0)
    return np.asarray(np.where(left[0] > 0, np.sqrt(variance), -1.0))


def _find_squeeze(
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
            before, after = (_share_in_place(copy - to, owner) for to in (master, squeeze.apply(master)))
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


def _share_in_place(left: FloatArray, owner: IntArray) -> float:
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
