"""New light on a known surface: any lamp on normals and albedo, or a mixture of three photographs."""

from __future__ import annotations

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import FloatArray, Surface


def relight(surface: Surface, *, tilt: float, slant: float) -> FloatArray:
    """Light a surface by one distant lamp.

    Parameters
    ----------
    surface : Surface
        Its normals and albedo are used.
    tilt : float
        Degrees, counter-clockwise from +x: 0 right, 90 top.
    slant : float
        Degrees from +z, in [0, 90].

    Returns
    -------
    (H, W) or (H, W, 3) float32 ndarray
        Brightness in [0, 1], linear; of the shape of the albedo.

    Raises
    ------
    SurfaceError
        When an angle is not finite or the slant lies outside its range.

    Notes
    -----
    Lambert's law, 0 where the surface turns away from the lamp; no cast shadows.
    """
    t, s = _check_angles(tilt, slant)
    lamp = np.array([np.cos(t) * np.sin(s), np.sin(t) * np.sin(s), np.cos(s)], dtype=np.float32)
    shading = np.maximum(surface.normals @ lamp, 0.0)
    if surface.albedo.ndim == 3:
        shading = shading[..., None]
    return np.asarray(np.clip(surface.albedo * shading, 0.0, 1.0)).astype(np.float32)


def relight_three(
    a: FloatArray, b: FloatArray, c: FloatArray, *, slant: float, tilt: float, new_slant: float | None = None
) -> FloatArray:
    """A photograph at any tilt mixed from the paper's three, Eq. (8): no normals are needed. (H, W) float32.

    a, b, c: (H, W) linear brightness at tilt 0, 90, 180 degrees and one slant, strictly between 0 and 90.
    At the same slant the three coefficients sum to 1; tilt 270 is a + c - b. `new_slant` is our extension to
    another slant: sines and cosines of the lamp scale by their ratios to the old ones.
    Exact where all three photographs and the result are lit; clamped at 0, the attached shadow.
    Raises SurfaceError when shapes differ or an angle lies outside its range.
    """
    if not (a.ndim == 2 and a.shape == b.shape == c.shape):
        raise SurfaceError(f"expected three images of one shape (H, W), got {a.shape}, {b.shape}, {c.shape}")
    if not 0.0 < slant < 90.0:
        raise SurfaceError(f"expected a slant strictly between 0 and 90 degrees, got {slant}")
    t, old = _check_angles(tilt, slant)
    _, new = _check_angles(tilt, slant if new_slant is None else new_slant)
    sideways, facing = np.sin(new) / np.sin(old), np.cos(new) / np.cos(old)
    of_a = (sideways * (np.cos(t) - np.sin(t)) + facing) / 2.0
    of_b = sideways * np.sin(t)
    of_c = (facing - sideways * (np.cos(t) + np.sin(t))) / 2.0
    return np.asarray(np.maximum(of_a * a + of_b * b + of_c * c, 0.0)).astype(np.float32)


def _check_angles(tilt: float, slant: float) -> tuple[float, float]:
    """Both in radians. Raises SurfaceError."""
    if not np.isfinite(tilt):
        raise SurfaceError(f"expected a finite tilt in degrees, got {tilt}")
    if not 0.0 <= slant <= 90.0:
        raise SurfaceError(f"expected a slant between 0 and 90 degrees, got {slant}")
    return float(np.radians(tilt)), float(np.radians(slant))
