"""Inflation of ink: the height of a stroke from its outline alone.

Our reconstruction of the Laplacian inflation that the paper cites for single images: solve Laplace(u) = -1
in the ink with u = 0 on its border, and take h = sqrt(2u). Across a long stroke of half-width W this is the
half circle of radius W; on a disk of radius R it is an ellipsoid of height R / sqrt(2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import SurfaceError

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class InflationSettings:
    """How far the system is solved.

    tolerance: residual over right-hand side at which the iteration ends. iterations: most steps of conjugate
        gradients; ordinary strokes need about five. sweeps: Jacobi sweeps before and after each coarser
        grid; last_sweeps: on the coarsest; damping: theirs.
    """

    tolerance: float = 3e-2
    iterations: int = 60
    sweeps: int = 2
    damping: float = 0.8
    last_sweeps: int = 4


def inflate(mask: npt.NDArray[Any], *, settings: InflationSettings | None = None) -> Floats:
    """Height of the inflated ink, in pixels.

    mask: (H, W) bool, True on ink. What lies outside the picture counts as paper.
    Returns (H, W) float32, 0 off the ink and above 0 on it. A function of the outline and of nothing else.
    Raises SurfaceError when the mask is no (H, W) bool array.
    """
    if mask.ndim != 2 or mask.dtype != np.bool_:
        raise SurfaceError(f"expected a bool mask of shape (H, W), got {mask.dtype} {mask.shape}")
    height = np.zeros(mask.shape, np.float32)
    if not mask.any():
        return height
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    potential = _solve(mask[box], settings or InflationSettings())
    height[box] = np.sqrt(2.0 * np.maximum(potential, 0.0))
    return height


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """diagonal * u - (sum over the linked neighbours) = right, on the ink; u = 0 elsewhere.

    ink, diagonal, right: (H, W) float32; H and W are even and the rim is paper. ink is 1 on ink, else 0.
    weight: damping * ink / diagonal.
    east, south: (H, W) float32, weight of the link to the next pixel in the row, in the column.
    """

    ink: Floats
    diagonal: Floats
    weight: Floats
    right: Floats
    east: Floats
    south: Floats
    finest: bool = False


_CROSS = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], np.float32)
_HALVING = np.array([0.25, 0.75, 0.75, 0.25], np.float32)  # the transpose of bilinear doubling


def _grids(mask: Bools, settings: InflationSettings) -> list[_Grid]:
    """The equations on the picture and on pictures of half, a quarter... of its resolution.

    No coarser than the widest stroke: where strokes are one pixel wide, the sweeps do the rest.
    """
    import cv2

    ink = _rimmed(mask.astype(np.float32))
    half_width = float(cv2.distanceTransform(ink.astype(np.uint8), cv2.DIST_L2, 3).max())
    grids = [_finest(ink, settings.damping)]
    for _ in range(int(np.log2(max(half_width, 1.0)))):
        grids.append(_coarser(grids[-1], settings.damping))
    return grids


def _rimmed(picture: npt.NDArray[Any]) -> Floats:
    """With a rim of zeros and even sides."""
    height, width = picture.shape
    rimmed = np.zeros((height + 2 + height % 2, width + 2 + width % 2), np.float32)
    rimmed[1 : height + 1, 1 : width + 1] = picture
    return rimmed


def _finest(ink: Floats, damping: float) -> _Grid:
    """The 5-point equations, with the border half-way between an ink pixel and a paper pixel.

    The value beyond the border follows from u = 0 on it and from the curvature that the equation itself
    prescribes: across one axis -1, shared by both axes at a corner. That makes a strip exact.
    """
    import cv2

    places = cv2.filter2D(ink.astype(np.uint8), -1, _PLACES, borderType=cv2.BORDER_CONSTANT)
    diagonal, right, weight = (cv2.LUT(places, table) for table in _by_place(damping))
    east, south = np.zeros_like(ink), np.zeros_like(ink)
    np.multiply(ink[:, :-1], ink[:, 1:], out=east[:, :-1])
    np.multiply(ink[:-1], ink[1:], out=south[:-1])
    return _Grid(ink, diagonal, weight, right, east, south, finest=True)


_PLACES = np.array([[0, 3, 0], [1, 9, 1], [0, 3, 0]], np.float32)
"""9 on ink, and 1 for each neighbour in the row that is ink, and 3 for each in the column; below 9 off it."""


@lru_cache(maxsize=4)
def _by_place(damping: float) -> tuple[Floats, Floats, Floats]:
    """Diagonal, right side and weight of a pixel, each (256,), by its `_PLACES`."""
    place = np.arange(256) % 18  # a table of OpenCV's has 256 entries
    on_ink = place >= 9
    across, down = (np.where(on_ink, 2 - k, 2) for k in (place % 3, (place - 9) // 3))
    missing = (across + down).astype(np.float32)
    curvature = np.where((across > 0) & (down > 0), np.float32(0.125), np.float32(0.25))
    diagonal = np.float32(4.0) + missing
    right = np.where(on_ink, np.float32(1.0) - missing * curvature, np.float32(0.0))
    return diagonal, right, np.where(on_ink, np.float32(damping) / diagonal, np.float32(0.0))


def _coarser(grid: _Grid, damping: float) -> _Grid:
    """Half the Galerkin product over blocks of 2 x 2: inside the ink it is the 5-point equation again.

    Links between blocks are counted, so strokes that nearly touch stay apart on every grid.
    """
    internal = grid.east[::2, ::2] + grid.east[1::2, ::2] + grid.south[::2, ::2] + grid.south[::2, 1::2]
    east = 0.5 * (grid.east[::2, 1::2] + grid.east[1::2, 1::2])
    south = 0.5 * (grid.south[1::2, ::2] + grid.south[1::2, 1::2])
    ink = _rimmed(_block_sums(grid.ink) > 0)
    diagonal = _rimmed(0.5 * _block_sums(grid.diagonal * grid.ink) - internal)
    weight = np.asarray(np.float32(damping) * ink / np.maximum(diagonal, 0.5), dtype=np.float32)
    return _Grid(ink, diagonal, weight, _halved(grid.right), _rimmed(east), _rimmed(south))


def _block_sums(picture: Floats) -> Floats:
    return picture[::2, ::2] + picture[1::2, ::2] + picture[::2, 1::2] + picture[1::2, 1::2]


def _neighbours(grid: _Grid, u: Floats) -> Floats:
    """Weighted sum over the linked neighbours; on the finest grid u = 0 off the ink does the weighting."""
    import cv2

    if grid.finest:
        return np.asarray(cv2.filter2D(u, -1, _CROSS, borderType=cv2.BORDER_CONSTANT))
    near = np.zeros_like(u)
    total, value, east, south = near.ravel(), u.ravel(), grid.east.ravel(), grid.south.ravel()
    row = u.shape[1]  # flat views are quicker; the rim keeps the end of a row from the start of the next
    np.multiply(east[:-1], value[1:], out=total[:-1])
    total[1:] += east[:-1] * value[:-1]
    total[:-row] += south[:-row] * value[row:]
    total[row:] += south[:-row] * value[:-row]
    return near


def _image(grid: _Grid, u: Floats) -> Floats:
    """The left side of the equations at u, which is 0 off the ink."""
    image = grid.diagonal * u
    image -= _neighbours(grid, u)
    image *= grid.ink
    return image


def _residual(grid: _Grid, u: Floats, right: Floats) -> Floats:
    """The right side, which is 0 off the ink, less the left side at u."""
    left = _image(grid, u)
    return np.subtract(right, left, out=left)


def _swept(grid: _Grid, u: Floats, right: Floats, damping: float) -> Floats:
    """One damped Jacobi sweep."""
    import cv2

    swept = _neighbours(grid, u)
    swept += right
    swept *= grid.weight
    return np.asarray(cv2.scaleAdd(u, 1.0 - damping, swept, dst=swept))


def _correction(grids: list[_Grid], residual: Floats, settings: InflationSettings) -> Floats:
    """One V-cycle from nothing: a symmetric approximation of the inverse."""
    grid = grids[0]
    u = grid.weight * residual
    for _ in range(settings.sweeps - 1 if len(grids) > 1 else settings.last_sweeps):
        u = _swept(grid, u, residual, settings.damping)
    if len(grids) == 1:
        return u
    u += _doubled(_correction(grids[1:], _halved(_residual(grid, u, residual)), settings), grid)
    for _ in range(settings.sweeps):
        u = _swept(grid, u, residual, settings.damping)
    return u


def _halved(residual: Floats) -> Floats:
    """To the grid of half the resolution, which has a rim of its own."""
    import cv2

    sums = cv2.sepFilter2D(residual, -1, _HALVING, _HALVING, anchor=(1, 1), borderType=cv2.BORDER_CONSTANT)
    return _rimmed(sums[::2, ::2])


def _doubled(u: Floats, grid: _Grid) -> Floats:
    """Bilinear, from the grid of half the resolution."""
    import cv2

    height, width = grid.ink.shape
    inner = u[1 : height // 2 + 1, 1 : width // 2 + 1]
    return np.asarray(cv2.resize(inner, (width, height), interpolation=cv2.INTER_LINEAR) * grid.ink)


def _solve(mask: Bools, settings: InflationSettings) -> Floats:
    """(H, W) float32 potential: conjugate gradients, preconditioned by one V-cycle."""
    grids = _grids(mask, settings)
    grid = grids[0]
    u = _first_guess(grids, settings)
    residual = _residual(grid, u, grid.right)
    goal = settings.tolerance**2 * _dot(grid.right, grid.right)
    direction, energy = np.zeros_like(u), 1.0
    for _ in range(settings.iterations):
        if _dot(residual, residual) <= goal:
            break
        corrected = _correction(grids, residual, settings)
        energy, before = _dot(residual, corrected), energy
        direction *= np.float32(energy / before)
        direction += corrected
        image = _image(grid, direction)
        step = np.float32(energy / _dot(direction, image))
        u += step * direction
        residual -= step * image
    return u[1 : mask.shape[0] + 1, 1 : mask.shape[1] + 1]


def _first_guess(grids: list[_Grid], settings: InflationSettings) -> Floats:
    """From the coarsest grid up: each starts from the one below and takes one V-cycle."""
    u = np.zeros_like(grids[-1].ink)
    for k in range(len(grids) - 1, 0, -1):
        u += _correction(grids[k:], _residual(grids[k], u, grids[k].right), settings)
        u = _doubled(u, grids[k - 1])
    return u


def _dot(a: Floats, b: Floats) -> float:
    return float(np.vdot(a, b))
