"""Centre lines of a sheet, ready to be matched: the master's by stroke, the copy's as they come."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rumu.assessment.matching import Points
from rumu.assessment.sheets import RADIUS, Sheet, frame
from rumu.surface.skeleton import Skeleton, Stroke, skeletonise, strokes
from rumu.values import BoolArray, FloatArray

FEWEST_WIDTHS = 0.9
"""A line shorter than so many stroke widths that joins another is a corner of it and no stroke."""
SPECK = 0.008
"""Share of the ink below which a lone dot is no stroke."""
CORNER = 50.0
"""Degrees of turning, over a stroke's width to each side, at which one stroke becomes two."""
MOST_POINTS = 180
"""Points on all lines of a sheet together, so that matching takes the same time for every character."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One stroke of the master, between corners.

    points: (n, 2) in the frame of `sheets`, as it is written: from left to right, or downward.
    radius: (n,) half-width, rms radii. free: whether its beginning and its end join nothing.
    clear: (n,) away from forks, where the half-width is the stroke's own. arc: (n,) way along the line from
        its beginning, rms radii.
    """

    points: FloatArray
    radius: FloatArray
    free: tuple[bool, bool]
    clear: BoolArray
    arc: FloatArray

    @property
    def length(self) -> float:
        return float(self.arc[-1])

    @property
    def chord(self) -> FloatArray:
        return np.asarray(self.points[-1] - self.points[0])


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """The lines of a sheet. width: of a common stroke, rms radii; points: along the lines."""

    lines: tuple[Line, ...]
    points: Points
    width: float
    skeleton: Skeleton


def master_drawing(sheet: Sheet) -> Drawing:
    """The strokes of the master, longest first, corners cut; corners' whiskers are left out."""
    skeleton = skeletonise(sheet.ink)
    pieces = [piece for s in strokes(skeleton) for piece in _cut(s, skeleton)]
    least = FEWEST_WIDTHS * skeleton.width
    longest = max(pieces, key=lambda s: s.length)
    ink = SPECK * sheet.ink.sum()
    kept = [
        p for p in pieces if p.length >= least or (all(_free(p, skeleton)) and _area(p) > ink) or p is longest
    ]
    lines = tuple(_line(p, skeleton) for p in sorted(kept, key=lambda p: -p.length))
    return Drawing(lines, points_along(lines), skeleton.width / RADIUS, skeleton)


def copy_drawing(sheet: Sheet) -> Drawing:
    """All lines of the copy, by segment: which strokes they belong to is what matching finds out."""
    skeleton = skeletonise(sheet.ink)
    lines = tuple(
        Line(frame(s.points), s.radius / RADIUS, (False, False), _clear(s.points, skeleton), _arc(s.points))
        for s in skeleton.segments
    )
    return Drawing(lines, points_along(lines), skeleton.width / RADIUS, skeleton)


def _area(stroke: Stroke) -> float:
    """Of its ink, in pixels."""
    r = float(stroke.radius.mean())
    return 2.0 * r * stroke.length + np.pi * r**2


def _cut(stroke: Stroke, skeleton: Skeleton) -> list[Stroke]:
    """A stroke in pieces, from corner to corner."""
    n, arm = len(stroke.points), max(round(skeleton.width), 3)
    if n < 4 * arm:
        return [stroke]
    p = stroke.points
    before, after = p[arm:-arm] - p[: -2 * arm], p[2 * arm :] - p[arm:-arm]
    cos = (before * after).sum(axis=1) / np.maximum(np.hypot(*before.T) * np.hypot(*after.T), 1e-9)
    turning = np.zeros(n)
    turning[arm:-arm] = np.degrees(np.arccos(np.clip(cos, -1.0, 1.0)))
    turning[: int(1.3 * arm)] = turning[n - int(1.3 * arm) :] = 0.0
    cuts: list[int] = []
    while turning.max() >= CORNER:
        k = int(turning.argmax())
        cuts.append(k)
        turning[max(k - 2 * arm, 0) : k + 2 * arm] = 0.0
    marks = [0, *sorted(cuts), n - 1]
    return [_piece(stroke, a, b) for a, b in pairwise(marks)]


def _piece(stroke: Stroke, a: int, b: int) -> Stroke:
    points, radius = stroke.points[a : b + 1], stroke.radius[a : b + 1]
    # a cut end joins the piece beside it: no node of its own
    ends = (stroke.ends[0] if a == 0 else -1, stroke.ends[1] if b == len(stroke.points) - 1 else -1)
    right, down = points[-1] - points[0]
    if (right < 0) if abs(right) >= abs(down) else (down < 0):
        return Stroke(points[::-1], radius[::-1], (ends[1], ends[0]), stroke.segments)
    return Stroke(points, radius, ends, stroke.segments)


def _free(stroke: Stroke, skeleton: Skeleton) -> tuple[bool, bool]:
    first, last = (end >= 0 and bool(skeleton.degree[end] < 2) for end in stroke.ends)
    return first, last


def _line(stroke: Stroke, skeleton: Skeleton) -> Line:
    points, radius, free = stroke.points, stroke.radius, _free(stroke, skeleton)
    right, down = points[-1] - points[0]
    if (
        right > 0 and down < -0.45 * right and _tapers_to_start(radius)
    ):  # a left-falling stroke that lies flat
        points, radius, free = points[::-1], radius[::-1], free[::-1]
    return Line(frame(points), radius / RADIUS, free, _clear(points, skeleton), _arc(points))


def _arc(points: FloatArray) -> FloatArray:
    """(n,) way along points of a sheet, rms radii."""
    step = np.diff(points, axis=0)
    arc = np.zeros(len(points))
    np.cumsum(np.sqrt((step * step).sum(axis=1)) / RADIUS, out=arc[1:])
    return arc


def _tapers_to_start(radius: FloatArray) -> bool:
    third = max(len(radius) // 3, 1)
    return float(radius[:third].mean()) < 0.85 * float(radius[-third:].mean())


def _clear(points: FloatArray, skeleton: Skeleton) -> BoolArray:
    forks = skeleton.nodes[skeleton.degree > 2]
    if len(forks) == 0:
        return np.ones(len(points), bool)
    near = ((points[:, None] - forks) ** 2).sum(axis=2).min(axis=1)
    return np.asarray(near > (0.75 * skeleton.width) ** 2)


def points_along(lines: tuple[Line, ...], *, most: int = MOST_POINTS) -> Points:
    """Points on lines, one each 0.05 rms radii, or about `most` where the lines are long."""
    total = sum(line.length for line in lines)
    spacing = max(0.05, total / most)
    xy, double, radius, owner, clear = [], [], [], [], []
    for k, line in enumerate(lines):
        arc = line.arc
        at = np.linspace(0.0, arc[-1], max(round(arc[-1] / spacing) + 1, 2)) if arc[-1] > 0 else np.zeros(1)
        points = np.column_stack([np.interp(at, arc, line.points[:, i]) for i in (0, 1)])
        ways = np.gradient(points, axis=0) if len(points) > 1 else np.zeros((1, 2))
        angle = 2 * np.arctan2(ways[:, 1], ways[:, 0])
        known = (np.hypot(*ways.T) > 1e-9).astype(float)
        xy.append(points)
        double.append(np.column_stack([np.cos(angle), np.sin(angle)]) * known[:, None])
        radius.append(np.interp(at, arc, line.radius))
        owner.append(np.full(len(at), k))
        clear.append(np.interp(at, arc, line.clear.astype(float)) > 0.5)
    return Points(
        xy=np.concatenate(xy),
        double=np.concatenate(double),
        radius=np.concatenate(radius),
        owner=np.concatenate(owner),
        clear=np.concatenate(clear),
        spacing=spacing,
    )
