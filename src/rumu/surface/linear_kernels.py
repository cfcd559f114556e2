"""Gray brightness, the least-squares solution and the normals that it tells, compiled.

A kernel's cache notices changes of its own file alone, so this file calls none of `rumu.surface.kernels`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

_MATH = {"contract", "arcp", "nsz", "reassoc"}
_kernel: Any = njit(nogil=True, cache=True, fastmath=_MATH, error_model="numpy")
_exact: Any = njit(nogil=True, cache=True, error_model="numpy")  # so that equal values stay equal, for ranks

_BLOCK = 64  # pixels at a time, so that they stay near the processor
_ZERO, _ONE = np.float32(0), np.float32(1)
_TINY = np.float32(1e-12)


@_exact
def brightness(values: Any, black: Any, floor: Any, share: Any, white: Any, rows: Any, reached: Any) -> None:
    """Gray brightness less the black level, and which pixels three lamps reach.

    values: (N, P, C) linear. rows: (N, P), written; of gray photographs it holds the values already. reached:
    (P,) bool, written: at least three values that are neither dark (below `floor`, or `share` of the
    brightest) nor `white`.
    """
    n, pixels, channels = values.shape
    top, count = np.empty(_BLOCK, np.float32), np.empty(_BLOCK, np.int32)
    for first in range(0, pixels, _BLOCK):
        width = min(_BLOCK, pixels - first)
        for j in range(_BLOCK):
            top[j], count[j] = _ZERO, 0
        for i in range(n):
            row = rows[i, first : first + width]
            if channels == 3:
                for j in range(width):
                    p = first + j
                    row[j] = (values[i, p, 0] + values[i, p, 1] + values[i, p, 2]) / np.float32(3)
            for j in range(width):
                top[j] = row[j] if row[j] > top[j] else top[j]
        for j in range(_BLOCK):
            top[j] = max(floor, share * top[j])
        for i in range(n):
            row = rows[i, first : first + width]
            for j in range(width):
                count[j] += 1 if top[j] < row[j] < white else 0
            if black != _ZERO:
                for j in range(width):
                    row[j] = max(row[j] - black, _ZERO) if row[j] > floor else _ZERO
        for j in range(width):
            reached[first + j] = count[j] >= 3


@_kernel
def least_squares(rows: Any, inverse: Any, scaled: Any) -> None:
    """Write the least-squares solution. inverse: (3, N), of the lamps; scaled: (3, P)."""
    for first in range(0, rows.shape[1], _BLOCK):
        width = min(_BLOCK, rows.shape[1] - first)
        for k in range(3):
            out = scaled[k, first : first + width]
            for j in range(width):
                out[j] = _ZERO
            for i in range(rows.shape[0]):
                row, weight = rows[i, first : first + width], inverse[k, i]
                for j in range(width):
                    out[j] += weight * row[j]


@_kernel
def split(scaled: Any, normals: Any, albedo: Any) -> None:
    """Write albedo (P,) and unit normals (P, 3) of scaled (3, P); what is black faces the camera."""
    for p in range(scaled.shape[1]):
        x, y, z = scaled[0, p], scaled[1, p], scaled[2, p]
        length = np.sqrt(x * x + y * y + z * z)
        seen = length > _TINY
        share = _ONE / (length if seen else _ONE)
        albedo[p] = length
        normals[p, 0], normals[p, 1] = x * share if seen else _ZERO, y * share if seen else _ZERO
        normals[p, 2] = z * share if seen else _ONE
