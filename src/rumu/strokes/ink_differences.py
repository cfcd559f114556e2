"""How the copy's ink differs from the master's along each stroke: what a fault must be seen in.

Lines that are laid on ink may be laid in two ways that are nearly as good, and then a perfect copy seems to
have a turned stroke. So the ink itself is compared, in a strip along the master's line and a little beyond
its ends: the master's ink there, and the copy's where the whole character's size, place and lean put the
strip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import CentreLines, FramedInk, LinePoints, to_pixels
from rumu.strokes.pose import CharacterPose
from rumu.strokes.stance import Squeeze
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class StripSettings:
    """The strip along a stroke in which ink is compared.

    across: half-widths of the stroke to each side, and columns: how many samples there. beyond: stroke widths
    by which it goes on past each end. core: half-widths to each side within which the ink of an end is looked
    for. end_widths, end_share: how much of the stroke is an end: widths, but at most so large a share.
    """

    across: float = 1.8
    columns: int = 13
    beyond: float = 1.5
    core: float = 0.5
    end_widths: float = 1.2
    end_share: float = 0.4


STRIP = StripSettings()


@dataclass(frozen=True, slots=True, eq=False)
class MasterStrips:
    """The strips of a master's strokes, in steps along each; made once for all copies.

    grid: (n, columns, 2) where samples are taken, in the common frame. owner: (n,) number of the line.
    along: (n,) rms radii from the line's beginning, below 0 before it. lengths, steps: (k,) of each line and
    between its samples, rms radii. ink: (n, columns) of the master, 0 to 1.
    """

    grid: FloatArray
    owner: IntArray
    along: FloatArray
    lengths: FloatArray
    steps: FloatArray
    ink: FloatArray


@dataclass(frozen=True, slots=True)
class InkDifference:
    """How a stroke's ink differs; shares of the master's ink in its strip, 0 where the ink is the same.

    unlike: where the whole character's faults put the stroke. moved: the same when the stroke's own shift and
    turn are taken out, which is less when they are true. entry, exit: as unlike, of the ends alone.
    fuller: how much more ink there is where the stroke is, below 0 for less. lacking: by which the ink ends
    too early, both ends together, over the stroke's length, its turn and its shift sideways taken out; below
    0 where it goes on too far.
    """

    unlike: float
    moved: float
    entry: float
    exit: float
    fuller: float
    lacking: float


UNSEEN = InkDifference(float("inf"), 0.0, float("inf"), float("inf"), 0.0, 0.0)
"""Of a stroke too short to have a strip: nothing speaks against what was measured."""


def cut_strips(lines: CentreLines, framed: FramedInk) -> MasterStrips:
    """The strips of all lines with the ink that lies in them."""
    points, columns = lines.points, np.linspace(-STRIP.across, STRIP.across, STRIP.columns)
    grids, along, owner, steps = [], [], [], np.zeros(len(lines.lines))
    for k in range(len(lines.lines)):
        own = points.owner == k
        xy = points.xy[own]
        if len(xy) < 2:
            continue
        steps[k] = step = max(float(np.hypot(*np.diff(xy, axis=0).T).mean()), 1e-6)
        more = max(round(STRIP.beyond * lines.width / step), 2)
        path = np.concatenate([_beyond(xy[::-1], step, more)[::-1], xy, _beyond(xy, step, more)])
        ways = np.gradient(path, axis=0)
        ways /= np.maximum(np.hypot(*ways.T), 1e-9)[:, None]
        aside = np.column_stack([-ways[:, 1], ways[:, 0]]) * float(np.median(points.radius[own]))
        grids.append(path[:, None] + columns[:, None] * aside[:, None])
        along.append(step * (np.arange(len(path)) - more))
        owner.append(np.full(len(path), k))
    grid = np.concatenate(grids or [np.zeros((0, STRIP.columns, 2))])
    return MasterStrips(
        grid,
        np.concatenate(owner or [np.zeros(0, int)]),
        np.concatenate(along or [np.zeros(0)]),
        np.array([line.length for line in lines.lines]),
        steps,
        _ink_at(framed, grid),
    )


@dataclass(frozen=True, slots=True, eq=False)
class InkComparison:
    """A master's strips on a copy.

    lines: the master's. framed_master, framed: the ink of both in the common frame. pose, squeeze: of the
    copy. places: (n, 2) where the master's points lie in itself; moved: (n, 2) where they lie in the copy.
    """

    strips: MasterStrips
    lines: CentreLines
    framed_master: FramedInk
    framed: FramedInk
    pose: CharacterPose
    squeeze: Squeeze | None
    places: FloatArray
    moved: FloatArray

    def differences(self) -> tuple[InkDifference, ...]:
        """How the ink of each stroke differs from its master's."""
        strips, count = self.strips, len(self.lines.lines)
        length = strips.lengths[strips.owner]
        inside = (strips.along >= 0) & (strips.along <= length + 1e-6)
        still, moved, pushed = (_ink_at(self.framed, grid) for grid in self._placed())

        least = np.full(strips.ink.shape, 0.5 / STRIP.across)

        def share(ink: FloatArray, part: BoolArray) -> FloatArray:
            own = np.maximum(
                _sums(strips, strips.ink, part & inside, count), _sums(strips, least, part & inside, count)
            )
            return _sums(strips, ink, part, count) / np.maximum(own, 1.0)

        every = np.ones(len(strips.along), bool)
        end = np.minimum(STRIP.end_widths * self.lines.width, STRIP.end_share * length)
        numbers = zip(
            share(np.abs(still - strips.ink), every),
            share(np.abs(moved - strips.ink), every),
            share(np.abs(still - strips.ink), strips.along <= end),
            share(np.abs(still - strips.ink), strips.along >= length - end),
            share(moved - strips.ink, inside),
            _lacking(strips, pushed),
            strict=True,
        )
        return tuple(
            InkDifference(*(float(value) for value in row)) if step > 0 else UNSEEN
            for row, step in zip(numbers, strips.steps, strict=True)
        )

    def _placed(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The grid in the copy: as the whole stands; as each stroke does; and as that but not slid along."""
        strips, points = self.strips, self.lines.points
        expected = self._in_copy(self.places)
        grid = self._in_copy(strips.grid.reshape(-1, 2)).reshape(strips.grid.shape)
        before, after, turns = _rigid_moves(points, expected, self.moved)
        shift, chord = after - before, _chords(points, expected)
        aside = shift - (shift * chord).sum(axis=1)[:, None] * chord
        owner = strips.owner
        turned = np.einsum("nij,ncj->nci", turns[owner], grid - before[owner, None])
        return grid, turned + after[owner, None], turned + (before + aside)[owner, None]

    def _in_copy(self, points: FloatArray) -> FloatArray:
        """(n, 2) of the master -> where the whole's pose and a squeezed part put them in the copy's frame."""
        squeezed = points if self.squeeze is None else self.squeeze.apply(points)
        cell = squeezed @ self.pose.linear.T + self.pose.shift
        picture, to_picture = self.framed_master.on_picture(cell), self.framed.to_picture
        return np.asarray((picture - to_picture[:, 2]) @ np.linalg.inv(to_picture[:, :2]).T)


def _beyond(path: FloatArray, step: float, count: int) -> FloatArray:
    """(count, 2): a path goes on, straight, past its last point."""
    way = path[-1] - path[max(len(path) - 4, 0)]
    return np.asarray(
        path[-1] + step * np.arange(1, count + 1)[:, None] * way / max(float(np.hypot(*way)), 1e-9)
    )


def _ink_at(framed: FramedInk, points: FloatArray) -> FloatArray:
    """(...,) from 0 to 1: the ink at (..., 2) points of the common frame."""
    import cv2

    if not points.size:
        return np.zeros(points.shape[:-1])
    at = to_pixels(points).astype(np.float32)
    ink = framed.ink.view(np.uint8).astype(np.float32)
    return np.asarray(cv2.remap(ink, at[..., 0], at[..., 1], cv2.INTER_LINEAR), dtype=float)


def _rigid_moves(
    points: LinePoints, before: FloatArray, after: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(k, 2) middles of each line before and after, and (k, 2, 2) the turn that takes one to the other."""
    owner = points.owner
    count = np.bincount(owner).astype(float)[:, None]
    a, b = (np.column_stack([np.bincount(owner, at[:, i]) for i in (0, 1)]) / count for at in (before, after))
    p, q = before - a[owner], after - b[owner]
    angle = np.arctan2(
        np.bincount(owner, p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]), np.bincount(owner, (p * q).sum(axis=1))
    )
    c, s = np.cos(angle), np.sin(angle)
    return a, b, np.stack([np.column_stack([c, -s]), np.column_stack([s, c])], axis=1)


def _chords(points: LinePoints, at: FloatArray) -> FloatArray:
    """(k, 2) unit vectors from the first to the last point of each line."""
    starts = np.flatnonzero(np.concatenate([[True], np.diff(points.owner) != 0]))
    ends = np.concatenate([starts[1:], [len(points.owner)]]) - 1
    chord = at[ends] - at[starts]
    return np.asarray(chord / np.maximum(np.hypot(*chord.T), 1e-9)[:, None])


def _sums(strips: MasterStrips, values: FloatArray, part: BoolArray, count: int) -> FloatArray:
    """(k,) sums over each line's part of its strip."""
    return np.asarray(np.bincount(strips.owner, values.sum(axis=1) * part, minlength=count), dtype=float)


def _lacking(strips: MasterStrips, copy: FloatArray) -> FloatArray:
    """(k,) by how much the copy's ink, (n, columns), ends earlier than the master's, over the lengths."""
    core = np.abs(np.linspace(-STRIP.across, STRIP.across, STRIP.columns)) <= STRIP.core
    inked, wanted = (ink[:, core].mean(axis=1) > 0.5 for ink in (copy, strips.ink))
    lacking = np.zeros(len(strips.steps))
    for k in np.unique(strips.owner):
        own = strips.owner == k
        for way in (1, -1):
            ink, want = inked[own][::way], wanted[own][::way]
            half = len(ink) // 2
            first, begin = (int(np.argmax(run)) if run.any() else half for run in (ink, want))
            lacking[k] += (first - begin) * strips.steps[k]
    return np.asarray(lacking / np.maximum(strips.lengths, 1e-9))
