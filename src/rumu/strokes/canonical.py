"""Canonical strokes of a known character laid on a master's ink, so that each line has its number and name.

The centre lines of `characters.stroke_data` are cut at their corners, brought to the spread of the master's
skeleton, laid on it as a master's lines are laid on a copy (see `matching`), bent sideways to the middle of
their ink and carried to its end. What the master has beyond its canonical strokes stays as lines without a
number. A master that is written otherwise than copybooks print it is not named at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter, evenly_spaced
from rumu.strokes.centre_lines import (
    SCALE,
    CentreLine,
    CentreLines,
    FramedInk,
    LinePoints,
    between_corners,
    doubled_directions,
    find_segments,
    pixels_at,
    sample_lines,
)
from rumu.strokes.matching import LineMatch, MatchSettings, find_covered, match_lines
from rumu.strokes.naming import HORIZONTAL, PLAIN_KINDS, VERTICAL
from rumu.strokes.placement import claimed_twice, unevenness
from rumu.values import BoolArray, FloatArray, IntArray

_LOOSE = MatchSettings(shift_cost=2.0, affine_cost=5.0, bend_cost=12.0)
_STARTS = (
    replace(
        _LOOSE,
        warp_sigmas=(0.35, 0.28, 0.22, 0.18, 0.15, 0.12),
        stroke_sigmas=(0.2, 0.17, 0.14, 0.12, 0.1, 0.085, 0.07, 0.06, 0.05),
        stroke_travel=0.4,
    ),
    replace(_LOOSE, warp_sigmas=(0.5, 0.4, 0.32, 0.25, 0.2, 0.16, 0.13), stroke_travel=0.25),
)
_FINE = replace(
    _LOOSE,
    warp_sigmas=(0.15, 0.12, 0.1),
    stroke_sigmas=(0.1, 0.085, 0.07, 0.06, 0.05, 0.04),
    stroke_travel=0.15,
    bend_cost=8.0,
)


@dataclass(frozen=True, slots=True)
class LayingSettings:
    """How canonical strokes are laid on a master. Lengths in stroke widths of the master unless said.

    step: distance of points along a canonical line, and arm: of the sides between which turning is measured,
        both in sides of its square. clip: greatest ratio by which the proportions of the square are changed
        beforehand.
    starts: matchings tried one after another until one leaves no more than `good`; fine: the last one, from
        where the best has brought the lines.
    own_ink_reach: within which ink is a line's own. bend: points of a line over which it is bent together.
    longest_tail: by which an end is carried on to the end of its ink; tail_depth: share of its half-width
        that the ink must be deep there.
    near: distance to another line within which an end joins it, and a half-width is not that of one line.
    beside: share of the shorter of two horizontals, or verticals, that must lie beside the other for them to
        have changed places.
    shortest_spare: length of a run of the master's ink from which it becomes a line without a number.
    confident: sum of the shares of the canonical lines and of the master's ink that may be left over in a
        master whose strokes are named; even: mean square, rms radii, by which its lines may leave one affine
        move of the canonical ones.
    """

    step: float = 1 / 256
    arm: int = 6
    clip: float = 1.33
    starts: tuple[MatchSettings, ...] = _STARTS
    fine: MatchSettings = _FINE
    good: float = 0.09
    own_ink_reach: float = 0.75
    bend: float = 2.0
    longest_tail: float = 1.0
    tail_depth: float = 0.35
    near: float = 0.75
    beside: float = 0.5
    shortest_spare: float = 1.0
    confident: float = 0.2
    even: float = 0.04


LAYING = LayingSettings()


@dataclass(frozen=True, slots=True, eq=False)
class LaidCharacter:
    """A character's canonical strokes on a master.

    lines: in the order of writing, cut at corners; each knows the number of its stroke. left_over: share of
        the canonical lines that found no ink, plus share of the ink that no canonical line explains.
    unevenness: mean square, rms radii, by which the lines leave one affine move of the canonical ones.
    confidence: (strokes,) share of each canonical stroke that found ink of its own, which no other claims.
    """

    character: CanonicalCharacter
    lines: CentreLines
    left_over: float
    unevenness: float
    confidence: FloatArray

    @property
    def is_confident(self) -> bool:
        """Whether the master is written as copybooks print it, so that its strokes may be named."""
        return self.left_over <= LAYING.confident and self.unevenness <= LAYING.even


def lay_character(character: CanonicalCharacter, framed: FramedInk) -> LaidCharacter:
    """Lay the strokes of a character on a master's ink."""
    ink = find_segments(framed)
    lines = _canonical_lines(character, ink.points)
    points = sample_lines(lines)
    best: tuple[float, FloatArray, BoolArray, IntArray] | None = None
    for settings in LAYING.starts:
        at = _bend_to_ink(points, match_lines(points, ink.points, settings=settings), ink.points)
        found = match_lines(_moved_points(points, at), ink.points, settings=LAYING.fine)
        at = _bend_to_ink(points, found, ink.points)
        covered, owner = find_covered(
            LineMatch(at, found.responsibility), ink.points, points, near=LAYING.own_ink_reach * ink.width
        )
        left_over = 1.0 - float(covered.mean()) + float((owner < 0).mean())
        if best is None or left_over < best[0]:
            best = left_over, at, covered, owner
        if best[0] <= LAYING.good:
            break
    assert best is not None
    left_over, at, covered, owner = best
    numbers = np.array([line.number for line in lines])[points.owner]
    named = _lines_on_ink(lines, points, at, framed, ink.width)
    crossed = _crossed_pairs(character, lines, named, ink.width)
    named = _exchange(named, crossed)
    beside = ((ink.points.xy[:, None] - at) ** 2).sum(axis=2).min(axis=1) < (LAYING.near * ink.width) ** 2
    spare = _spare_lines(ink, (owner < 0) & ~beside)
    every = _with_neighbours((*named, *spare), ink.width)
    confidence = np.zeros(len(character.strokes))
    for number in range(1, len(confidence) + 1):
        own = numbers == number
        shared = claimed_twice(points, at, points.xy, own=own, width=ink.width)
        confidence[number - 1] = (covered[own] & ~shared).mean()
    for a, b in crossed:
        confidence[[lines[a].number - 1, lines[b].number - 1]] = confidence[
            [lines[b].number - 1, lines[a].number - 1]
        ]
    return LaidCharacter(
        character=character,
        lines=CentreLines(every, sample_lines(every), ink.width),
        left_over=left_over,
        unevenness=unevenness(points, at, np.ones(len(at), bool)),
        confidence=confidence,
    )


def _crossed_pairs(
    character: CanonicalCharacter, before: Sequence[CentreLine], laid: Sequence[CentreLine], width: float
) -> list[tuple[int, int]]:
    """Two horizontals, the upper of which came to lie below the other, or two verticals, by their positions.

    before, laid: the lines as copybooks print them, and on the master. In 寧 the long horizontal of 丁 lies
    where the copybook's 皿 has one as long, and each found the other's ink.
    """
    whole = [sum(line.number == other.number for other in before) == 1 for line in before]
    kinds = [character.strokes[line.number - 1].name.zh for line in before]
    found: list[tuple[int, int]] = []
    for kind, k in ((HORIZONTAL.zh, 1), (VERTICAL.zh, 0)):
        alike = [i for i, own in enumerate(kinds) if own == kind and whole[i]]
        for a, b in combinations(alike, 2):
            was, now = (
                lines[b].points[:, k].mean() - lines[a].points[:, k].mean() for lines in (before, laid)
            )
            beside = _overlap(laid[a].points[:, 1 - k], laid[b].points[:, 1 - k]) >= LAYING.beside
            free = all(a not in pair and b not in pair for pair in found)
            if was * now < 0 and min(abs(was), abs(now)) > width and beside and free:
                found.append((a, b))
    return found


def _overlap(a: FloatArray, b: FloatArray) -> float:
    """Share of the shorter of two stretches, given by points on them, that lies in the other."""
    both = min(a.max(), b.max()) - max(a.min(), b.min())
    return float(both / max(min(np.ptp(a), np.ptp(b)), 1e-9))


def _exchange(lines: list[CentreLine], pairs: Sequence[tuple[int, int]]) -> list[CentreLine]:
    """The lines with those of each pair in each other's place and of each other's number."""
    changed = list(lines)
    for a, b in pairs:
        changed[a] = replace(lines[b], number=lines[a].number)
        changed[b] = replace(lines[a], number=lines[b].number)
    return changed


def _canonical_lines(character: CanonicalCharacter, ink: LinePoints) -> tuple[CentreLine, ...]:
    """The canonical strokes, cut at corners, with the middle and the spread of a skeleton's points."""
    strokes = [_resample(stroke.centre_line, LAYING.step) for stroke in character.strokes]
    every = np.concatenate(strokes)
    spread = ink.xy.std(axis=0) / np.maximum(every.std(axis=0), 1e-3)
    size, ratio = np.sqrt(spread.prod()), np.clip(spread[0] / spread[1], 1 / LAYING.clip, LAYING.clip)
    factor = size * np.array([np.sqrt(ratio), 1 / np.sqrt(ratio)])
    lines = []
    for number, (stroke, known) in enumerate(zip(strokes, character.strokes, strict=True), start=1):
        moved = (stroke - every.mean(axis=0)) * factor + ink.xy.mean(axis=0)
        is_plain = known.name.zh in {kind.zh for kind in PLAIN_KINDS}
        pieces = [(0, len(stroke) - 1)] if is_plain else between_corners(stroke, arm=LAYING.arm)
        lines += [_line(moved[a : b + 1], number=number) for a, b in pieces]
    return tuple(lines)


def _resample(points: FloatArray, step: float) -> FloatArray:
    """A polyline with its points evenly spaced, about `step` apart."""
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    return evenly_spaced(points, max(round(length / step), 2) + 1)


def _line(points: FloatArray, *, number: int, radius: FloatArray | None = None) -> CentreLine:
    """A line whose neighbours are not known yet."""
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    n = len(points)
    radius = np.ones(n) if radius is None else radius
    return CentreLine(points, radius, (True, True), np.ones(n, bool), arc, number)


def _moved_points(points: LinePoints, at: FloatArray) -> LinePoints:
    """The points at other places, with the directions that their lines have there."""
    double = np.concatenate([doubled_directions(at[own]) for own in _runs_of_owner(points.owner)])
    return replace(points, xy=at, double=double)


def _runs_of_owner(owner: IntArray) -> list[slice]:
    """Where the points of each line stand."""
    ends = [0, *(np.flatnonzero(np.diff(owner)) + 1).tolist(), len(owner)]
    return [slice(a, b) for a, b in pairwise(ends)]


def _bend_to_ink(points: LinePoints, found: LineMatch, ink: LinePoints) -> FloatArray:
    """(n, 2): the moved points, pushed sideways, neighbours together, to the ink that is theirs."""
    at = found.moved.copy()
    given = found.responsibility * np.where(ink.clear, np.float32(1.0), np.float32(0.1))
    weight = given.sum(axis=1)
    off = (given @ ink.xy.astype(np.float32)) / np.maximum(weight, 1e-6)[:, None] - at
    weight = np.minimum(weight, 1.0)
    for own in _runs_of_owner(points.owner):
        w, n = weight[own], own.stop - own.start
        if n < 3:
            at[own] += (w[:, None] * off[own]).sum(axis=0) / max(float(w.sum()), 1.0)
            continue
        ways = np.gradient(at[own], axis=0)
        ways /= np.maximum(np.hypot(*ways.T), 1e-9)[:, None]
        aside = np.column_stack([-ways[:, 1], ways[:, 0]])
        steps = np.arange(n)
        near = np.exp(-0.5 * ((steps[:, None] - steps) / LAYING.bend) ** 2)
        support = near @ w
        push = near @ (w * (off[own] * aside).sum(axis=1)) / np.maximum(support, 1e-6)
        push *= np.minimum(2.0 * support / near.sum(axis=1), 1.0)  # little ink pushes little
        at[own] += push[:, None] * aside
    return at


def _lines_on_ink(
    lines: tuple[CentreLine, ...], points: LinePoints, at: FloatArray, framed: FramedInk, width: float
) -> list[CentreLine]:
    """The lines where they lie on the master, ends carried to the end of the ink, with its half-widths."""
    import cv2

    depth = cv2.distanceTransform(framed.ink.view(np.uint8), cv2.DIST_L2, 5) / SCALE
    made = []
    runs = _runs_of_owner(points.owner)
    for k, (line, own) in enumerate(zip(lines, runs, strict=True)):
        path = at[own]
        first = k == 0 or lines[k - 1].number != line.number
        last = k + 1 == len(lines) or lines[k + 1].number != line.number
        if len(path) > 1:
            if first:
                path = np.concatenate([_tail(path[::-1], depth, width)[::-1], path])
            if last:
                path = np.concatenate([path, _tail(path, depth, width)])
            path = _resample(path, 0.5 * points.spacing)
        made.append(_line(path, number=line.number, radius=np.maximum(depth[pixels_at(path)], 1 / SCALE)))
    return made


def _tail(path: FloatArray, depth: FloatArray, width: float) -> FloatArray:
    """(n, 2): the points by which a path goes on, straight, to the end of its ink."""
    way = path[-1] - path[max(len(path) - 4, 0)]
    length = float(np.hypot(*way))
    if length < 1e-9:
        return np.zeros((0, 2))
    steps = np.arange(1, int(LAYING.longest_tail * width * SCALE) + 1)[:, None] / SCALE
    tail = path[-1] + steps * way / length
    least = LAYING.tail_depth * float(np.median(depth[pixels_at(path)]))
    inside = depth[pixels_at(tail)] > least
    count = len(tail) if inside.all() else int(np.argmin(inside))
    # a line of the skeleton ends half a width before its ink does
    return np.asarray(tail[: max(count - round(0.25 * width * SCALE), 0)])


def _spare_lines(ink: CentreLines, left: BoolArray) -> list[CentreLine]:
    """Runs of the master's ink that no canonical line explains, (m,) left, as lines without a number."""
    spare = []
    for own in _runs_of_owner(ink.points.owner):
        free = np.concatenate([[0], left[own].astype(int), [0]])
        edges = np.flatnonzero(np.diff(free))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            if (b - a) * ink.points.spacing >= LAYING.shortest_spare * ink.width and b - a > 1:
                run = slice(own.start + a, own.start + b)
                spare.append(_line(ink.points.xy[run], number=0, radius=ink.points.radius[run]))
    return spare


def _with_neighbours(lines: tuple[CentreLine, ...], width: float) -> tuple[CentreLine, ...]:
    """The lines with what is known once all are there: which ends are free, and where each is alone."""
    reach = LAYING.near * width
    made = []
    for k, line in enumerate(lines):
        others = np.concatenate(
            [other.points for j, other in enumerate(lines) if j != k] or [np.zeros((0, 2))]
        )
        if not len(others):
            made.append(line)
            continue
        squared = ((line.points[:, None] - others) ** 2).sum(axis=2).min(axis=1)
        alone = squared > reach**2
        made.append(replace(line, free=(bool(alone[0]), bool(alone[-1])), clear=np.asarray(alone)))
    return tuple(made)
