"""The search of `rumu.surface.reflectance`, compiled with numba: the same steps, 32-bit floats, in lanes.

Many pixels are worked on side by side, as in `rumu.surface.kernels`. `limits` is told throughout: squared
proportional error, squared width, darkness at the start, longest step, and the step at which a pixel has
settled. A kernel's cache notices changes of its own file alone, so this file calls none of
`rumu.surface.kernels`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

LANES = 64
"""Pixels that are worked on side by side."""
GLOSS, METAL, ROUGH = 0, 1, 2
"""Kinds of material, see `rumu.surface.reflectance.Material`."""

_MATH = {"contract", "arcp", "nsz", "reassoc"}
_kernel: Any = njit(nogil=True, cache=True, fastmath=_MATH, error_model="numpy")

_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_APART = np.float32(0.01)  # radians over which derivatives are taken
_DAMPING = np.float32(1e-3)  # of the first step
_EDGE = np.float32(0.05)  # least nz of a normal


@_kernel
def _reflect(kind: int, roughness: Any, share: Any, normals: Any, lamps: Any, shape: Any) -> None:
    """Write what a material of brightness 1 shows in every lane under every lamp.

    normals: (3 * LANES,). lamps: (N, 6), directions and halfway directions. shape: (N, LANES).
    """
    a2 = roughness * roughness
    seen = np.empty(LANES, np.float32)
    for j in range(LANES):
        z = max(normals[2 * LANES + j], np.float32(1e-3))
        seen[j] = z if kind == ROUGH else np.float32(0.5) * a2 / (z + np.sqrt(a2 + (_ONE - a2) * z * z))
    of_lobe = _ONE if kind == METAL else share
    of_facing = _ZERO if kind == METAL else _ONE
    for i in range(lamps.shape[0]):
        x, y, z = lamps[i, 0], lamps[i, 1], lamps[i, 2]
        hx, hy, hz = lamps[i, 3], lamps[i, 4], lamps[i, 5]
        out = shape[i]
        if kind == ROUGH:
            for j in range(LANES):
                facing = normals[j] * x + normals[LANES + j] * y + normals[2 * LANES + j] * z
                facing = max(facing, _ZERO)
                grazing = _TWO * facing / (facing + seen[j])
                out[j] = (_ONE - share) * facing + share * grazing
        else:
            for j in range(LANES):
                facing = normals[j] * x + normals[LANES + j] * y + normals[2 * LANES + j] * z
                facing = max(facing, _ZERO)
                halfway = normals[j] * hx + normals[LANES + j] * hy + normals[2 * LANES + j] * hz
                spread = halfway * halfway * (a2 - _ONE) + _ONE
                masked = _TWO * facing / (facing + np.sqrt(a2 + (_ONE - a2) * facing * facing))
                out[j] = of_facing * facing + of_lobe * seen[j] * masked / (spread * spread)


@_kernel
def _rescale(
    values: Any, noise2: Any, shape: Any, limits: Any, brightness: Any, above: Any, below: Any
) -> None:
    """One reweighting of the brightness of every lane. above, below: (LANES,), written over."""
    proportional2, width2 = limits[0], limits[1]
    for j in range(LANES):
        above[j], below[j] = _ZERO, np.float32(1e-20)
    for i in range(values.shape[0]):
        for j in range(LANES):
            shown = brightness[j] * shape[i, j]
            variance = noise2[j] + proportional2 * shown * shown
            off = values[i, j] - shown
            agrees = width2 * variance / (width2 * variance + off * off)
            weight = agrees * agrees / variance if values[i, j] >= _ZERO else _ZERO
            above[j] += weight * shape[i, j] * values[i, j]
            below[j] += weight * shape[i, j] * shape[i, j]
    for j in range(LANES):
        brightness[j] = above[j] / below[j]


@_kernel
def _first_brightness(
    values: Any, noise2: Any, shape: Any, limits: Any, brightness: Any, above: Any, below: Any
) -> None:
    """The brightness of every lane from what is not dark, by least squares."""
    for j in range(LANES):
        above[j], below[j] = _ZERO, np.float32(1e-20)
    for i in range(values.shape[0]):
        for j in range(LANES):
            value = values[i, j]
            weight = _ONE / (noise2[j] + limits[0] * value * value) if value > limits[2] else _ZERO
            above[j] += weight * shape[i, j] * value
            below[j] += weight * shape[i, j] * shape[i, j]
    for j in range(LANES):
        brightness[j] = above[j] / below[j]


@_kernel
def _contradict(values: Any, noise2: Any, shape: Any, limits: Any, brightness: Any, found: Any) -> None:
    """Write the share of the lamps that tell anything that contradict, in every lane."""
    proportional2, width2, dark = limits[0], limits[1], limits[2]
    count = np.zeros(LANES, np.float32)
    for j in range(LANES):
        found[j] = _ZERO
    for i in range(values.shape[0]):
        for j in range(LANES):
            shown = brightness[j] * shape[i, j]
            limit = width2 * (noise2[j] + proportional2 * shown * shown)
            off = values[i, j] - shown
            telling = values[i, j] > dark or (shown > dark and values[i, j] >= _ZERO)
            found[j] += limit / (limit + off * off) if telling else _ZERO
            count[j] += _ONE if telling else _ZERO
    for j in range(LANES):
        found[j] = _ONE - found[j] / max(count[j], _ONE)


@_kernel
def _turn(normals: Any, along_u: Any, along_v: Any, turned: Any) -> None:
    """Write unit normals that lie beside others, by so much along two directions at right angles to each."""
    for j in range(LANES):
        x, y, z = normals[j], normals[LANES + j], normals[2 * LANES + j]
        a = -_ONE / (_ONE + z)
        b = x * y * a
        u, v = along_u[j], along_v[j]
        tx = x + u * (_ONE + x * x * a) + v * b
        ty = y + u * b + v * (_ONE + y * y * a)
        tz = max(z - u * x - v * y, _EDGE)
        length = _ONE / np.sqrt(tx * tx + ty * ty + tz * tz)
        turned[j], turned[LANES + j], turned[2 * LANES + j] = tx * length, ty * length, tz * length


@_kernel
def _step(
    values: Any, noise2: Any, shape: Any, by_u: Any, by_v: Any, brightness: Any, damping: Any, limits: Any,
    step_u: Any, step_v: Any, moved: Any, sums: Any,
) -> None:  # fmt: skip
    """Write a damped Gauss-Newton step of every lane: two turns, and the brightness after it.

    by_u, by_v: shapes under normals turned by `_APART`. sums: (9 * LANES,), written over.
    """
    proportional2, width2 = limits[0], limits[1]
    for a in range(9 * LANES):
        sums[a] = _ZERO
    for i in range(values.shape[0]):
        for j in range(LANES):
            g = shape[i, j]
            shown = brightness[j] * g
            variance = noise2[j] + proportional2 * shown * shown
            off = values[i, j] - shown
            agrees = width2 * variance / (width2 * variance + off * off)
            weight = agrees * agrees / variance if values[i, j] >= _ZERO else _ZERO
            du = brightness[j] * (by_u[i, j] - g) / _APART
            dv = brightness[j] * (by_v[i, j] - g) / _APART
            wu, wv, wg = weight * du, weight * dv, weight * g
            sums[j] += wu * du
            sums[LANES + j] += wu * dv
            sums[2 * LANES + j] += wu * g
            sums[3 * LANES + j] += wv * dv
            sums[4 * LANES + j] += wv * g
            sums[5 * LANES + j] += wg * g
            sums[6 * LANES + j] += wu * off
            sums[7 * LANES + j] += wv * off
            sums[8 * LANES + j] += wg * off
    for j in range(LANES):
        xx, xy, xz = np.float64(sums[j]), np.float64(sums[LANES + j]), np.float64(sums[2 * LANES + j])
        yy, yz = np.float64(sums[3 * LANES + j]), np.float64(sums[4 * LANES + j])
        zz = np.float64(sums[5 * LANES + j])
        ridge = 1e-9 * max(xx, yy, zz) + 1e-20
        grown = 1.0 + np.float64(damping[j])
        xx, yy, zz = grown * xx + ridge, grown * yy + ridge, grown * zz + ridge
        cxx, cxy, cxz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        cyy, cyz, czz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
        share = 1.0 / max(xx * cxx + xy * cxy + xz * cxz, 1e-90)
        p, q, r = (
            np.float64(sums[6 * LANES + j]),
            np.float64(sums[7 * LANES + j]),
            np.float64(sums[8 * LANES + j]),
        )
        u, v = (cxx * p + cxy * q + cxz * r) * share, (cxy * p + cyy * q + cyz * r) * share
        lighter = (cxz * p + cyz * q + czz * r) * share
        shorter = min(1.0, np.float64(limits[3]) / max(np.sqrt(u * u + v * v), 1e-12))
        step_u[j], step_v[j] = np.float32(shorter * u), np.float32(shorter * v)
        moved[j] = np.float32(max(np.float64(brightness[j]) + shorter * lighter, 0.0))


@_kernel
def _keep(found: Any, moved: Any, turned: Any, damping: Any, best: Any, bright: Any, now: Any) -> None:
    """Take what was tried where it is contradicted less, and damp the next step by whether it was."""
    for j in range(LANES):
        wins = found[j] < best[j]
        damping[j] *= np.float32(0.3) if wins else np.float32(10)
        best[j] = found[j] if wins else best[j]
        bright[j] = moved[j] if wins else bright[j]
        for axis in range(3):
            at = axis * LANES + j
            now[at] = turned[at] if wins else now[at]


@_kernel
def _load(values: Any, first: int, count: int, lanes: Any) -> None:
    """Take the values (N, P) of `count` pixels from `first` on into lanes (N, LANES), the last one again."""
    for i in range(values.shape[0]):
        for j in range(LANES):
            lanes[i, j] = values[i, first + min(j, count - 1)]


@_kernel
def fit(
    values: Any, noise: Any, lamps: Any, starts: Any, kind: int, roughness: Any, share: Any, limits: Any,
        rounds: int,
    normals: Any, brightness: Any, contradicted: Any,
) -> None:  # fmt: skip
    """Write the normal of each pixel under which a material explains most; see `reflectance.fit_material`.

    values: (N, P), -1 where overexposed. noise: (P,) squared. starts: (S, 3, P). normals: (3, P); brightness,
        contradicted: (P,).
    """
    _rate_starts(
        values, noise, lamps, starts, kind, roughness, share, limits, normals, brightness, contradicted
    )
    _improve(values, noise, lamps, kind, roughness, share, limits, rounds, normals, brightness, contradicted)


@_kernel
def _rate_starts(
    values: Any, noise: Any, lamps: Any, starts: Any, kind: int, roughness: Any, share: Any, limits: Any,
    normals: Any, brightness: Any, contradicted: Any,
) -> None:  # fmt: skip
    """Write the best of the starts of each pixel, with its brightness and what contradicts it."""
    n, pixels = values.shape
    lanes, shape = np.empty((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    now, turned = np.empty(3 * LANES, np.float32), np.empty(3 * LANES, np.float32)
    bright, moved = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    best, found = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    above, below = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    noise2, damping = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    for first in range(0, pixels, LANES):
        count = min(LANES, pixels - first)
        _load(values, first, count, lanes)
        for j in range(LANES):
            best[j], damping[j] = _TWO, _ONE
            noise2[j] = noise[first + min(j, count - 1)]
        for k in range(starts.shape[0]):
            for axis in range(3):
                for j in range(LANES):
                    turned[axis * LANES + j] = starts[k, axis, first + min(j, count - 1)]
            _reflect(kind, roughness, share, turned, lamps, shape)
            _first_brightness(lanes, noise2, shape, limits, moved, above, below)
            _rescale(lanes, noise2, shape, limits, moved, above, below)
            _contradict(lanes, noise2, shape, limits, moved, found)
            _keep(found, moved, turned, damping, best, bright, now)
        for j in range(count):
            p = first + j
            brightness[p], contradicted[p] = bright[j], best[j]
            for axis in range(3):
                normals[axis, p] = now[axis * LANES + j]


@_kernel
def _improve(
    values: Any, noise: Any, lamps: Any, kind: int, roughness: Any, share: Any, limits: Any, rounds: int,
    normals: Any, brightness: Any, contradicted: Any,
) -> None:  # fmt: skip
    """Improve on each pixel's normal, until a step is too short to matter; then the next takes its lane."""
    n, pixels = values.shape
    lanes, shape = np.ones((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    by_u, by_v = np.empty((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    now, turned = np.ones(3 * LANES, np.float32), np.empty(3 * LANES, np.float32)
    bright, moved = np.ones(LANES, np.float32), np.empty(LANES, np.float32)
    best, found = np.zeros(LANES, np.float32), np.empty(LANES, np.float32)
    step_u, step_v = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    above, below = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    apart, nothing = np.full(LANES, _APART, np.float32), np.zeros(LANES, np.float32)
    noise2, damping = np.ones(LANES, np.float32), np.ones(LANES, np.float32)
    sums = np.empty(9 * LANES, np.float32)
    pixel, age = np.full(LANES, -1, np.int64), np.zeros(LANES, np.int32)
    busy = min(LANES, pixels) if rounds > 0 else 0
    following = busy
    for j in range(busy):
        pixel[j] = j
        _take(values, noise, normals, brightness, contradicted, j, j, lanes, noise2, now, bright, best)
        damping[j] = _DAMPING
    while busy > 0:
        _reflect(kind, roughness, share, now, lamps, shape)
        _turn(now, apart, nothing, turned)
        _reflect(kind, roughness, share, turned, lamps, by_u)
        _turn(now, nothing, apart, turned)
        _reflect(kind, roughness, share, turned, lamps, by_v)
        _step(lanes, noise2, shape, by_u, by_v, bright, damping, limits, step_u, step_v, moved, sums)
        _turn(now, step_u, step_v, turned)
        _reflect(kind, roughness, share, turned, lamps, shape)
        _rescale(lanes, noise2, shape, limits, moved, above, below)
        _contradict(lanes, noise2, shape, limits, moved, found)
        _keep(found, moved, turned, damping, best, bright, now)
        for j in range(LANES):
            p = pixel[j]
            age[j] += 1
            if p < 0 or (age[j] < rounds and max(abs(step_u[j]), abs(step_v[j])) > limits[4]):
                continue
            brightness[p], contradicted[p] = bright[j], best[j]
            for axis in range(3):
                normals[axis, p] = now[axis * LANES + j]
            if following < pixels:
                pixel[j], age[j], damping[j] = following, 0, _DAMPING
                _take(
                    values, noise, normals, brightness, contradicted, following, j, lanes, noise2, now,
                    bright, best,
                )  # fmt: skip
                following += 1
            else:
                pixel[j], busy = -1, busy - 1


@_kernel
def _take(
    values: Any, noise: Any, normals: Any, brightness: Any, contradicted: Any, p: int, j: int, lanes: Any,
    noise2: Any, now: Any, bright: Any, best: Any,
) -> None:  # fmt: skip
    """Put pixel p, as it stands, into lane j."""
    for i in range(values.shape[0]):
        lanes[i, j] = values[i, p]
    noise2[j], bright[j], best[j] = noise[p], brightness[p], contradicted[p]
    for axis in range(3):
        now[axis * LANES + j] = normals[axis, p]


@_kernel
def doubt(
    values: Any,
    noise: Any,
    lamps: Any,
    normals: Any,
    limits: Any,
    exact: Any,
    contradicted: Any,
    doubtful: Any,
) -> None:
    """Write how far each pixel contradicts Lambert's law, and where it is in doubt; see `reflectance.doubt`.

    values: (N, P), -1 where overexposed. noise: (P,) squared. normals: (3, P). exact: over the noise.
    contradicted: (P,) float32, doubtful: (P,) bool, written.
    """
    n, pixels = values.shape
    lanes, shape = np.empty((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    now, bright = np.empty(3 * LANES, np.float32), np.empty(LANES, np.float32)
    above, below = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    noise2, found = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    near, telling = np.empty(LANES, np.int32), np.empty(LANES, np.int32)
    dark, within = limits[2], exact * exact
    for first in range(0, pixels, LANES):
        count = min(LANES, pixels - first)
        _load(values, first, count, lanes)
        for j in range(LANES):
            p = first + min(j, count - 1)
            noise2[j], near[j], telling[j] = noise[p], 0, 0
            for axis in range(3):
                now[axis * LANES + j] = normals[axis, p]
        _reflect(ROUGH, _ONE, _ZERO, now, lamps, shape)
        _first_brightness(lanes, noise2, shape, limits, bright, above, below)
        _rescale(lanes, noise2, shape, limits, bright, above, below)
        _contradict(lanes, noise2, shape, limits, bright, found)
        for i in range(n):
            for j in range(LANES):
                shown = bright[j] * shape[i, j]
                off = lanes[i, j] - shown
                tells = lanes[i, j] > dark or (shown > dark and lanes[i, j] >= _ZERO)
                telling[j] += 1 if tells else 0
                near[j] += 1 if tells and off * off <= within * noise2[j] else 0
        for j in range(count):
            contradicted[first + j] = found[j]
            doubtful[first + j] = telling[j] > 0 and near[j] < (telling[j] - 1) // 2 + 1
