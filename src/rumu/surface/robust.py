"""Solvers for normals under N lamps that survive cast shadow and gloss, in NumPy.

Each works on rows of brightness, one row for a pixel and one column for a lamp. Lambert's law itself is in
`rumu.surface.stereo`. Whole photographs are solved in `rumu.surface.solve`, which takes the compiled form of
this module where there is one; this one says what it must find.

"least_squares" trusts every value; "trimmed" drops each pixel's darkest and brightest lamps; "l1" minimises
absolute residuals; "robust" goes on from there with a loss that forgets outliers, counts a lamp behind the
surface as agreeing when the pixel is dark, and stays with "l1" where the material is not Lambert's at all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from rumu.image_stack import SATURATION
from rumu.surface.stereo import (
    SHADOW_FLOOR,
    channel_albedo,
    enough_lit,
    scaled_normals,
    split,
)
from rumu.values import BoolArray, FloatArray

Solver = Literal["least_squares", "trimmed", "l1", "robust"]

SOLVERS: tuple[Solver, ...] = get_args(Solver)
TILE_RESIDUALS = 5_000
"""About how many residuals of a tile the median rests on, so that a large photograph needs little memory."""
_TINY = 1e-12


@dataclass(frozen=True, slots=True)
class RobustSettings:
    """How far a value may lie from Lambert's law before it is an outlier; shares are of a pixel's brightness.

    darkest, brightest: shares of the lamps that "trimmed" drops.
    dark: below it a value is in shadow. noise: smallest residual that matters; at 8 bits a step is 0.004.
    proportional: noise that grows with the brightness (lamps that are not quite even).
    width: the loss turns over at this multiple of the pixel's own spread.
    lambertian: up to the first spread the loss that forgets is used, beyond the second "l1" alone.
    settled: a pixel is done when its scaled normal moves by less. l1_iterations, iterations: most rounds of
        reweighting, for "l1" and for the loss that forgets.
    """

    darkest: float = 0.3
    brightest: float = 0.1
    dark: float = 0.05
    noise: float = 3e-3
    proportional: float = 0.02
    width: float = 2.0
    lambertian: tuple[float, float] = (0.02, 0.05)
    settled: float = 1e-4
    l1_iterations: int = 20
    iterations: int = 25


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """scaled: (P, 3) albedo times normal. weights: (P, N) in [0, 1], the trust in each value in the end."""

    scaled: FloatArray
    weights: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class TileSolution:
    """Some pixels, solved.

    normals: (P, 3) float32. albedo: (P,) or (P, 3) float32, >= 0. confidence: (P,) float32 in [0, 1].
    residuals: |brightness - law| of some lit values, in shares of the pixel's brightness. dark, lit: how many
    values are in shadow and how many are not.
    """

    normals: FloatArray
    albedo: FloatArray
    confidence: FloatArray
    residuals: FloatArray
    dark: int
    lit: int


def solve_tile(
    values: FloatArray, lights: FloatArray, *, solver: Solver, black_level: float, settings: RobustSettings
) -> TileSolution:
    """Normals and albedo of some pixels; what `rumu.surface.compiled` does, in NumPy.

    values: (N, P) or (N, P, 3), linear; lights: (N, 3), times strength.
    """
    rows = brightness_rows(values, black_level=black_level)
    fit = _SOLVERS[solver](rows, lights, settings)
    normals, albedo = split(fit.scaled)
    if values.ndim == 3:
        albedo = channel_albedo(values - black_level, normals, lights, weights=fit.weights)
    off, lit = relative_residuals(rows, lights, fit.scaled, dark=settings.dark)
    reached = enough_lit((values if values.ndim == 2 else values.mean(axis=2))[:, None])[0]
    confidence = np.where(reached, _confidence(off, lit, lights), 0.0).astype(np.float32)
    count = int(np.count_nonzero(lit))
    residuals = off[lit]
    residuals = residuals[:: max(1, count // TILE_RESIDUALS)]
    return TileSolution(normals, np.maximum(albedo, 0.0), confidence, residuals, lit.size - count, count)


def brightness_rows(values: FloatArray, *, black_level: float = 0.0) -> FloatArray:
    """(P, N) float64 gray brightness, less the black level, from values (N, P) or (N, P, 3)."""
    gray = values if values.ndim == 2 else values.mean(axis=2)
    rows = gray.T.astype(np.float64)
    return subtract_black(rows, black_level) if black_level else rows


def subtract_black(rows: FloatArray, black_level: float) -> FloatArray:
    """Brightness less the black level, which may be negative; what was cut to black stays black."""
    return np.where(rows > SHADOW_FLOOR, np.maximum(rows - black_level, 0.0), 0.0)


def pixel_scale(rows: FloatArray) -> FloatArray:
    """(P, 1): how bright each pixel gets, its nine-tenths quantile over the lamps. rows: (P, N)."""
    rank = int(np.ceil(0.9 * (rows.shape[1] - 1)))
    return np.partition(rows, rank, axis=1)[:, rank : rank + 1] + _TINY


def relative_residuals(
    rows: FloatArray, lights: FloatArray, scaled: FloatArray, *, dark: float
) -> tuple[FloatArray, BoolArray]:
    """|brightness - law| in shares of the pixel's brightness, and which values are lit; both (P, N)."""
    scale = pixel_scale(rows)
    off = np.abs(rows - np.maximum(law(scaled, lights), 0.0)) / scale
    return off, rows > np.maximum(dark * scale, SHADOW_FLOOR)


def _least_squares(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> Fit:
    return Fit(scaled_normals(rows, lights), np.ones_like(rows))


def _trimmed(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> Fit:
    n = rows.shape[1]
    low, high = int(settings.darkest * n), int(settings.brightest * n)
    rank = np.argsort(np.argsort(rows, axis=1, kind="stable"), axis=1, kind="stable")
    weights = ((rank >= low) & (rank < n - high)).astype(np.float64)
    return Fit(weighted(rows, lights, weights), weights)


def l1(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> Fit:
    """Least absolute residuals by reweighting. rows: (P, N); lights: (N, 3)."""
    scaled = scaled_normals(rows, lights)
    scale = pixel_scale(rows)
    weights = np.ones_like(rows)
    going = np.arange(len(rows))
    for _ in range(settings.l1_iterations):
        off = (rows[going] - law(scaled[going], lights)) / scale[going]
        weights[going] = 1.0 / np.sqrt(1.0 + (off / (settings.noise / 3)) ** 2)
        new = weighted(rows[going], lights, weights[going])
        moved = np.abs(new - scaled[going]).max(axis=1) / scale[going, 0]
        scaled[going] = new
        going = going[moved > settings.settled]
        if going.size == 0:
            break
    return Fit(scaled, weights)


def robust(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> Fit:
    """Least absolute residuals, then a loss that forgets outliers. rows: (P, N); lights: (N, 3)."""
    start = l1(rows, lights, settings)
    scale = pixel_scale(rows)
    scaled, weights = start.scaled.copy(), start.weights.copy()
    spread = np.zeros((len(rows), 1))
    going = np.arange(len(rows))
    for _ in range(settings.iterations):
        weights[going], spread[going] = _outlier_weights(
            rows[going], scaled[going], lights, scale[going], settings
        )
        new = weighted(rows[going], lights, weights[going])
        moved = np.abs(new - scaled[going]).max(axis=1) / scale[going, 0]
        scaled[going] = new
        going = going[moved > settings.settled]
        if going.size == 0:
            break
    low, high = settings.lambertian
    trust = np.clip((high - spread) / (high - low), 0.0, 1.0)
    blend = trust * weights + (1.0 - trust) * start.weights
    return Fit(trust * scaled + (1.0 - trust) * start.scaled, blend)


def _outlier_weights(
    rows: FloatArray, scaled: FloatArray, lights: FloatArray, scale: FloatArray, settings: RobustSettings
) -> tuple[FloatArray, FloatArray]:
    """Geman-McClure weights (P, N) and the spread (P, 1) of the residuals, in shares of the brightness."""
    raw = law(scaled, lights)
    lit = np.maximum(raw, 0.0)
    off = (rows - lit) / scale
    # A lamp behind the surface and a dark pixel agree with the law, but say nothing about the normal.
    informative = (raw > 0) | (rows > settings.dark * scale)
    spread = 1.4826 * _masked_median(np.abs(off), informative)
    width2 = (settings.width * spread) ** 2 + settings.noise**2 + (settings.proportional * lit / scale) ** 2
    weights = np.where(informative & (rows < SATURATION), 1.0 / (1.0 + off * off / width2) ** 2, 0.0)
    return weights, spread


def weighted(rows: FloatArray, lights: FloatArray, weights: FloatArray) -> FloatArray:
    """(P, 3) weighted least squares, one 3 x 3 system for each row, solved in closed form.

    rows, weights: (P, N), weights >= 0; lights: (N, 3). A trace of trust in every value keeps it solvable.
    """
    weights = weights + 1e-5
    x, y, z = lights.T
    products = np.stack([x * x, x * y, x * z, y * y, y * z, z * z], axis=1)
    xx, xy, xz, yy, yz, zz = _sum_over_lamps(weights, products)
    ridge = 1e-10 * (xx + yy + zz) + 1e-30
    xx, yy, zz = xx + ridge, yy + ridge, zz + ridge
    # The symmetric inverse by cofactors: a batched LAPACK call is ten times slower on 3 x 3.
    cxx, cxy, cxz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    cyy, cyz, czz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    det = xx * cxx + xy * cxy + xz * cxz
    u, v, w = _sum_over_lamps(weights * rows, lights)
    solution = [cxx * u + cxy * v + cxz * w, cxy * u + cyy * v + cyz * w, cxz * u + cyz * v + czz * w]
    return np.asarray(np.stack(solution, axis=1) / np.maximum(det, 1e-90)[:, None])


def law(scaled: FloatArray, lights: FloatArray) -> FloatArray:
    """(P, N) brightness by Lambert's law, negative where a lamp stands behind the surface."""
    # Not a matrix product: on matrices this thin starting the threads of BLAS costs more than the product.
    return np.asarray(np.einsum("pk,kn->pn", scaled, np.ascontiguousarray(lights.T)))


def _sum_over_lamps(weights: FloatArray, of_lamps: FloatArray) -> FloatArray:
    """(K, P): for each pixel, what belongs to the lamps, (N, K), summed by weight (P, N)."""
    return np.asarray(np.einsum("pn,kn->kp", weights, np.ascontiguousarray(of_lamps.T)))


def _masked_median(values: FloatArray, chosen: BoolArray) -> FloatArray:
    """(P, 1) lower median of the chosen values of each row; 0 when none is chosen."""
    ordered = np.sort(np.where(chosen, values, np.inf), axis=1)
    count = np.count_nonzero(chosen, axis=1)
    middle = np.take_along_axis(ordered, np.maximum((count - 1) // 2, 0)[:, None], axis=1)
    return np.where(count[:, None] > 0, middle, 0.0)


def _confidence(off: FloatArray, lit: BoolArray, lights: FloatArray) -> FloatArray:
    """(P,) in [0, 1]: agreement with the law times how well the lamps that agree span the directions."""
    agreement = 1.0 / (1.0 + (off / 0.05) ** 2)
    typical = 1.0 / (1.0 + (_masked_median(off, lit)[:, 0] / 0.05) ** 2)
    return typical * span_of_lamps(np.where(lit, agreement, 0.0), lights)


def span_of_lamps(weights: FloatArray, lights: FloatArray) -> FloatArray:
    """(P,) in [0, 1]: how well the lamps that each pixel trusts span the directions, beside all lamps.

    weights: (P, N) in [0, 1]; lights: (N, 3).
    """
    x, y, z = lights.T
    products = np.stack([x * x, x * y, x * z, y * y, y * z, z * z], axis=1)
    span = _determinant(_sum_over_lamps(weights, products))
    full = _determinant(products.sum(axis=0)[:, None])
    return np.asarray(np.cbrt(np.clip(span / full, 0.0, 1.0)))


def _determinant(symmetric: FloatArray) -> FloatArray:
    """Of (6, P): the upper triangle of symmetric 3 x 3 matrices, row by row."""
    xx, xy, xz, yy, yz, zz = symmetric
    return np.asarray(xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz))


_SOLVERS: dict[Solver, Callable[[FloatArray, FloatArray, RobustSettings], Fit]] = {
    "least_squares": _least_squares,
    "trimmed": _trimmed,
    "l1": l1,
    "robust": robust,
}
