"""The card as a PDF."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from rumu.capture.stored import to_srgb
from rumu.card.layout import GRAYS, CardLayout
from rumu.pages.paper_canvas import GREY, INK, MM, PaperCanvas, new_canvas
from rumu.pages.sheet_font import SheetFont
from rumu.pages.sheet_layout import Paper
from rumu.pages.sheet_markers import marker_modules

_TITLE = ("拍攝卡", "capture card")
_FIRST = ("原大列印，不縮放", "Print at 100%, no scaling.")
_STEPS = (
    ("貼平；字放在窗內，或剪下窗口放在字上", "Lay flat; writing in the window, or cut it out"),
    ("亮球放在圓圈裡（可不放）", "A shiny ball in the ring, if there is one"),
    ("室內關燈；相機不動，全卡入鏡", "Dark room; camera fixed, whole card in view"),
    ("小燈移三處以上，每處拍一張", "A small lamp in 3+ places, one shot each"),
)
_WINDOW = ("字放這裡", "the writing lies here")
_BALL = ("亮球", "shiny ball")
_RULER = ("用尺量，應是", "measure it:")
_THIN, _TICK = 0.15, 2.0  # width of lines, and length of the scale's longer ticks


def card_pdf(paper: Paper = "A4") -> bytes:
    """The card on one sheet of paper, to be printed without scaling."""
    layout = CardLayout(paper)
    texts = [*_TITLE, *_FIRST, *_WINDOW, *_BALL, *_RULER, *(word for step in _STEPS for word in step)]
    stream = io.BytesIO()
    canvas = new_canvas(stream, layout.size, title="rumu: capture card")
    page = PaperCanvas(canvas, layout.size, SheetFont("".join(texts)))
    for number, box in layout.markers.items():
        page.draw_modules(marker_modules(number), box)
    _draw_grays(page, layout)
    _draw_scale(page, layout)
    _draw_places(page, layout)
    _draw_words(page, layout)
    canvas.showPage()
    canvas.save()
    return stream.getvalue()


def _draw_grays(page: PaperCanvas, layout: CardLayout) -> None:
    levels = to_srgb(np.array(GRAYS))
    for patch in layout.patches:
        path = page.canvas.beginPath()
        page.add_rectangle(path, patch.box)
        page.canvas.setFillGray(float(levels[patch.level]))
        page.canvas.drawPath(path, stroke=0, fill=1)


def _draw_scale(page: PaperCanvas, layout: CardLayout) -> None:
    """A line of 100 mm with a tick at every fifth."""
    (x0, y), (x1, _) = layout.scale
    page.line((x0, y), (x1, y), INK, _THIN)
    for k in range(21):
        x = x0 + 5 * k
        page.line((x, y), (x, y + (_TICK if k % 2 == 0 else _TICK / 2)), INK, _THIN)
    end = page.write(x0, y + 5.2, _RULER[0], 6.5, GREY)
    page.write(end + 0.8, y + 5.2, f"100 mm  ({_RULER[1]} 100 mm)", 6, GREY)


def _draw_places(page: PaperCanvas, layout: CardLayout) -> None:
    """The window to be cut out, and the ring of the ball."""
    window, (x, y) = layout.window, layout.ball
    corners: Any = window.corners
    for k in range(4):
        page.line(corners[k], corners[(k + 1) % 4], GREY, _THIN, dashed=True)
    end = page.write(window.left + 3, window.top + 6, _WINDOW[0], 8, GREY)
    page.write(end + 1.5, window.top + 6, _WINDOW[1], 7, GREY)
    page.canvas.setStrokeColorRGB(*GREY)
    page.canvas.setLineWidth(_THIN * MM)
    page.canvas.circle(x * MM, page.up(y), layout.ring * MM, stroke=1, fill=0)
    page.line((x - 1.5, y), (x + 1.5, y), GREY, _THIN)
    page.line((x, y - 1.5), (x, y + 1.5), GREY, _THIN)
    end = page.write(x - 7, y + 6, _BALL[0], 6.5, GREY)
    page.write(end + 0.8, y + 6, _BALL[1], 5.5, GREY)


def _draw_words(page: PaperCanvas, layout: CardLayout) -> None:
    title, steps = layout.title, layout.steps
    end = page.write(title.left, title.top + 6, f"rumu {_TITLE[0]}", 15, INK)
    page.write(end + 1.5, title.top + 6, _TITLE[1], 9, GREY)
    end = page.write(title.left, title.top + 11.5, _FIRST[0], 7.5, INK)
    page.write(end + 1.5, title.top + 11.5, _FIRST[1], 6.5, GREY)
    for k, (zh, en) in enumerate(_STEPS):
        y = steps.top + 3.2 + 4.2 * k
        end = page.write(steps.left, y, f"{k + 1} {zh}", 6.2, INK)
        page.write(end + 1, y, en, 5.0, GREY)
