"""Ink as a field of signed distances, so that what is moved, bent or joined keeps smooth edges.

`depth`: (H, W) float32, pixels from the nearest edge of the ink, positive inside, negative outside.
"""

from __future__ import annotations

import numpy as np

from rumu.values import BoolArray, FloatArray

NO_INK = np.float32(-1e4)


def depth_of(mask: BoolArray) -> FloatArray:
    """Depth of a mask (H, W) bool, smoothed by less than a pixel; NO_INK everywhere for an empty mask."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    if not mask.any():
        return np.full(mask.shape, NO_INK, dtype=np.float32)
    # The picture's edge is no edge of the ink's paper: pad, or a full picture would have none.
    padded = np.pad(mask, 1)
    inside, outside = distance_transform_edt(padded), distance_transform_edt(~padded)
    depth = np.where(padded, inside - 0.5, 0.5 - outside)
    return np.asarray(gaussian_filter(depth, 0.7)[1:-1, 1:-1], dtype=np.float32)


def coverage(depth: FloatArray) -> FloatArray:
    """(H, W) float32 in [0, 1]: how much of each pixel the ink covers."""
    return np.asarray(np.clip(depth + 0.5, 0.0, 1.0), dtype=np.float32)


def brush_depth(shape: tuple[int, ...], path: FloatArray, radius: FloatArray) -> FloatArray:
    """Depth of what a round brush leaves along a path (N, 2) of (row, column), `radius` (N,) wide.

    Between path points less than a pixel apart; (H, W) float32.
    """
    from scipy.ndimage import distance_transform_edt

    row, column = np.clip(np.round(path).astype(int), 0, np.array(shape) - 1).T
    off, wide = np.ones(shape, dtype=bool), np.zeros(shape)
    off[row, column] = False
    np.maximum.at(wide, (row, column), radius)
    distance, (r, c) = distance_transform_edt(off, return_indices=True)
    return np.asarray(wide[r, c] - distance, dtype=np.float32)


def move(depth: FloatArray, *, matrix: FloatArray, centre: FloatArray, shift: FloatArray) -> FloatArray:
    """The ink under x -> centre + matrix (x - centre) + shift, all in (row, column)."""
    from scipy.ndimage import affine_transform

    back = np.linalg.inv(matrix)
    offset = centre - back @ (centre + shift)
    scale = float(np.sqrt(abs(np.linalg.det(matrix))))
    warped = affine_transform(depth, back, offset, order=1, mode="constant", cval=float(depth.min()))
    return np.asarray(warped * scale, dtype=np.float32)


def tremble(depth: FloatArray, *, pixels: float, grain: float, seed: int) -> FloatArray:
    """The ink drawn by a trembling hand: every place leaves its own by about `pixels`, smoothly."""
    from scipy.ndimage import map_coordinates

    at = np.indices(depth.shape).astype(np.float64)
    for axis in (0, 1):
        at[axis] += pixels * roughness(depth.shape, grain=grain, seed=seed + axis)
    return np.asarray(map_coordinates(depth, at, order=1, mode="nearest"), dtype=np.float32)


def close_clefts(depth: FloatArray, *, gap: float, near: BoolArray) -> FloatArray:
    """The ink with clefts narrower than `gap` pixels filled, inside `near` (H, W) bool only."""
    from scipy.ndimage import distance_transform_edt

    grown = np.pad(depth > -gap / 2, 1)
    closed = np.asarray(distance_transform_edt(grown))[1:-1, 1:-1] - gap / 2 - 0.5
    return np.where(near, np.maximum(depth, closed), depth).astype(np.float32)


def roughness(shape: tuple[int, ...], *, grain: float, seed: int) -> FloatArray:
    """Smooth random field (H, W) of mean 0 and standard deviation 1 with bumps about `grain` pixels wide."""
    from scipy.ndimage import gaussian_filter

    noise = gaussian_filter(np.random.default_rng(seed).normal(size=shape), grain / 2.0, mode="wrap")
    return np.asarray((noise - noise.mean()) / noise.std(), dtype=np.float32)
