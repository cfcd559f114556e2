"""The parts that a character is made of: how wide each is, how they stand to each other, what is enclosed.

Which parts there are is known from the character's structure; where the master's meet is read from its ink.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rumu.characters.stroke_data import Structure
from rumu.strokes.centre_lines import SCALE, SIDE
from rumu.strokes.correspondence import StrokeMatch
from rumu.strokes.stance import Axis, widening
from rumu.values import BoolArray, FloatArray, IntArray

AXES: Mapping[Structure, Axis] = {
    "left-right": "across",
    "left-middle-right": "across",
    "top-bottom": "down",
    "top-middle-bottom": "down",
    "three alike": "down",
}
"""Structure -> along which axis its parts stand; the others have no such parts."""


@dataclass(frozen=True, slots=True)
class PartSettings:
    """How parts are found. Shares of the character's extent unless said.

    borders: between which the parts may meet. share: of the points that each part must hold; strokes: of the
    master's that each must have, since a single stroke is no part to a teacher. seen: share of each part's
    points that the copy must have. reach: distance from the edge up to which a stroke is one that
    encloses. inner: shares of all points between which what is enclosed must lie.
    """

    borders: tuple[float, float] = (0.22, 0.78)
    share: float = 0.15
    strokes: int = 2
    seen: float = 0.6
    reach: float = 0.1
    inner: tuple[float, float] = (0.15, 0.8)


PARTS = PartSettings()


@dataclass(frozen=True, slots=True, eq=False)
class PartMeasures:
    """Two parts of a copy against the master's, size, place and lean of the whole taken out.

    axis: along which they stand. first: (n,) which of the master's points are of the left (upper) one.
    width: of each along the axis, over the master's. apart: (x right, y DOWN), rms radii, by which the first
    one is off its place beside the second. explained: (n, 2) how far the parts' faults move each point.
    """

    axis: Axis
    first: BoolArray
    width: tuple[float, float]
    apart: FloatArray
    explained: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class InnerMeasures:
    """What is enclosed.

    points: (n,) which of the master's points it holds. size: of it over the size of what encloses it, over
    the same of the master. apart: (x right, y DOWN), rms radii, by which it is off its place in that.
    explained: (n, 2) how far these faults move each of the master's points.
    """

    points: BoolArray
    size: float
    apart: FloatArray
    explained: FloatArray


def measure_parts(
    match: StrokeMatch, structure: Structure | None, *, radical_border: int | None = None
) -> PartMeasures | None:
    """Measure the two parts of a character; None where its structure has none, or one cannot be seen.

    radical_border: see `CanonicalCharacter`.
    """
    axis = AXES.get(structure) if structure is not None else None
    if axis is None:
        return None
    k = 0 if axis == "across" else 1
    places, copy, seen = match.places, match.pose.undo(match.in_cell), match.covered
    first = _first_part(match, k, radical_border)
    if first is None:
        return None
    width, moved = [], []
    explained = np.zeros_like(places)
    for part in (first, ~first):
        own = part & seen
        if own.sum() < max(PARTS.seen * part.sum(), 4):
            return None
        spread = widening(places[own, k], copy[own, k], match.master.points.owner[own])
        shift = (copy[own] - places[own]).mean(axis=0)
        explained[part] = shift
        explained[part, k] += (spread - 1.0) * (places[part, k] - places[own, k].mean())
        width.append(spread)
        moved.append(shift)
    return PartMeasures(axis, first, (width[0], width[1]), moved[0] - moved[1], explained)


def _first_part(match: StrokeMatch, k: int, radical_border: int | None) -> BoolArray | None:
    """(n,) which of the master's points are of its left (k is 0) or upper (k is 1) part.

    The parts meet where the radical ends or begins, if all strokes before lie before all others. Else they
    meet where the master has the least ink; a stroke is of the part in which its middle lies, and of that in
    which it is written.
    """
    points = match.master.points
    own = [points.owner == i for i in range(len(match.master.lines))]
    middles = np.array([points.xy[line, k].mean() for line in own])
    numbers = np.array([line.number for line in match.master.lines])
    before = None if radical_border is None else _before_border(middles, numbers, radical_border)
    if before is None:
        before = middles < _emptiest_line(match, k)
        before = _written_first(before, numbers, np.array([points.radius[line].sum() for line in own]))
    strokes, first = int(before.sum()), before[points.owner]
    whole = PARTS.strokes <= strokes <= len(before) - PARTS.strokes
    return first if whole and PARTS.share <= first.mean() <= 1 - PARTS.share else None


def _before_border(middles: FloatArray, numbers: IntArray, border: int) -> BoolArray | None:
    """(m,) which lines are written before the border; None where they do not all lie before the others.

    middles: (m,) of the lines, along the axis. numbers: of their strokes, 0 where they are not known.
    """
    before, after = (numbers > 0) & (numbers <= border), numbers > border
    if not (before.any() and after.any()) or middles[before].max() >= middles[after].min():
        return None
    between = (middles[before].max() + middles[after].min()) / 2
    return np.where(numbers > 0, before, middles < between)


def _emptiest_line(match: StrokeMatch, k: int) -> float:
    """Where across the axis the master has the least ink, near the middle."""
    ink = match.framed_master.ink.sum(axis=k).astype(float)
    inked = np.flatnonzero(ink)
    low, extent = inked[0], inked[-1] - inked[0]
    a, b = (round(low + share * extent) for share in PARTS.borders)
    candidates = np.arange(a, b + 1)
    least = candidates[ink[a : b + 1] <= ink[a : b + 1].min() + 0.5]
    middle = (a + b) / 2
    return (float(least[np.abs(least - middle).argmin()]) - (SIDE - 1) / 2) / SCALE


def _written_first(before: BoolArray, numbers: IntArray, ink: FloatArray) -> BoolArray:
    """(m,) which lines are of the first part, given those that lie before the border: (m,), as all of these.

    The strokes of one part are written after those of the other: a dot that reaches over the border changes
    sides. Of the places in the order of writing where the parts may meet, the one that moves the least ink.
    numbers: of their strokes, 0 where they are not known; such lines stay where they are.
    """
    known = numbers > 0
    if not known.any():
        return before
    last = np.arange(1, numbers.max() + 1)
    moved = [float(ink[known & ((numbers <= number) != before)].sum()) for number in last]
    return np.where(known, numbers <= last[int(np.argmin(moved))], before)


def measure_inner(match: StrokeMatch, structure: Structure | None) -> InnerMeasures | None:
    """Measure what an enclosed or half-enclosed character encloses; None where that cannot be told."""
    if structure not in ("enclosed", "half-enclosed"):
        return None
    points, places, seen = match.master.points, match.places, match.covered
    low, high = points.xy.min(axis=0), points.xy.max(axis=0)
    reach = PARTS.reach * (high - low)
    outer = np.zeros(len(points.xy), bool)
    for i in range(len(match.master.lines)):
        own = points.owner == i
        least, most = points.xy[own].min(axis=0), points.xy[own].max(axis=0)
        # the left, the right or the upper edge; below, most enclosures are open
        outer[own] = bool((least < low + reach).any() or most[0] > high[0] - reach[0])
    inner = ~outer
    if not PARTS.inner[0] <= inner.mean() <= PARTS.inner[1]:
        return None
    copy, sizes, moved = match.pose.undo(match.in_cell), [], []
    explained = np.zeros_like(places)
    for part in (inner, outer):
        own = part & seen
        if own.sum() < max(PARTS.seen * part.sum(), 4):
            return None
        size = float(np.sqrt(np.var(copy[own], axis=0).sum() / np.var(places[own], axis=0).sum()))
        middle, shift = places[own].mean(axis=0), (copy[own] - places[own]).mean(axis=0)
        explained[part] = shift + (size - 1.0) * (places[part] - middle)
        sizes.append(size)
        moved.append(shift)
    return InnerMeasures(inner, sizes[0] / sizes[1], moved[0] - moved[1], explained)
