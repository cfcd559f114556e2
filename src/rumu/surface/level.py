"""Plane and bow of a sheet, taken off its height and its normals on request.

A sheet that did not lie square to the camera leans, and paper and panels are bowed; a slow error of the lamps
adds a bow of its own. A plane, or a polynomial of second degree, is fitted to what most of the sheet agrees
on, so that a relief on it does not draw it up, and is taken off.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray

Level = Literal["none", "plane", "bow"]

LEVELS: tuple[Level, ...] = get_args(Level)
_POWERS: dict[str, tuple[tuple[int, int], ...]] = {
    "plane": ((0, 0), (1, 0), (0, 1)),
    "bow": ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
}
"""Powers of x and y of each term."""
_LOOKED_AT = 200_000
"""Pixels that are fitted to."""
_ROUNDS = 20
_BAND = 1_000_000
"""Pixels worked on at a time."""


def check_level(level: str) -> None:
    """Raise SurfaceError for none of LEVELS."""
    if level not in LEVELS:
        raise SurfaceError(f"expected a level among {', '.join(LEVELS)}, got {level!r}")


def take_level(height: FloatArray, normals: FloatArray, measured: BoolArray, *, level: str) -> None:
    """Take the plane, or the plane and the bow, off a surface; both arrays change.

    height: (H, W) float32 in pixels. normals: (H, W, 3) float32, unit length, turned along. measured: (H, W),
    what the plane is fitted to. level: one of LEVELS; 'none' changes nothing.
    """
    check_level(level)
    if level == "none":
        return
    h, w = height.shape
    powers = _POWERS[level]
    terms = _fit(height, measured, powers)
    x = (np.arange(w, dtype=np.float64) - (w - 1) / 2) / max(h, w)
    step = max(1, _BAND // w)
    for top in range(0, h, step):
        rows = slice(top, min(top + step, h))
        y = ((h - 1) / 2 - np.arange(rows.start, rows.stop, dtype=np.float64))[:, None] / max(h, w)
        parts = [(t, i, j) for t, (i, j) in zip(terms, powers, strict=True)]
        height[rows] -= np.asarray(sum(t * x**i * y**j for t, i, j in parts), dtype=np.float32)
        along_x = sum(t * i * x ** max(i - 1, 0) * y**j for t, i, j in parts) / max(h, w)
        along_y = sum(t * j * x**i * y ** max(j - 1, 0) for t, i, j in parts) / max(h, w)
        band = normals[rows]
        band[..., 0] += np.asarray(band[..., 2] * along_x, np.float32)  # slopes are -n_x / n_z
        band[..., 1] += np.asarray(band[..., 2] * along_y, np.float32)
        normals[rows] = band / np.maximum(np.linalg.norm(band, axis=2, keepdims=True), 1e-12)


def _fit(height: FloatArray, measured: BoolArray, powers: tuple[tuple[int, int], ...]) -> FloatArray:
    """The polynomial's terms, by reweighted least squares that forget what lies off it (Geman-McClure)."""
    h, w = height.shape
    pixels = np.flatnonzero(measured)
    pixels = pixels[:: max(1, len(pixels) // _LOOKED_AT)]
    x = (pixels % w - (w - 1) / 2) / max(h, w)
    y = ((h - 1) / 2 - pixels // w) / max(h, w)
    A = np.stack([x**i * y**j for i, j in powers], axis=1)
    z = height.reshape(-1)[pixels].astype(np.float64)
    weights = np.ones(len(z))
    terms: FloatArray = np.zeros(len(powers))
    for _ in range(_ROUNDS):
        terms = np.linalg.lstsq(A * weights[:, None], z * weights, rcond=None)[0]
        off = np.abs(z - A @ terms)
        spread = max(2.0 * float(np.median(off)), 1e-6)
        weights = 1.0 / (1.0 + (off / spread) ** 2)
    return np.asarray(terms)
