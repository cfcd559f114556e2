"""A practice sheet as a PDF: markers and code, the grids with their models, the order of strokes, a name."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter, find_character
from rumu.errors import RumuError
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

_MM = 72 / 25.4  # points
_INK, _GREY, _PALE = (0.13, 0.12, 0.11), (0.46, 0.44, 0.42), (0.80, 0.78, 0.76)
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
    from reportlab.pdfgen.canvas import Canvas

    missing = "".join(dict.fromkeys(c for page in pages for c in page.text if c not in masters))
    if missing or not pages:
        raise RumuError(
            f"expected a master of every character of the sheet, found none of {missing or 'any'}"
        )
    words = "".join(zh for zh, _ in _WORDS.values())
    font = SheetFont(words + "".join(page.text + page.pupil for page in pages))
    stream = io.BytesIO()
    canvas = Canvas(stream, pagesize=tuple(side * _MM for side in pages[0].size), pageCompression=1)
    canvas.setTitle(f"rumu: {pages[0].text}")
    canvas.setAuthor("rumu")
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

    def draw(self) -> None:
        page = self._page
        self._canvas.setPageSize(tuple(side * _MM for side in page.size))
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

    # --- markers and code ---------------------------------------------------------------------------

    def _draw_markers(self) -> None:
        for number, box in marker_boxes(self._page.paper).items():
            self._draw_modules(marker_modules(number), box)
        self._draw_modules(code_modules(self._page), self._page.code_box)

    def _draw_modules(self, modules: Any, box: Box) -> None:
        """Fill the dark modules, those beside each other in a row as one, so that no seam shows."""
        self._canvas.setFillColorRGB(0, 0, 0)
        path, side = self._canvas.beginPath(), box.width / len(modules)
        for row, dark in enumerate(modules):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], dark.astype(int), [0]])))
            for start, stop in edges.reshape(-1, 2).tolist():
                self._add_rectangle(
                    path, Box(box.left + start * side, box.top + row * side, (stop - start) * side, side)
                )
        self._canvas.drawPath(path, stroke=0, fill=1)

    # --- words --------------------------------------------------------------------------------------

    def _draw_head(self) -> None:
        page, left = self._page, MARGIN + MARKER + CLEAR
        title = "".join(dict.fromkeys(page.text))
        title = title if len(title) <= TITLE else title[: TITLE - 1] + "…"
        self._write(left, MARGIN + 5.2, title, 15, _INK)
        for name, x, width in (("name", left, 62.0), ("class", left + 65, 32.0), ("date", left + 100, 34.0)):
            end = self._write(x, MARGIN + HEAD - 3, _WORDS[name][0], 10.5, _INK)
            end = self._write(end + 1, MARGIN + HEAD - 3, _WORDS[name][1], 6.5, _GREY)
            self._line((end + 1.2, MARGIN + HEAD - 1.8), (x + width, MARGIN + HEAD - 1.8), _GREY, 0.15)
            if name == "name" and page.pupil:
                self._write(end + 3, MARGIN + HEAD - 3.2, page.pupil, 12, _INK)

    def _draw_foot(self) -> None:
        page = self._page
        y = page.size[1] - MARGIN - 1.2
        x = MARGIN + MARKER + CLEAR
        for name in ("write", "photograph"):
            x = self._write(x, y, _WORDS[name][0], 7.5, _GREY) + 1
            x = self._write(x, y, _WORDS[name][1], 6, _GREY) + 4
        text = f"rumu {page.identity}   {page.number} / {page.count}"
        right = page.size[0] - MARGIN - MARKER - CLEAR
        self._write(right - self._font.width(text, 7) / _MM, y, text, 7, _GREY)

    def _write(self, x: float, y: float, text: str, size: float, colour: Any) -> float:
        """Write one line from (x, y) on its baseline, `size` in points; the x of its end."""
        self._canvas.setFillColorRGB(*colour)
        return self._font.draw(self._canvas, x * _MM, self._up(y), text, size) / _MM

    # --- above the cells ----------------------------------------------------------------------------

    def _draw_label(self, character: str, strip: Box) -> None:
        """The order of the strokes, a picture for each; the character alone where it is not known."""
        known = _canonical(character) if self._page.strokes else None
        side = 0.0 if known is None else min(strip.height - 1.0, (strip.width - 1.5) / len(known.strokes))
        if known is None or side < 3.0:
            self._write(strip.left + 0.6, strip.top + strip.height - 1.3, character, 9, _INK)
            return
        for step in range(len(known.strokes)):
            box = Box(strip.left + step * side, strip.top + strip.height - side - 0.6, side, side)
            for number, stroke in enumerate(known.strokes[: step + 1]):
                path = self._canvas.beginPath()
                self._add_polygon(path, stroke.polygon(), box)
                self._canvas.setFillColorRGB(*(_STROKE if number == step else _GREY))
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
                path.circle(at[0] * _MM, self._up(at[1]), radius * _MM)
            canvas.setFillColorRGB(*DOT)
            canvas.drawPath(path, stroke=0, fill=1)
            return
        for outline in shape.outlines:
            self._add_polygon(path, outline, cell.box)
        hollow = cell.model == "outlined"
        canvas.setFillColorRGB(*(_INK if cell.model == "full" else FAINT))
        canvas.setStrokeColorRGB(*OUTLINE)
        canvas.setLineWidth(OUTLINE_WIDTH * _MM)
        canvas.setLineJoin(1)
        canvas.drawPath(path, stroke=int(hollow), fill=int(not hollow), fillMode=0)

    def _draw_grid(self, cell: SheetCell) -> None:
        box, grid = cell.box, self._page.grid
        if grid == "none":
            for x, right in ((box.left, TICK), (box.left + box.width, -TICK)):
                for y, down in ((box.top, TICK), (box.top + box.height, -TICK)):
                    self._line((x, y), (x + right, y), FRAME, FRAME_WIDTH)
                    self._line((x, y), (x, y + down), FRAME, FRAME_WIDTH)
            return
        for start, end in inner_lines(grid):
            self._line(_within(box, start), _within(box, end), LINE, LINE_WIDTH, dashed=grid != "hui")
        corners = box.corners
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            self._line(start, end, FRAME, FRAME_WIDTH)

    # --- the paper's coordinates ---------------------------------------------------------------------

    def _up(self, y: float) -> float:
        return float((self._page.size[1] - y) * _MM)

    def _line(self, start: Any, end: Any, colour: Any, width: float, *, dashed: bool = False) -> None:
        canvas = self._canvas
        canvas.setStrokeColorRGB(*colour)
        canvas.setLineWidth(width * _MM)
        canvas.setLineCap(2 if not dashed else 0)
        canvas.setDash([1.1 * _MM, 0.9 * _MM] if dashed else [])
        canvas.line(start[0] * _MM, self._up(start[1]), end[0] * _MM, self._up(end[1]))
        canvas.setDash([])

    def _add_rectangle(self, path: Any, box: Box) -> None:
        path.rect(box.left * _MM, self._up(box.top + box.height), box.width * _MM, box.height * _MM)

    def _add_polygon(self, path: Any, shares: Any, box: Box) -> None:
        """Add a closed outline, whose points are shares of a box."""
        points = [_within(box, point) for point in shares]
        path.moveTo(points[0][0] * _MM, self._up(points[0][1]))
        for x, y in points[1:]:
            path.lineTo(x * _MM, self._up(y))
        path.close()


def _within(box: Box, share: Any) -> tuple[float, float]:
    return box.left + float(share[0]) * box.width, box.top + float(share[1]) * box.height


@cache
def _canonical(character: str) -> CanonicalCharacter | None:
    return find_character(character)
