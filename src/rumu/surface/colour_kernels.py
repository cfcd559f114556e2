"""The albedo of colour photographs, compiled: each channel under the trust that the solver gave each value.

A kernel's cache notices changes of its own file alone, so this file calls none of `rumu.surface.kernels`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

_MATH = {"contract", "arcp", "nsz", "reassoc"}
_kernel: Any = njit(nogil=True, cache=True, fastmath=_MATH, error_model="numpy")

_ZERO, _ONE = np.float32(0), np.float32(1)
_BLOCK = 256  # pixels at a time, so that their sums stay near the processor


@_kernel
def trust(
    rows: Any, lights: Any, scale: Any, limits: Any, start: Any, found: Any, spread: Any, share: Any,
    weights: Any,
) -> None:  # fmt: skip
    """Write the trust in each value: that of the loss that forgets, by `share`, and that of "l1".

    rows: (N, P). limits: see `kernels.reweighted`. start, found: (3, P), the solutions of "l1" and of the
    loss that forgets. spread, share: (P,). weights: (N, P), written.
    """
    dark, noise2, proportional, width, white = limits[0], limits[1], limits[2], limits[3], limits[4]
    for i in range(rows.shape[0]):
        x, y, z = lights[i, 0], lights[i, 1], lights[i, 2]
        for p in range(rows.shape[1]):
            inverse = _ONE / scale[p]
            off = (rows[i, p] - (start[0, p] * x + start[1, p] * y + start[2, p] * z)) * inverse * limits[5]
            weight = _ONE / np.sqrt(_ONE + off * off)
            if share[p] > _ZERO:
                raw = found[0, p] * x + found[1, p] * y + found[2, p] * z
                facing = max(raw, _ZERO) * inverse
                miss = rows[i, p] * inverse - facing
                spread2 = width * spread[p]
                width2 = spread2 * spread2 + noise2 + proportional * proportional * facing * facing
                near = width2 / (width2 + miss * miss)
                informative = (raw > _ZERO or rows[i, p] > dark * scale[p]) and rows[i, p] < white
                weight = share[p] * (near * near if informative else _ZERO) + (_ONE - share[p]) * weight
            weights[i, p] = weight


@_kernel
def channels(values: Any, black: Any, lights: Any, normals: Any, weights: Any, albedo: Any) -> None:
    """Write the albedo of each channel, (P, 3), by weighted least squares on the shading of the normals.

    values: (N, P, 3) linear; black: taken from each; normals: (P, 3); weights: (N, P).
    """
    n, pixels, _ = values.shape
    power, sums = np.empty(_BLOCK, np.float32), np.empty((_BLOCK, 3), np.float32)
    for first in range(0, pixels, _BLOCK):
        count = min(_BLOCK, pixels - first)
        power[:] = _ZERO
        sums[:] = _ZERO
        for i in range(n):
            x, y, z = lights[i, 0], lights[i, 1], lights[i, 2]
            for j in range(count):
                p = first + j
                shading = max(normals[p, 0] * x + normals[p, 1] * y + normals[p, 2] * z, _ZERO)
                trusted = weights[i, p] * shading
                power[j] += trusted * shading
                for c in range(3):
                    sums[j, c] += trusted * (values[i, p, c] - black)
        for j in range(count):
            share = _ONE / max(power[j], np.float32(1e-12))
            for c in range(3):
                albedo[first + j, c] = max(sums[j, c] * share, _ZERO)
