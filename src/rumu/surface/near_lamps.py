"""Normals under lamps that stand near the sheet, whose directions differ from place to place.

The photographs of such a capture are free of fall-off already: flat paper is evenly bright in them. Under a
lamp at (X, Y, Z) with direction l from the middle of the sheet, a normal n at (x, y) then shows

    albedo (n . l  -  l_z / Z (n_x x + n_y y)),

which is Lambert's law with the direction of the place, scaled to the height of l. Our own. Pixels are
solved in small blocks under the lamps of their middle; what the rest of a block sees otherwise is taken off
by its own normals, and the block solved again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rumu.capture.dome import places
from rumu.image_stack import SATURATION, ImageStack, Progress, each_range
from rumu.surface.compiled import tile_solver
from rumu.surface.robust import RobustSettings, Solver, TileSolution
from rumu.surface.solve import Solution, SolutionArrays
from rumu.surface.stereo import SHADOW_FLOOR, check_stack
from rumu.values import BoolArray, Capture, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class NearSettings:
    """How blocks are solved.

    side: pixels of a block, at most this share of the height of the lowest lamp (of_height). rounds: times
    that a block is solved. values: of brightness that a thread holds at a time.
    """

    side: int = 64
    of_height: float = 0.1
    rounds: int = 4
    values: int = 4_000_000


def solve_near(
    stack: ImageStack,
    lights: FloatArray,
    positions: FloatArray,
    *,
    solver: Solver,
    mask: BoolArray,
    black_level: float = 0.0,
    settings: RobustSettings | None = None,
    near: NearSettings | None = None,
    progress: Progress | None = None,
) -> Solution:
    """Normals and albedo of photographs under near lamps.

    stack: without fall-off, see `rumu.capture.dome.without_fall_off`. lights: (N, 3) from the middle of the
    sheet, times their strength. positions: (N, 3) in pixels from there. The rest as of
    `rumu.surface.solve.solve`. Raises SurfaceError for a stack that does not belong together.
    """
    check_stack(stack, lights)
    near = near or NearSettings()
    options = {"solver": solver, "black_level": black_level, "settings": settings or RobustSettings()}
    n, height, width = stack.shape[:3]
    lamps = _NearLamps(lights, positions, (height, width))
    side = max(4, min(near.side, int(near.of_height * positions[:, 2].min())))
    rows = max(1, min(side, near.values // (n * width)))
    found, chosen = SolutionArrays(stack.shape[1:]), mask.reshape(-1)

    def one(part: slice) -> list[tuple[FloatArray, int, int]]:
        found.leave(part)
        values = stack.range(part.start, part.stop)
        solved = []
        for block in _blocks(part, width, side):
            pixels = block[chosen[block]]
            if not pixels.size:
                continue
            tile = values[:, pixels - part.start]
            done = lamps.solve(tile, pixels, block, near.rounds, options)
            found.put(pixels, done)
            solved.append((done.residuals, done.dark, done.lit))
        return solved

    bands = each_range(
        one, stack.pixels, size=rows * width, label="Solving for the normals", progress=progress
    )
    return found.whole(tile for tiles in bands for tile in tiles)


def shading(capture: Capture, normals: FloatArray, pixels: IntArray) -> FloatArray:
    """(N, P): what white paper shows by Lambert's law under each lamp, negative behind it.

    normals: (P, 3) of some pixels, by their numbers. Lamps with positions count as near.
    """
    shown = capture.lights @ normals.T.astype(np.float64)
    if capture.positions is None:
        return np.asarray(shown)
    x, y = places(pixels, capture.mask.shape)
    aside = normals[:, 0] * x + normals[:, 1] * y
    return np.asarray(shown - _loss(capture.lights, capture.positions)[:, None] * aside)


def _loss(lights: FloatArray, positions: FloatArray) -> FloatArray:
    """(N,): by how much each lamp loses of n_x and n_y for every pixel away from the middle."""
    return np.asarray(lights[:, 2] / positions[:, 2])


def _blocks(part: slice, width: int, side: int) -> Iterator[IntArray]:
    """The numbers of the pixels of each block of a band of whole rows."""
    band = np.arange(part.start, part.stop).reshape(-1, width)
    return (band[:, left : left + side].reshape(-1) for left in range(0, width, side))


@dataclass(frozen=True, slots=True, eq=False)
class _NearLamps:
    """lights: (N, 3), times strength. positions: (N, 3) in pixels. shape: (H, W)."""

    lights: FloatArray
    positions: FloatArray
    shape: tuple[int, int]

    def solve(
        self,
        values: FloatArray,
        pixels: IntArray,
        block: IntArray,
        rounds: int,
        options: dict[str, Any],
    ) -> TileSolution:
        """Some pixels (P,) of a block, whose values are (N, P[, 3]). options: of `solve_tile`."""
        solve_tile, loss = tile_solver(), _loss(self.lights, self.positions)[:, None]
        x, y = places(pixels, self.shape)
        middle = [float(one.mean()) for one in places(block[[0, -1]], self.shape)]
        lights = self.lights.copy()
        lights[:, :2] -= loss * middle
        done = solve_tile(values, lights, **options)
        lit = (values > SHADOW_FLOOR) & (values < SATURATION)
        for _ in range(rounds - 1):
            beside = done.normals[:, 0] * (x - middle[0]) + done.normals[:, 1] * (y - middle[1])
            seen_less = (-loss * beside).astype(np.float32)
            less = seen_less * done.albedo if values.ndim == 2 else seen_less[..., None] * done.albedo
            moved = np.clip(values - less, np.float32(1.01 * SHADOW_FLOOR), np.float32(0.999 * SATURATION))
            done = solve_tile(np.where(lit, moved, values), lights, **options)
        return done
