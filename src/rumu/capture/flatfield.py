"""The light on a flat sheet, fitted to blank paper and not to ink: the recommended rectification.

Our own method. Two laws are fitted to the paper of the sheet, and the one that fits it better is used:

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

_BLACK = 1e-5  # below one step of 16 bits; keeps the logarithm finite


@dataclass(frozen=True, slots=True)
class FlatfieldSettings:
    """How blank paper is found and the light fitted to it.

    side: pixels of the longer side that are enough to fit six numbers. block: side, in pixels, of a block of
        the reduced picture, whose upper quartile is paper unless it is all ink.
    faintest_paper: share of the first guess of the light; ink is darker, washes and stains too.
    ink_edge: pixels around ink that blur has darkened. least_noise: relative; rounding to 8 bits alone is of
        this order. rounds: of finding paper and fitting. fewest: pixels of paper that a fit needs.
    """

    side: int = 256
    block: int = 8
    faintest_paper: float = 0.75
    ink_edge: int = 2
    least_noise: float = 0.003
    rounds: int = 4
    fewest: int = 60


@dataclass(frozen=True, slots=True, eq=False)
class Flatfield:
    """Light on a sheet.

    level: (H, W) float32, above 0: what blank paper shows there. paper: (H, W) bool, blank paper.
    law: which law fits better. residual: relative rms difference of the paper from the level.
    """

    level: FloatArray
    paper: BoolArray
    law: Law
    residual: float


def fit_flatfield(
    image: FloatArray, *, mask: BoolArray | None = None, settings: FlatfieldSettings | None = None
) -> Flatfield:
    """Fit the light to the blank paper of a photograph.

    image: (H, W) float32, linear. mask: (H, W) bool, the sheet; all of the image when not given.
    Outside the paper the level is held between its extremes on paper, never extrapolated beyond.
    Raises CaptureError when no blank paper is found.
    """
    settings = settings or FlatfieldSettings()
    step = -(-max(image.shape) // settings.side)
    log_image = np.log(np.maximum(image[::step, ::step], _BLACK)).astype(np.float64)
    inside = np.ones(log_image.shape, bool) if mask is None else mask[::step, ::step]
    x, y = _coordinates(image.shape)
    near_x, near_y = x[::step].astype(np.float64), y[::step].astype(np.float64)
    fit, paper = _fit_around_ink(log_image, inside, near_x, near_y, settings)
    level = np.exp(fit.log_level(x, y))
    on_paper = np.exp(fit.log_level(near_x, near_y)[paper])
    level = np.clip(level, float(on_paper.min()), float(on_paper.max())).astype(np.float32, copy=False)
    ratio = np.log(np.maximum(image, np.float32(_BLACK)) / level)
    faintest = np.log(settings.faintest_paper)
    full = _find_blank(ratio, tolerance=fit.tolerance, faintest=faintest, edge=settings.ink_edge * step)
    if mask is not None:
        full &= mask
    return Flatfield(level, full if full.any() else ratio > faintest, fit.law, fit.residual)


@dataclass(frozen=True, slots=True, eq=False)
class _LightFit:
    """A law with its six coefficients; residual: rms, tolerance: of blank paper, both in the logarithm."""

    law: Law
    coefficients: FloatArray
    residual: float
    tolerance: float

    def log_level(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """(len(y), len(x)) from coordinates along the two sides."""
        c = self.coefficients.tolist()  # plain numbers keep the precision, and the memory, of x and y
        x, y = x[None, :], y[:, None]
        quadratic = np.asarray((c[0] + c[1] * x + c[3] * x * x) + (c[2] * y + c[5] * y * y) + c[4] * x * y)
        if self.law == "smooth":
            return quadratic
        return np.asarray(-1.5 * np.log(np.maximum(quadratic, 1e-12)))


def _coordinates(shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return x of each column and y of each row, in units of half the longer side, 0 at the centre, y up."""
    half = max(shape) / 2
    height, width = shape
    columns, rows = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)
    return (columns - (width - 1) / 2) / half, ((height - 1) / 2 - rows) / half


def quadratic_terms(x: FloatArray, y: FloatArray) -> FloatArray:
    """(..., 6): what the six coefficients of a quadratic are multiplied by; x and y are of one shape."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def _fit_around_ink(
    log_image: FloatArray, inside: BoolArray, x: FloatArray, y: FloatArray, settings: FlatfieldSettings
) -> tuple[_LightFit, BoolArray]:
    """Fit the light, find the paper that agrees with it, and so on; the fit and the paper, (h, w)."""
    fit = _first_guess(log_image, inside, x, y, settings)
    faintest = np.log(settings.faintest_paper)
    grid_x, grid_y = np.broadcast_arrays(x[None, :], y[:, None])
    paper = inside
    for _ in range(settings.rounds):
        ratio = log_image - fit.log_level(x, y)
        blank = _find_blank(ratio, tolerance=fit.tolerance, faintest=faintest, edge=settings.ink_edge)
        paper = blank & inside
        if np.count_nonzero(paper) < settings.fewest:
            raise CaptureError("expected blank paper to fit the light to, found none: is it a light sheet?")
        fits = _fit_laws(log_image[paper], grid_x[paper], grid_y[paper], settings)
        fit = min(fits, key=lambda one: one.residual)
    return fit, paper


def _first_guess(
    log_image: FloatArray, inside: BoolArray, x: FloatArray, y: FloatArray, settings: FlatfieldSettings
) -> _LightFit:
    """Least absolute deviations of the upper quartile of blocks: blocks of nothing but ink are outvoted."""
    block = settings.block
    rows, columns = (n // block for n in log_image.shape)
    if min(rows, columns) < 3:
        blocks, bx, by = log_image[inside], *(g[inside] for g in np.broadcast_arrays(x[None, :], y[:, None]))
    else:
        visible = np.where(inside, log_image, -np.inf)[: rows * block, : columns * block]
        tiles = visible.reshape(rows, block, columns, block).swapaxes(1, 2).reshape(rows, columns, -1)
        rank = (3 * block * block) // 4
        quartile = np.partition(tiles, rank, axis=2)[:, :, rank]
        seen = np.isfinite(quartile)
        centres = [c[: n * block].reshape(n, block).mean(axis=1) for c, n in ((x, columns), (y, rows))]
        grids = np.broadcast_arrays(centres[0][None, :], centres[1][:, None])
        blocks, bx, by = quartile[seen], grids[0][seen], grids[1][seen]
    if blocks.size < 6:
        raise CaptureError(f"expected a sheet of at least 6 blocks of paper, found {blocks.size}")
    terms = quadratic_terms(bx, by)
    weight: FloatArray = np.ones(blocks.size)
    coefficients: FloatArray = np.zeros(6)
    for _ in range(30):
        coefficients = _least_squares(terms, blocks, weight)
        weight = 1 / np.maximum(np.abs(blocks - terms @ coefficients), settings.least_noise)
    return _LightFit("smooth", coefficients, np.inf, -float(np.log(settings.faintest_paper)))


def _fit_laws(
    values: FloatArray, x: FloatArray, y: FloatArray, settings: FlatfieldSettings
) -> list[_LightFit]:
    """Both laws fitted to the logarithms of paper, (n,); the point lamp only where it is possible."""
    terms = quadratic_terms(x, y)
    smooth = _least_squares(terms, values, np.ones_like(values))
    solutions: list[tuple[Law, FloatArray, FloatArray]] = [("smooth", smooth, values - terms @ smooth)]
    target = np.exp(values * (-2 / 3))
    # weights so that relative errors count, as they do in the logarithm
    point = _least_squares(terms, target, target**-2)
    modelled = terms @ point
    if (modelled > 0.1 * target).all():
        solutions.append(("point lamp", point, values + 1.5 * np.log(modelled)))
    fits = []
    for law, coefficients, residuals in solutions:
        spread = max(1.4826 * float(np.median(np.abs(residuals))), settings.least_noise)
        fits.append(_LightFit(law, coefficients, float(np.sqrt(np.mean(residuals**2))), 3 * spread))
    return fits


def _least_squares(terms: FloatArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weighted least squares by the normal equations: six well-scaled terms, up to 65 000 rows."""
    weighted = terms * weight[:, None]
    return np.linalg.lstsq(terms.T @ weighted, weighted.T @ values, rcond=None)[0]


def _find_blank(ratio: FloatArray, *, tolerance: float, faintest: float, edge: int) -> BoolArray:
    """Pixels within `tolerance` of the level in the logarithm, and not beside ink."""
    from scipy import ndimage

    ink = ratio < min(faintest, -tolerance)
    near_ink = ndimage.maximum_filter(ink, size=2 * edge + 1)
    return np.asarray((np.abs(ratio) <= tolerance) & ~near_ink)
