"""A small page drawn from the starter works: six characters in columns, and its text."""

from __future__ import annotations

import io
from itertools import cycle, islice

import numpy as np
from PIL import Image

from rumu.gallery.starter import starter_works

CHARACTERS = "天人水書日月"
COLUMNS, ROWS, CELL = 5, 7, 88


def page_text() -> str:
    """A line for each column, from right to left."""
    written = "".join(islice(cycle(CHARACTERS), COLUMNS * ROWS))
    return "\n".join(written[at : at + ROWS] for at in range(0, len(written), ROWS))


def draw_page(*, paper: tuple[int, int, int] = (236, 226, 203)) -> Image.Image:
    """The page: regular script in ink on toned paper with a margin."""
    glyphs = {work.character: Image.open(work.path).convert("L") for work in starter_works(script="regular")}
    page = np.full((ROWS * CELL + 120, COLUMNS * (CELL + 14) + 120), 255, np.uint8)
    for column, line in enumerate(page_text().splitlines()):
        left = page.shape[1] - 60 - (column + 1) * (CELL + 14)
        for row, character in enumerate(line):
            glyph = np.asarray(glyphs[character].resize((CELL - 8, CELL - 8)))
            top = 60 + row * CELL
            page[top : top + glyph.shape[0], left : left + glyph.shape[1]] = glyph
    rng = np.random.default_rng(3)
    toned = page[..., None] / 255 * np.array(paper) + rng.normal(0, 1.5, page.shape)[..., None]
    return Image.fromarray(np.clip(toned, 0, 255).astype(np.uint8))


def packed(picture: Image.Image) -> bytes:
    """The picture as a PNG."""
    png = io.BytesIO()
    picture.save(png, "PNG")
    return png.getvalue()
