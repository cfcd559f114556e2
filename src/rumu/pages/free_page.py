"""A page without a grid: its ink, its registers and columns, its characters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.character_shapes import CharacterShape, shapes_of
from rumu.pages.columns import Column, find_columns
from rumu.pages.direction import find_direction
from rumu.pages.furniture import text_only
from rumu.pages.page import Direction
from rumu.pages.page_characters import ColumnPlaces, part_register
from rumu.pages.page_ink import Picture, find_page_ink
from rumu.pages.page_marks import without_marks
from rumu.pages.page_parts import find_parts
from rumu.values import BoolArray, IntArray

_WRITTEN = 0.5  # of what may be writing on a page, the share that is in its columns at least
_OF_ALL_INK = 0.08  # of all ink, lines and pictures too


@dataclass(frozen=True, slots=True, eq=False)
class WrittenColumn:
    """A column and its characters.

    register, number: where it stands, from 0 in reading order. column, places: its ink and where it is cut.
    shapes: its characters in reading order.
    """

    register: int
    number: int
    column: Column
    places: ColumnPlaces
    shapes: tuple[CharacterShape, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FreePage:
    """The columns of a page in reading order; none where most of the ink stands in no columns.

    Rows and columns of everything in `columns` are swapped where `direction` is "horizontal". size: about
    what a character measures, in pixels. width, height: of the picture. lines: (height, width) bool, ruled
    lines and frames, swapped as the columns are.
    """

    columns: tuple[WrittenColumn, ...]
    direction: Direction
    size: float
    width: int
    height: int
    lines: BoolArray

    def looks(self) -> list[tuple[IntArray, IntArray]]:
        """Rows and columns of the ink of each character, as it stands on the picture."""
        shapes = [shape for column in self.columns for shape in column.shapes]
        return [(one.y, one.x) if self.direction == "vertical" else (one.x, one.y) for one in shapes]


def find_free_page(picture: Picture) -> FreePage:
    """Registers, columns and characters of a page that has no grid.

    picture: (H, W, 3) uint8 sRGB, flat and upright. Raises ImageError where there is no ink.
    """
    page = find_page_ink(picture)
    parts = find_parts(page.ink, faint=page.faint)
    direction = find_direction(parts.ink, size=parts.size)
    if direction == "horizontal":
        parts = find_parts(_turned(page.ink), faint=_turned(page.faint))
    registers = text_only(find_columns(parts), size=parts.size, signed=direction == "vertical")
    if direction == "horizontal":  # swapped, the first row is the leftmost column
        registers = [columns[::-1] for columns in registers]
    registers = [without_marks(columns, direction) for columns in registers]
    written = [
        WrittenColumn(r, c, column, places, tuple(shapes_of(column, places)))
        for r, columns in enumerate(registers)
        for c, (column, places) in enumerate(zip(columns, part_register(columns), strict=True))
    ]
    ink = sum(len(shape.y) for column in written for shape in column.shapes)
    all_ink = int(page.ink.sum())
    if ink < _WRITTEN * int(parts.ink.sum()) or ink < _OF_ALL_INK * all_ink:
        written = []
    height, width = picture.shape[:2]
    return FreePage(tuple(written), direction, parts.size, width, height, parts.lines)


def _turned(mask: BoolArray) -> BoolArray:
    return np.ascontiguousarray(mask.T)
