"""A page of a PDF in millimetres from the paper's upper left corner, x right, y down, as in layouts."""

from __future__ import annotations

from typing import Any, BinaryIO

import numpy as np

from rumu.pages.sheet_font import SheetFont
from rumu.pages.sheet_layout import Box

MM = 72 / 25.4
"""Points of a millimetre."""
INK, GREY, SEAL = (0.13, 0.12, 0.11), (0.46, 0.44, 0.42), (0.69, 0.13, 0.10)
"""Colours of words and lines; the last is the red of seals, for what counts."""


def new_canvas(stream: BinaryIO, size: tuple[float, float], *, title: str) -> Any:
    """A canvas of reportlab for a PDF. size: width and height of its pages, in millimetres."""
    from reportlab.pdfgen.canvas import Canvas

    canvas = Canvas(stream, pagesize=tuple(side * MM for side in size), pageCompression=1)
    canvas.setTitle(title)
    canvas.setAuthor("rumu")
    return canvas


class PaperCanvas:
    """A canvas of reportlab for one page. size: width and height of the paper. font: of its words."""

    def __init__(self, canvas: Any, size: tuple[float, float], font: SheetFont) -> None:
        self.canvas, self._height, self._font = canvas, size[1], font

    def up(self, y: float) -> float:
        """The points from the paper's lower side of a place so far from its upper side."""
        return float((self._height - y) * MM)

    def draw_modules(self, modules: Any, box: Box) -> None:
        """Fill the dark modules, those beside each other in a row as one, so that no seam shows."""
        self.canvas.setFillColorRGB(0, 0, 0)
        path, side = self.canvas.beginPath(), box.width / len(modules)
        for row, dark in enumerate(modules):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], dark.astype(int), [0]])))
            for start, stop in edges.reshape(-1, 2).tolist():
                self.add_rectangle(
                    path, Box(box.left + start * side, box.top + row * side, (stop - start) * side, side)
                )
        self.canvas.drawPath(path, stroke=0, fill=1)

    def write(self, x: float, y: float, text: str, size: float, colour: Any) -> float:
        """Write one line from (x, y) on its baseline, `size` in points; the x of its end."""
        self.canvas.setFillColorRGB(*colour)
        return self._font.draw(self.canvas, x * MM, self.up(y), text, size) / MM

    def line(self, start: Any, end: Any, colour: Any, width: float, *, dashed: bool = False) -> None:
        """Draw a line from (x, y) to (x, y)."""
        canvas = self.canvas
        canvas.setStrokeColorRGB(*colour)
        canvas.setLineWidth(width * MM)
        canvas.setLineCap(2 if not dashed else 0)
        canvas.setDash([1.1 * MM, 0.9 * MM] if dashed else [])
        canvas.line(start[0] * MM, self.up(start[1]), end[0] * MM, self.up(end[1]))
        canvas.setDash([])

    def add_rectangle(self, path: Any, box: Box) -> None:
        """Add a box to a path of the canvas."""
        path.rect(box.left * MM, self.up(box.top + box.height), box.width * MM, box.height * MM)

    def add_polygon(self, path: Any, shares: Any, box: Box) -> None:
        """Add a closed outline, whose points are shares of a box."""
        points = [within(box, point) for point in shares]
        path.moveTo(points[0][0] * MM, self.up(points[0][1]))
        for x, y in points[1:]:
            path.lineTo(x * MM, self.up(y))
        path.close()


def within(box: Box, share: Any) -> tuple[float, float]:
    """The place on the paper of a point that is told as shares of a box."""
    return box.left + float(share[0]) * box.width, box.top + float(share[1]) * box.height
