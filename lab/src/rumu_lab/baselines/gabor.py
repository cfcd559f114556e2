"""Directional decomposition of writing by Gabor filters, and the thresholds that give its strokes back.

A bar as wide as a stroke is half a wave across it: the wave length is twice the stroke width. That Gabor
filters part the strokes by direction, and that thresholds are found step by step so that the
reconstruction error is least, is known from the abstract of Su and Wang 2003; the filters' constants and
the rest are our reconstruction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class GaborSettings:
    """directions: how many, from 0 degrees (along +x) counter-clockwise to below 180.

    across, along: standard deviations of the filter over its wave length, across and along the stroke.
    margin: how far beyond the ink, in stroke widths, a response may reach and be charged for.
    rival: share of the strongest response at a pixel that a direction needs to claim it.
    grid: levels a threshold may have. sweeps: most rounds over the directions; tolerance: least gain of one.
    """

    directions: int = 8
    across: float = 0.4
    along: float = 0.8
    margin: float = 0.5
    rival: float = 0.7
    grid: int = 32
    sweeps: int = 10
    tolerance: float = 1e-3


def responses(density: FloatArray, *, width: float, settings: GaborSettings) -> FloatArray:
    """(H, W) density -> (directions, H, W) float32 in [0, 1]: even, zero-mean responses, negative ones cut.

    All are divided by the greatest of all, not each by its own: a direction in which nothing was written
    would else be blown up. width: of the strokes, in pixels.
    """
    from scipy import fft

    side = max(density.shape)
    size = fft.next_fast_len(side + round(6.0 * settings.along * width), real=True)
    spectrum = fft.rfft2(density.astype(np.float32), s=(size, size))
    filters = _filters(size, round(width, 1), settings)
    found = fft.irfft2(spectrum * filters, s=(size, size))[:, : density.shape[0], : density.shape[1]]
    positive = np.maximum(found, 0.0, dtype=np.float32)
    return np.asarray(positive / max(float(positive.max()), 1e-9))


@lru_cache(maxsize=8)
def _filters(size: int, width: float, settings: GaborSettings) -> FloatArray:
    """(directions, size, size // 2 + 1) complex64: the filters' transforms, centred on pixel (0, 0)."""
    from scipy import fft

    wave = 2.0 * width
    place = fft.fftfreq(size, 1.0 / size)
    x, y = place[None, :], -place[:, None]
    angles = np.pi * np.arange(settings.directions)[:, None, None] / settings.directions
    along, across = x * np.cos(angles) + y * np.sin(angles), y * np.cos(angles) - x * np.sin(angles)
    shape = (across / (settings.across * wave)) ** 2 + (along / (settings.along * wave)) ** 2
    window = np.exp(-shape / 2.0)
    ripple = np.cos(2.0 * np.pi * across / wave)
    mean = (window * ripple).sum(axis=(1, 2), keepdims=True) / window.sum(axis=(1, 2), keepdims=True)
    filters = (window * (ripple - mean)).astype(np.float32)
    return np.asarray(fft.rfft2(filters / np.abs(filters).sum(axis=(1, 2), keepdims=True)))


def reconstruct(
    found: FloatArray, ink: BoolArray, *, width: float, settings: GaborSettings
) -> tuple[BoolArray, float]:
    """Pixels that each direction claims, (directions, H, W) bool, and the reconstruction error they leave.

    The error is the pixels in which the union of the claims differs from the ink, over the ink's. Thresholds
    go down it one direction at a time, each to its best on the grid given the others. By itself that is ill
    posed: one direction with a threshold of 0 would cover all ink. So a direction claims a pixel only where
    it answers nearly as strongly as any other does; two strokes that cross still both do.
    """
    near = _grow(ink, settings.margin * width)
    strength, inside = found[:, near], ink[near]
    rank = np.minimum((strength * settings.grid).astype(np.intp), settings.grid - 1)
    rank[strength < settings.rival * strength.max(axis=0)] = -1
    own = rank >= np.array([_isodata(f[inside], settings.grid) for f in strength])[:, None]
    count = own.sum(axis=0)
    error, share = np.inf, max(float(inside.mean()), 1e-9)
    for _ in range(settings.sweeps):
        for t in range(len(found)):
            count -= own[t]
            own[t] = rank[t] >= _best(rank[t], inside, count == 0, settings.grid)
            count += own[t]
        before, error = error, float(np.mean((count > 0) != inside)) / share
        if before - error < settings.tolerance:
            break
    claims = np.zeros(found.shape, bool)
    claims[:, near] = own
    return claims, error


def _best(rank: IntArray, inside: BoolArray, free: BoolArray, grid: int) -> int:
    """The threshold of one direction that leaves the least error where no other direction claims anything."""
    paper, covered = (
        np.bincount(rank[free & side] + 1, minlength=grid + 1)[1:] for side in (~inside, inside)
    )
    of_threshold = np.append(np.cumsum((paper - covered)[::-1])[::-1], 0)
    return int(np.argmin(of_threshold))


def _isodata(strength: FloatArray, grid: int) -> int:
    """Threshold half-way between the means of its two sides (Ridler and Calvard 1978), on the grid."""
    level = float(strength.mean())
    for _ in range(20):
        high = strength > level
        if not high.any() or high.all():
            break
        moved = float(strength[high].mean() + strength[~high].mean()) / 2.0
        if abs(moved - level) < 0.5 / grid:
            break
        level = moved
    return round(level * grid)


def _grow(ink: BoolArray, reach: float) -> BoolArray:
    import cv2

    k = max(1, round(reach))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * k + 1, 2 * k + 1))
    return np.asarray(cv2.dilate(ink.astype(np.uint8), disc) > 0)
