"""Surfaces whose height and normals are known in closed form, for the lamps to shine on.

Frame as in `rumu_lab.simulation.lamps`: x right, y up, origin at the centre of the sheet; all lengths in
the unit of `spacing`, the length of one pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import FloatArray
from rumu_lab.simulation.lamps import from_slopes, grid

_STEEPEST = 0.999  # share of a radius; at the rim of a ball the slope is infinite and no pixel can hold it


class KnownSurface(NamedTuple):
    """A known surface.

    height: (H, W) float64. normals: (H, W, 3) float64, unit length, exact, not from differences.
    """

    height: FloatArray
    normals: FloatArray


def sphere(size: tuple[int, int], *, radius: float, spacing: float = 1.0) -> KnownSurface:
    """The upper half of a ball of `radius` on a flat sheet of (H, W) pixels; flat outside the ball."""
    x, y = grid(size, spacing=spacing)
    inside = x**2 + y**2 < (_STEEPEST * radius) ** 2
    z = np.sqrt(np.where(inside, radius**2 - x**2 - y**2, 1.0))
    slopes = (np.where(inside, -x / z, 0.0), np.where(inside, -y / z, 0.0))
    return KnownSurface(np.where(inside, z, 0.0), from_slopes(*slopes))


def bump(size: tuple[int, int], *, peak: float, sigma: float, spacing: float = 1.0) -> KnownSurface:
    """A Gaussian hill, peak * exp(-(x^2 + y^2) / (2 sigma^2)), on a sheet of (H, W) pixels."""
    x, y = grid(size, spacing=spacing)
    z = peak * np.exp(-(x**2 + y**2) / (2.0 * sigma**2))
    return KnownSurface(z, from_slopes(-x * z / sigma**2, -y * z / sigma**2))


def plane(size: tuple[int, int], *, p: float, q: float, spacing: float = 1.0) -> KnownSurface:
    """An inclined plane z = p x + q y on a sheet of (H, W) pixels."""
    x, y = grid(size, spacing=spacing)
    return KnownSurface(p * x + q * y, from_slopes(np.full(size, float(p)), np.full(size, float(q))))


def ridges(
    size: tuple[int, int], *, width: float, pitch: float, angle: float = 0.0, spacing: float = 1.0
) -> KnownSurface:
    """Parallel half cylinders on a flat sheet, like brush strokes in relief.

    width: of one ridge (its height is width / 2); pitch: from one crest to the next, at least `width`;
    angle: of the crests in degrees, counter-clockwise from +x. One crest runs through the centre.
    """
    if not 0 < width <= pitch:
        raise SurfaceError(f"expected 0 < width <= pitch, got width {width:g}, pitch {pitch:g}")
    x, y = grid(size, spacing=spacing)
    turn = np.radians(angle)
    across = -x * np.sin(turn) + y * np.cos(turn)
    u = (across + pitch / 2) % pitch - pitch / 2
    inside = np.abs(u) < _STEEPEST * width / 2
    z = np.sqrt(np.where(inside, (width / 2) ** 2 - u**2, 1.0))
    slope = np.where(inside, -u / z, 0.0)
    return KnownSurface(np.where(inside, z, 0.0), from_slopes(-np.sin(turn) * slope, np.cos(turn) * slope))
