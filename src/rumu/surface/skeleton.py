"""A mask -> its skeleton, cleaned, and the strokes that run through it.

Thinning leaves a short bridge where strokes cross and a whisker at every bump of the edge: forks closer than
a stroke's width are one fork, and what does not stick out of the stroke is no branch. Points are (x, y) in
pixels, x the column and y the row; everything here depends on the mask alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from rumu.errors import SurfaceError
from rumu.surface.thinning import Path, Thinned, thinned
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A centre line between two nodes.

    points: (n >= 1, 2) float64, (x column, y row) pixels, along the line; one alone for a round dot.
    radius: (n,) float64, half-width of the ink there in pixels. ends: numbers of the nodes it runs between,
        the same twice for a ring or a dot.
    """

    points: FloatArray
    radius: FloatArray
    ends: tuple[int, int]

    @property
    def length(self) -> float:
        """Of the line, in pixels."""
        return _length(self.points)


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The centre lines of a mask.

    nodes: (k, 2) float64, places (x, y) of ends and forks. degree: (k,) how many line ends meet there: 1 an
        end, 3 or more a fork, 2 a ring's beginning, 0 a dot. segments: what runs between them.
    width: twice the median half-width along the lines, in pixels. shape: of the mask.
    """

    nodes: FloatArray
    degree: IntArray
    segments: tuple[Segment, ...]
    width: float
    shape: tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A line that a brush could have drawn in one go.

    points: (n >= 1, 2) float64, (x, y) pixels, from `start` to `end`: left to right, or top to bottom where
        it stands steeper than 45 degrees. radius: (n,) float64, half-width.
    ends: numbers of the skeleton's nodes. segments: numbers of the segments it is made of, in order.
    """

    points: FloatArray
    radius: FloatArray
    ends: tuple[int, int]
    segments: tuple[int, ...]

    @property
    def length(self) -> float:
        """Of the line, in pixels."""
        return _length(self.points)

    @property
    def start(self) -> FloatArray:
        return np.asarray(self.points[0])

    @property
    def end(self) -> FloatArray:
        return np.asarray(self.points[-1])

    @property
    def direction(self) -> float:
        """Degrees from start to end as the page shows it, counter-clockwise from +x; 0 for a ring or a dot.

        Between -135 and 45: level is 0, straight down -90, falling to the right in between.
        """
        right, down = self.end - self.start
        return float(np.rad2deg(np.arctan2(-down, right))) if np.hypot(right, down) > 1e-9 else 0.0


def skeletonise(mask: BoolArray) -> Skeleton:
    """The skeleton of a mask (H, W) bool: whiskers pruned, forks merged, rings and lone dots kept.

    A branch is pruned when it is shorter than half a stroke's width or ends within three tenths of a width
    of the fork's own ink. Raises SurfaceError for an empty mask or one that is no mask.
    """
    if mask.ndim != 2 or mask.dtype != np.bool_:
        raise SurfaceError(f"expected an (H, W) bool mask, got {mask.dtype} {mask.shape}")
    if not mask.any():
        raise SurfaceError("expected a mask that holds ink, got an empty one")
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    top, left = int(rows[0]), int(columns[0])
    raw = thinned(np.ascontiguousarray(mask[top : rows[-1] + 1, left : columns[-1] + 1]))
    width = 2.0 * float(
        np.median(np.concatenate([_half_widths_of_dots(raw), *(p.radius for p in raw.paths)]))
    )
    nodes, paths = _cleaned(raw, width)
    return _skeleton(nodes, paths, width=width, origin=np.array([left, top], float), shape=mask.shape)


def strokes(skeleton: Skeleton, *, turn: float = 35.0) -> tuple[Stroke, ...]:
    """Segments joined through forks where one goes on as the other came, straightest first.

    turn: degrees; a way through a fork that bends more is none. Longest stroke first.
    """
    follows = _good_continuations(skeleton, turn=turn)
    found, used = [], set[int]()
    for k in range(len(skeleton.segments)):
        if k not in used:
            chain = _chain(k, follows)
            used.update(number for number, _ in chain)
            found.append(_stroke(skeleton, chain))
    return tuple(sorted(found, key=lambda s: -s.length))


# --- cleaning ------------------------------------------------------------------------------------------


def _cleaned(raw: Thinned, width: float) -> tuple[FloatArray, list[Path]]:
    """Forks merged and whiskers pruned until nothing changes; a fork of two is no fork."""
    nodes, paths = raw.nodes, [*raw.paths]
    paths += [Path(nodes[k][None], np.array([_at(raw.half_width, nodes[k])]), (k, k)) for k in raw.dots]
    for _ in range(6):
        before = len(paths)
        nodes, paths = _merged(nodes, paths, raw.half_width, width)
        paths = _dissolved(_pruned(paths, width))
        if len(paths) == before:
            break
    return nodes, paths


def _merged(
    nodes: FloatArray, paths: list[Path], half_width: FloatArray, width: float
) -> tuple[FloatArray, list[Path]]:
    """Forks that a bridge shorter than a stroke's width joins become one, in their middle."""
    degree = _degrees(len(nodes), (p.ends for p in paths))
    bridge = [_bridges(p, degree, half_width, nodes, width) for p in paths]
    if not any(bridge):
        return nodes, paths
    leader = np.arange(len(nodes))
    for path, short in zip(paths, bridge, strict=True):
        if short:
            a, b = leader[path.ends[0]], leader[path.ends[1]]
            leader[leader == b] = a
    nodes = nodes.copy()
    forks = np.flatnonzero(degree >= 3)
    for k in np.unique(leader[forks]):
        members = forks[leader[forks] == k]
        nodes[k] = nodes[members].mean(axis=0)
    kept = []
    for path, short in zip(paths, bridge, strict=True):
        if not short:
            a, b = int(leader[path.ends[0]]), int(leader[path.ends[1]])
            kept.append(_reaching(path, nodes, (a, b)))
    return nodes, kept


def _bridges(path: Path, degree: IntArray, half_width: FloatArray, nodes: FloatArray, width: float) -> bool:
    a, b = path.ends
    if len(path.points) < 2 or degree[a] < 3 or degree[b] < 3:
        return False
    reach = max(width, _at(half_width, nodes[a]), _at(half_width, nodes[b]))
    return path.length < reach


def _reaching(path: Path, nodes: FloatArray, ends: tuple[int, int]) -> Path:
    """The path with its ends moved to where their nodes are now."""
    if len(path.points) < 2:
        return replace(path, ends=ends)
    points = path.points.copy()
    points[0], points[-1] = nodes[ends[0]], nodes[ends[1]]
    return Path(points, path.radius, ends)


def _pruned(paths: list[Path], width: float) -> list[Path]:
    """Without the branches that do not stick out; of a blot that is all branches the longest two stay."""
    count = 1 + max(max(p.ends) for p in paths)
    degree = _degrees(count, (p.ends for p in paths))
    whisker = [_is_whisker(p, degree, width) for p in paths]
    for k in {
        end for p, gone in zip(paths, whisker, strict=True) if gone for end in p.ends if degree[end] > 2
    }:
        here = [i for i, p in enumerate(paths) if k in p.ends]
        if all(whisker[i] for i in here):
            for i in sorted(here, key=lambda i: -paths[i].length)[:2]:
                whisker[i] = False
    return [p for p, gone in zip(paths, whisker, strict=True) if not gone]


def _is_whisker(path: Path, degree: IntArray, width: float) -> bool:
    a, b = (int(degree[end]) for end in path.ends)
    if len(path.points) < 2 or {a, b} == {1} or min(a, b) != 1:
        return path.ends[0] == path.ends[1] and a > 2 and path.length < width
    fork, tip = (path.radius[0], path.radius[-1]) if b == 1 else (path.radius[-1], path.radius[0])
    return path.length < 0.5 * width or bool(path.length + tip - fork < 0.3 * width)


def _dissolved(paths: list[Path]) -> list[Path]:
    """Two paths that meet in a node of their own become one."""
    paths = [*paths]
    while True:
        count = 1 + max(max(p.ends) for p in paths)
        degree = _degrees(count, (p.ends for p in paths))
        pair = _pair_at_two(paths, degree)
        if pair is None:
            return paths
        one, two = pair
        a, b = paths[one], paths[two]
        shared = next(end for end in a.ends if end in b.ends and degree[end] == 2)
        a = a if a.ends[1] == shared else a.turned()
        b = b if b.ends[0] == shared else b.turned()
        joined = Path(
            np.concatenate([a.points, b.points[1:]]),
            np.concatenate([a.radius, b.radius[1:]]),
            (a.ends[0], b.ends[1]),
        )
        paths = [p for k, p in enumerate(paths) if k not in pair] + [joined]


def _pair_at_two(paths: list[Path], degree: IntArray) -> tuple[int, int] | None:
    meets: dict[int, int] = {}
    for k, path in enumerate(paths):
        if path.ends[0] == path.ends[1]:
            continue
        for end in path.ends:
            if degree[end] == 2 and end in meets:
                return meets[end], k
            meets[end] = k
    return None


def _skeleton(
    nodes: FloatArray, paths: list[Path], *, width: float, origin: FloatArray, shape: tuple[int, ...]
) -> Skeleton:
    used = sorted({end for p in paths for end in p.ends})
    number = {node: k for k, node in enumerate(used)}
    segments = tuple(
        Segment(
            _smoothed(p.points, reach=0.3 * width) + origin,
            p.radius,
            (number[p.ends[0]], number[p.ends[1]]),
        )
        for p in paths
    )
    degree = _degrees(len(used), (s.ends for s in segments if len(s.points) > 1))
    return Skeleton(nodes[used] + origin, degree, segments, width, (int(shape[0]), int(shape[1])))


# --- strokes -------------------------------------------------------------------------------------------

Side = tuple[int, int]
"""A segment's number and which of its ends: 0 or 1."""


def _good_continuations(skeleton: Skeleton, *, turn: float) -> dict[Side, Side]:
    """Which end of which segment goes on in which, both ways; each end in one other at most."""
    meeting: dict[int, list[Side]] = {}
    for k, segment in enumerate(skeleton.segments):
        for side, node in enumerate(segment.ends):
            if len(segment.points) > 1 and skeleton.degree[node] > 2:
                meeting.setdefault(node, []).append((k, side))
    away = {at: _leaving(skeleton, *at) for sides in meeting.values() for at in sides}
    follows: dict[Side, Side] = {}
    for sides in meeting.values():
        bends = sorted((_bend(away[a], away[b]), a, b) for i, a in enumerate(sides) for b in sides[i + 1 :])
        for bend, a, b in bends:
            if bend < turn and a not in follows and b not in follows:
                follows[a], follows[b] = b, a
    return follows


def _leaving(skeleton: Skeleton, number: int, side: int) -> FloatArray:
    """(2,) unit direction in which a segment leaves its node, seen beyond the fork's own distortion."""
    segment = skeleton.segments[number]
    points = segment.points if side == 0 else segment.points[::-1]
    far = np.hypot(*(points - points[0]).T)
    here = segment.radius[0] if side == 0 else segment.radius[-1]
    near = int(np.argmax(far >= min(here, 0.4 * float(far.max()))))
    beyond = far >= far[near] + skeleton.width
    reach = int(np.argmax(beyond)) if beyond.any() else len(points) - 1
    way = points[max(reach, 1)] - points[min(near, max(reach, 1) - 1)]
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))


def _bend(a: FloatArray, b: FloatArray) -> float:
    """Degrees by which a brush turns that comes along a and goes on along b."""
    return float(np.rad2deg(np.arccos(np.clip(-(a @ b), -1.0, 1.0))))


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


def _stroke(skeleton: Skeleton, chain: list[tuple[int, bool]]) -> Stroke:
    parts = [(skeleton.segments[k], backward) for k, backward in chain]
    first, last = parts[0], parts[-1]
    ends = (first[0].ends[1 if first[1] else 0], last[0].ends[0 if last[1] else 1])
    points, radius = _along(parts, skeleton.width)
    numbers = tuple(k for k, _ in chain)
    right, down = points[-1] - points[0]
    if (right < 0) if abs(right) >= abs(down) else (down < 0):
        return Stroke(points[::-1], radius[::-1], (ends[1], ends[0]), numbers[::-1])
    return Stroke(points, radius, ends, numbers)


def _along(parts: list[tuple[Segment, bool]], width: float) -> tuple[FloatArray, FloatArray]:
    """Points and half-widths of segments laid end to end, bridged straight across the forks between."""
    points, radius = [], []
    for number, (segment, backward) in enumerate(parts):
        xy, r = (segment.points[::-1], segment.radius[::-1]) if backward else (segment.points, segment.radius)
        keep = np.ones(len(xy), bool)
        # near a fork the line is drawn aside and the ink is wider than the stroke
        if number > 0:
            keep &= np.hypot(*(xy - xy[0]).T) >= r[0]
        if number < len(parts) - 1:
            keep &= np.hypot(*(xy - xy[-1]).T) >= r[-1]
        points.append(xy[keep])
        radius.append(r[keep])
    xy, r = np.concatenate(points), np.concatenate(radius)
    if len(xy) < 2:  # forks one upon another
        xy = np.concatenate([p.points[::-1] if back else p.points for p, back in parts])
        r = np.concatenate([p.radius[::-1] if back else p.radius for p, back in parts])
    return _evenly(xy, r) if len(parts) > 1 else (xy, r)


# --- lines ---------------------------------------------------------------------------------------------


def _evenly(points: FloatArray, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same line with a point at about every pixel."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, along[-1], max(round(float(along[-1])) + 1, 2))
    return np.column_stack([np.interp(at, along, points[:, k]) for k in (0, 1)]), np.interp(at, along, radius)


def _smoothed(points: FloatArray, *, reach: float) -> FloatArray:
    """Stairs of pixels made a line: a moving mean over `reach` pixels to each side; the ends stay."""
    half = min(max(round(reach), 1), (len(points) - 1) // 2)
    if half < 1:
        return points
    # mirrored through each end, so that it stays and the line keeps its direction there
    before = 2 * points[0] - points[half:0:-1]
    after = 2 * points[-1] - points[-2 : -half - 2 : -1]
    sums = np.cumsum(np.concatenate([np.zeros((1, 2)), before, points, after]), axis=0)
    return np.asarray((sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1))


def _length(points: FloatArray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0


def _degrees(count: int, ends: Iterable[tuple[int, int]]) -> IntArray:
    return np.bincount(np.array([e for pair in ends for e in pair], dtype=np.intp), minlength=count)


def _half_widths_of_dots(raw: Thinned) -> FloatArray:
    return np.array([_at(raw.half_width, raw.nodes[k]) for k in raw.dots])


def _at(field: FloatArray, place: FloatArray) -> float:
    """The largest value within a pixel of a place, which need not lie on the line itself."""
    column, row = (round(float(v)) for v in place)
    return float(field[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].max())
