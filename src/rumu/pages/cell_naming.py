"""Names for the written cells of a printed grid, from a text."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rumu.capture.image import shrink
from rumu.pages.grids import PageGrid
from rumu.pages.page import PageCharacter
from rumu.pages.page_ink import Picture, find_page_ink
from rumu.pages.recutting import Words
from rumu.pages.text_alignment import (
    AlignmentSettings,
    FoundCharacters,
    Step,
    align,
    distinct_characters,
    read_text,
)
from rumu.values import IntArray

IN_CELLS = AlignmentSettings(even=0.5, worst=-1.0, skip=3.0, skip_more=0.6)
"""A cell holds one character for certain, and a learner's hand is less like print: order counts for more."""


_LEAST_SHARE, _MOST_INK = 0.12, 0.4
_SIDE = 1000  # longest side, in pixels, at which the shares below are taken


def holds_writing(grid: PageGrid, picture: Picture) -> bool:
    """Whether a grid is one to write in: much of the page's ink stands in its cells, and leaves them room.

    Crossing lines and patterns make cells, too.
    """
    import cv2

    small = shrink(picture, side=_SIDE)
    ink = find_page_ink(small).ink
    scale = small.shape[1] / picture.shape[1]
    mask = np.zeros(ink.shape, dtype=np.uint8)
    for cell in grid.cells:
        if not cell.empty:
            cv2.fillPoly(mask, [np.rint(cell.polygon * scale).astype(np.int32)], 1)
    if not mask.any():  # nothing is written yet
        return True
    inside = ink & (mask > 0)
    share = float(inside.sum()) / max(int(ink.sum()), 1)
    return share > _LEAST_SHARE and float(inside.sum()) < _MOST_INK * max(int(mask.sum()), 1)


def written_looks(grid: PageGrid) -> list[tuple[IntArray, IntArray]]:
    """Rows and columns of the ink in each cell with writing."""
    return [_ink_of(cell, grid) for cell in grid.cells if not cell.empty]


def written_cells(grid: PageGrid, text: str | None) -> tuple[PageCharacter, ...]:
    """The cells with writing in reading order, each with its name where a text is given and has it.

    Cells that the text leaves out, and characters that no cell holds, are passed over.
    """
    cells = [cell for cell in grid.cells if not cell.empty]
    if text is None or not cells:
        return tuple(cells)
    given = read_text(text)
    different, which = distinct_characters(given.characters)
    words = Words(different, "vertical")  # the ink of a cell is upright however cells are read
    z = words.likeness(written_looks(grid))
    n = len(cells)
    columns = [(cell.register, cell.column) for cell in cells]
    found = FoundCharacters(
        z=z,
        z_merged=np.zeros_like(z),
        mergeable=np.zeros(n, dtype=bool),
        beside=np.zeros(n, dtype=bool),
        small=np.zeros(n, dtype=bool),
        height=np.zeros(n),  # no cell holds two characters
        first=np.array([k == 0 or columns[k] != columns[k - 1] for k in range(n)]),
        known=words.known,
    )
    for step in align(found, which, given.starts, settings=IN_CELLS):
        if step.step == Step.MATCH:
            cells[step.found] = replace(cells[step.found], character=given.characters[step.text])
    return tuple(cells)


def _ink_of(cell: PageCharacter, grid: PageGrid) -> tuple[IntArray, IntArray]:
    """Rows and columns of the ink in a cell; its middle where there is none."""
    left, top, right, bottom = (max(0, round(edge)) for edge in cell.box)
    y, x = np.nonzero(grid.ink[top:bottom, left:right])
    if not len(y):
        return np.array([0]), np.array([0])
    return y, x
