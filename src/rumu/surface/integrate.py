"""Normals become height: three solvers of one least-squares problem, and one that keeps steps.

All look for the height whose slopes are nearest to those of the normals; they differ in what a slope is and
in what they assume at the edge. 'bilateral' stands in `rumu.surface.bilateral`, a camera at a finite distance
in `rumu.surface.perspective`. Rows grow downward, so dz/drow = -q. Heights are in pixels, mean 0.
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from rumu.capture.image import bounding_box
from rumu.errors import SurfaceError
from rumu.image_stack import each_range
from rumu.surface.bilateral import integrate_bilateral
from rumu.surface.neighbours import centre_parts, conjugate_gradients, poisson
from rumu.surface.perspective import check_focal_length, height_of_distance, seen_normals
from rumu.surface.stereo import gradients_from_normals
from rumu.values import BoolArray, FloatArray

Integrator = Literal["auto", "dct", "frankot_chellappa", "masked", "bilateral"]

INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
STEEPEST = 10.0
"""Largest slope, 84 degrees; see `gradients_from_normals`."""
_BAND = 1_000_000
"""Pixels whose slopes are computed at a time."""


def integrate(
    normals: FloatArray,
    *,
    mask: BoolArray | None = None,
    method: Integrator = "auto",
    weights: FloatArray | None = None,
    focal_length: float | None = None,
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
    method : {'auto', 'dct', 'frankot_chellappa', 'masked', 'bilateral'}
        'dct': Poisson's equation with free edges; the best on a full sheet. 'frankot_chellappa': projection
        on integrable slopes in the frequency domain, mirrored at the edges. 'masked': least squares on the
        mask alone, for an object on a background. 'bilateral': keeps steps, which the others bend into ramps,
        in some ten times the time. 'auto': 'dct' without a mask, else 'masked'. With a mask
        'dct' and 'frankot_chellappa' take what is outside for flat.
    weights : (H, W) ndarray, optional
        Trust in each normal, in [0, 1]; used by 'masked' and 'bilateral' alone.
    focal_length : float, optional
        Of the camera, in pixels of the photograph, whose axis is in its middle; None for one that is far
        away. Heights are then those of the points that the pixels see, counted along the axis.

    Returns
    -------
    (H, W) float32 ndarray
        Height in pixels, finite, mean 0 over the mask and 0 outside it.

    Raises
    ------
    SurfaceError
        For a wrong shape, an unknown method, an empty mask, NaN inside the mask, normals most of which point
        away, a bad focal length.

    Notes
    -----
    'frankot_chellappa' follows Frankot and Chellappa (1988), with sine and cosine series in place of the
    Fourier transform of a fourfold, mirrored sheet.
    """
    n, inside = _check_normals(normals, mask, method)
    if focal_length is None:
        return _height(n, inside, method, weights)
    check_focal_length(focal_length, n.shape)
    height = height_of_distance(_height(seen_normals(n, focal_length), inside, method, weights), focal_length)
    return _centred(height, inside)


def _height(
    n: FloatArray, inside: BoolArray | None, method: Integrator, weights: FloatArray | None
) -> FloatArray:
    """The height whose slopes are those of checked normals (H, W, 3); inside: None for everywhere."""
    if method == "masked" or (method == "auto" and (weights is not None or inside is not None)):
        return _solve_masked(n, np.ones(n.shape[:2], bool) if inside is None else inside, weights)
    if method == "bilateral":
        return _solve_bilateral(n, np.ones(n.shape[:2], bool) if inside is None else inside, weights)
    if method == "frankot_chellappa":
        height = _frankot_chellappa(*_slopes(n, inside)).astype(np.float32, copy=False)
    else:
        height = poisson(_divergence_of(n, inside, weights=None))
    return _centred(height, inside)


def _centred(height: FloatArray, inside: BoolArray | None) -> FloatArray:
    """The height with mean 0, and 0 where it is not inside; it may change."""
    if inside is None:
        height -= height.mean(dtype=np.float64)
        return height
    return np.where(inside, height - height[inside].mean(dtype=np.float64), 0.0).astype(np.float32)


def _slopes(normals: FloatArray, inside: BoolArray | None) -> tuple[FloatArray, FloatArray]:
    """dz/dcolumn and dz/drow, (H, W) float32 each; 0 where it is not inside."""
    p, q = gradients_from_normals(normals, steepest=STEEPEST)
    if inside is not None:
        p, q = np.where(inside, p, np.float32(0)), np.where(inside, q, np.float32(0))
    return p, -q


def _divergence_of(
    normals: FloatArray, inside: BoolArray | None, *, weights: tuple[FloatArray, FloatArray] | None
) -> FloatArray:
    """(H, W) float32: the divergence of the slopes between neighbours, times weights if there are any.

    normals: (H, W, 3). weights: (H, W - 1) of neighbours in a row, and (H - 1, W) of those in a column.
    Worked out some rows at a time, since slopes of a whole sheet would take as much as the sheet twice more.
    """
    h, w = normals.shape[:2]
    result = np.empty((h, w), np.float32)

    def work(rows: slice) -> None:
        around = slice(max(rows.start - 1, 0), min(rows.stop + 1, h))  # what the first and last differ from
        by_column, by_row = _slopes(normals[around], None if inside is None else inside[around])
        own = slice(rows.start - around.start, rows.stop - around.start)
        right = np.float32(0.5) * (by_column[own, 1:] + by_column[own, :-1])
        down = np.float32(0.5) * (by_row[1:] + by_row[:-1])
        if weights is not None:
            right *= weights[0][rows]
            down *= weights[1][around.start : around.stop - 1]
        here = result[rows]
        here[:, :-1], here[:, -1] = right, 0
        here[:, 1:] -= right
        below, above = down[own.start : own.stop], down[: own.stop - 1]
        here[: len(below)] += below
        here[len(here) - len(above) :] -= above

    for _ in each_range(work, h, size=max(1, _BAND // w), label="Integrating the height"):
        pass
    return result


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


def _solve_bilateral(normals: FloatArray, inside: BoolArray, weights: FloatArray | None) -> FloatArray:
    """Bilateral integration of the rectangle around the mask, beginning with the least-squares height."""
    box = _box(inside)
    part = inside[box]
    trust = part.astype(np.float32) if weights is None else np.maximum(weights[box], np.float32(1e-3))
    start = _solve_masked(normals, inside, weights)[box]
    height = np.zeros(inside.shape, np.float32)
    height[box] = integrate_bilateral(*_slopes(normals[box], part), part, trust, start=start)
    return height


def _box(inside: BoolArray) -> tuple[slice, slice]:
    """The rectangle around a mask."""
    top, bottom, left, right = bounding_box(inside)
    return slice(top, bottom), slice(left, right)


def _solve_masked(normals: FloatArray, inside: BoolArray, weights: FloatArray | None) -> FloatArray:
    """Weighted least squares over pairs of neighbours within the mask, by conjugate gradients.

    Only the rectangle around the mask is worked on, made a little larger where the transforms are slow.
    """
    from scipy.fft import next_fast_len

    box = _box(inside)
    part = inside[box]
    trust = np.zeros([next_fast_len(max(side, 2), real=True) for side in part.shape], np.float32)
    near = trust[: part.shape[0], : part.shape[1]]
    near[...] = part if weights is None else np.where(part, np.maximum(weights[box], np.float32(1e-3)), 0)
    right, down = np.minimum(trust[:, 1:], trust[:, :-1]), np.minimum(trust[1:], trust[:-1])
    target = np.zeros_like(trust)
    target[: part.shape[0], : part.shape[1]] = _divergence_of(
        normals[box],
        part,
        weights=(right[: part.shape[0], : part.shape[1] - 1], down[: part.shape[0] - 1, : part.shape[1]]),
    )
    np.negative(target, out=target)
    found = conjugate_gradients(target, right, down)[: part.shape[0], : part.shape[1]]
    height = np.zeros(inside.shape, np.float32)
    height[box] = centre_parts(found, part)
    return height


def _check_normals(
    normals: FloatArray, mask: BoolArray | None, method: str
) -> tuple[FloatArray, BoolArray | None]:
    """The normals, and the mask unless it holds everything."""
    n = np.asarray(normals, dtype=np.float32)
    if n.ndim != 3 or n.shape[2] != 3 or min(n.shape[:2]) < 2:
        raise SurfaceError(f"expected normals of shape (H >= 2, W >= 2, 3), got {n.shape}")
    if method not in INTEGRATORS:
        raise SurfaceError(f"expected an integrator among {', '.join(INTEGRATORS)}, got {method!r}")
    if mask is None:
        _check_finite(n)
        _check_direction(n)
        return n, None
    inside = np.asarray(mask)
    if inside.shape != n.shape[:2] or inside.dtype != np.bool_:
        raise SurfaceError(f"expected a bool mask of shape {n.shape[:2]}, got {inside.dtype} {inside.shape}")
    if not inside.any():
        raise SurfaceError("expected a mask with at least one pixel, got an empty one")
    if not inside.all():
        n = np.where(inside[..., None], n, np.float32(0))
    _check_finite(n)
    _check_direction(n)
    return n, None if inside.all() else inside


def _check_direction(n: FloatArray) -> None:
    """Raise SurfaceError where most normals point away from the camera: those of another convention."""
    z = n[..., 2]
    away, toward = np.count_nonzero(z < 0), np.count_nonzero(z > 0)
    if away > toward:
        raise SurfaceError(
            f"expected normals with z toward the camera, got {away} of {away + toward} that point away: "
            "turn their sign"
        )


def _check_finite(n: FloatArray) -> None:
    if not np.isfinite(n.sum(dtype=np.float64)):  # one pass; where it went wrong is looked up only then
        bad = int(np.count_nonzero(~np.isfinite(n).all(axis=2)))
        raise SurfaceError(f"expected finite normals, got {bad} pixels that hold NaN or infinity")
