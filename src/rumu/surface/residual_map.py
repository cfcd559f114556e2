"""Where the photographs of a capture contradict the surface that was made of them, as a map."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rumu.image_stack import SATURATION
from rumu.surface.near_lamps import shading
from rumu.surface.stereo import SHADOW_FLOOR
from rumu.values import BoolArray, Capture, FloatArray, Surface

_LIT = 0.05  # of the brightest that the law makes, below which a lamp counts as grazing


def residual_map(capture: Capture, surface: Surface, *, side: int = 480) -> FloatArray:
    """The share of the brightness that contradicts Lambert's law, the median over lamps that light a place.

    side: most places along the longer side, of which every so many pixels one is looked at. Returns (h, w)
    float32, 0 or more; NaN where nothing was measured or fewer than two lamps light it.
    """
    height, width = surface.height.shape
    step = max(1, -(-max(height, width) // side))
    rows, columns = np.arange(step // 2, height, step), np.arange(step // 2, width, step)
    pixels = (rows[:, None] * width + columns).reshape(-1)
    values, law = seen_and_law(capture, surface, pixels)
    measured = surface.mask.reshape(-1)[pixels]
    off = np.full(law.shape, np.nan)
    for one, seen, shown in zip(off, values, law, strict=True):
        lit = measured & is_lit(seen, shown)
        if lit.any():
            _, one[lit] = lamp_and_residuals(seen[lit], shown[lit])
    enough = np.isfinite(off).sum(axis=0) >= 2
    found = np.full(len(pixels), np.nan, np.float32)
    found[enough] = np.nanmedian(off[:, enough], axis=0)
    return found.reshape(len(rows), len(columns))


def seen_and_law(
    capture: Capture, surface: Surface, pixels: npt.NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """What photographs show at some pixels, and what Lambert's law makes of the surface: (N, P) each."""
    values = capture.photographs.at(pixels)
    values = values if values.ndim == 2 else values.mean(axis=2)
    albedo = surface.albedo.reshape(surface.height.size, -1)[pixels].mean(axis=1)
    law = shading(capture, surface.normals.reshape(-1, 3)[pixels], pixels)
    return values, np.maximum(law, 0) * albedo


def is_lit(values: FloatArray, law: FloatArray) -> BoolArray:
    """(P,): where a lamp lights pixels well, and the photograph is neither dark nor overexposed."""
    well = law > _LIT * max(float(law.max()), 1e-9)
    return np.asarray(well & (values > SHADOW_FLOOR) & (values < SATURATION))


def lamp_and_residuals(values: FloatArray, law: FloatArray) -> tuple[float, FloatArray]:
    """The strength of a lamp, by pixels that it lights, and the shares (P,) by which they contradict it."""
    strength = float(np.median(values / law))
    return strength, np.abs(values / (strength * law) - 1)
