"""How the copy stands in its cell: what the strokes agree upon.

The registration rests on all ink; a stroke that was moved, left out or put in pulls it along. Here the pose
is what most of the strokes say, and the simplest one that explains them: a character is taken to stand
where its master stands until its strokes say otherwise together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.values import FloatArray, IntArray


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


POSE = PoseSettings()


@dataclass(frozen=True, slots=True, eq=False)
class CharacterPose:
    """x -> linear x + shift, from the master's place in the cell to the copy's; y down.

    angle: degrees, positive clockwise. scale: of the copy, 1 is the same. aspect: natural logarithm of its
    width over its height, over the same of the master; above 0 it is too wide.
    """

    linear: FloatArray
    shift: FloatArray

    @property
    def scale(self) -> float:
        return float(np.sqrt(np.linalg.det(self.linear)))

    @property
    def angle(self) -> float:
        return float(np.degrees(np.arctan2(self.linear[1, 0], self.linear[0, 0])))

    @property
    def aspect(self) -> float:
        across, down = np.hypot(*self.linear)
        return float(np.log(across / down))

    def undo(self, points: FloatArray) -> FloatArray:
        """Points of the copy where they would be in an upright copy of the master's size and place."""
        return np.asarray((points - self.shift) @ np.linalg.inv(self.linear).T)


NO_POSE = CharacterPose(np.eye(2), np.zeros(2))


def find_pose(master: FloatArray, copy: FloatArray, *, owner: IntArray, double: FloatArray) -> CharacterPose:
    """The pose that most points agree upon; (n, 2) points of the master and where the copy has them.

    owner: (n,) number of the stroke. double: (n, 2) (cos 2t, sin 2t) of its direction.
    """
    left = copy - master
    if len(master) < 4 or _is_one_out_of_place(left, owner):
        return NO_POSE
    if _is_one_out_of_place(_without_slide(left, double), owner, out_share=POSE.out_share):
        return NO_POSE
    poses = [NO_POSE, *_fit_robust(master, copy)]
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


_PARTS = np.array([(False, False), (True, False), (False, True), (True, True)])
"""Whether a pose turns and whether it changes the size, from simple to rich; all of them shift."""


def _fit_robust(master: FloatArray, copy: FloatArray) -> list[CharacterPose]:
    """A pose of each kind, fitted with Geman and McClure's weights, which downweight outliers.

    Their reach shrinks.
    """
    linear, shift = _fit_weighted(master, copy, np.ones((len(_PARTS), len(master))))
    for share in POSE.schedule:
        reach = share * POSE.reach
        left = copy - master @ linear.transpose(0, 2, 1) - shift[:, None]
        weight = (reach**2 / (reach**2 + (left * left).sum(axis=2))) ** 2
        linear, shift = _fit_weighted(master, copy, weight)
    return [CharacterPose(*fit) for fit in zip(linear, shift, strict=True)]


def _fit_weighted(master: FloatArray, copy: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(k, 2, 2) and (k, 2): of each kind of pose the one of least squares with its weights, (k, n)."""
    w = weight / weight.sum(axis=1, keepdims=True)
    a, b = w @ master, w @ copy
    m, c = master - a[:, None], copy - b[:, None]
    S = (c * w[:, :, None]).transpose(0, 2, 1) @ m
    angle = np.where(_PARTS[:, 0], np.arctan2(S[:, 1, 0] - S[:, 0, 1], S[:, 0, 0] + S[:, 1, 1]), 0.0)
    cos, sin = np.cos(angle), np.sin(angle)
    R = np.stack([cos, -sin, sin, cos], axis=1).reshape(-1, 2, 2)
    spread = np.maximum((w * (m * m).sum(axis=2)).sum(axis=1), 1e-9)
    scale = np.where(_PARTS[:, 1], (R * S).sum(axis=(1, 2)) / spread, 1.0)
    linear = np.maximum(scale, POSE.min_scale)[:, None, None] * R
    return linear, b - (linear @ a[:, :, None])[:, :, 0]
