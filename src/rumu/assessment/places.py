"""Words and boxes for places on the copy's picture."""

from __future__ import annotations

import numpy as np

from rumu.assessment.stroke_names import Name
from rumu.values import FloatArray

Box = tuple[float, float, float, float]
Lines = tuple[tuple[tuple[float, float], ...], ...]

_COMPASS = (
    Name("右", "right"), Name("右下", "lower right"), Name("下", "bottom"), Name("左下", "lower left"),
    Name("左", "left"), Name("左上", "upper left"), Name("上", "top"), Name("右上", "upper right"),
)  # fmt: skip


def towards(way: FloatArray) -> Name:
    """The nearest of eight directions; way: (x right, y DOWN)."""
    return _COMPASS[round(float(np.arctan2(way[1], way[0])) / (np.pi / 4)) % 8]


def box(points: FloatArray, *, margin: float = 0.0) -> Box:
    """The box of (n, 2) points in fractions of a picture, widened by `margin`, cut at its edges."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    (x0, y0), (x1, y1) = np.clip(low, 0.0, 0.998), np.clip(high, 0.002, 1.0)
    return float(x0), float(y0), float(max(x1, x0 + 0.002)), float(max(y1, y0 + 0.002))


def as_lines(*lines: FloatArray) -> Lines:
    """Lines of (n, 2) points as plain numbers, a thousandth of the picture fine."""
    return tuple(tuple((round(float(x), 4), round(float(y), 4)) for x, y in line) for line in lines)
