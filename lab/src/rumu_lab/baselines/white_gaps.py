"""The white between neighbouring strokes, and the ink in an elastic mesh of nine cells (九宫).

Our reconstruction of what AEST calls distribution; only the word is known from its abstract.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from rumu.values import BoolArray, FloatArray, IntArray
from rumu_lab.baselines.lines import StrokeLine

Gaps = Mapping[tuple[int, int], float]
"""Mean white between two lines, numbered lower first, in sides of the picture."""


def white_gaps(ink: BoolArray, lines: Sequence[StrokeLine], *, least: float) -> Gaps:
    """The gaps between lines that face each other across white, along rows or along columns.

    ink: (S, S) bool. lines: in its pixels; a pixel belongs to the line nearest to it. least: pixels over
    which two must face each other to be neighbours. Of rows and columns those count in which they face
    longer.
    """
    side, n = ink.shape[0], len(lines)
    found: dict[tuple[int, int], tuple[int, float]] = {}
    for turned in (False, True):
        first, last, length = _white_runs(ink.T if turned else ink)
        places = [
            p[:, ::-1] if turned else p for p in (first, last)
        ]  # (row, column) of the ink at both sides
        one, two = (_nearest_line(p, lines) for p in places)
        code = np.minimum(one, two) * n + np.maximum(one, two)
        count = np.bincount(code, minlength=n * n)
        total = np.bincount(code, length, minlength=n * n)
        for pair in np.flatnonzero(count >= least):
            i, j = divmod(int(pair), n)
            if i != j and count[pair] > found.get((i, j), (0, 0.0))[0]:
                found[i, j] = int(count[pair]), float(total[pair] / count[pair]) / side
    return {pair: gap for pair, (_, gap) in sorted(found.items())}


def _white_runs(ink: BoolArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Runs of white between ink in each row: (k, 2) the ink pixel before, the one after, and (k,) lengths."""
    step = np.diff(np.pad(ink, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row_on, on = np.nonzero(step == 1)  # first pixel of each run of ink
    row_off, off = np.nonzero(step == -1)  # one past its last
    same = row_on[1:] == row_off[:-1]
    before = np.column_stack([row_off[:-1], off[:-1] - 1])[same]
    after = np.column_stack([row_on[1:], on[1:]])[same]
    return before, after, (on[1:] - off[:-1])[same].astype(float)


def _nearest_line(places: IntArray, lines: Sequence[StrokeLine]) -> IntArray:
    """(k,) number of the line whose centre is nearest to each pixel (row, column)."""
    from scipy.spatial import cKDTree

    if len(places) == 0:
        return np.zeros(0, dtype=np.intp)
    points = np.concatenate([line.points for line in lines])
    owner = np.repeat(np.arange(len(lines)), [len(line.points) for line in lines])
    return np.asarray(owner[cKDTree(points).query(places[:, ::-1])[1]])


def elastic_shares(mass: FloatArray, lines: tuple[FloatArray, FloatArray]) -> FloatArray:
    """(9,) share of the ink in each cell of a mesh. mass: (H, W), 0 or more, not all 0.

    lines: inner lines of the mesh, two rows and two columns, in pixels, fractions of a pixel shared.
    """
    rows, columns = (_weights(cuts, length) for cuts, length in zip(lines, mass.shape, strict=True))
    return np.asarray((rows @ mass @ columns.T).ravel() / mass.sum())


def _weights(cuts: FloatArray, length: int) -> FloatArray:
    """(3, length) how much of each pixel lies in each third."""
    edges = np.concatenate([[0.0], np.clip(cuts, 0.0, length), [float(length)]])
    start = np.arange(length)[None]
    return np.asarray(
        np.clip(np.minimum(edges[1:, None], start + 1) - np.maximum(edges[:-1, None], start), 0, 1)
    )


def mesh_of(mass: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The elastic mesh of a character: lines that leave a third of the ink on each side, rows and columns."""
    return _thirds(mass.sum(axis=1)), _thirds(mass.sum(axis=0))


def _thirds(profile: FloatArray) -> FloatArray:
    """(2,) places with a third and two thirds of the profile before them."""
    total = np.concatenate([[0.0], np.cumsum(profile)]) / profile.sum()
    goals, places = np.array([1.0, 2.0]) / 3.0, np.arange(len(total), dtype=float)
    rising = total + 1e-9 * places
    return np.asarray(np.interp(goals, rising, places))
