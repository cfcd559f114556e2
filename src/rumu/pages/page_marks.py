"""What stands in a column and is no character: punctuation, and pieces of a frame at its head and foot."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.pages.column_rhythm import find_pace
from rumu.pages.columns import Column
from rumu.pages.page import Direction
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class MarkSettings:
    """When a stretch of ink between empty ones is no character; lengths in sides of a character.

    paced, slender: a side is this share of the pace, but one to so many breadths of a column.

    A point (。，、) is shorter than `point` along its column and across it, its middle lies beyond the
    column's by `aside` (to the right, or below in a row), and `after` of paper follows it; or it has `alone`
    of paper on both sides. Other marks are told on pages of rows: `slim` along the row at most, no higher
    than `high`, `open` of paper on one side. tiny: the dots of an ellipsis. between: between a mark and its
    neighbour at least.

    flat: a piece of a frame is lower than this, `apart` from what comes next, and lies `beyond` the ends of
    the columns beside it, `near` on either side, of which `agree`, as a share, end within `level` of their
    median without such pieces, one of them having none.
    """

    paced: float = 0.85
    slender: float = 1.25
    point: float = 0.36
    aside: float = 0.14
    after: float = 0.12
    alone: float = 0.28
    slim: float = 0.4
    high: float = 1.02
    open: float = 0.3
    tiny: float = 0.16
    between: float = 0.03
    flat: float = 0.3
    apart: float = 0.15
    beyond: float = 0.1
    near: int = 5
    agree: float = 0.5
    level: float = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """Stretches of ink of a column between empty ones.

    begin, end: (n,) rows of the page. low, high: (n,) the offsets between which the ink lies. number: (k,)
    which of them each pixel of the column is in.
    """

    begin: IntArray
    end: IntArray
    low: FloatArray
    high: FloatArray
    number: IntArray


def without_marks(
    columns: list[Column], direction: Direction, *, settings: MarkSettings | None = None
) -> list[Column]:
    """The columns of a register without punctuation, and without pieces of its frame."""
    settings = settings or MarkSettings()
    breadth = float(np.median([column.breadth for column in columns]))
    pace = find_pace(columns)
    side = float(np.clip(settings.paced * pace, breadth, settings.slender * breadth))
    columns = _without_frame(columns, side, settings)
    kept = []
    for column in columns:
        own = _stretches(column)
        marks = _marks(own, side, pace, direction, settings)
        kept.append(_without(column, marks[own.number]))
    return kept


def _without(column: Column, those: BoolArray) -> Column:
    """The column without these pixels of its ink; as it is where nothing would be left."""
    if not those.any() or those.all():
        return column
    keep = ~those
    return replace(column, y=column.y[keep], offset=column.offset[keep], part=column.part[keep])


def _stretches(column: Column) -> _Stretches:
    top, bottom = column.extent
    inked = np.bincount(column.y - top, minlength=bottom - top) > 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inked, [False]]).astype(np.int8)))
    begin, end = edges[::2] + top, edges[1::2] + top
    number = np.searchsorted(begin, column.y, side="right") - 1
    low, high = np.full(len(begin), np.inf), np.full(len(begin), -np.inf)
    np.minimum.at(low, number, column.offset)
    np.maximum.at(high, number, column.offset + 1)
    return _Stretches(begin, end, low, high, number)


def _marks(
    own: _Stretches, side: float, pace: float, direction: Direction, settings: MarkSettings
) -> BoolArray:
    """(n,) bool: which stretches are punctuation."""
    along, across = (own.end - own.begin) / side, (own.high - own.low) / side
    aside = (own.high + own.low) / 2 / side
    gaps = np.concatenate([[np.inf], (own.begin[1:] - own.end[:-1]) / side, [np.inf]])
    before, after = gaps[:-1], gaps[1:]
    small = np.maximum(along, across) < settings.point
    clear = np.minimum(before, after) > settings.between
    lone = np.minimum(before, after) > settings.alone
    marks = small & clear & np.isfinite(before) & ((aside > settings.aside) & (after > settings.after) | lone)
    if direction == "vertical":
        return np.asarray(marks)
    marks |= (np.maximum(along, across) < settings.tiny) & (np.minimum(before, after) > settings.tiny / 2)
    slim = (along < settings.slim) & (across < settings.high) & clear & ~marks
    for k in map(int, np.flatnonzero(slim)):
        closes = np.isfinite(before[k]) and after[k] > settings.open
        opens = np.isfinite(after[k]) and before[k] > settings.open
        marks[k] = (closes and _is_beside(own, marks, k, -1, side=side, pace=pace, settings=settings)) or (
            opens and _is_beside(own, marks, k, 1, side=side, pace=pace, settings=settings)
        )
    return np.asarray(marks)


def _is_beside(
    own: _Stretches, marks: BoolArray, k: int, way: int, *, side: float, pace: float, settings: MarkSettings
) -> bool:
    """Whether the characters next to a slim stretch, before it (-1) or after it, are whole without it."""
    begins, ends = (own.begin, own.end) if way == 1 else (-own.end, -own.begin)
    first = last = k + way
    while 0 <= last + way < len(begins) and not marks[last + way]:
        if begins[last + way] - ends[last] > settings.open * side:
            break
        last += way
    paper = max(0.0, pace - side)
    without = (ends[last] - begins[first] + paper) / pace
    with_it = (ends[last] - begins[k] + paper) / pace
    if without > 4.5:  # the paces of so many are not known to a part of one
        return True
    return bool(abs(without - max(1, round(without))) < abs(with_it - round(with_it)))


def _without_frame(columns: list[Column], side: float, settings: MarkSettings) -> list[Column]:
    """The columns without flat pieces above the heads, or below the feet, of those beside them."""
    every = [_stretches(column) for column in columns]
    taken = [np.zeros(len(own.begin), dtype=bool) for own in every]
    for way in (1, -1):  # from the head down, from the foot up
        counts = np.array([_flat_ends(own, side, way, settings) for own in every])
        heads = [own.begin if way == 1 else -own.end[::-1] for own in every]
        ends = np.array([head[count] for head, count in zip(heads, counts, strict=True)], dtype=float)
        for k, own in enumerate(every):
            near = np.abs(np.arange(len(every)) - k) <= settings.near
            near[k] = False
            if not counts[k] or not near.any():
                continue
            usual = float(np.median(ends[near]))
            level = near & (np.abs(ends - usual) < settings.level * side)
            if level.sum() < settings.agree * near.sum() or not (level & (counts == 0)).any():
                continue
            inner = own.end if way == 1 else -own.begin
            flat = np.arange(len(inner)) if way == 1 else np.arange(len(inner))[::-1]
            taken[k] |= (flat < counts[k]) & (inner < usual - settings.beyond * side)
    return [
        _without(column, those[own.number]) for column, own, those in zip(columns, every, taken, strict=True)
    ]


def _flat_ends(own: _Stretches, side: float, way: int, settings: MarkSettings) -> int:
    """How many flat stretches stand apart at the head of a column (1), or at its foot (-1)."""
    heights, gaps = (own.end - own.begin)[::way], (own.begin[1:] - own.end[:-1])[::way]
    ended = (heights[:-1] > settings.flat * side) | (gaps < settings.apart * side)
    return int(np.argmax(ended)) if ended.any() else 0
