"""The input as feature points and line segments, and the strokes that may lie in it, found by line following.

Known from the publication's abstract: the input is feature points and line segments, its strokes undecided
until they are matched, and the candidates for each reference stroke come from following lines. How far a
line is followed, over what turns and gaps, and what a candidate costs, is our reconstruction.
Lengths are in sides of the character's box, y up.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rumu.surface.skeleton import Skeleton
from rumu.values import FloatArray, IntArray
from rumu_lab.baselines.lines import StrokeLine, angles_between, as_line, corners, polygon
from rumu_lab.baselines.relational_graph import Frame, Graph, Traits, traits_of, wrap_degrees

Way = tuple[int, ...]
"""Directed pieces in order: number p forward is p, backward is p + (number of pieces)."""

TOLERANCE = {"D": 60.0, "K": 45.0}
"""Degrees a candidate's direction may be off, by type; 30 for the others. Short lines have no steady one."""


@dataclass(frozen=True, slots=True)
class FollowSettings:
    """Which ways through the input are looked at.

    deviation: of the polygon whose vertices are feature points. reach: farthest start from the
    reference's. turn: most degrees at a fork, or at a bend over chords of `arm` stroke widths, as strokes
    of the reference are cut; blind_turn: the same from or into a piece shorter than `blind` stroke widths,
    whose direction is a fork's or a tip's more than the stroke's. gap: widest break in the ink that is
    jumped. shortest, longest: length over the reference's. most: ways looked at for each stroke. keep:
    candidates for each stroke.
    """

    deviation: float = 0.02
    reach: float = 0.25
    tolerance: float = 30.0
    turn: float = 45.0
    arm: float = 1.25
    blind: float = 1.5
    blind_turn: float = 90.0
    gap: float = 0.06
    shortest: float = 0.4
    longest: float = 2.0
    most: int = 400
    keep: int = 8


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The input as pieces of line between feature points.

    pieces: m lines between feature points. ends: (2m, 2) feature point at which each directed
    piece starts and stops. heading: (2m, 2) unit direction in which it sets out. follows: of each directed
    piece the directed pieces that may come next. width: of a stroke. forks: numbers of feature points with
    three ends or more. places: (k, 2) of the feature points.
    """

    pieces: tuple[StrokeLine, ...]
    traits: Traits
    ends: IntArray
    heading: FloatArray
    follows: tuple[tuple[int, ...], ...]
    width: float
    forks: frozenset[int]
    places: FloatArray

    def reverse(self, way: Way) -> Way:
        """The same pieces from the other end."""
        m = len(self.pieces)
        return tuple((d + m) % (2 * m) for d in reversed(way))

    def line(self, way: Way) -> StrokeLine:
        """The pieces of a way as one line."""
        m = len(self.pieces)
        parts = [self.pieces[d] if d < m else self.pieces[d - m].reversed() for d in way]
        return StrokeLine(
            np.concatenate([p.points for p in parts]), np.concatenate([p.radius for p in parts])
        )


def segments_of(skeleton: Skeleton, frame: Frame, *, settings: FollowSettings | None = None) -> Segments:
    """Feature points (ends, forks, corners of the polygon) and the pieces between them, in box sides."""
    settings = settings or FollowSettings()
    width = skeleton.width / frame.side
    pieces, ends, smooth = _pieces(skeleton, frame, settings)
    directed = np.array([*ends, *(end[::-1] for end in ends)], dtype=np.intp)
    lines = [*pieces, *(piece.reversed() for piece in pieces)]
    count = int(directed.max()) + 1
    places = np.zeros((count, 2))
    for line, end in zip(lines, directed, strict=True):
        places[end[0]] = line.points[0]
    heading = np.array([_heading(line, width) for line in lines])
    degree = np.bincount(directed[:, 0], minlength=count)
    tip = np.array([line.radius[0] for line in lines])
    short = np.array([line.length < settings.blind * width for line in lines])
    limit = np.where(short[:, None] | short[None], settings.blind_turn, settings.turn)
    limit[np.isin(directed[:, 1], smooth)] = 180.0
    follows = _find_successors(directed, heading, degree, places, tip=tip, limit=limit, gap=settings.gap)
    return Segments(
        tuple(pieces),
        traits_of(lines),
        directed,
        heading,
        follows,
        width,
        frozenset(np.flatnonzero(degree > 2).tolist()),
        places,
    )


def _pieces(
    skeleton: Skeleton, frame: Frame, settings: FollowSettings
) -> tuple[list[StrokeLine], list[tuple[int, int]], list[int]]:
    """Pieces, the feature points they run between, and those of them where a line bends without a corner."""
    pieces, ends, smooth, fresh = [], [], [], len(skeleton.nodes)
    arm = settings.arm * skeleton.width / frame.side
    for segment in skeleton.segments:
        line = frame.to_box(as_line(segment.points, segment.radius))
        marks = polygon(line.points, deviation=settings.deviation)
        start, stop = segment.ends
        if len(segment.points) < 2:  # a dot is one feature point; as a line it has two
            stop, fresh = fresh, fresh + 1
        numbers = [start, *range(fresh, fresh + len(marks) - 2), stop]
        fresh += len(marks) - 2
        sharp = corners(line, deviation=settings.deviation, arm=arm, least=settings.turn)
        smooth += [number for mark, number in zip(marks, numbers, strict=True) if mark not in sharp][1:-1]
        for k, (a, b) in enumerate(pairwise(marks)):
            pieces.append(line.part(a, b))
            ends.append((numbers[k], numbers[k + 1]))
    return pieces, ends, smooth


def _heading(line: StrokeLine, width: float) -> FloatArray:
    """(2,) unit direction in which a line sets out, seen beyond what a fork distorts."""
    far = np.hypot(*(line.points - line.points[0]).T)
    near = int(np.argmax(far >= min(float(line.radius[0]), 0.4 * float(far.max()))))
    beyond = far >= far[near] + width
    reach = int(np.argmax(beyond)) if beyond.any() else len(far) - 1
    way = line.points[max(reach, 1)] - line.points[min(near, max(reach, 1) - 1)]
    return np.asarray(way / max(float(np.hypot(*way)), 1e-12))


def _find_successors(
    ends: IntArray,
    heading: FloatArray,
    degree: IntArray,
    places: FloatArray,
    *,
    tip: FloatArray,
    limit: FloatArray,
    gap: float,
) -> tuple[tuple[int, ...], ...]:
    """What each directed piece may go on in: at its feature point, or across a gap from end to end.

    tip: (2m,) half-width where each sets out. limit: (2m, 2m) most degrees from one into the other.
    """
    m = len(ends) // 2
    back = (np.arange(2 * m) + m) % (2 * m)
    arriving = -heading[back]
    bend = angles_between(arriving[:, None], heading[None])
    joined = (ends[:, 1][:, None] == ends[:, 0][None]) & (bend <= limit)
    jump = places[ends[:, 0]][None] - places[ends[:, 1]][:, None]
    distance = np.linalg.norm(jump, axis=-1)
    loose = (degree[ends[:, 1]] == 1)[:, None] & (degree[ends[:, 0]] == 1)[None]
    between = distance - tip[back][:, None] - tip[None]  # a centre line ends a half-width before its ink
    ahead = angles_between(arriving[:, None], jump) <= limit
    across = loose & (distance > 1e-9) & (between <= gap) & ahead & (bend <= limit)
    allowed = joined | across
    allowed[np.arange(2 * m), back] = False
    allowed[np.arange(2 * m), np.arange(2 * m)] = False
    return tuple(tuple(np.flatnonzero(row).tolist()) for row in allowed)


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Ways through the input that may be strokes of the reference.

    ways: the u directed ways that are candidate of any stroke. traits: theirs. choice: for each reference
    stroke the numbers of its ways, cheapest first. cost: their node costs.
    """

    ways: tuple[Way, ...]
    traits: Traits
    choice: tuple[tuple[int, ...], ...]
    cost: tuple[tuple[float, ...], ...]


def candidates_of(graph: Graph, segments: Segments, *, settings: FollowSettings | None = None) -> Candidates:
    """For each stroke of the reference the cheapest ways through the input that may be it."""
    settings = settings or FollowSettings()
    followed = [_follow(i, graph, segments, settings) for i in range(len(graph.lines))]
    number = {way: k for k, way in enumerate(dict.fromkeys(way for found in followed for way in found))}
    ways = tuple(number)
    traits = traits_of([segments.line(way) for way in ways])
    choice, costs = [], []
    for i, found in enumerate(followed):
        members = np.array([number[way] for way in found], dtype=np.intp)
        cost = node_costs(graph, i, traits, members)
        order = [k for k in np.argsort(cost, kind="stable")[: settings.keep] if cost[k] < 1.0]
        choice.append(tuple(int(members[k]) for k in order))
        costs.append(tuple(float(cost[k]) for k in order))
    # Streaky ink has thousands of ways; what follows compares all of these with each other.
    kept = tuple(dict.fromkeys(k for chosen in choice for k in chosen))
    place = {k: at for at, k in enumerate(kept)}
    return Candidates(
        tuple(ways[k] for k in kept),
        traits_of([segments.line(ways[k]) for k in kept]),
        tuple(tuple(place[k] for k in chosen) for chosen in choice),
        tuple(costs),
    )


def node_costs(graph: Graph, i: int, traits: Traits, members: IntArray) -> FloatArray:
    """(k,) cost of each of these lines as stroke i: places of the ends, length and direction."""
    tips = np.linalg.norm(traits.three[members][:, ::2] - graph.traits.three[i, ::2], axis=-1).sum(axis=1)
    ratio = np.maximum(traits.length[members], 1e-6) / max(float(graph.traits.length[i]), 1e-6)
    bend = np.abs(wrap_degrees(traits.direction[members] - graph.traits.direction[i]))
    return np.asarray(tips + 0.25 * np.abs(np.log(ratio)) + 0.25 * bend / 45.0)


def _follow(i: int, graph: Graph, segments: Segments, settings: FollowSettings) -> list[Way]:
    """All ways that set out near the start of stroke i and run as it runs, of a length to be compared."""
    model = graph.lines[i]
    tolerance = TOLERANCE.get(graph.kinds[i], settings.tolerance)
    along, length = model.along, model.length
    starts = segments.traits.three[:, 0]
    near = np.linalg.norm(starts - graph.traits.three[i, 0], axis=1) <= settings.reach
    stops = segments.traits.three[:, 2]

    def runs_alike(start: int, stop: int, travelled: float) -> bool:
        """The chord so far against the reference's over the same length; a stub has no direction yet."""
        if travelled < segments.width:
            return True
        ahead = np.array([np.interp(travelled, along, v) for v in model.points.T]) - model.points[0]
        return bool(angles_between(stops[stop] - starts[start], ahead) <= tolerance)

    def distance_off(stop: int, travelled: float) -> float:
        """How far the last piece stops from where the reference is after the same length."""
        place = np.array([np.interp(travelled, along, v) for v in model.points.T])
        return float(np.hypot(*(stops[stop] - place)))

    found: list[Way] = []
    lengths, m = segments.traits.length, len(segments.pieces)
    # The nearest to the reference first, so that in streaky ink, with thousands of ways, the best are seen.
    open_ways: list[tuple[float, int, Way, float]] = [
        (distance_off(d, float(lengths[d])), d, (d,), float(lengths[d]))
        for d in np.flatnonzero(near).tolist()
    ]
    heapq.heapify(open_ways)
    ticket = 2 * m
    for _ in range(settings.most):
        if not open_ways:
            break
        _, _, way, travelled = heapq.heappop(open_ways)
        if travelled > settings.longest * length or not runs_alike(way[0], way[-1], travelled):
            continue
        if travelled >= settings.shortest * length:
            found.append(way)
        walked = {d % m for d in way}
        for onward in segments.follows[way[-1]]:
            if onward % m not in walked:
                jump = float(np.hypot(*(starts[onward] - stops[way[-1]])))
                farther = travelled + jump + float(lengths[onward])
                ticket += 1
                heapq.heappush(open_ways, (distance_off(onward, farther), ticket, (*way, onward), farther))
    return found
