"""Where everything stands on a practice sheet, in millimetres: one geometry for printing and for reading.

The origin is the paper's upper left corner, x right, y down. A page says all that its layout depends on, and
its printed code says the page, so a reader knows where each cell is and what belongs in it.
"""

from __future__ import annotations

import unicodedata
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from rumu.errors import RumuError
from rumu.values import FloatArray

Paper = Literal["A4", "Letter"]
Grid = Literal["mi", "nine", "tian", "hui", "none"]
"""米字格, 九宮格, 田字格, 回宮格, or the corners of cells alone."""
Help = Literal["faint", "outlined", "beside", "shrinking", "none"]
"""How the master helps: 描紅, 雙鉤, beside the cells, less from cell to cell, or not at all."""
Model = Literal["full", "faint", "outlined", "dots", "none"]
"""How the master is printed in one cell; a full one is to look at, and nothing is written over it."""

PAPERS: dict[Paper, tuple[float, float]] = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}
GRIDS: tuple[Grid, ...] = get_args(Grid)
HELPS: tuple[Help, ...] = get_args(Help)

MARGIN = 10.0  # from each side of the paper: printers leave up to 6 mm blank
MARKER = 8.0  # side of a marker
MARKER_ROWS = 5  # of markers along each long side, the corners among them
HEAD = 28.0  # height of the head, and side of the code in it
CLEAR = 2.0  # white around markers and code
GAP = 2.5  # below each row of cells
LABEL, STROKES = 4.5, 8.5  # height of what stands above a row: the character alone, or its strokes too
FRAME_WIDTH, LINE_WIDTH, OUTLINE_WIDTH = 0.30, 0.18, 0.20  # of a cell's sides, the lines in it, hollow models
TICK = 2.0  # length of the corners that stand for a grid
SMALLEST_CELL, LARGEST_CELL = 12.0, 160.0
MOST_CHARACTERS = 54  # on one page, so that its code stays coarse enough to be read
LONGEST_PUPIL = 24  # characters of a name that the code holds


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle on the paper, in millimetres."""

    left: float
    top: float
    width: float
    height: float

    @property
    def corners(self) -> FloatArray:
        """(4, 2): upper left, upper right, lower right, lower left."""
        right, bottom = self.left + self.width, self.top + self.height
        return np.array([[self.left, self.top], [right, self.top], [right, bottom], [self.left, bottom]])


@dataclass(frozen=True, slots=True)
class SheetCell:
    """One printed cell.

    row, column: from 0, from the top and the left. character: what belongs in it. model: how its master is
    printed there. box: where.
    """

    row: int
    column: int
    character: str
    model: Model
    box: Box

    @property
    def is_for_writing(self) -> bool:
        """Whether a pupil writes in it; the other cells show the master."""
        return self.model != "full"


def characters_to_write(text: str) -> str:
    """The characters of a text that are written in cells: no spaces, no line ends, no punctuation."""
    return "".join(sign for sign in text if unicodedata.category(sign)[0] not in "ZCP")


@dataclass(frozen=True)
class SheetPage:
    """One page of a sheet: all that its layout depends on, as its code says it.

    Parameters
    ----------
    text
        The characters of this page, in order.
    master
        Whose writing is copied, see `rumu.gallery.sheet_masters`.
    paper, cell, grid, help
        The paper, the side of a cell in millimetres, the lines in it, and how the master helps.
    times
        Cells to write in for each character; 0 fills whole rows, and a page as well as they can.
    strokes
        Whether the order of its strokes stands above each character.
    sheet
        Eight digits that tell sheets apart.
    number, count
        Which page of how many, from 1.
    pupil
        Who it is printed for; "" for anybody.
    """

    text: str
    master: str
    paper: Paper = "A4"
    cell: float = 28.0
    grid: Grid = "mi"
    help: Help = "faint"
    times: int = 0
    strokes: bool = True
    sheet: str = ""
    number: int = 1
    count: int = 1
    pupil: str = ""

    def __post_init__(self) -> None:
        known = self.paper in PAPERS and self.grid in GRIDS and self.help in HELPS
        if not known or not SMALLEST_CELL <= self.cell <= LARGEST_CELL or not 0 <= self.times <= 500:
            raise RumuError(
                f"expected a sheet of {', '.join(PAPERS)}, {', '.join(GRIDS)}, {', '.join(HELPS)}, cells of "
                f"{SMALLEST_CELL:.0f} to {LARGEST_CELL:.0f} mm and at most 500 of each character, got "
                f"{self.paper}, {self.grid}, {self.help}, {self.cell:g} mm, {self.times}"
            )
        if not self.text or any(not sign.isprintable() or sign.isspace() for sign in self.text):
            raise RumuError(f"expected characters to print, got {self.text!r}", zh="這裡有印不出來的字。")
        if not 1 <= self.number <= self.count:
            raise RumuError(f"expected a page from 1 to {self.count}, got {self.number}")
        if len(self.pupil) > LONGEST_PUPIL:
            count, begun = len(self.pupil), self.pupil[:LONGEST_PUPIL]
            raise RumuError(
                f"expected a pupil's name of at most {LONGEST_PUPIL} characters, got {count}: {begun}…",
                zh=f"學生的名字最多 {LONGEST_PUPIL} 個字，「{begun}…」有 {count} 個。",
            )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the paper."""
        return PAPERS[self.paper]

    @property
    def columns(self) -> int:
        """Cells beside each other."""
        width = self.size[0] - 2 * (MARGIN + MARKER + CLEAR)
        return max(1, int(width / self.cell + 1e-9))

    @property
    def group(self) -> int:
        """Cells for each character, with the one that shows the master where there is one."""
        return max(1, self.times) + (self.help in ("beside", "shrinking"))

    @property
    def label_height(self) -> float:
        """Of the strip above each row of cells."""
        return STROKES if self.strokes else LABEL

    @property
    def rows(self) -> int:
        """Rows of cells that the page has room for."""
        height = self.size[1] - (MARGIN + HEAD + CLEAR) - (MARGIN + MARKER + CLEAR)
        return max(1, int((height + GAP) / (self.label_height + self.cell + GAP) + 1e-9))

    @property
    def capacity(self) -> int:
        """Characters that one page has room for; 0 where one does not fit on it."""
        if self.group <= self.columns:
            fits = self.columns // self.group * self.rows
        else:
            fits = self.rows // -(-self.group // self.columns)
        return min(fits, MOST_CHARACTERS)

    @cached_property
    def cells(self) -> tuple[SheetCell, ...]:
        """The cells in reading order: rows from the top, in each from the left."""
        columns, group = self.columns, self.group
        in_row = max(1, columns // group)  # characters in one row
        rows_each = -(-group // columns)  # rows of one character
        left = (self.size[0] - columns * self.cell) / 2
        pitch = self.label_height + self.cell + GAP
        top = MARGIN + HEAD + CLEAR + self.label_height
        cells = []
        for k, character in enumerate(self.text):
            first_row, place = k // in_row * rows_each, k % in_row * group
            for n, model in enumerate(self._models()):
                row, column = first_row + n // columns, place + n % columns
                box = Box(left + column * self.cell, top + row * pitch, self.cell, self.cell)
                cells.append(SheetCell(row, column, character, model, box))
        return tuple(cells)

    @property
    def labels(self) -> Iterator[tuple[str, Box]]:
        """The character of each group of cells, and the strip above its first row."""
        group = self.group
        for k in range(0, len(self.cells), group):
            cell, across = self.cells[k], min(group, self.columns)
            top = cell.box.top - self.label_height
            yield cell.character, Box(cell.box.left, top, across * self.cell, self.label_height)

    @property
    def code_box(self) -> Box:
        """Where the code stands."""
        return Box(self.size[0] - MARGIN - MARKER - CLEAR - 1 - HEAD, MARGIN, HEAD, HEAD)

    @property
    def name_box(self) -> Box:
        """Where the pupil's name is written."""
        return Box(MARGIN + MARKER + CLEAR, MARGIN + HEAD - 12, 62.0, 11.0)

    @property
    def identity(self) -> str:
        """What tells this page from all others, for people and tables."""
        return f"{self.sheet}-{self.number}"

    def _models(self) -> Iterator[Model]:
        """How the master is printed in the cells of one character."""
        if self.help in ("beside", "shrinking"):
            yield "full"
        written = self.group - (self.help in ("beside", "shrinking"))
        for n in range(written):
            if self.help == "shrinking":
                yield "faint" if 3 * n < written else "dots" if 3 * n < 2 * written else "none"
            elif self.help == "beside":
                yield "none"
            else:
                yield self.help


def marker_boxes(paper: Paper) -> dict[int, Box]:
    """Where the markers stand, by their numbers: left side, right side, middle of the top and the bottom."""
    width, height = PAPERS[paper]
    right, bottom = width - MARGIN - MARKER, height - MARGIN - MARKER
    tops = np.linspace(MARGIN, bottom, MARKER_ROWS)
    places = [(left, float(top)) for left in (MARGIN, right) for top in tops]
    places += [((width - MARKER) / 2, MARGIN), ((width - MARKER) / 2, bottom)]
    return {number: Box(left, top, MARKER, MARKER) for number, (left, top) in enumerate(places)}


def inner_lines(grid: Grid) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    """The lines within a cell, from point to point, as shares of it."""
    half = (((0.5, 0.0), (0.5, 1.0)), ((0.0, 0.5), (1.0, 0.5)))
    if grid == "tian":
        return half
    if grid == "mi":
        return (*half, ((0.0, 0.0), (1.0, 1.0)), ((1.0, 0.0), (0.0, 1.0)))
    if grid == "nine":
        thirds = (1 / 3, 2 / 3)
        return tuple(((t, 0.0), (t, 1.0)) for t in thirds) + tuple(((0.0, t), (1.0, t)) for t in thirds)
    if grid == "hui":
        left, right, top, bottom = 0.26, 0.74, 0.18, 0.82  # the inner frame is higher than wide
        corners = ((left, top), (right, top), (right, bottom), (left, bottom))
        return tuple(zip(corners, (*corners[1:], corners[0]), strict=True))
    return ()


def lay_out(whole: SheetPage) -> tuple[SheetPage, ...]:
    """The pages of a sheet.

    whole: as one page, with all of its text. Raises RumuError when not one character fits on a page.
    """
    from dataclasses import replace

    if whole.times == 0:
        rows_each = max(1, whole.rows // len(whole.text))
        shown = whole.help in ("beside", "shrinking")
        whole = replace(whole, times=max(1, rows_each * whole.columns - shown))
    capacity = whole.capacity
    if capacity == 0:
        raise RumuError(
            f"expected cells that fit on {whole.paper}, got {whole.group} of {whole.cell:g} mm "
            "for each character",
            zh="一頁放不下一個字要的格數；請把格子改小，或每字少寫幾格。",
        )
    parts = [whole.text[k : k + capacity] for k in range(0, len(whole.text), capacity)]
    if len(parts) > 99:
        raise RumuError(
            f"expected a sheet of at most 99 pages, got {len(parts)}; print its text in parts",
            zh=f"一份練習紙最多 99 頁，這裡要 {len(parts)} 頁；請分幾次印。",
        )
    whole = replace(whole, cell=round(whole.cell, 1))  # as the code says it
    plan = replace(whole, sheet="", number=1, count=1, pupil="")
    sheet = f"{zlib.crc32(repr(plan).encode()):08x}"
    return tuple(
        replace(whole, text=text, sheet=sheet, number=k, count=len(parts))
        for k, text in enumerate(parts, start=1)
    )
