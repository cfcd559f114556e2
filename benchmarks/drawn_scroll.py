"""A scroll as large as one likes, drawn in bands: characters of the starter works on silk."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class DrawnScroll:
    """How a scroll is drawn.

    width, height, cell: pixels. silk, ink: colours. grain: of the silk, in gray levels.
    """

    width: int = 16_000
    height: int = 7_500
    cell: int = 500
    silk: tuple[int, int, int] = (214, 198, 164)
    ink: tuple[int, int, int] = (38, 34, 32)
    grain: float = 5.0


def draw_scroll(path: Path, scroll: DrawnScroll) -> None:
    """Write a scroll as a compressed TIFF; only one row of characters is in memory at a time."""
    import tifffile

    tifffile.imwrite(
        path,
        _strips(scroll),
        shape=(scroll.height, scroll.width, 3),
        dtype=np.uint8,
        photometric="rgb",
        rowsperstrip=scroll.cell,
        compression="zlib",
    )


def _strips(scroll: DrawnScroll) -> Iterator[bytes]:
    for band in bands(scroll):
        yield zlib.compress(band.tobytes(), 1)


def bands(scroll: DrawnScroll) -> Iterator[Bytes]:
    """Rows of characters, (cell, width, 3) uint8 each; the last may have fewer rows."""
    glyphs = _glyphs(scroll.cell)
    random = np.random.default_rng(7)
    for row, top in enumerate(range(0, scroll.height, scroll.cell)):
        coverage = np.zeros((scroll.cell, scroll.width), np.float32)
        for column, left in enumerate(range(0, scroll.width - scroll.cell + 1, scroll.cell)):
            coverage[:, left : left + scroll.cell] = glyphs[(7 * row + 3 * column) % len(glyphs)]
        grain = random.normal(0, scroll.grain, coverage.shape).astype(np.float32)
        band = np.empty((*coverage.shape, 3), np.uint8)
        for channel in range(3):
            ground = np.float32(scroll.silk[channel]) + grain
            band[..., channel] = (ground + coverage * (scroll.ink[channel] - ground)).clip(0, 255)
        yield band[: scroll.height - top]


def _glyphs(side: int) -> list[npt.NDArray[np.float32]]:
    """How much of each pixel is ink, (side, side), of the starter works."""
    import cv2
    from PIL import Image

    from rumu.gallery.starter import starter_works

    glyphs = []
    for work in starter_works():
        with Image.open(work.path) as image:
            gray = np.asarray(image.convert("L"), dtype=np.float32)
        inner = cv2.resize(255 - gray, (side - side // 5,) * 2, interpolation=cv2.INTER_AREA) / 255
        glyphs.append(np.pad(inner, ((side // 10, side - side // 10 - len(inner)),) * 2))
    return glyphs
