"""Which line of a copy is which of the reference, once both lie in one frame.

Skeletons cut strokes differently: a fork moved by a pixel joins two lines or parts one. So each set is first
cut where the other one ends a line that runs on in the same direction; then lines are paired one to one.
Our own; the publications that need such pairs do not say in their abstracts how they came by them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rumu.values import FloatArray, IntArray
from rumu_lab.baselines.lines import StrokeLine

SAMPLES = 16
"""Points along each line at which two lines are compared."""


@dataclass(frozen=True, slots=True)
class PairSettings:
    """How near and how parallel lines must be.

    near: how far, in stroke widths, an end may lie from the line that it cuts; parallel: degrees between
    them; least: shortest piece that is cut off, in stroke widths. far, askew: distance of middles in cells
    and degrees beyond which two lines are never a pair.
    """

    near: float = 1.5
    parallel: float = 30.0
    least: float = 1.5
    far: float = 0.2
    askew: float = 45.0


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """n lines sampled alike. points: (n, SAMPLES, 2), in cells. radius: (n, SAMPLES). length: (n,).

    direction: (n,) degrees of the chord, modulo 180.
    """

    points: FloatArray
    radius: FloatArray
    length: FloatArray
    direction: FloatArray


def curves_of(lines: Sequence[StrokeLine]) -> Curves:
    """Lines sampled at equal steps of their length."""
    shares = np.linspace(0.0, 1.0, SAMPLES)
    points = np.array([line.at(shares) for line in lines]).reshape(-1, SAMPLES, 2)
    radius = np.array([line.radius_at(shares) for line in lines]).reshape(-1, SAMPLES)
    chords = points[:, -1] - points[:, 0]
    direction = np.degrees(np.arctan2(chords[:, 1], chords[:, 0])) % 180.0
    return Curves(points, radius, np.array([line.length for line in lines]), direction)


def cut_alike(
    one: Sequence[StrokeLine],
    two: Sequence[StrokeLine],
    *,
    width: float,
    settings: PairSettings | None = None,
) -> tuple[list[StrokeLine], list[StrokeLine]]:
    """Both sets cut where the other set's lines end and its own run on; width: of a stroke, same unit."""
    settings = settings or PairSettings()
    return _cut_at_ends(one, two, width, settings), _cut_at_ends(two, one, width, settings)


def _cut_at_ends(
    lines: Sequence[StrokeLine], others: Sequence[StrokeLine], width: float, settings: PairSettings
) -> list[StrokeLine]:
    ends = np.concatenate([[line.points[0], line.points[-1]] for line in others])
    tangents = np.concatenate([_tangents(line, width)[[0, -1]] for line in others])
    found: list[StrokeLine] = []
    for line in lines:
        along, own = line.along, _tangents(line, width)
        gaps = np.linalg.norm(line.points[:, None] - ends[None], axis=-1)
        nearest = gaps.argmin(axis=0)
        agree = np.abs((own[nearest] * tangents).sum(axis=1)) >= np.cos(np.radians(settings.parallel))
        close = gaps.min(axis=0) <= settings.near * width
        found += _parts(line, along, nearest[agree & close], settings.least * width)
    return found


def _parts(line: StrokeLine, along: FloatArray, places: IntArray, least: float) -> list[StrokeLine]:
    cuts: list[int] = []
    for place in sorted({int(p) for p in places}):
        before = along[cuts[-1]] if cuts else 0.0
        if along[place] - before >= least and along[-1] - along[place] >= least:
            cuts.append(place)
    marks = [0, *cuts, len(line.points) - 1]
    return [line.part(a, b) for a, b in pairwise(marks)]


def _tangents(line: StrokeLine, width: float) -> FloatArray:
    """(n, 2) unit directions at each point, over chords of a stroke's width to both sides."""
    along = line.along
    ahead, behind = (
        np.column_stack([np.interp(along + s * width, along, v) for v in line.points.T]) for s in (1, -1)
    )
    way = ahead - behind
    return np.asarray(way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12))


def orient(copy: Curves, reference: Curves) -> tuple[FloatArray, FloatArray]:
    """Each line of the copy as it runs beside each line of the reference.

    (n, m, SAMPLES, 2) points and (n, m, SAMPLES) half-widths of copy line j as it runs beside line i of
    the reference, turned where its ends are nearer so.
    """
    straight = _end_gaps(copy.points, reference.points)
    back = (_end_gaps(copy.points[:, ::-1], reference.points) < straight)[..., None]
    points = np.where(back[..., None], copy.points[None, :, ::-1], copy.points[None])
    return points, np.where(back, copy.radius[None, :, ::-1], copy.radius[None])


def _end_gaps(copy: FloatArray, reference: FloatArray) -> FloatArray:
    gaps = np.linalg.norm(reference[:, None, [0, -1]] - copy[None, :, [0, -1]], axis=-1)
    return np.asarray(gaps.sum(axis=-1))


def directions_apart(reference: Curves, copy: Curves) -> FloatArray:
    """(n, m) degrees in [0, 90] between reference line i and copy line j, without regard to sense."""
    bend = np.abs(reference.direction[:, None] - copy.direction[None])
    return np.asarray(np.minimum(bend, 180.0 - bend))


def middles_apart(reference: Curves, copy: Curves) -> FloatArray:
    """(n, m) distance between the middles of reference line i and copy line j."""
    one, two = (c.points[:, SAMPLES // 2 - 1 : SAMPLES // 2 + 1].mean(axis=1) for c in (reference, copy))
    return np.asarray(np.linalg.norm(one[:, None] - two[None], axis=-1))


def pair_lines(
    worth: FloatArray, reference: Curves, copy: Curves, *, settings: PairSettings | None = None
) -> list[tuple[int, int]]:
    """One-to-one pairs (i, j) of most worth, each weighed by the mean length of its lines.

    worth: (n, m) in [0, 1], how good line j of the copy is as line i of the reference.
    """
    from scipy.optimize import linear_sum_assignment

    settings = settings or PairSettings()
    allowed = (directions_apart(reference, copy) <= settings.askew) & (
        middles_apart(reference, copy) <= settings.far
    )
    gain = np.where(allowed, worth * (reference.length[:, None] + copy.length[None]) / 2, 0.0)
    rows, columns = linear_sum_assignment(-gain)
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if gain[i, j] > 0]
