"""Differences between neighbours become height: Poisson's equation on a rectangle, least squares on a mask.

Heights are of pixels, differences between a pixel and the next of its row or column. Everything is float32.
"""

from __future__ import annotations

import numpy as np

from rumu.values import BoolArray, FloatArray

_ROWS_IN_CACHE = 100_000
"""Pixels of the rows that a step of conjugate gradients goes over at a time."""
_ITERATIONS = 300
"""Most steps of conjugate gradients."""
_TOLERANCE = 1e-4
"""Residual of the normal equations, relative: height errors far below the noise of any capture."""


def divergence(right: FloatArray, down: FloatArray) -> FloatArray:
    """(H, W): what leaves each pixel. right: (H, W - 1), to the next of its row; down: (H - 1, W)."""
    result = np.zeros((right.shape[0], down.shape[1]), np.float32)
    result[:, :-1] += right
    result[:, 1:] -= right
    result[:-1] += down
    result[1:] -= down
    return result


def poisson(divergence: FloatArray) -> FloatArray:
    """Height of mean 0 whose five-point Laplacian, with free edges, is the divergence, which is used up.

    It is diagonal in the cosine basis.
    """
    from scipy.fft import dctn, idctn

    h, w = divergence.shape
    rows = 2.0 * np.cos(np.pi * np.arange(h) / h) - 2.0
    columns = (2.0 * np.cos(np.pi * np.arange(w) / w) - 2.0).astype(divergence.dtype)
    spectrum = dctn(divergence, type=2, workers=-1, overwrite_x=True)
    frequency = rows.astype(divergence.dtype)[:, None]
    step = max(1, _ROWS_IN_CACHE // w)
    for top in range(0, h, step):
        sums = frequency[top : top + step] + columns
        if top == 0:
            sums[0, 0] = 1.0  # what is undetermined
        spectrum[top : top + step] /= sums
    spectrum[0, 0] = 0.0
    return np.asarray(idctn(spectrum, type=2, workers=-1, overwrite_x=True))


def conjugate_gradients(
    left: FloatArray,
    right: FloatArray,
    down: FloatArray,
    *,
    tolerance: float = _TOLERANCE,
    iterations: int = _ITERATIONS,
) -> FloatArray:
    """Solve (D' W D) z = left, which is used up; D: differences between neighbours, W: their weights.

    The preconditioner is the Poisson solver of the whole rectangle: then the number of steps depends on the
    shape of the mask but hardly on the number of pixels.
    """
    z, ahead = np.zeros_like(left), np.empty_like(left)
    guess = poisson(-left)
    direction = guess.copy()
    power = start = float(np.vdot(left, guess))
    for _ in range(iterations):
        if power <= tolerance**2 * start:
            break
        _stiffness(direction, right, down, ahead)
        step = np.float32(power / max(float(np.vdot(direction, ahead)), 1e-300))
        z += step * direction
        ahead *= step
        left -= ahead
        guess = poisson(-left)
        before, power = power, float(np.vdot(left, guess))
        direction *= np.float32(power / before)
        direction += guess
    return z


def _stiffness(z: FloatArray, right: FloatArray, down: FloatArray, result: FloatArray) -> None:
    """Write (D' W D) z, some rows at a time: it is bound by memory."""
    result[...] = 0
    step = max(1, _ROWS_IN_CACHE // z.shape[1])
    for top in range(0, len(z), step):
        rows = slice(top, min(top + step, len(z)))
        across = right[rows] * (z[rows, 1:] - z[rows, :-1])
        result[rows, :-1] -= across
        result[rows, 1:] += across
        end = min(rows.stop, len(z) - 1)
        along = down[top:end] * (z[top + 1 : end + 1] - z[top:end])
        result[top:end] -= along
        result[top + 1 : end + 1] += along


def centre_parts(height: FloatArray, inside: BoolArray) -> FloatArray:
    """Each part of the mask on its own mean, 0 outside."""
    from scipy import ndimage

    parts, count = ndimage.label(inside)
    means = np.zeros(count + 1)
    means[1:] = ndimage.mean(height, parts, np.arange(1, count + 1))
    return np.where(inside, height - means[parts], 0.0)
