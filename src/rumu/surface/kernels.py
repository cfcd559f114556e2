"""The solvers of `rumu.surface.robust`, compiled with numba: the same steps in the same order, 32-bit floats.

Many pixels are worked on side by side, in lanes, so that the processor's vector instructions apply to them:
the inner loop always runs over lanes. A pixel whose normal has settled leaves its lane to the next one. The
median over the lamps comes from a sorting network (Batcher, "Sorting networks and their applications", 1968),
which exchanges the same pairs of lamps in every lane.

Nothing here starts threads: the caller does, since the lock of the interpreter is released throughout.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

LANES = 64
"""Pixels that are worked on side by side."""

_MATH = {"contract", "arcp", "nsz", "reassoc"}  # what lets the loops become vector instructions
_kernel: Any = njit(nogil=True, cache=True, fastmath=_MATH, error_model="numpy")

_ZERO, _ONE = np.float32(0), np.float32(1)
_TINY = np.float32(1e-12)
_TRACE = np.float32(1e-5)  # of trust in every value, so that a system stays solvable
_HUGE = np.float32(1e30)  # what is not to be counted, at the end of the order


# --- lanes -----------------------------------------------------------------------------------------


@_kernel
def _sort(lanes: Any, pairs: Any) -> None:
    """Order each lane (column) of (N, LANES) upward. pairs: (M, 2), the exchanges of a sorting network."""
    for k in range(pairs.shape[0]):
        low, high = lanes[pairs[k, 0]], lanes[pairs[k, 1]]
        for j in range(LANES):
            one, other = low[j], high[j]
            low[j] = one if one < other else other
            high[j] = other if one < other else one


@_kernel
def _accumulate(values: Any, i: int, trust: Any, lights: Any, sums: Any) -> None:
    """Add the lamps i and i + 1 to the nine sums of every lane, which halves how often the sums are moved.

    values: (N, LANES). trust: (2, LANES), in each lamp; of an odd number the last stands alone, and what
    is in the second row becomes 0. sums: (9 * LANES,).
    """
    k = min(i + 1, values.shape[0] - 1)
    one, other, first, second = values[i], values[k], trust[0], trust[1]
    if k == i:
        second[:] = _ZERO
    x, y, z = lights[i, 0], lights[i, 1], lights[i, 2]
    u, v, w = lights[k, 0], lights[k, 1], lights[k, 2]
    xx, xy, xz, yy, yz, zz = x * x, x * y, x * z, y * y, y * z, z * z
    uu, uv, uw, vv, vw, ww = u * u, u * v, u * w, v * v, v * w, w * w
    for j in range(LANES):
        a, b = first[j], second[j]
        lit, also = a * one[j], b * other[j]
        sums[j] += a * xx + b * uu
        sums[LANES + j] += a * xy + b * uv
        sums[2 * LANES + j] += a * xz + b * uw
        sums[3 * LANES + j] += a * yy + b * vv
        sums[4 * LANES + j] += a * yz + b * vw
        sums[5 * LANES + j] += a * zz + b * ww
        sums[6 * LANES + j] += lit * x + also * u
        sums[7 * LANES + j] += lit * y + also * v
        sums[8 * LANES + j] += lit * z + also * w


@_kernel
def _solve_lanes(sums: Any, scaled: Any) -> None:
    """Each lane's 3 x 3 system by cofactors, in 64 bits, since they cancel. scaled: (3 * LANES,)."""
    for j in range(LANES):
        xx, xy = np.float64(sums[j]), np.float64(sums[LANES + j])
        xz, yy = np.float64(sums[2 * LANES + j]), np.float64(sums[3 * LANES + j])
        yz, zz = np.float64(sums[4 * LANES + j]), np.float64(sums[5 * LANES + j])
        ridge = 1e-10 * (xx + yy + zz) + 1e-30
        xx, yy, zz = xx + ridge, yy + ridge, zz + ridge
        cxx, cxy, cxz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        cyy, cyz, czz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
        det = xx * cxx + xy * cxy + xz * cxz
        share = 1.0 / max(det, 1e-90)
        u, v, w = sums[6 * LANES + j], sums[7 * LANES + j], sums[8 * LANES + j]
        scaled[j] = np.float32((cxx * u + cxy * v + cxz * w) * share)
        scaled[LANES + j] = np.float32((cxy * u + cyy * v + cyz * w) * share)
        scaled[2 * LANES + j] = np.float32((cxz * u + cyz * v + czz * w) * share)


@_kernel
def _law(scaled: Any, x: Any, y: Any, z: Any, lit: Any) -> None:
    """Brightness of every lane under one lamp by Lambert's law; negative behind the surface."""
    for j in range(LANES):
        lit[j] = scaled[j] * x + scaled[LANES + j] * y + scaled[2 * LANES + j] * z


@_kernel
def _load(rows: Any, first: int, lanes: Any) -> int:
    """Fill the lanes with LANES pixels of rows (N, P) from `first` on; the last pixel fills what is left."""
    count: int = min(LANES, rows.shape[1] - first)
    for i in range(rows.shape[0]):
        row, lane = rows[i, first : first + count], lanes[i]
        for j in range(count):
            lane[j] = row[j]
        for j in range(count, LANES):
            lane[j] = row[count - 1]
    return count


# --- solvers -----------------------------------------------------------------------------------------


@_kernel
def scales(rows: Any, rank: int, pairs: Any, scale: Any) -> None:
    """Write how bright each pixel gets, the value of this rank over the lamps. rows: (N, P); scale: (P,).

    pairs: of a network that brings this rank to its place.
    """
    ordered = np.empty((rows.shape[0], LANES), np.float32)
    for first in range(0, rows.shape[1], LANES):
        count = _load(rows, first, ordered)
        _sort(ordered, pairs)
        for j in range(count):
            scale[first + j] = ordered[rank, j] + _TINY


@_kernel
def trimmed(rows: Any, lights: Any, low: int, high: int, pairs: Any, weights: Any, scaled: Any) -> None:
    """Weighted least squares on the values whose rank over the lamps is in low : high.

    Equal values rank in the order of their lamps. weights: (N, P), written; scaled: (3, P), written.
    """
    n, pixels = rows.shape
    values, ordered = np.empty((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    both, sums = np.empty((2, LANES), np.float32), np.empty(9 * LANES, np.float32)
    out = np.empty(3 * LANES, np.float32)
    seen_low, seen_high = np.empty(LANES, np.int32), np.empty(LANES, np.int32)
    for first in range(0, pixels, LANES):
        count = _load(rows, first, values)
        ordered[:] = values
        _sort(ordered, pairs)
        for j in range(LANES):
            seen_low[j], seen_high[j] = 0, 0
        for i in range(n):  # rank of the first value that equals a limit
            for j in range(LANES):
                seen_low[j] += 1 if values[i, j] < ordered[low, j] else 0
                seen_high[j] += 1 if values[i, j] < ordered[high - 1, j] else 0
        sums[:] = _ZERO
        for i in range(n):
            trust = both[i % 2]
            for j in range(LANES):
                at_low, at_high = values[i, j] == ordered[low, j], values[i, j] == ordered[high - 1, j]
                kept = ordered[low, j] <= values[i, j] <= ordered[high - 1, j]
                if (at_low and seen_low[j] < low) or (at_high and seen_high[j] >= high):
                    kept = False
                seen_low[j] += 1 if at_low else 0
                seen_high[j] += 1 if at_high else 0
                trust[j] = (_ONE if kept else _ZERO) + _TRACE
            for j in range(count):
                weights[i, first + j] = trust[j] - _TRACE
            if i % 2 or i == n - 1:
                _accumulate(values, i - i % 2, both, lights, sums)
        _solve_lanes(sums, out)
        for k in range(3):
            for j in range(count):
                scaled[k, first + j] = out[k * LANES + j]


@_kernel
def _l1_round(values: Any, lights: Any, inverse_width: Any, scaled: Any, both: Any, sums: Any) -> None:
    """One reweighting of all lanes for least absolute residuals; `sums` takes the system to solve."""
    n = values.shape[0]
    for a in range(9 * LANES):
        sums[a] = _ZERO
    for i in range(n):
        row, trust = values[i], both[i % 2]
        x, y, z = lights[i, 0], lights[i, 1], lights[i, 2]
        for j in range(LANES):
            off = row[j] - (scaled[j] * x + scaled[LANES + j] * y + scaled[2 * LANES + j] * z)
            off = off * inverse_width[j]
            trust[j] = _ONE / np.sqrt(_ONE + off * off) + _TRACE
        if i % 2 or i == n - 1:
            _accumulate(values, i - i % 2, both, lights, sums)


@_kernel
def _forgetting_round(
    values: Any, lights: Any, scale: Any, limits: Any, scaled: Any, order: Any, pairs: Any, spread: Any,
    both: Any, sums: Any,
) -> None:  # fmt: skip
    """One reweighting of all lanes with the loss that forgets outliers (Geman-McClure).

    limits: dark, noise squared, proportional, width, white. spread: (LANES,), written.
    """
    n = values.shape[0]
    dark, noise2, proportional, width, white = limits[0], limits[1], limits[2], limits[3], limits[4]
    counted = np.empty(LANES, np.int32)
    lit = np.empty(LANES, np.float32)
    for j in range(LANES):
        counted[j] = 0
    for i in range(n):
        row, out = values[i], order[i]
        _law(scaled, lights[i, 0], lights[i, 1], lights[i, 2], lit)
        for j in range(LANES):
            informative = lit[j] > _ZERO or row[j] > dark * scale[j]
            off = abs(row[j] - max(lit[j], _ZERO)) / scale[j]
            out[j] = off if informative else _HUGE
            counted[j] += 1 if informative else 0
    _sort(order, pairs)
    for j in range(LANES):
        middle = max(counted[j] - 1, 0) // 2
        spread[j] = np.float32(1.4826) * order[middle, j] if counted[j] > 0 else _ZERO
    for a in range(9 * LANES):
        sums[a] = _ZERO
    for i in range(n):
        row = values[i]
        _law(scaled, lights[i, 0], lights[i, 1], lights[i, 2], lit)
        _forgetting_trust(row, scale, lit, spread, dark, noise2, proportional, width, white, both[i % 2])
        if i % 2 or i == n - 1:
            _accumulate(values, i - i % 2, both, lights, sums)


@_kernel
def _forgetting_trust(
    row: Any, scale: Any, lit: Any, spread: Any, dark: Any, noise2: Any, proportional: Any, width: Any,
    white: Any, trust: Any,
) -> None:  # fmt: skip
    """Write the trust in one lamp's value of every lane, with the trace that all values have."""
    for j in range(LANES):
        inverse = _ONE / scale[j]
        facing = max(lit[j], _ZERO) * inverse
        off = row[j] * inverse - facing
        spread2 = width * spread[j]
        width2 = spread2 * spread2 + noise2 + proportional * proportional * facing * facing
        share = width2 / (width2 + off * off)
        informative = (lit[j] > _ZERO or row[j] > dark * scale[j]) and row[j] < white
        trust[j] = (share * share if informative else _ZERO) + _TRACE


@_kernel
def reweighted(
    rows: Any, lights: Any, scale: Any, pairs: Any, limits: Any, forgetting: bool, rounds: int, settled: Any,
    scaled: Any, spread: Any,
) -> None:  # fmt: skip
    """Reweight each pixel until its scaled normal moves by less than `settled` of its brightness.

    rows: (N, P); scale: (P,); limits: see `_forgetting_round`, and at its end one over the width of "l1".
    forgetting: the loss that forgets outliers, else least absolute residuals. rounds: most of a pixel.
    scaled: (3, P), where each pixel starts, and then its solution. spread: (P,), written when forgetting.
    """
    n, pixels = rows.shape
    values, order = np.zeros((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    now, new = np.zeros(3 * LANES, np.float32), np.empty(3 * LANES, np.float32)
    sums, trust = np.empty(9 * LANES, np.float32), np.empty((2, LANES), np.float32)
    bright, inverse_width = np.ones(LANES, np.float32), np.ones(LANES, np.float32)
    lane_spread = np.zeros(LANES, np.float32)
    pixel, age = np.full(LANES, -1, np.int64), np.zeros(LANES, np.int32)
    following, busy = 0, 0
    for j in range(min(LANES, pixels)):
        _take(rows, scale, scaled, following, j, values, bright, now)
        pixel[j], following, busy = following, following + 1, busy + 1
    while busy > 0:
        if forgetting:
            _forgetting_round(values, lights, bright, limits, now, order, pairs, lane_spread, trust, sums)
        else:
            for j in range(LANES):
                inverse_width[j] = limits[5] / bright[j]
            _l1_round(values, lights, inverse_width, now, trust, sums)
        _solve_lanes(sums, new)
        for j in range(LANES):
            moved = max(abs(new[j] - now[j]), abs(new[LANES + j] - now[LANES + j]))
            moved = max(moved, abs(new[2 * LANES + j] - now[2 * LANES + j])) / bright[j]
            now[j], now[LANES + j], now[2 * LANES + j] = new[j], new[LANES + j], new[2 * LANES + j]
            age[j] += 1
            p = pixel[j]
            if p >= 0 and (moved <= settled or age[j] >= rounds):
                for k in range(3):
                    scaled[k, p] = now[k * LANES + j]
                if forgetting:
                    spread[p] = lane_spread[j]
                age[j] = 0
                if following < pixels:
                    _take(rows, scale, scaled, following, j, values, bright, now)
                    pixel[j], following = following, following + 1
                else:
                    pixel[j], busy = -1, busy - 1


@_kernel
def _take(rows: Any, scale: Any, scaled: Any, p: int, j: int, values: Any, bright: Any, now: Any) -> None:
    """Put pixel p into lane j."""
    for i in range(rows.shape[0]):
        values[i, j] = rows[i, p]
    bright[j] = scale[p]
    for k in range(3):
        now[k * LANES + j] = scaled[k, p]


# --- what the solution rests on --------------------------------------------------------------------


@_kernel
def agreement(
    rows: Any, lights: Any, scale: Any, scaled: Any, dark: Any, floor: Any, pairs: Any, full: Any,
    stride: int, confidence: Any, sampled: Any,
) -> int:  # fmt: skip
    """Write the confidence of each pixel, and a sample of residuals; returns how many values are lit.

    full: determinant of the sum of all lamps' outer products. sampled: (N, ceil(P / stride)), the residuals
    of every `stride`-th pixel in shares of its brightness, negative where not lit.
    """
    n, pixels = rows.shape
    values, order = np.empty((n, LANES), np.float32), np.empty((n, LANES), np.float32)
    now, sums = np.empty(3 * LANES, np.float32), np.empty(9 * LANES, np.float32)
    inverse, least = np.empty(LANES, np.float32), np.empty(LANES, np.float32)
    both, counted = np.empty((2, LANES), np.float32), np.empty(LANES, np.float32)
    share = np.empty(LANES, np.float32)
    total = 0
    for first in range(0, pixels, LANES):
        count = _load(rows, first, values)
        for j in range(LANES):
            p = first + min(j, count - 1)
            inverse[j], least[j], counted[j] = _ONE / scale[p], max(dark * scale[p], floor), _ZERO
            for k in range(3):
                now[k * LANES + j] = scaled[k, p]
        for a in range(9 * LANES):
            sums[a] = _ZERO
        for i in range(n):
            row, out, trust = values[i], order[i], both[i % 2]
            x, y, z = lights[i, 0], lights[i, 1], lights[i, 2]
            for j in range(LANES):
                lit = now[j] * x + now[LANES + j] * y + now[2 * LANES + j] * z
                off = abs(row[j] - (lit if lit > _ZERO else _ZERO)) * inverse[j]
                near = off * np.float32(20)
                close, shines = _ONE / (_ONE + near * near), row[j] > least[j]
                out[j] = off if shines else _HUGE
                trust[j] = close if shines else _ZERO
                counted[j] += _ONE if shines else _ZERO
            if i % 2 or i == n - 1:
                _accumulate(values, i - i % 2, both, lights, sums)
        for p in range(first + (-first) % stride, first + count, stride):
            for i in range(n):
                off = order[i, p - first]
                sampled[i, p // stride] = off if off < _HUGE else -_ONE
        _sort(order, pairs)
        for j in range(LANES):
            xx, xy, xz = np.float64(sums[j]), np.float64(sums[LANES + j]), np.float64(sums[2 * LANES + j])
            yy, yz = np.float64(sums[3 * LANES + j]), np.float64(sums[4 * LANES + j])
            zz = np.float64(sums[5 * LANES + j])
            span = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
            share[j] = np.float32(min(max(span / full, 0.0), 1.0))
        for j in range(count):
            seen = int(counted[j])
            total += seen
            typical = np.float32(20) * (order[max(seen - 1, 0) // 2, j] if seen > 0 else _ZERO)
            confidence[first + j] = share[j] ** np.float32(1.0 / 3.0) / (_ONE + typical * typical)
    return total
