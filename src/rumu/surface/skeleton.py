"""The skeleton of a mask, cleaned, and the strokes that run through it.

Thinning leaves a short bridge where strokes cross and a short branch at every bump of the edge. So forks
closer than a stroke's width are merged, and branches that do not stick out of the stroke are pruned. Points
are (x, y) in pixels, x the column and y the row; everything here depends on the mask alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from rumu.capture.image import bounding_box
from rumu.errors import SurfaceError
from rumu.surface.thinning import RawSkeleton, Segment, thin, value_near
from rumu.values import BoolArray, FloatArray, IntArray, Polyline


@dataclass(frozen=True, slots=True)
class SkeletonSettings:
    """How a skeleton is cleaned; lengths are in stroke widths.

    shortest_branch: a branch that is shorter is pruned. protrusion: so is one whose tip sticks out of the
        ink of its fork by less. smoothing: reach of the moving mean along a line, to each side.
    rounds: most times that forks are merged and branches pruned.
    """

    shortest_branch: float = 0.5
    protrusion: float = 0.3
    smoothing: float = 0.3
    rounds: int = 6


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The centre lines of a mask.

    nodes: (k, 2) float64, (x, y) of ends and forks. degree: (k,) how many line ends meet there: 1 an end,
        3 or more a fork, 2 a ring's beginning, 0 a dot. segments: what runs between them.
    width: twice the median half-width along the lines, in pixels.
    """

    nodes: FloatArray
    degree: IntArray
    segments: tuple[Segment, ...]
    width: float


@dataclass(frozen=True, slots=True, eq=False)
class Stroke(Polyline):
    """A line that a brush could have drawn in one go, in pixels (x column, y row); see `as_written`.

    ends: numbers of the skeleton's nodes, -1 where the stroke was cut. segments: numbers of the segments it
        is made of, in order.
    """

    ends: tuple[int, int]
    segments: tuple[int, ...]

    def reversed(self) -> Self:
        """The same stroke from its other end."""
        return replace(
            self,
            points=self.points[::-1],
            radius=self.radius[::-1],
            ends=self.ends[::-1],
            segments=self.segments[::-1],
        )

    def part(self, first: int, last: int) -> Self:
        """The stroke from the point numbered `first` to the one numbered `last`, both included."""
        return replace(
            self,
            points=self.points[first : last + 1],
            radius=self.radius[first : last + 1],
            ends=(self.ends[0] if first == 0 else -1, self.ends[1] if last == len(self.points) - 1 else -1),
        )


def skeletonise(mask: BoolArray, *, settings: SkeletonSettings | None = None) -> Skeleton:
    """The skeleton of a mask (H, W) bool: branches pruned, forks merged, rings and lone dots kept.

    Raises SurfaceError for an empty mask or one that is no mask.
    """
    if mask.ndim != 2 or mask.dtype != np.bool_:
        raise SurfaceError(f"expected an (H, W) bool mask, got {mask.dtype} {mask.shape}")
    if not mask.any():
        raise SurfaceError("expected a mask that holds ink, got an empty one")
    settings = settings or SkeletonSettings()
    y0, y1, x0, x1 = bounding_box(mask)
    raw = thin(np.ascontiguousarray(mask[y0:y1, x0:x1]))
    width = 2.0 * float(np.median(np.concatenate([s.radius for s in raw.segments])))
    nodes, segments = _clean(raw, width, settings)
    origin = np.array([x0, y0], float)
    used = sorted({end for s in segments for end in s.ends})
    number = {node: k for k, node in enumerate(used)}
    lines = tuple(
        Segment(
            _smooth(s.points, reach=settings.smoothing * width) + origin,
            s.radius,
            (number[s.ends[0]], number[s.ends[1]]),
        )
        for s in segments
    )
    degree = _degrees(len(used), (s.ends for s in lines if len(s.points) > 1))
    return Skeleton(nodes[used] + origin, degree, lines, width)


def strokes(skeleton: Skeleton, *, turn: float = 35.0) -> tuple[Stroke, ...]:
    """Segments joined through forks where one continues the direction of another, straightest first.

    turn: most degrees that a stroke bends in a fork. Longest stroke first.
    """
    follows = _good_continuations(skeleton, turn=turn)
    result, used = [], set[int]()
    for k in range(len(skeleton.segments)):
        if k not in used:
            chain = _chain(k, follows)
            used.update(number for number, _ in chain)
            result.append(_join(skeleton, chain))
    return tuple(sorted(result, key=lambda s: -s.length))


def as_written(stroke: Stroke) -> Stroke:
    """The stroke from left to right, or from top to bottom where it is steeper than 45 degrees."""
    right, down = stroke.chord
    backward = right < 0 if abs(right) >= abs(down) else down < 0
    return stroke.reversed() if backward else stroke


# --- cleaning ------------------------------------------------------------------------------------------


def _clean(raw: RawSkeleton, width: float, settings: SkeletonSettings) -> tuple[FloatArray, list[Segment]]:
    """Merge forks and prune branches until nothing changes; where only two lines meet they become one."""
    nodes, segments = raw.nodes, raw.segments
    for _ in range(settings.rounds):
        before = len(segments)
        nodes, segments = _merge_forks(nodes, segments, raw.half_width, width)
        segments = _join_pairs(_prune(segments, width, settings))
        if len(segments) == before:
            break
    return nodes, segments


def _merge_forks(
    nodes: FloatArray, segments: list[Segment], half_width: FloatArray, width: float
) -> tuple[FloatArray, list[Segment]]:
    """Forks that a bridge shorter than a stroke's width joins become one, in their middle."""
    degree = _degrees(len(nodes), (s.ends for s in segments))
    bridge = [_is_bridge(s, degree, half_width, nodes, width) for s in segments]
    if not any(bridge):
        return nodes, segments
    leader = np.arange(len(nodes))
    for segment, short in zip(segments, bridge, strict=True):
        if short:
            a, b = leader[segment.ends[0]], leader[segment.ends[1]]
            leader[leader == b] = a
    nodes = nodes.copy()
    forks = np.flatnonzero(degree >= 3)
    for k in np.unique(leader[forks]):
        members = forks[leader[forks] == k]
        nodes[k] = nodes[members].mean(axis=0)
    rest = []
    for segment, short in zip(segments, bridge, strict=True):
        if not short:
            a, b = int(leader[segment.ends[0]]), int(leader[segment.ends[1]])
            points = segment.points.copy()
            if len(points) > 1:  # its ends move with their nodes
                points[0], points[-1] = nodes[a], nodes[b]
            rest.append(Segment(points, segment.radius, (a, b)))
    return nodes, rest


def _is_bridge(
    segment: Segment, degree: IntArray, half_width: FloatArray, nodes: FloatArray, width: float
) -> bool:
    a, b = segment.ends
    if len(segment.points) < 2 or degree[a] < 3 or degree[b] < 3:
        return False
    return segment.length < max(width, value_near(half_width, nodes[a]), value_near(half_width, nodes[b]))


def _prune(segments: list[Segment], width: float, settings: SkeletonSettings) -> list[Segment]:
    """Drop the branches that do not stick out; of a blot that is all branches the longest two stay."""
    count = 1 + max(max(s.ends) for s in segments)
    degree = _degrees(count, (s.ends for s in segments))
    pruned = [_is_spur(s, degree, width, settings) for s in segments]
    for k in {
        end for s, spur in zip(segments, pruned, strict=True) if spur for end in s.ends if degree[end] > 2
    }:
        here = [i for i, s in enumerate(segments) if k in s.ends]
        if all(pruned[i] for i in here):
            for i in sorted(here, key=lambda i: -segments[i].length)[:2]:
                pruned[i] = False
    return [s for s, spur in zip(segments, pruned, strict=True) if not spur]


def _is_spur(segment: Segment, degree: IntArray, width: float, settings: SkeletonSettings) -> bool:
    a, b = (int(degree[end]) for end in segment.ends)
    if len(segment.points) < 2 or {a, b} == {1} or min(a, b) != 1:
        return segment.ends[0] == segment.ends[1] and a > 2 and segment.length < width
    fork, tip = segment.radius[[0, -1] if b == 1 else [-1, 0]]
    short = segment.length < settings.shortest_branch * width
    return short or bool(segment.length + tip - fork < settings.protrusion * width)


def _join_pairs(segments: list[Segment]) -> list[Segment]:
    """Two segments that meet in a node where nothing else ends become one."""
    segments = [*segments]
    while True:
        count = 1 + max(max(s.ends) for s in segments)
        degree = _degrees(count, (s.ends for s in segments))
        pair = _first_pair(segments, degree)
        if pair is None:
            return segments
        a, b = (segments[k] for k in pair)
        shared = next(end for end in a.ends if end in b.ends and degree[end] == 2)
        a = a if a.ends[1] == shared else a.reversed()
        b = b if b.ends[0] == shared else b.reversed()
        joined = Segment(
            np.concatenate([a.points, b.points[1:]]),
            np.concatenate([a.radius, b.radius[1:]]),
            (a.ends[0], b.ends[1]),
        )
        segments = [s for k, s in enumerate(segments) if k not in pair] + [joined]


def _first_pair(segments: list[Segment], degree: IntArray) -> tuple[int, int] | None:
    """Numbers of two segments that share a node of degree 2; None when there are none."""
    at_node: dict[int, int] = {}
    for k, segment in enumerate(segments):
        if segment.ends[0] == segment.ends[1]:
            continue
        for end in segment.ends:
            if degree[end] == 2 and end in at_node:
                return at_node[end], k
            at_node[end] = k
    return None


# --- strokes -------------------------------------------------------------------------------------------

Side = tuple[int, int]
"""A segment's number and which of its ends: 0 or 1."""


def _good_continuations(skeleton: Skeleton, *, turn: float) -> dict[Side, Side]:
    """Which end of which segment continues which, both ways; each end at most one other."""
    meeting: dict[int, list[Side]] = {}
    for k, segment in enumerate(skeleton.segments):
        for side, node in enumerate(segment.ends):
            if len(segment.points) > 1 and skeleton.degree[node] > 2:
                meeting.setdefault(node, []).append((k, side))
    away = {at: _leaving_direction(skeleton, *at) for sides in meeting.values() for at in sides}
    follows: dict[Side, Side] = {}
    for sides in meeting.values():
        pairs = [(a, b) for i, a in enumerate(sides) for b in sides[i + 1 :]]
        # degrees by which a brush turns that comes along one and goes on along the other
        bends = sorted((np.rad2deg(np.arccos(np.clip(-(away[a] @ away[b]), -1, 1))), a, b) for a, b in pairs)
        for bend, a, b in bends:
            if bend < turn and a not in follows and b not in follows:
                follows[a], follows[b] = b, a
    return follows


def _leaving_direction(skeleton: Skeleton, number: int, side: int) -> FloatArray:
    """(2,) unit direction in which a segment leaves its node, seen beyond the fork's own distortion."""
    segment = skeleton.segments[number] if side == 0 else skeleton.segments[number].reversed()
    points = segment.points
    distance = np.hypot(*(points - points[0]).T)
    near = int(np.argmax(distance >= min(segment.radius[0], 0.4 * float(distance.max()))))
    beyond = distance >= distance[near] + skeleton.width
    reach = int(np.argmax(beyond)) if beyond.any() else len(points) - 1
    step = points[max(reach, 1)] - points[min(near, max(reach, 1) - 1)]
    return np.asarray(step / max(float(np.hypot(*step)), 1e-9))


def _chain(start: int, follows: dict[Side, Side]) -> list[tuple[int, bool]]:
    """Numbers of the segments of one stroke in order, and whether each runs backward."""
    chain = [(start, False)]
    for side in (1, 0):  # onward from its end, then back from its beginning
        at = (start, side)
        while at in follows and follows[at][0] not in [k for k, _ in chain]:
            number, entered = follows[at]
            if side == 1:
                chain.append((number, entered == 1))
            else:
                chain.insert(0, (number, entered == 0))
            at = (number, 1 - entered)
    return chain


def _join(skeleton: Skeleton, chain: list[tuple[int, bool]]) -> Stroke:
    """Segments laid end to end, with straight bridges across the forks between them."""
    segments = [skeleton.segments[k] for k, _ in chain]
    parts = [s.reversed() if backward else s for s, (_, backward) in zip(segments, chain, strict=True)]
    points, radius = [], []
    for number, part in enumerate(parts):
        keep = np.ones(len(part.points), bool)
        # near a fork the line is drawn aside and the ink is wider than the stroke
        if number > 0:
            keep &= np.hypot(*(part.points - part.points[0]).T) >= part.radius[0]
        if number < len(parts) - 1:
            keep &= np.hypot(*(part.points - part.points[-1]).T) >= part.radius[-1]
        points.append(part.points[keep])
        radius.append(part.radius[keep])
    if sum(map(len, points)) < 2:  # forks one upon another
        points, radius = [part.points for part in parts], [part.radius for part in parts]
    line = Polyline(np.concatenate(points), np.concatenate(radius))
    if len(parts) > 1:
        line = _resample(line)
    ends = (parts[0].ends[0], parts[-1].ends[1])
    return as_written(Stroke(line.points, line.radius, ends, tuple(k for k, _ in chain)))


# --- lines ---------------------------------------------------------------------------------------------


def _resample(line: Polyline) -> Polyline:
    """The same line with a point at about every pixel."""
    along = line.along
    at = np.linspace(0.0, along[-1], max(round(float(along[-1])) + 1, 2))
    points = np.column_stack([np.interp(at, along, values) for values in line.points.T])
    return Polyline(points, np.interp(at, along, line.radius))


def _smooth(points: FloatArray, *, reach: float) -> FloatArray:
    """Steps of pixels become a smooth line: a moving mean over `reach` pixels to each side; the ends stay."""
    half = min(max(round(reach), 1), (len(points) - 1) // 2)
    if half < 1:
        return points
    # mirrored through each end, so that it stays and the line keeps its direction there
    before = 2 * points[0] - points[half:0:-1]
    after = 2 * points[-1] - points[-2 : -half - 2 : -1]
    sums = np.cumsum(np.concatenate([np.zeros((1, 2)), before, points, after]), axis=0)
    return np.asarray((sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1))


def _degrees(count: int, ends: Iterable[tuple[int, int]]) -> IntArray:
    """(count,) how many line ends each node has."""
    return np.bincount(np.array([e for pair in ends for e in pair], dtype=np.intp), minlength=count)
