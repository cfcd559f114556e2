"""Pages of a PDF that are filled from the top: lines, tables, pictures; a new page where one is full."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from rumu.pages.paper_canvas import GREY, INK, MM, PaperCanvas, new_canvas
from rumu.pages.sheet_font import SheetFont
from rumu.pdf_text import wrap_text
from rumu.report.pictures import Picture, png_bytes

_SIZE = (210.0, 297.0)  # A4
_MARGIN, _FOOT = 18.0, 14.0  # millimetres
_HEADING = 13.0  # millimetres
_COUNT = "pages"
"""The form that says how many pages there are."""
_DIGIT = 1.37  # millimetres of a digit of the page's number
_LINE = 0.48  # millimetres of a line's height for each point of its letters
_FOOT_SIZE = 6.5  # points of what every page says at its foot

WIDTH = _SIZE[0] - 2 * _MARGIN
"""Millimetres between the margins."""


class FilledPages:
    """A4 pages in millimetres.

    title: of the file, and at the foot of each page. letters: all that is set. foot: what every page
    says above that line.
    """

    def __init__(self, title: str, letters: str, *, foot: str = "") -> None:
        self._stream = io.BytesIO()
        self.canvas = new_canvas(self._stream, _SIZE, title=title)
        self.paper = PaperCanvas(self.canvas, _SIZE, SheetFont(letters + title + foot))
        self._title, self._page = title, 1
        self._foot = wrap_text(foot, _FOOT_SIZE, width=WIDTH * MM)
        self._bottom = _SIZE[1] - _MARGIN - _FOOT / 2 - _LINE * _FOOT_SIZE * len(self._foot)
        self.left, self.y = _MARGIN, _MARGIN

    def make_room(self, height: float) -> bool:
        """Begin a new page unless there are so many millimetres left on this one; whether one was begun."""
        if self.y + height <= self._bottom:
            return False
        self._end_page()
        self.y = _MARGIN
        return True

    def write(
        self,
        text: str,
        size: float,
        colour: Any = INK,
        *,
        left: float = 0.0,
        width: float = WIDTH,
        bullet: str = "",
    ) -> None:
        """Write text, wrapped to a width; it goes on below.

        bullet: stands at the margin before the first line.
        """
        for k, line in enumerate(wrap_text(text, size, width=width * MM)):
            self.make_room(_LINE * size)
            self.y += _LINE * size
            y = self.y - 0.12 * size
            if bullet and k == 0:
                self.paper.write(self.left, y, bullet, size, colour)
            self.paper.write(self.left + left, y, line, size, colour)

    def heading(self, text: str, *, below: float = 9.0) -> None:
        """A heading of a section, on one page with the millimetres below it that stand together."""
        self.make_room(_HEADING + below)
        self.y += 5.0
        self.write(text, 11.5)
        self.paper.line((self.left, self.y + 0.8), (self.left + WIDTH, self.y + 0.8), GREY, 0.15)
        self.y += 2.2

    def row(
        self,
        cells: Sequence[tuple[float, str]],
        size: float,
        colour: Any = INK,
        *,
        head: Sequence[tuple[float, str]] = (),
    ) -> None:
        """One line of a table. cells: millimetres from the left margin, and what stands there.

        head: of the table, set once more where the line begins a page.
        """
        if self.make_room(_LINE * size) and head:
            self.row(head, size, GREY)
        self.y += _LINE * size
        for left, text in cells:
            self.paper.write(self.left + left, self.y - 0.12 * size, text, size, colour)

    def picture(self, picture: Picture, *, left: float, top: float, width: float, height: float) -> None:
        """A picture in the middle of a box, as large as it fits, with a thin frame."""
        from reportlab.lib.utils import ImageReader

        rows, columns = picture.shape[:2]
        scale = min(width / columns, height / rows)
        w, h = columns * scale, rows * scale
        x, y = self.left + left + (width - w) / 2, top + (height - h) / 2
        reader = ImageReader(io.BytesIO(png_bytes(picture)))
        self.canvas.drawImage(reader, x * MM, self.paper.up(y + h), w * MM, h * MM)
        self.canvas.setStrokeColorRGB(*GREY)
        self.canvas.setLineWidth(0.1 * MM)
        self.canvas.rect(x * MM, self.paper.up(y + h), w * MM, h * MM, stroke=1, fill=0)

    def finish(self) -> bytes:
        """The file."""
        self._end_page()
        self.canvas.beginForm(_COUNT)  # known only now, and shown on every page
        place = _SIZE[0] - _MARGIN - 8, _SIZE[1] - _FOOT
        self.paper.write(*place, f" / {self._page - 1}", 7, GREY)
        self.canvas.endForm()
        self.canvas.save()
        return self._stream.getvalue()

    def _end_page(self) -> None:
        y = _SIZE[1] - _FOOT
        for k, line in enumerate(reversed(self._foot), start=1):
            self.paper.write(_MARGIN, y - 1.0 - _LINE * _FOOT_SIZE * k, line, _FOOT_SIZE, GREY)
        self.paper.write(_MARGIN, y, self._title, 7, GREY)
        number = str(self._page)
        self.paper.write(_SIZE[0] - _MARGIN - 8 - _DIGIT * len(number), y, number, 7, GREY)
        self.canvas.doForm(_COUNT)
        self.canvas.showPage()
        self._page += 1
