"""Pixels that were not measured, filled in from those about them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from rumu.surface.stereo import gradients_from_normals, normals_from_gradients
from rumu.values import BoolArray, FloatArray, IntArray

_BAND = 2_000_000
"""Pixels whose slopes are averaged at a time."""


def fill_holes(normals: FloatArray, albedo: FloatArray, *, known: BoolArray, within: BoolArray) -> None:
    """Give each unknown pixel of `within` what lies between the known ones near it; both arrays change.

    normals: (H, W, 3) float32, of which slopes are averaged; outside `within` they become flat. albedo:
    (H, W) or (H, W, 3) float32. known, within: (H, W). Averages are taken in ever coarser cells until every
    cell holds a known pixel.
    """
    holes = np.flatnonzero(within & ~known)
    if holes.size:
        p, q = (_blend(normals, known, holes, of=partial(_slope, axis=axis)) for axis in (0, 1))
        normals.reshape(-1, 3)[holes] = normals_from_gradients(p, q)
        if albedo.ndim == 2:
            albedo.reshape(-1)[holes] = np.clip(_blend(albedo, known, holes, of=np.asarray), 0.0, 1.0)
        else:
            for channel in range(3):
                one = _blend(albedo[..., channel], known, holes, of=np.asarray)
                albedo[..., channel].flat[holes] = np.clip(one, 0.0, 1.0)
    if not within.all():
        normals[~within] = (0, 0, 1)


def _slope(normals: FloatArray, *, axis: int) -> FloatArray:
    """P or q, (h, W), of some rows of normals."""
    return gradients_from_normals(normals)[axis]


def _blend(
    values: FloatArray, known: BoolArray, holes: IntArray, *, of: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """(K,) float32: what lies between known values where there are none.

    values: (H, W, ...), of which `of` makes what is blended, (H, W). holes: numbers of the unknown pixels.
    """
    width, sums = known.shape[1], []
    step = max(2, _BAND // width // 2 * 2)
    for top in range(0, len(known), step):
        inside = known[top : top + step]
        part = np.where(inside, of(values[top : top + step]), 0.0).astype(np.float32)
        sums.append((_halve(part), _halve(inside.astype(np.float32))))
    total, weight = (np.concatenate(parts) for parts in zip(*sums, strict=True))
    rows, columns = np.divmod(holes, width)
    return np.asarray(_push_pull(total, weight)[rows // 2, columns // 2])


def _push_pull(total: FloatArray, weight: FloatArray) -> FloatArray:
    """Push-pull: means of known values, from the coarser half-size picture where there are none."""
    here = total / np.maximum(weight, 1e-6)
    if weight.min() > 0 or max(weight.shape) == 1:
        return here
    coarse = _push_pull(_halve(total), _halve(weight))
    wide = coarse.repeat(2, axis=0).repeat(2, axis=1)[: weight.shape[0], : weight.shape[1]]
    trust = np.minimum(weight, 1.0)
    return trust * here + (1.0 - trust) * wide


def _halve(values: FloatArray) -> FloatArray:
    padded = np.pad(values, [(0, side % 2) for side in values.shape])
    h, w = padded.shape
    return np.asarray(padded.reshape(h // 2, 2, w // 2, 2).sum(axis=(1, 3)))
