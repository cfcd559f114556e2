"""The compiled solvers behind the interface of `rumu.surface.robust`, where numba can be had."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from rumu.image_stack import SATURATION
from rumu.surface import reflectance, robust
from rumu.surface.reflectance import Lamps, Material, MaterialFit, MaterialSettings, PixelValues
from rumu.surface.robust import TILE_RESIDUALS, RobustSettings, Solver, TileSolution
from rumu.surface.stereo import SHADOW_FLOOR, SHADOW_SHARE
from rumu.values import BoolArray, FloatArray

_FACTOR = "10 to 30"
"""Times that the solvers take in NumPy of what they take compiled, as benchmarks/museum.py prints it."""


class SlowSolverWarning(UserWarning):
    """The solvers run in NumPy, since numba is not there."""


@lru_cache(maxsize=1)
def has_numba() -> bool:
    """Whether the compiled solvers can be used; warns once, with the factor, when they cannot."""
    try:
        import numba  # noqa: F401
    except ImportError as error:
        message = f"numba is not there ({error}): surfaces take {_FACTOR} times as long; pip install numba"
        warnings.warn(SlowSolverWarning(message), stacklevel=2)
        return False
    return True


def tile_solver() -> Callable[..., TileSolution]:
    """What solves some pixels: the compiled kernels, or NumPy where there is no numba, after a warning."""
    return solve_tile if has_numba() else robust.solve_tile


def material_fitter() -> Callable[..., MaterialFit]:
    """What searches for normals under a material: the same."""
    return fit_material if has_numba() else reflectance.fit_material


def doubt_finder() -> Callable[..., tuple[FloatArray, BoolArray]]:
    """What tells where Lambert's law is in doubt: the same."""
    return doubt if has_numba() else reflectance.doubt


def l1_solver() -> Callable[[FloatArray, FloatArray, RobustSettings], FloatArray]:
    """What finds (P, 3) albedo times normal by least absolute residuals of rows (P, N): the same."""
    return l1 if has_numba() else _l1_in_numpy


def _l1_in_numpy(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> FloatArray:
    return robust.l1(rows, lights, settings).scaled


@lru_cache(maxsize=64)
def sorting_network(n: int) -> npt.NDArray[np.int64]:
    """(M, 2): pairs (low, high) whose exchange, in this order, sorts n values upward.

    Batcher's odd-even merge for the next power of two, without the pairs beyond n: what they would move is
    larger than all.
    """
    pairs, whole = [], 1 << max(n - 1, 1).bit_length()
    merged = 1
    while merged < whole:
        apart = merged
        while apart >= 1:
            for start in range(apart % merged, whole - apart, 2 * apart):
                for low in range(start, min(start + apart, whole - apart)):
                    same_run = low // (2 * merged) == (low + apart) // (2 * merged)
                    if same_run and low + apart < n:
                        pairs.append((low, low + apart))
            apart //= 2
        merged *= 2
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


@lru_cache(maxsize=64)
def selecting_network(n: int, rank: int) -> npt.NDArray[np.int64]:
    """(M, 2): pairs (low, high) whose exchange, in this order, brings the value of one rank to its place.

    What the sorting network does for that rank, or, where it is less, what carries the largest values up one
    after the other.
    """
    up = [(low, low + 1) for top in range(n - 1, max(rank, 1) - 1, -1) for low in range(top)]
    needed, pairs = {rank}, []
    for low, high in sorting_network(n)[::-1].tolist():
        if low in needed or high in needed:
            needed |= {low, high}
            pairs.append((low, high))
    return np.array(min(up, pairs[::-1], key=len), dtype=np.int64).reshape(-1, 2)


class _Tile:
    """Some pixels under their lamps, as the kernels want them."""

    def __init__(self, values: FloatArray, lights: FloatArray, black_level: float, settings: RobustSettings):
        from rumu.surface import kernels, linear_kernels

        self.values = np.ascontiguousarray(values, dtype=np.float32).reshape(*values.shape[:2], -1)
        self.lights = np.ascontiguousarray(lights, dtype=np.float32)
        self.inverse = np.ascontiguousarray(np.linalg.pinv(lights), dtype=np.float32)
        self.settings = settings
        n, pixels = self.values.shape[:2]
        self.pairs = sorting_network(n)
        self.rows = np.empty((n, pixels), np.float32) if self.values.shape[2] == 3 else self.values[..., 0]
        self.reached: BoolArray = np.empty(pixels, np.bool_)
        self.scale = np.empty(pixels, np.float32)
        self.black = np.float32(black_level)
        if black_level and self.values.shape[2] == 1:
            self.rows = self.rows.copy()  # it is taken from them, and the values may be another's
        floor, share, white = (np.float32(one) for one in (SHADOW_FLOOR, SHADOW_SHARE, SATURATION))
        linear_kernels.brightness(self.values, self.black, floor, share, white, self.rows, self.reached)
        rank = math.ceil(0.9 * (n - 1))
        kernels.scales(self.rows, rank, selecting_network(n, rank), self.scale)

    @property
    def limits(self) -> FloatArray:
        """What `kernels.reweighted` is told of the settings."""
        s = self.settings
        numbers = (s.dark, s.noise**2, s.proportional, s.width, SATURATION, 3.0 / s.noise)
        return np.array(numbers, dtype=np.float32)

    def least_squares(self) -> FloatArray:
        """(3, P) albedo times normal."""
        from rumu.surface import linear_kernels

        scaled = np.empty((3, self.rows.shape[1]), np.float32)
        linear_kernels.least_squares(self.rows, self.inverse, scaled)
        return scaled

    def trimmed(self, weights: FloatArray) -> FloatArray:
        """(3, P) albedo times normal; writes the weights (N, P)."""
        from rumu.surface import kernels

        n, pixels = self.rows.shape
        low, high = int(self.settings.darkest * n), n - int(self.settings.brightest * n)
        scaled = np.empty((3, pixels), np.float32)
        kernels.trimmed(self.rows, self.lights, low, high, self.pairs, weights, scaled)
        return scaled

    def reweighted(self, start: FloatArray, *, forgetting: bool) -> tuple[FloatArray, FloatArray]:
        """(3, P) albedo times normal, and (P,) the spread of the residuals, by a reweighting from `start`."""
        from rumu.surface import kernels

        scaled, spread = start.copy(), np.zeros(self.rows.shape[1], np.float32)
        rounds = self.settings.iterations if forgetting else self.settings.l1_iterations
        kernels.reweighted(
            self.rows, self.lights, self.scale, self.pairs, self.limits, forgetting, rounds,
            np.float32(self.settings.settled), scaled, spread,
        )  # fmt: skip
        return scaled, spread

    def agreement(self, scaled: FloatArray) -> tuple[FloatArray, FloatArray, int]:
        """(P,) confidence, some residuals of lit values, and how many values are lit."""
        from rumu.surface import kernels

        n, pixels = self.rows.shape
        stride = max(1, n * pixels // TILE_RESIDUALS)
        sampled = np.empty((n, -(-pixels // stride)), np.float32)
        confidence = np.empty(pixels, np.float32)
        full = float(np.linalg.det(self.lights.T.astype(np.float64) @ self.lights))
        dark, floor = np.float32(self.settings.dark), np.float32(SHADOW_FLOOR)
        lit = kernels.agreement(
            self.rows, self.lights, self.scale, scaled, dark, floor, self.pairs, full, stride, confidence,
            sampled,
        )  # fmt: skip
        confidence[~self.reached] = 0.0
        return confidence, sampled[sampled >= 0].astype(np.float64), int(lit)


def solve_tile(
    values: FloatArray, lights: FloatArray, *, solver: Solver, black_level: float, settings: RobustSettings
) -> TileSolution:
    """Normals and albedo of some pixels; see `rumu.surface.robust.solve_tile`."""
    from rumu.surface import linear_kernels

    tile = _Tile(values, lights, black_level, settings)
    n, pixels = tile.rows.shape
    is_colour = values.ndim == 3
    weights = np.ones((n, pixels) if is_colour or solver == "trimmed" else (n, 0), np.float32)
    scaled = tile.trimmed(weights) if solver == "trimmed" else tile.least_squares()
    if solver in ("l1", "robust"):
        start, spread = tile.reweighted(scaled, forgetting=False)
        scaled, trust = start, np.zeros(pixels, np.float32)
        if solver == "robust":
            found, spread = tile.reweighted(start, forgetting=True)
            low, high = settings.lambertian
            trust = np.clip((np.float32(high) - spread) / np.float32(high - low), 0, 1)
            scaled = trust * found + (1 - trust) * start
        if is_colour:
            from rumu.surface import colour_kernels

            ends = (start, found if solver == "robust" else start)
            colour_kernels.trust(
                tile.rows, tile.lights, tile.scale, tile.limits, *ends, spread, trust, weights
            )
    normals, albedo = np.empty((pixels, 3), np.float32), np.empty(pixels, np.float32)
    linear_kernels.split(scaled, normals, albedo)
    confidence, residuals, lit = tile.agreement(scaled)
    if is_colour:
        from rumu.surface import colour_kernels

        albedo = np.empty((pixels, 3), np.float32)
        colour_kernels.channels(tile.values, tile.black, tile.lights, normals, weights, albedo)
    return TileSolution(normals, albedo, confidence, residuals, n * pixels - lit, lit)


def l1(rows: FloatArray, lights: FloatArray, settings: RobustSettings) -> FloatArray:
    """(P, 3) albedo times normal by least absolute residuals; see `rumu.surface.robust.l1`. rows: (P, N)."""
    tile = _Tile(rows.T, lights, 0.0, settings)
    return tile.reweighted(tile.least_squares(), forgetting=False)[0].T.astype(np.float64)


def fit_material(
    seen: PixelValues,
    lamps: Lamps,
    material: Material,
    *,
    starts: FloatArray,
    settings: MaterialSettings,
) -> MaterialFit:
    """The normal of each pixel under a material; see `rumu.surface.reflectance.fit_material`."""
    from rumu.surface import reflectance_kernels as kernels

    kind = {"gloss": kernels.GLOSS, "metal": kernels.METAL, "rough": kernels.ROUGH}[material.kind]
    normals = np.empty((3, len(seen)), np.float32)
    brightness, contradicted = (np.empty(len(seen), np.float32) for _ in range(2))
    kernels.fit(
        *_material_inputs(seen, lamps), np.ascontiguousarray(starts.transpose(1, 2, 0), dtype=np.float32),
        kind, np.float32(material.roughness), np.float32(material.share), _material_limits(settings),
        settings.rounds, normals, brightness, contradicted,
    )  # fmt: skip
    return MaterialFit(*(one.astype(np.float64) for one in (normals.T, brightness, contradicted)))


def doubt(
    seen: PixelValues, lamps: Lamps, normals: FloatArray, settings: MaterialSettings
) -> tuple[FloatArray, BoolArray]:
    """Where Lambert's law is in doubt; see `rumu.surface.reflectance.doubt`."""
    from rumu.surface import reflectance_kernels as kernels

    contradicted, doubtful = np.empty(len(seen), np.float32), np.empty(len(seen), np.bool_)
    kernels.doubt(
        *_material_inputs(seen, lamps), np.ascontiguousarray(normals.T, dtype=np.float32),
        _material_limits(settings), np.float32(settings.exact), contradicted, doubtful,
    )  # fmt: skip
    return contradicted, doubtful


def _material_inputs(seen: PixelValues, lamps: Lamps) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shares (N, P), noise (P,) and lamps (N, 6) as `reflectance_kernels` wants them."""
    return (
        np.ascontiguousarray(seen.shares.T, dtype=np.float32),
        seen.noise2[:, 0].astype(np.float32),
        np.ascontiguousarray(np.hstack([lamps.directions, lamps.halfway]), dtype=np.float32),
    )


def _material_limits(settings: MaterialSettings) -> FloatArray:
    """What `reflectance_kernels` is told of the settings."""
    s = settings
    return np.array((s.proportional**2, s.width**2, s.dark, s.longest_step, s.settled), np.float32)
