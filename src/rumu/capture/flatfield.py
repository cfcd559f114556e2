"""The light on a flat sheet, fitted to its paper while its ink is left out: the recommended rectification.

Ours, not the paper's. Two laws are fitted and the one that the paper of the sheet agrees with is kept:

    point lamp   I^(-2/3) is a quadratic in x and y. This is exact for a small lamp near a plane, where
                 I = h / (rho^2 + h^2)^(3/2): the distance and the angle of incidence together.
    smooth       log I is a quadratic in x and y: broad lamps, lens vignetting, both at once.

The ground must be lighter than the ink. A slow bend of the whole sheet is shading too, and counts as light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.errors import CaptureError
from rumu.values import BoolArray, FloatArray

Law = Literal["point lamp", "smooth"]

_SIDE = 256  # pixels of the longer side that are enough to fit six numbers
_BLOCK = 8  # pixels of a block of the reduced picture, whose upper quartile is paper unless it is all ink
_BLACK = 1e-5  # below one step of 16 bits; keeps the logarithm finite
_FAINTEST_PAPER = 0.75  # of the first guess of the light; ink is darker, washes and stains too
_INK_EDGE = 2  # pixels around ink that blur has darkened
_LEAST_NOISE = 0.003  # relative; rounding to 8 bits alone is of this order
_ROUNDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Flatfield:
    """Light on a sheet.

    level: (H, W) float32, above 0: what blank paper shows there. paper: (H, W) bool, blank paper.
    law: the law that was kept. residual: relative rms difference of the paper from the level.
    """

    level: FloatArray
    paper: BoolArray
    law: Law
    residual: float


def fit_flatfield(image: FloatArray, *, mask: BoolArray | None = None) -> Flatfield:
    """Fit the light to the blank paper of a photograph.

    image: (H, W) float32, linear. mask: (H, W) bool, the sheet; all of the image when not given.
    Outside the paper the level is held between its extremes on paper, never extrapolated beyond.
    Raises CaptureError when no blank paper is found.
    """
    step = -(-max(image.shape) // _SIDE)
    log_image = np.log(np.maximum(image[::step, ::step], _BLACK)).astype(np.float64)
    inside = np.ones(log_image.shape, bool) if mask is None else mask[::step, ::step]
    x, y = _coordinates(image.shape)
    near_x, near_y = x[::step].astype(np.float64), y[::step].astype(np.float64)
    fit, paper = _fit_around_ink(log_image, inside, near_x, near_y)
    level = np.exp(fit.log_level(x, y))
    on_paper = np.exp(fit.log_level(near_x, near_y)[paper])
    level = np.clip(level, float(on_paper.min()), float(on_paper.max())).astype(np.float32, copy=False)
    ratio = np.log(np.maximum(image, np.float32(_BLACK)) / level)
    full = _blank(ratio, tolerance=fit.tolerance, edge=_INK_EDGE * step)
    if mask is not None:
        full &= mask
    return Flatfield(level, full if full.any() else ratio > np.log(_FAINTEST_PAPER), fit.law, fit.residual)


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    law: Law
    coefficients: FloatArray
    residual: float
    tolerance: float

    def log_level(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """(len(y), len(x)) from coordinates along the two sides."""
        quadratic = _quadratic(x[None, :], y[:, None], self.coefficients)
        if self.law == "smooth":
            return quadratic
        return np.asarray(-1.5 * np.log(np.maximum(quadratic, 1e-12)))


def _coordinates(shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """x of each column and y of each row, in units of half the longer side, 0 at the centre, y up."""
    half = max(shape) / 2
    height, width = shape
    columns, rows = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)
    return (columns - (width - 1) / 2) / half, ((height - 1) / 2 - rows) / half


def _quadratic(x: FloatArray, y: FloatArray, coefficients: FloatArray) -> FloatArray:
    c = coefficients.tolist()  # plain numbers keep the precision, and the memory, of x and y
    return np.asarray((c[0] + c[1] * x + c[3] * x * x) + (c[2] * y + c[5] * y * y) + c[4] * x * y)


def _terms(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def _fit_around_ink(
    log_image: FloatArray, inside: BoolArray, x: FloatArray, y: FloatArray
) -> tuple[_Fit, BoolArray]:
    fit = _first_guess(log_image, inside, x, y)
    grid_x, grid_y = np.broadcast_arrays(x[None, :], y[:, None])
    paper = inside
    for _ in range(_ROUNDS):
        ratio = log_image - fit.log_level(x, y)
        paper = _blank(ratio, tolerance=fit.tolerance, edge=_INK_EDGE) & inside
        if np.count_nonzero(paper) < 60:
            raise CaptureError("expected blank paper to fit the light to, found none: is it a light sheet?")
        fits = _both_laws(log_image[paper], grid_x[paper], grid_y[paper])
        fit = min(fits, key=lambda one: one.residual)
    return fit, paper


def _first_guess(log_image: FloatArray, inside: BoolArray, x: FloatArray, y: FloatArray) -> _Fit:
    """Least absolute deviations of the upper quartile of blocks: blocks of nothing but ink are outvoted."""
    rows, columns = (n // _BLOCK for n in log_image.shape)
    if min(rows, columns) < 3:
        blocks, bx, by = log_image[inside], *(g[inside] for g in np.broadcast_arrays(x[None, :], y[:, None]))
    else:
        hidden = np.where(inside, log_image, -np.inf)[: rows * _BLOCK, : columns * _BLOCK]
        tiles = hidden.reshape(rows, _BLOCK, columns, _BLOCK).swapaxes(1, 2).reshape(rows, columns, -1)
        place = (3 * _BLOCK * _BLOCK) // 4
        quartile = np.partition(tiles, place, axis=2)[:, :, place]
        seen = np.isfinite(quartile)
        centres = [c[: n * _BLOCK].reshape(n, _BLOCK).mean(axis=1) for c, n in ((x, columns), (y, rows))]
        grids = np.broadcast_arrays(centres[0][None, :], centres[1][:, None])
        blocks, bx, by = quartile[seen], grids[0][seen], grids[1][seen]
    if blocks.size < 6:
        raise CaptureError(f"expected a sheet of at least 6 blocks of paper, found {blocks.size}")
    terms = _terms(bx, by)
    weight: FloatArray = np.ones(blocks.size)
    coefficients: FloatArray = np.zeros(6)
    for _ in range(30):
        coefficients = _solved(terms, blocks, weight)
        weight = 1 / np.maximum(np.abs(blocks - terms @ coefficients), _LEAST_NOISE)
    return _Fit("smooth", coefficients, np.inf, -float(np.log(_FAINTEST_PAPER)))


def _both_laws(values: FloatArray, x: FloatArray, y: FloatArray) -> list[_Fit]:
    terms = _terms(x, y)
    smooth = _solved(terms, values, np.ones_like(values))
    fits = [_judged("smooth", smooth, values - terms @ smooth)]
    target = np.exp(values * (-2 / 3))
    point = _solved(terms, target, target**-2)  # so that relative errors count, as they do in the logarithm
    modelled = terms @ point
    if (modelled > 0.1 * target).all():
        fits.append(_judged("point lamp", point, values + 1.5 * np.log(modelled)))
    return fits


def _solved(terms: FloatArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weighted least squares by the normal equations: six well-scaled terms, up to 65 000 rows."""
    weighted = terms * weight[:, None]
    return np.linalg.lstsq(terms.T @ weighted, weighted.T @ values, rcond=None)[0]


def _judged(law: Law, coefficients: FloatArray, residuals: FloatArray) -> _Fit:
    spread = 1.4826 * float(np.median(np.abs(residuals)))
    return _Fit(law, coefficients, float(np.sqrt(np.mean(residuals**2))), 3 * max(spread, _LEAST_NOISE))


def _blank(ratio: FloatArray, *, tolerance: float, edge: int) -> BoolArray:
    """Pixels within `tolerance` of the level in log, and not beside ink."""
    from scipy import ndimage

    ink = ratio < min(np.log(_FAINTEST_PAPER), -tolerance)
    near_ink = ndimage.maximum_filter(ink, size=2 * edge + 1)
    return np.asarray((np.abs(ratio) <= tolerance) & ~near_ink)
