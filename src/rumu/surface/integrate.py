"""Normals become height: three solvers of one least-squares problem.

All look for the height whose slopes are nearest to those of the normals; they differ in what a slope is and
in what they assume at the edge. Rows grow downward, so dz/drow = -q. Heights are in pixels, mean 0.
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from rumu.errors import SurfaceError
from rumu.surface.stereo import gradients_from_normals
from rumu.values import BoolArray, FloatArray

Integrator = Literal["auto", "dct", "frankot_chellappa", "masked"]

INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
STEEPEST = 10.0
"""Largest slope, 84 degrees; see `gradients_from_normals`."""
_ITERATIONS = 300
"""Most steps of conjugate gradients."""
_TOLERANCE = 1e-4
"""Residual of the normal equations, relative: height errors far below the noise of any capture."""


def integrate(
    normals: FloatArray,
    *,
    mask: BoolArray | None = None,
    method: Integrator = "auto",
    weights: FloatArray | None = None,
) -> FloatArray:
    """Height from normals.

    Parameters
    ----------
    normals : (H, W, 3) ndarray
        x right, y up, z to the camera; of any length. Steeper than 84 degrees or turned away they count as 84
        degrees; (0, 0, 0) as flat.
    mask : (H, W) bool ndarray, optional
        Where there is a surface; outside it normals are ignored. Parts that do not touch each have mean 0,
        since nothing relates their heights.
    method : {'auto', 'dct', 'frankot_chellappa', 'masked'}
        'dct': Poisson's equation with free edges; the best on a full sheet. 'frankot_chellappa': projection
        on integrable slopes in the frequency domain, mirrored at the edges. 'masked': least squares on the
        mask alone, for an object on a background. 'auto': 'dct' without a mask, else 'masked'. With a mask
        'dct' and 'frankot_chellappa' take what is outside for flat.
    weights : (H, W) ndarray, optional
        Trust in each normal, in [0, 1]; used by 'masked' alone.

    Returns
    -------
    (H, W) float32 ndarray
        Height in pixels, finite, mean 0 over the mask and 0 outside it.

    Raises
    ------
    SurfaceError
        For a wrong shape, an unknown method, an empty mask, NaN inside the mask.

    Notes
    -----
    'frankot_chellappa' follows Frankot and Chellappa (1988), with sine and cosine series in place of the
    Fourier transform of a fourfold, mirrored sheet.
    """
    n, inside = _check_normals(normals, mask, method)
    p, q = gradients_from_normals(n, steepest=STEEPEST)
    by_column, by_row = p, -q  # outside the mask the normals are (0, 0, 0) by now: flat
    if method == "masked" or (method == "auto" and (weights is not None or not inside.all())):
        height = _solve_masked(by_column, by_row, inside, weights)
    else:
        height = (_frankot_chellappa if method == "frankot_chellappa" else _dct)(by_column, by_row)
        height = height - height[inside].mean()
    return np.where(inside, height, 0.0).astype(np.float32)


def _dct(by_column: FloatArray, by_row: FloatArray) -> FloatArray:
    """Poisson's equation with free edges, diagonal in the cosine basis. Arrays (H, W)."""
    h, w = by_column.shape
    between_columns = 0.5 * (by_column[:, 1:] + by_column[:, :-1])
    between_rows = 0.5 * (by_row[1:] + by_row[:-1])
    return _poisson(_divergence(between_columns, between_rows, (h, w)))


def _divergence(right: FloatArray, down: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """(H, W): minus the transpose of the differences. right: (H, W - 1); down: (H - 1, W)."""
    result = np.zeros(shape, dtype=right.dtype)
    result[:, :-1] += right
    result[:, 1:] -= right
    result[:-1] += down
    result[1:] -= down
    return result


def _poisson(divergence: FloatArray) -> FloatArray:
    """Height of mean 0 whose five-point Laplacian, with free edges, is the divergence."""
    from scipy.fft import dctn, idctn

    h, w = divergence.shape
    rows = 2.0 * np.cos(np.pi * np.arange(h) / h) - 2.0
    columns = 2.0 * np.cos(np.pi * np.arange(w) / w) - 2.0
    laplacian = (rows[:, None] + columns[None, :]).astype(divergence.dtype)
    laplacian[0, 0] = 1.0
    spectrum = dctn(divergence, type=2, workers=-1, overwrite_x=True)
    spectrum /= laplacian
    spectrum[0, 0] = 0.0
    return np.asarray(idctn(spectrum, type=2, workers=-1, overwrite_x=True))


def _frankot_chellappa(by_column: FloatArray, by_row: FloatArray) -> FloatArray:
    """Projection on integrable slopes, after mirroring the sheet at its edges.

    The mirrored height is even, so each slope is odd across the edges it runs into: sine series along its own
    direction and cosine series along the other, which spares the fourfold sheet. Derivatives are those of the
    waves themselves, exact for a smooth surface.
    """
    from scipy.fft import dct, dst, idctn

    h, w = by_column.shape
    rows, columns = np.pi * np.arange(h) / h, np.pi * np.arange(w) / w
    options: dict[str, Any] = {"type": 2, "workers": -1}
    P = _shift(dst(dct(by_column, axis=0, **options), axis=1, **options), axis=1)
    Q = _shift(dst(dct(by_row, axis=1, **options), axis=0, **options), axis=0)
    frequency = (rows[:, None] ** 2 + columns[None, :] ** 2).astype(by_column.dtype)
    frequency[0, 0] = 1.0
    Z = -(P * columns.astype(P.dtype)[None, :] + Q * rows.astype(Q.dtype)[:, None]) / frequency
    Z[0, 0] = 0.0
    return np.asarray(idctn(Z, type=2, workers=-1, overwrite_x=True))


def _shift(sines: FloatArray, *, axis: int) -> FloatArray:
    """Sine coefficients moved to the indices of the cosines: the k-th wave at k, none at 0."""
    result = np.roll(sines, 1, axis=axis)
    result[(slice(None),) * axis + (0,)] = 0.0
    return result


def _solve_masked(
    by_column: FloatArray, by_row: FloatArray, inside: BoolArray, weights: FloatArray | None
) -> FloatArray:
    """Weighted least squares over pairs of neighbours within the mask, by conjugate gradients.

    The preconditioner is the Poisson solver of the whole sheet: then the number of steps depends on the shape
    of the mask but hardly on the number of pixels.
    """
    trust = inside.astype(np.float64) if weights is None else np.where(inside, np.maximum(weights, 1e-3), 0.0)
    right = np.minimum(trust[:, 1:], trust[:, :-1])
    down = np.minimum(trust[1:], trust[:-1])
    g = by_column.astype(np.float64), by_row.astype(np.float64)
    target = -_divergence(
        right * 0.5 * (g[0][:, 1:] + g[0][:, :-1]), down * 0.5 * (g[1][1:] + g[1][:-1]), inside.shape
    )
    height = _conjugate_gradients(target, right, down)
    return _centre_parts(height, inside)


def _conjugate_gradients(target: FloatArray, right: FloatArray, down: FloatArray) -> FloatArray:
    """Solve (D' W D) z = target; D: differences between neighbours, W: their weights."""
    z = np.zeros_like(target)
    left = target.copy()
    guess = -_poisson(left.copy())
    direction = guess.copy()
    power = start = float((left * guess).sum())
    for _ in range(_ITERATIONS):
        if power <= _TOLERANCE**2 * start:
            break
        across, along = np.diff(direction, axis=1), np.diff(direction, axis=0)
        ahead = -_divergence(right * across, down * along, target.shape)
        step = power / max(float((direction * ahead).sum()), 1e-300)
        z += step * direction
        left -= step * ahead
        guess = -_poisson(left.copy())
        before, power = power, float((left * guess).sum())
        direction = guess + (power / before) * direction
    return z


def _centre_parts(height: FloatArray, inside: BoolArray) -> FloatArray:
    """Each part of the mask on its own mean, 0 outside."""
    from scipy import ndimage

    parts, count = ndimage.label(inside)
    means = np.zeros(count + 1)
    means[1:] = ndimage.mean(height, parts, np.arange(1, count + 1))
    return np.where(inside, height - means[parts], 0.0)


def _check_normals(normals: FloatArray, mask: BoolArray | None, method: str) -> tuple[FloatArray, BoolArray]:
    n = np.asarray(normals, dtype=np.float32)
    if n.ndim != 3 or n.shape[2] != 3 or min(n.shape[:2]) < 2:
        raise SurfaceError(f"expected normals of shape (H >= 2, W >= 2, 3), got {n.shape}")
    if method not in INTEGRATORS:
        raise SurfaceError(f"expected an integrator among {', '.join(INTEGRATORS)}, got {method!r}")
    inside = np.ones(n.shape[:2], dtype=bool) if mask is None else np.asarray(mask)
    if inside.shape != n.shape[:2] or inside.dtype != np.bool_:
        raise SurfaceError(f"expected a bool mask of shape {n.shape[:2]}, got {inside.dtype} {inside.shape}")
    if not inside.any():
        raise SurfaceError("expected a mask with at least one pixel, got an empty one")
    n = n if mask is None else np.where(inside[..., None], n, np.float32(0))
    if not np.isfinite(n.sum(dtype=np.float64)):  # one pass; where it went wrong is looked up only then
        bad = int(np.count_nonzero(~np.isfinite(n).all(axis=2)))
        raise SurfaceError(f"expected finite normals, got {bad} pixels that hold NaN or infinity")
    return n, inside
