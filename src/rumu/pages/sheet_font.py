"""A font of the characters that a PDF shows, made of the copybooks' strokes, and embedded in it.

So sheets and reports need no font of the machine, print the same everywhere, and their text can be searched
and copied.
"""

from __future__ import annotations

import io
import itertools
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from rumu.characters.stroke_data import CanonicalStroke, find_character
from rumu.pages.punctuation import PUNCTUATION
from rumu.pdf_text import draw_text, text_width

_EM = 1000  # units of the font
_DESCENT = 120  # units that the square of a character of the stroke data reaches below the line


class SheetFont:
    """Some characters as an embedded font; Latin is set in Helvetica, what is unknown as `pdf_text` does.

    letters: all that will be set.
    """

    def __init__(self, letters: str) -> None:
        written = {letter: found for letter in sorted(set(letters)) if (found := find_character(letter))}
        marks = sorted(set(letters) & set(PUNCTUATION))
        known = [*written, *marks]
        self._known = frozenset(known)
        # reportlab takes fonts of one name for one font
        self._name = f"rumu-{zlib.crc32(''.join(known).encode()):08x}"
        if known:
            from reportlab.pdfbase.pdfmetrics import registerFont
            from reportlab.pdfbase.ttfonts import TTFont

            strokes = {letter: found.strokes for letter, found in written.items()}
            registerFont(TTFont(self._name, io.BytesIO(_font_file(strokes, marks, name=self._name))))

    def width(self, text: str, size: float) -> float:
        """Width of a line of text in points."""
        return sum(len(run) * size if known else text_width(run, size) for known, run in self._runs(text))

    def draw(self, canvas: Any, x: float, y: float, text: str, size: float) -> float:
        """Draw one line from (x, y) on its baseline in the fill colour; the x of its end, in points."""
        for known, run in self._runs(text):
            if known:
                canvas.setFont(self._name, size)
                canvas.drawString(x, y, run)
                x += len(run) * size
            else:
                x = draw_text(canvas, x, y, run, size)
        return x

    def _runs(self, text: str) -> list[tuple[bool, str]]:
        return [
            (known, "".join(run)) for known, run in itertools.groupby(text, key=lambda c: c in self._known)
        ]


def _font_file(
    characters: dict[str, tuple[CanonicalStroke, ...]], marks: Sequence[str], *, name: str
) -> bytes:
    """A TrueType font with these characters and marks of punctuation."""
    from fontTools.fontBuilder import FontBuilder  # type: ignore[import-untyped]
    from fontTools.pens.ttGlyphPen import TTGlyphPen  # type: ignore[import-untyped]

    glyphs = {".notdef": TTGlyphPen(None).glyph()}
    names = {ord(letter): f"u{ord(letter):05x}" for letter in (*characters, *marks)}
    for letter, strokes in characters.items():
        pen = TTGlyphPen(None)
        for stroke in strokes:
            _draw_stroke(pen, stroke)
        glyphs[names[ord(letter)]] = pen.glyph()
    for letter in marks:
        pen = TTGlyphPen(None)
        for outline in PUNCTUATION[letter]:
            first, *others = (_on_em(point) for point in outline)
            pen.moveTo(first)
            for point in others:
                pen.lineTo(point)
            pen.closePath()
        glyphs[names[ord(letter)]] = pen.glyph()
    builder = FontBuilder(_EM, isTTF=True)
    builder.setupGlyphOrder(list(glyphs))
    builder.setupCharacterMap(names)
    builder.setupGlyf(glyphs)
    table = builder.font["glyf"]
    builder.setupHorizontalMetrics({glyph: (_EM, getattr(table[glyph], "xMin", 0)) for glyph in glyphs})
    builder.setupHorizontalHeader(ascent=_EM - _DESCENT, descent=-_DESCENT)
    builder.setupNameTable({"familyName": name, "styleName": "Regular", "psName": name})
    builder.setupOS2(sTypoAscender=_EM - _DESCENT, sTypoDescender=-_DESCENT)
    builder.setupPost()
    stream = io.BytesIO()
    builder.save(stream)
    return stream.getvalue()


def _draw_stroke(pen: Any, stroke: CanonicalStroke) -> None:
    """Add the outline of a stroke, all of them in one direction: where two cross, ink stays ink."""
    from fontTools.pens.cu2quPen import Cu2QuPen  # type: ignore[import-untyped]
    from fontTools.pens.reverseContourPen import ReverseContourPen  # type: ignore[import-untyped]

    x, y = stroke.polygon().T
    clockwise = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) > 0  # as y grows downward
    target = Cu2QuPen(pen if clockwise else ReverseContourPen(pen), max_err=1.0)
    draw = {"M": target.moveTo, "L": target.lineTo, "Q": target.qCurveTo, "C": target.curveTo}
    for command, points in stroke.outline:
        if command == "Z":
            target.closePath()
        else:
            draw[command](*map(_on_em, points))


def _on_em(point: Any) -> tuple[int, int]:
    """A point of the character's square, its shares from the upper left, in units of the font."""
    return round(_EM * float(point[0])), round(_EM * (1 - float(point[1]))) - _DESCENT
