"""A practice sheet as a PDF: markers and code, the grids with their models, the order of strokes, a name."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter, find_character
from rumu.errors import RumuError
from rumu.pages.paper_canvas import GREY, INK, MM, PaperCanvas, new_canvas, within
from rumu.pages.sheet_code import code_modules
from rumu.pages.sheet_font import SheetFont
from rumu.pages.sheet_layout import (
    CLEAR,
    FRAME_WIDTH,
    HEAD,
    LINE_WIDTH,
    MARGIN,
    MARKER,
    OUTLINE_WIDTH,
    TICK,
    Box,
    SheetCell,
    SheetPage,
    inner_lines,
    marker_boxes,
)
from rumu.pages.sheet_markers import marker_modules
from rumu.pages.sheet_models import DOT_RADIUS, MasterShape
from rumu.pages.sheet_print import DOT, FAINT, FRAME, LINE, OUTLINE

_STROKE = (0.84, 0.16, 0.12)
TITLE = 14  # characters of the text that stand at the top
_WORDS = {
    "name": ("姓名", "Name"),
    "class": ("班級", "Class"),
    "date": ("日期", "Date"),
    "write": ("用深色墨寫", "dark ink"),
    "photograph": ("四角全部照到", "all corners in the picture"),
}


def sheet_pdf(pages: Sequence[SheetPage], masters: Mapping[str, MasterShape]) -> bytes:
    """Return the pages as a PDF.

    masters: by character; every character of the pages must be there, else RumuError.
    """
    missing = "".join(dict.fromkeys(c for page in pages for c in page.text if c not in masters))
    if missing or not pages:
        raise RumuError(
            f"expected a master of every character of the sheet, found none of {missing or 'any'}"
        )
    words = "".join(zh for zh, _ in _WORDS.values())
    font = SheetFont(words + "".join(page.text + page.pupil for page in pages))
    stream = io.BytesIO()
    canvas = new_canvas(stream, pages[0].size, title=f"rumu: {pages[0].text}")
    for page in pages:
        _SheetDrawing(canvas, page, font, masters).draw()
        canvas.showPage()
    canvas.save()
    return stream.getvalue()


class _SheetDrawing:
    """One page on a canvas, in millimetres from the paper's upper left corner."""

    def __init__(
        self, canvas: Any, page: SheetPage, font: SheetFont, masters: Mapping[str, MasterShape]
    ) -> None:
        self._canvas, self._page, self._font, self._masters = canvas, page, font, masters
        self._paper = PaperCanvas(canvas, page.size, font)

    def draw(self) -> None:
        page = self._page
        self._canvas.setPageSize(tuple(side * MM for side in page.size))
        self._draw_markers()
        self._draw_head()
        for character, strip in page.labels:
            self._draw_label(character, strip)
        for cell in page.cells:
            if cell.is_for_writing:
                self._draw_model(cell)
        for cell in page.cells:
            self._draw_grid(cell)
        for cell in page.cells:
            if not cell.is_for_writing:
                self._draw_model(cell)
        self._draw_foot()

    def _draw_markers(self) -> None:
        for number, box in marker_boxes(self._page.paper).items():
            self._paper.draw_modules(marker_modules(number), box)
        self._paper.draw_modules(code_modules(self._page), self._page.code_box)

    # --- words --------------------------------------------------------------------------------------

    def _draw_head(self) -> None:
        page, left = self._page, MARGIN + MARKER + CLEAR
        title = "".join(dict.fromkeys(page.text))
        title = title if len(title) <= TITLE else title[: TITLE - 1] + "…"
        self._paper.write(left, MARGIN + 5.2, title, 15, INK)
        for name, x, width in (("name", left, 62.0), ("class", left + 65, 32.0), ("date", left + 100, 34.0)):
            end = self._paper.write(x, MARGIN + HEAD - 3, _WORDS[name][0], 10.5, INK)
            end = self._paper.write(end + 1, MARGIN + HEAD - 3, _WORDS[name][1], 6.5, GREY)
            self._paper.line((end + 1.2, MARGIN + HEAD - 1.8), (x + width, MARGIN + HEAD - 1.8), GREY, 0.15)
            if name == "name" and page.pupil:
                self._paper.write(end + 3, MARGIN + HEAD - 3.2, page.pupil, 12, INK)

    def _draw_foot(self) -> None:
        page = self._page
        y = page.size[1] - MARGIN - 1.2
        x = MARGIN + MARKER + CLEAR
        for name in ("write", "photograph"):
            x = self._paper.write(x, y, _WORDS[name][0], 7.5, GREY) + 1
            x = self._paper.write(x, y, _WORDS[name][1], 6, GREY) + 4
        text = f"rumu {page.identity}   {page.number} / {page.count}"
        right = page.size[0] - MARGIN - MARKER - CLEAR
        self._paper.write(right - self._font.width(text, 7) / MM, y, text, 7, GREY)

    # --- above the cells ----------------------------------------------------------------------------

    def _draw_label(self, character: str, strip: Box) -> None:
        """The order of the strokes, a picture for each; the character alone where it has none."""
        ordered = self._page.strokes and self._masters[character].in_strokes
        known = _canonical(character) if ordered else None
        side = 0.0 if known is None else min(strip.height - 1.0, (strip.width - 1.5) / len(known.strokes))
        if known is None or side < 3.0:
            self._paper.write(strip.left + 0.6, strip.top + strip.height - 1.3, character, 9, INK)
            return
        for step in range(len(known.strokes)):
            box = Box(strip.left + step * side, strip.top + strip.height - side - 0.6, side, side)
            for number, stroke in enumerate(known.strokes[: step + 1]):
                path = self._canvas.beginPath()
                self._paper.add_polygon(path, stroke.polygon(), box)
                self._canvas.setFillColorRGB(*(_STROKE if number == step else GREY))
                self._canvas.drawPath(path, stroke=0, fill=1)

    # --- cells --------------------------------------------------------------------------------------

    def _draw_model(self, cell: SheetCell) -> None:
        if cell.model == "none":
            return
        canvas, shape = self._canvas, self._masters[cell.character]
        path = canvas.beginPath()
        if cell.model == "dots":
            radius = DOT_RADIUS * cell.box.width
            for x, y in shape.dots:
                at = cell.box.left + x * cell.box.width, cell.box.top + y * cell.box.height
                path.circle(at[0] * MM, self._paper.up(at[1]), radius * MM)
            canvas.setFillColorRGB(*DOT)
            canvas.drawPath(path, stroke=0, fill=1)
            return
        for outline in shape.outlines:
            self._paper.add_polygon(path, outline, cell.box)
        hollow = cell.model == "outlined"
        canvas.setFillColorRGB(*(INK if cell.model == "full" else FAINT))
        canvas.setStrokeColorRGB(*OUTLINE)
        canvas.setLineWidth(OUTLINE_WIDTH * MM)
        canvas.setLineJoin(1)
        canvas.drawPath(path, stroke=int(hollow), fill=int(not hollow), fillMode=0)

    def _draw_grid(self, cell: SheetCell) -> None:
        box, grid = cell.box, self._page.grid
        if grid == "none":
            for x, right in ((box.left, TICK), (box.left + box.width, -TICK)):
                for y, down in ((box.top, TICK), (box.top + box.height, -TICK)):
                    self._paper.line((x, y), (x + right, y), FRAME, FRAME_WIDTH)
                    self._paper.line((x, y), (x, y + down), FRAME, FRAME_WIDTH)
            return
        for start, end in inner_lines(grid):
            self._paper.line(within(box, start), within(box, end), LINE, LINE_WIDTH, dashed=grid != "hui")
        corners = box.corners
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            self._paper.line(start, end, FRAME, FRAME_WIDTH)


@cache
def _canonical(character: str) -> CanonicalCharacter | None:
    return find_character(character)
