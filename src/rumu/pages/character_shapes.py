"""The ink of each character of a column, and the four corners around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.columns import Column
from rumu.pages.page_characters import ColumnPlaces
from rumu.values import BoolArray, FloatArray, IntArray

_OWN = 0.75  # share of a connected part that one character must hold to get all of it


@dataclass(frozen=True, slots=True, eq=False)
class CharacterShape:
    """A character of a column.

    corners: (4, 2) float64, x and y: left and right above, right and left below. small: None, or 0 or 1 in
    the right or left line of a double row. doubt: what it cost to take this for one character. y, x: (k,) the
    pixels of its ink.
    """

    corners: FloatArray
    small: int | None
    doubt: float
    y: IntArray
    x: IntArray


def shapes_of(column: Column, places: ColumnPlaces) -> list[CharacterShape]:
    """The characters of a column in reading order; of a double row, first its right line, then its left."""
    if not len(places.at):
        return []
    owner = _owners(column, places)
    order = np.argsort(owner, kind="stable")
    edges = np.searchsorted(owner[order], np.arange(len(places.at) + 1))
    found: list[CharacterShape] = []
    left_line: list[CharacterShape] = []
    for k, small in enumerate(places.small):
        own = order[edges[k] : edges[k + 1]]
        if not small:
            found += left_line
            left_line = []
            found += _shape(column, own, None, float(places.doubt[k]))
            continue
        side = _is_left(column.offset[own])
        found += _shape(column, own[~side], 0, float(places.doubt[k]))
        left_line += _shape(column, own[side], 1, float(places.doubt[k]))
    return found + left_line


def _owners(column: Column, places: ColumnPlaces) -> IntArray:
    """(k,): the character of each pixel, that of the whole part where most of it lies in one."""
    owner = np.searchsorted(places.at[:, 0], column.y + 0.5, side="right") - 1
    owner = np.clip(owner, 0, len(places.at) - 1)
    _, part = np.unique(column.part, return_inverse=True)
    count = len(places.at)
    votes = np.bincount(part * count + owner, minlength=(part.max() + 1) * count).reshape(-1, count)
    clear = votes.max(axis=1) > _OWN * votes.sum(axis=1)
    return np.asarray(np.where(clear[part], votes.argmax(axis=1)[part], owner))


def _is_left(offset: FloatArray) -> BoolArray:
    """(k,) bool: pixels left of the widest gap near the middle of a double row."""
    places = np.sort(np.append(offset, [0.0]))
    reach = 0.5 * max(abs(places[0]), abs(places[-1]))
    gaps = np.diff(places)
    middles = (places[1:] + places[:-1]) / 2
    gaps = np.where(np.abs(middles) <= reach, gaps, -1.0)
    at = float(middles[np.argmax(gaps)]) if gaps.max() > 1.5 else 0.0
    return np.asarray(offset < at)


def _shape(column: Column, own: IntArray, small: int | None, doubt: float) -> list[CharacterShape]:
    """The character of these pixels of a column; none where there are none."""
    if not len(own):
        return []
    y, offset = column.y[own], column.offset[own]
    x = np.rint(offset + column.ridge.at(y.astype(float))).astype(np.intp)
    return [CharacterShape(_corners(column, y, offset), small, doubt, y, x)]


def _corners(column: Column, y: IntArray, offset: FloatArray) -> FloatArray:
    """(4, 2): the corners around these pixels; the sides lean as the column does."""
    top, bottom = float(y.min()), float(y.max()) + 1
    left, right = float(offset.min()), float(offset.max()) + 1
    above, below = column.ridge.at(np.array([top, bottom]))
    return np.array(
        [[above + left, top], [above + right, top], [below + right, bottom], [below + left, bottom]]
    )


def _offset(column: Column, y: IntArray, x: IntArray) -> FloatArray:
    """How far pixels lie to the right of the middle of their column."""
    return np.asarray(x - column.ridge.at(y.astype(float)))


def joined_shape(upper: CharacterShape, lower: CharacterShape, column: Column) -> CharacterShape:
    """Two shapes of a column as one character: one above the other, or what was taken for a double row."""
    y, x = np.concatenate([upper.y, lower.y]), np.concatenate([upper.x, lower.x])
    corners = _corners(column, y, _offset(column, y, x))
    small = upper.small if upper.small == lower.small else None
    return CharacterShape(corners, small, max(upper.doubt, lower.doubt), y, x)


def cut_shape(
    shape: CharacterShape, row: float, column: Column
) -> tuple[CharacterShape, CharacterShape] | None:
    """A shape cut in two at this row of the page; None where one side would be empty."""
    upper = shape.y < row
    if not upper.any() or upper.all():
        return None
    above, below = (
        CharacterShape(_corners(column, y, _offset(column, y, x)), shape.small, shape.doubt, y, x)
        for y, x in ((shape.y[side], shape.x[side]) for side in (upper, ~upper))
    )
    return above, below
