"""MBSE-based grader (our reconstruction): model-based stroke extraction and matching.

After Liu, Kim and Kim, "Model-based stroke extraction and matching for handwritten Chinese character
recognition", Pattern Recognition 34(12), 2001, of which the abstract, keywords and captions were read.

Known from there: the reference is an attributed relational graph; the input is feature points and line
segments; candidates for each reference stroke are extracted by line following, then matched consistently by
a heuristic, semi-admissible search; structural post-processing betters the correspondence.
Reconstructed by us: every number, cost and angle (see `relational_graph`, `line_following`,
`semi_admissible`), the post-processing below, and the grade: the publication recognises, it does not grade.

Decided where the reconstruction left it open: the strokes of the reference come from its own skeleton, as
fonts and steles have no stroke data; an arc to a stroke that is not found costs what a differing relation
does; in the grade nodes and arcs count where strokes were found, as what is missing is charged by a factor of
its own; and an arc weighs the mean length of its two strokes, else characters of many short strokes would
cost more for the same deviation. Ends are extended over what is left of the line up to the next feature
point, and trimmed by a stub beyond a fork. Width of strokes, place, and size in the cell are not seen: the
frame is the character's own box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from rumu.values import FloatArray, IntArray
from rumu_lab.baselines.cell import Cell, Raw
from rumu_lab.baselines.line_following import (
    Candidates,
    FollowSettings,
    Segments,
    Way,
    candidates_of,
    node_costs,
    segments_of,
)
from rumu_lab.baselines.lines import StrokeLine, angles_between, lines_of, skeleton_of
from rumu_lab.baselines.relational_graph import (
    Frame,
    Graph,
    Traits,
    differences,
    frame_of,
    graph_of,
    relations,
    traits_of,
    wrap_degrees,
)
from rumu_lab.baselines.semi_admissible import SearchSettings, search

NULL_COST = 1.0
"""Node cost of a reference stroke that is not found."""
NULL_ARC = 0.25
"""Arc cost where one of its strokes, or both, is not found: the relation differs."""


@dataclass(frozen=True, slots=True)
class MbseSettings:
    """Settings of the stages and of the grade.

    follow, search: of the two stages. collinear: degrees within which a leftover continues a stroke.
    extra: shortest extra stroke, in stroke widths. steepness: of the grade; extra_share: what it loses to
    as much extra ink as the reference is long.
    """

    follow: FollowSettings = field(default_factory=FollowSettings)
    search: SearchSettings = field(default_factory=SearchSettings)
    collinear: float = 30.0
    extra: float = 1.5
    steepness: float = 1.5
    extra_share: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class StrokePair:
    """A stroke of the reference and the one of the copy that it is, None where it is missing.

    kind: stroke type, a letter. cost: of the node, 1 when missing. Both lines in pixels of the cell, y down.
    """

    kind: str
    reference: StrokeLine
    copy: StrokeLine | None
    cost: float


@dataclass(frozen=True, slots=True, eq=False)
class StrokeCorrespondence:
    """Which stroke of the copy is which of the reference.

    pairs: one for each reference stroke. extra: lines of the copy that are no part of
    the reference, pixels. node, arc: mean costs weighted by length, 0 or more. missing: share of the
    reference's length, 0 to 1. surplus: extra length over the reference's, 0 or more. expansions: of the
    search; bounded: whether it ended within its bound.
    """

    pairs: tuple[StrokePair, ...]
    extra: tuple[StrokeLine, ...]
    node: float
    arc: float
    missing: float
    surplus: float
    expansions: int
    bounded: bool


def raw(probe: Cell, reference: Cell) -> Raw:
    """The grade of a copy.

    features: the fields of `StrokeCorrespondence`; recovered: share of strokes found.
    """
    settings = MbseSettings()
    match = match_strokes(probe, reference, settings=settings)
    grade = np.exp(-settings.steepness * (match.node + match.arc)) * (1.0 - match.missing)
    grade *= 1.0 - settings.extra_share * min(1.0, match.surplus)
    found = sum(pair.copy is not None for pair in match.pairs)
    return Raw(
        float(np.clip(grade, 0.0, 1.0)),
        {
            "node": match.node,
            "arc": match.arc,
            "missing": match.missing,
            "surplus": match.surplus,
            "recovered": found / len(match.pairs),
            "expansions": float(match.expansions),
        },
    )


@lru_cache(maxsize=32)
def _model(reference: Cell) -> tuple[Frame, float, Graph]:
    """Frame, stroke width in box sides and graph of a reference; many copies of it come in a row."""
    lines = lines_of(reference)
    frame = frame_of(lines)
    width = skeleton_of(reference).width / frame.side
    return frame, width, graph_of([frame.to_box(line) for line in lines], width=width)


def match_strokes(
    probe: Cell, reference: Cell, *, settings: MbseSettings | None = None
) -> StrokeCorrespondence:
    """Which stroke of the copy is which of the reference's.

    Raises RumuError where a cell holds too little ink for a line.
    """
    settings = settings or MbseSettings()
    frame, _, graph = _model(reference)
    own = frame_of(lines_of(probe))
    segments = segments_of(skeleton_of(probe), own, settings=settings.follow)
    candidates = candidates_of(graph, segments, settings=settings.follow)
    order = _order(graph, candidates)
    nodes, arcs = _costs(graph, segments, candidates, order)
    choice = search(nodes, arcs, settings=settings.search)
    ways: list[Way | None] = [None] * len(order)
    for i, k in zip(order, choice.chosen, strict=True):
        if k < len(candidates.choice[i]):
            ways[i] = candidates.ways[candidates.choice[i][k]]
    ways, extra = _tidy(ways, segments, settings)
    return _grade(
        graph, segments, ways, extra, frames=(own, frame), search=(choice.expansions, choice.bounded)
    )


def _order(graph: Graph, candidates: Candidates) -> list[int]:
    """Long strokes first, by tenths of the box, and among those of a length the least ambiguous first."""
    lengths = graph.traits.length
    return sorted(
        range(len(lengths)), key=lambda i: (-int(10 * lengths[i]), len(candidates.choice[i]), -lengths[i])
    )


def _costs(
    graph: Graph, segments: Segments, candidates: Candidates, order: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """Node costs (n, K) and arc costs (n, K, n, K) for the search; the last candidate is "not found"."""
    n, K = len(order), 1 + max(len(choice) for choice in candidates.choice)
    nodes = np.full((n, K), np.inf)
    nodes[:, -1] = NULL_COST
    arcs = np.full((n, K, n, K), NULL_ARC / max(n - 1, 1))
    if not candidates.ways:
        return nodes, arcs
    pairwise = _PairCosts.of(graph, segments, candidates)
    members = [np.array(candidates.choice[i], dtype=np.intp) for i in order]
    for a, i in enumerate(order):
        nodes[a, : len(members[a])] = candidates.cost[i]
        for b in range(a + 1, n):
            cost = pairwise.between(i, order[b], members[a], members[b]) / max(n - 1, 1)
            arcs[a, : len(members[a]), b, : len(members[b])] = cost
    return nodes, arcs


@dataclass(frozen=True, slots=True, eq=False)
class _PairCosts:
    """What the arcs of all ways through the input are, and which ways exclude each other."""

    graph: Graph
    between_ways: FloatArray
    bend: FloatArray
    relation: IntArray
    excluded: np.ndarray

    @classmethod
    def of(cls, graph: Graph, segments: Segments, candidates: Candidates) -> _PairCosts:
        vectors, bend = differences(candidates.traits)
        relation = relations(candidates.traits, width=segments.width)
        return cls(graph, vectors, bend, relation, _find_conflicts(segments, candidates.ways))

    def between(self, i: int, j: int, one: IntArray, two: IntArray) -> FloatArray:
        """(k, m) cost of the arc from stroke i to j when they are these ways; inf where they exclude."""
        at = np.ix_(one, two)
        cost = arc_costs(
            self.graph,
            i,
            j,
            vector=self.between_ways[at],
            bend=self.bend[at],
            relation=self.relation[at],
        )
        return np.where(self.excluded[at], np.inf, cost)


def arc_costs(
    graph: Graph, i: int, j: int, *, vector: FloatArray, bend: FloatArray, relation: IntArray
) -> FloatArray:
    """Cost of arcs of the input as the arc from stroke i to j: vector between middles, turning, relation."""
    away = np.linalg.norm(vector - graph.between[i, j], axis=-1)
    off = np.abs(wrap_degrees(bend - graph.bend[i, j])) / 45.0
    return np.asarray(away + 0.25 * off + 0.25 * (relation != graph.relation[i, j]))


def _find_conflicts(segments: Segments, ways: Sequence[Way]) -> np.ndarray:
    """(u, u) bool: ways that share more than a crossing, a stroke's width of line."""
    m = len(segments.pieces)
    holds = np.zeros((len(ways), m))
    for k, way in enumerate(ways):
        holds[k, [d % m for d in way]] = 1.0
    return np.asarray((holds * segments.traits.length[:m]) @ holds.T > segments.width)


# --- post-processing -----------------------------------------------------------------------------------


def _tidy(
    ways: list[Way | None], segments: Segments, settings: MbseSettings
) -> tuple[list[Way | None], list[Way]]:
    """Leftovers that continue a stroke joined to it, stubs beyond a fork trimmed; the rest, joined: extra."""
    m = len(segments.pieces)
    free = set(range(m)) - {d % m for way in ways if way for d in way}
    ways = [_extend(way, segments, free, settings) if way else None for way in ways]
    ways = [_trim(way, segments) if way else None for way in ways]
    rest = _follow_leftovers(free, segments)
    longest = settings.extra * segments.width
    return ways, [way for way in rest if sum(segments.traits.length[d] for d in way) > longest]


def _extend(way: Way, segments: Segments, free: set[int], settings: MbseSettings) -> Way:
    """The way with the free pieces that lead on from it, or up to it, in its own direction."""
    m = len(segments.pieces)
    for _ in (0, 1):  # onward, then the same from the other end
        while True:
            arriving = -segments.heading[(way[-1] + m) % (2 * m)]
            stop = segments.traits.three[way[-1], 2]
            ahead = [
                d
                for d in range(2 * m)
                if d % m in free
                and np.hypot(*(segments.traits.three[d, 0] - stop)) <= segments.width
                and angles_between(arriving, segments.heading[d]) <= settings.collinear
                and angles_between(arriving, segments.traits.three[d, 2] - stop) <= settings.collinear
            ]
            if not ahead:
                break
            onward = max(ahead, key=lambda d: float(segments.traits.length[d]))
            free.discard(onward % m)
            way = (*way, onward)
        way = segments.reverse(way)
    return way


def _trim(way: Way, segments: Segments) -> Way:
    """The way without an end piece that lies within the ink of the fork it sticks out of.

    So do the strokes of the reference end, whose lines are bridged straight across their forks.
    """
    for _ in (0, 1):
        stub = segments.line(way[-1:])
        at_fork = int(segments.ends[way[-1], 0]) in segments.forks
        if len(way) > 1 and at_fork and stub.length < max(0.5 * segments.width, float(stub.radius[0])):
            way = way[:-1]
        way = segments.reverse(way)
    return way


def _follow_leftovers(free: set[int], segments: Segments) -> list[Way]:
    """Free pieces followed into one another, longest first."""
    m, left, found = len(segments.pieces), set(free), []
    for start in sorted(free, key=lambda p: -float(segments.traits.length[p])):
        if start not in left:
            continue
        left.discard(start)
        way: Way = (start,)
        for _ in (0, 1):
            while ahead := [d for d in segments.follows[way[-1]] if d % m in left]:
                way = (*way, ahead[0])
                left.discard(ahead[0] % m)
            way = segments.reverse(way)
        found.append(way)
    return found


# --- the grade -----------------------------------------------------------------------------------------


def _grade(
    graph: Graph,
    segments: Segments,
    ways: Sequence[Way | None],
    extra: Sequence[Way],
    *,
    frames: tuple[Frame, Frame],
    search: tuple[int, bool],
) -> StrokeCorrespondence:
    lengths = graph.traits.length
    found = [i for i, way in enumerate(ways) if way]
    traits = traits_of([segments.line(way) for way in ways if way])
    cost = np.full(len(ways), NULL_COST)
    for k, i in enumerate(found):
        cost[i] = node_costs(graph, i, traits, np.array([k]))[0]
    total, held = float(lengths.sum()), float(lengths[found].sum())
    pairs = tuple(
        StrokePair(
            graph.kinds[i],
            _to_pixels(graph.lines[i], frames[1]),
            _to_pixels(segments.line(way), frames[0]) if way else None,
            float(cost[i]),
        )
        for i, way in enumerate(ways)
    )
    return StrokeCorrespondence(
        pairs,
        tuple(_to_pixels(segments.line(way), frames[0]) for way in extra),
        float(lengths[found] @ cost[found]) / held if found else NULL_COST,
        _arc_mean(graph, traits, found, segments.width),
        1.0 - held / total,
        float(sum(segments.traits.length[d] for way in extra for d in way)) / total,
        *search,
    )


def _arc_mean(graph: Graph, traits: Traits, found: Sequence[int], width: float) -> float:
    """Half the mean cost of the arcs among the strokes found, each weighing the mean length of its strokes.

    The half makes it the sum of arcs over (number of strokes - 1) and all length, as the search has it.
    """
    if len(found) < 2:
        return 0.0
    vectors, bend = differences(traits)
    relation = relations(traits, width=width)
    total, weight = 0.0, 0.0
    for a, i in enumerate(found):
        for b in range(a + 1, len(found)):
            j = found[b]
            cost = arc_costs(graph, i, j, vector=vectors[a, b], bend=bend[a, b], relation=relation[a, b])
            mean_length = float(graph.traits.length[i] + graph.traits.length[j]) / 2
            total += float(cost) * mean_length
            weight += mean_length
    return 0.5 * total / weight


def _to_pixels(line: StrokeLine, frame: Frame) -> StrokeLine:
    points = line.points * (1.0, -1.0) * frame.side + frame.centre
    return StrokeLine(points, line.radius * frame.side)
