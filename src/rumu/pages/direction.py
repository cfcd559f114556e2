"""Whether a page is written in columns from the right or in rows from the left."""

from __future__ import annotations

import numpy as np

from rumu.pages.page import Direction
from rumu.values import BoolArray

_GRAIN = 8.0  # pixels that a character measures where directions are compared
_ALONG, _AROUND = 1.5, 1.0  # standard deviations of the blurs, in sizes of a character
_ROWS = 1.15  # how much more rows must stand out than columns: calligraphy is written in columns


def find_direction(ink: BoolArray, *, size: float) -> Direction:
    """The direction in which the gaps between lines of writing are emptier.

    ink: (H, W) bool, writing without ruled lines. size: about what a character measures, in pixels.
    """
    import cv2

    factor = min(1.0, _GRAIN / size)
    small = cv2.resize(ink.astype(np.float32), None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    columns, rows = (_contrast(small, size * factor, down) for down in (True, False))
    return "horizontal" if rows > _ROWS * columns else "vertical"


def _contrast(ink: np.ndarray, size: float, down: bool) -> float:
    """How much the ink, blurred along lines of writing, changes across them."""
    import cv2

    along, narrow, wide = _ALONG * size, 0.12 * size, _AROUND * size
    border = cv2.BORDER_CONSTANT
    sharp, broad = (
        cv2.GaussianBlur(ink, (0, 0), sigmaX=a, sigmaY=b, borderType=border)
        for a, b in (((narrow, along), (wide, along)) if down else ((along, narrow), (along, wide)))
    )
    return float(np.abs(sharp - broad).sum() / max(float(broad.sum()), 1e-9))
