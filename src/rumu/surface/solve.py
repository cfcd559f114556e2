"""Whole photographs solved for normals and albedo, tile by tile in threads.

Only a tile of brightness exists as floats at a time, so memory stays bounded however large the photographs
are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rumu.errors import SurfaceError
from rumu.image_stack import ImageStack, Progress, each_range
from rumu.surface.beyond_lambert import solve_materials
from rumu.surface.compiled import tile_solver
from rumu.surface.reflectance import Material
from rumu.surface.robust import SOLVERS, RobustSettings, Solver, TileSolution
from rumu.surface.stereo import check_stack
from rumu.values import BoolArray, FloatArray, IntArray

_TILE = 400_000
"""Values of brightness that a thread works on at a time: a few MB with all that is derived from them."""
_RESIDUALS = 1_000_000
"""Most residuals whose median is taken: those of 100 megapixels under 60 lamps would fill 2 GB."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Normals under N lamps, with what they rest on.

    normals: (H, W, 3) float32, unit length. albedo: (H, W) or (H, W, 3) float32, >= 0.
    confidence: (H, W) float32 in [0, 1]: agreement with Lambert's law times the share of lamps that carry
        the normal, 0 where fewer than three lamps reach the pixel.
    residual: median over all lit values of |brightness - law| in shares of the pixel's brightness.
    shadow_share: share of all values that are dark. materials: tried beside Lambert's law, where it fails.
    """

    normals: FloatArray
    albedo: FloatArray
    confidence: FloatArray
    residual: float
    shadow_share: float
    materials: tuple[Material, ...] = ()


class SolutionArrays:
    """A solution while it is made, some pixels at a time. shape: (H, W), or (H, W, 3) in colour."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        pixels = shape[0] * shape[1]
        self._shape = shape
        # Without values: memory is given to what is written first, and threads do that side by side.
        self._normals = np.empty((pixels, 3), dtype=np.float32)
        self._albedo = np.empty((pixels, *shape[2:]), dtype=np.float32)
        self._confidence = np.empty(pixels, dtype=np.float32)

    def leave(self, pixels: slice) -> None:
        """Make some pixels what those are that are not solved: they face the camera, with no confidence."""
        self._normals[pixels] = (0, 0, 1)
        self._albedo[pixels] = 0
        self._confidence[pixels] = 0

    def put(self, pixels: slice | IntArray, done: TileSolution) -> None:
        """Set some pixels by their numbers."""
        self._normals[pixels] = done.normals
        self._albedo[pixels] = done.albedo
        self._confidence[pixels] = done.confidence

    def whole(self, tiles: Iterable[tuple[FloatArray, int, int]]) -> Solution:
        """The solution, with the residuals, and the numbers of dark and lit values, of all tiles.

        Of more than `_RESIDUALS` residuals, every second, fourth... of each tile is looked at.
        """
        parts: list[FloatArray] = [np.zeros(0)]
        count, step, dark, lit = 0, 1, 0, 0
        for residuals, tile_dark, tile_lit in tiles:
            parts.append(residuals[::step])
            count, dark, lit = count + parts[-1].size, dark + tile_dark, lit + tile_lit
            if count > _RESIDUALS:
                parts = [np.concatenate(parts)[::2].copy()]
                count, step = parts[0].size, 2 * step
        pooled = np.concatenate(parts)
        return Solution(
            self._normals.reshape(*self._shape[:2], 3),
            self._albedo.reshape(self._shape),
            self._confidence.reshape(self._shape[:2]),
            float(np.median(pooled)) if pooled.size else 0.0,
            dark / max(1, dark + lit),
        )


def solve(
    images: FloatArray | ImageStack,
    lights: FloatArray,
    *,
    solver: Solver = "robust",
    mask: BoolArray | None = None,
    black_level: float = 0.0,
    settings: RobustSettings | None = None,
    materials: Sequence[Material] = (),
    tile: int = _TILE,
    progress: Progress | None = None,
) -> Solution:
    """Normals and albedo of a stack of photographs.

    images: (N, H, W) or (N, H, W, 3), linear. lights: (N, 3), toward the lamps, times their strength.
    mask: (H, W), pixels to solve; the rest face the camera with no confidence. black_level: taken from every
    value that is not black. materials: beside Lambert's law, tried where it fails; see
    `rumu.surface.beyond_lambert.find_materials`. tile: number of values worked on at a time; the result does
    not depend on it. Solved by numba's compiled kernels; where there is no numba by NumPy, after a
    SlowSolverWarning. Raises SurfaceError for an unknown solver or a stack that does not belong together.
    """
    if solver not in SOLVERS:
        raise SurfaceError(f"expected a solver among {', '.join(SOLVERS)}, got {solver!r}")
    check_stack(images, lights)
    stack = images if isinstance(images, ImageStack) else ImageStack.of_arrays(images)
    solve_tile, found = tile_solver(), SolutionArrays(stack.shape[1:])
    chosen = None if mask is None or mask.all() else mask.ravel()
    settings = settings or RobustSettings()

    def one(part: slice) -> tuple[FloatArray, int, int]:
        inside = slice(None) if chosen is None else np.flatnonzero(chosen[part])
        if not isinstance(inside, slice):
            found.leave(part)
            if not inside.size:
                return np.zeros(0), 0, 0
        if isinstance(inside, slice):
            values = stack.range(part.start, part.stop)
        else:
            values = stack.at(part.start + inside)
        done = solve_tile(values, lights, solver=solver, black_level=black_level, settings=settings)
        if materials:
            done = solve_materials(values, lights, done, materials, black_level=black_level)
        found.put(part if isinstance(inside, slice) else part.start + inside, done)
        return done.residuals, done.dark, done.lit

    size = max(1, tile // len(stack))
    solution = found.whole(
        each_range(one, stack.pixels, size=size, label="Solving for the normals", progress=progress)
    )
    return replace(solution, materials=tuple(materials))
