"""Widths and lines of text on a PDF page, and what the font of the copybooks' strokes lacks.

Latin is set in Helvetica, which every PDF reader has. Chinese characters and punctuation come from
`pages/sheet_font.py`; what it lacks, rare characters, is drawn as outlines of a font of this machine, so that
the page prints anywhere, and without one set in MSung-Light, which readers bring themselves.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

_CHINESE_FONTS = (
    *(
        "NotoSansCJK-Regular.ttc",
        "NotoSansTC-Regular.otf",
        "NotoSansTC-Regular.ttf",
        "NotoSerifCJK-Regular.ttc",
    ),
    *(
        "SourceHanSansTC-Regular.otf",
        "NotoSansCJKtc-Regular.otf",
        "PingFang.ttc",
        "Songti.ttc",
        "STHeiti Light.ttc",
    ),
    *("msjh.ttc", "mingliu.ttc", "wqy-zenhei.ttc", "wqy-microhei.ttc", "uming.ttc", "ukai.ttc"),
    *("DroidSansFallbackFull.ttf", "NotoSerifCJK-Bold.ttc", "NotoSansCJK-Bold.ttc"),
)
_FONT_FOLDERS = (
    *("/usr/share/fonts", "/usr/local/share/fonts", "~/.fonts", "~/.local/share/fonts"),
    *("/System/Library/Fonts", "/Library/Fonts", "~/Library/Fonts", "C:/Windows/Fonts"),
)
_LATIN, _READER_FONT = "Helvetica", "MSung-Light"
_EM = 1000.0


def text_width(text: str, size: float) -> float:
    """Return the width of a line of text in points."""
    return sum(_advance(run, size, chinese=chinese) for chinese, run in split_runs(text))


def draw_text(canvas: Canvas, x: float, y: float, text: str, size: float) -> float:
    """Draw one line from (x, y) on its baseline in the fill colour; return the x of its end, in points."""
    for chinese, run in split_runs(text):
        if not chinese:
            canvas.setFont(_LATIN, size)
            canvas.drawString(x, y, run)
        elif find_chinese_font() is not None:
            _draw_outlines(canvas, x, y, run, size)
        else:
            canvas.setFont(_register_reader_font(), size)
            canvas.drawString(x, y, run)
        x += _advance(run, size, chinese=chinese)
    return x


def wrap_text(text: str, size: float, *, width: float) -> list[str]:
    """Break text to `width` points, between words or Chinese characters, but not before a stop."""
    done, line = [], ""
    for piece in _words(text):
        if (
            line
            and text_width(line + piece.rstrip(), size) > width
            and piece[0] not in "，。、；：！？）」』%"
        ):
            done.append(line.rstrip())
            line = ""
        line += piece if line or not piece.isspace() else ""
    return [*done, line.rstrip()] if line.strip() else done


def split_runs(text: str) -> Iterator[tuple[bool, str]]:
    """Yield (whether it is beyond Latin, the part of the text), in order."""
    start = 0
    for at in range(1, len(text) + 1):
        if at == len(text) or _is_beyond_latin(text[at]) != _is_beyond_latin(text[start]):
            yield _is_beyond_latin(text[start]), text[start:at]
            start = at


@functools.cache
def find_chinese_font() -> Path | None:
    """Return a Chinese font of this machine: RUMU_FONT or a common one; None when there is none."""
    chosen = os.environ.get("RUMU_FONT")
    if chosen and Path(chosen).is_file():
        return Path(chosen)
    folders = [Path(folder).expanduser() for folder in _FONT_FOLDERS]
    installed = {
        path.name: path for folder in folders if folder.is_dir() for path in folder.rglob("*.[to]t[fc]")
    }
    return next((installed[name] for name in _CHINESE_FONTS if name in installed), None)


def _words(text: str) -> Iterator[str]:
    word = ""
    for letter in text:
        if _is_beyond_latin(letter) or letter.isspace():
            if word:
                yield word
            word = ""
            yield letter
        else:
            word += letter
    if word:
        yield word


def _is_beyond_latin(letter: str) -> bool:
    try:
        letter.encode("cp1252")
    except UnicodeEncodeError:
        return True
    return False


def _advance(run: str, size: float, *, chinese: bool) -> float:
    from reportlab.pdfbase.pdfmetrics import stringWidth

    if not chinese:
        return float(stringWidth(run, _LATIN, size))
    if find_chinese_font() is None:
        return len(run) * size
    return sum(_glyph(letter)[2] for letter in run) * size / _EM


def _draw_outlines(canvas: Canvas, x: float, y: float, run: str, size: float) -> None:
    scale = size / _EM
    path = canvas.beginPath()
    for letter in run:
        points, codes, advance = _glyph(letter)
        _trace(path, np.asarray(points) * scale + (x, y), codes)
        x += advance * scale
    canvas.drawPath(path, stroke=0, fill=1)


def _trace(path: Any, points: Any, codes: Any) -> None:
    """Add FreeType's outline codes to a path: move, line, quadratic and cubic curves, close."""
    at, k = (0.0, 0.0), 0
    while k < len(codes):
        code = codes[k]
        if code == 1:
            path.moveTo(*points[k])
        elif code == 2:
            path.lineTo(*points[k])
        elif code == 3:  # a quadratic curve as a cubic
            control, end = points[k], points[k + 1]
            path.curveTo(*(at + 2 / 3 * (control - at)), *(end + 2 / 3 * (control - end)), *end)
            k += 1
        elif code == 4:
            path.curveTo(*points[k], *points[k + 1], *points[k + 2])
            k += 2
        else:
            path.close()
        at = points[k]
        k += 1


@functools.lru_cache(maxsize=4000)
def _glyph(letter: str) -> tuple[Any, Any, float]:
    """Return a glyph's outline in thousandths of an em, its codes and its advance."""
    face, unhinted = _face()
    glyph = face.load_char(ord(letter), flags=unhinted)
    points, codes = face.get_path()
    return np.asarray(points, dtype=float), np.asarray(codes), glyph.linearHoriAdvance / 65536


@functools.cache
def _face() -> tuple[Any, Any]:
    from matplotlib import ft2font

    face = ft2font.FT2Font(str(find_chinese_font()))
    face.set_size(_EM, 72)  # pixels to the em
    flags: Any = getattr(ft2font, "LoadFlags", None)
    return face, flags.NO_HINTING if flags else vars(ft2font)["LOAD_NO_HINTING"]  # before matplotlib 3.10


@functools.cache
def _register_reader_font() -> str:
    from reportlab.pdfbase.cidfonts import UnicodeCIDFont
    from reportlab.pdfbase.pdfmetrics import registerFont

    registerFont(UnicodeCIDFont(_READER_FONT))
    return _READER_FONT
