"""Lines of the master laid on lines of the copy: first by one smooth warp, then each stroke by itself.

Expectation-maximisation after coherent point drift (Myronenko and Song 2010): each point of the copy is
softly assigned to the points of the master that may explain it, or to none; then the master's points move
to what was assigned to them. Ink that one stroke explains is not available to another, so a stroke that the
copy lacks finds nothing and stays where its neighbours suggest. Positions in rms radii, see `centre_lines`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import LinePoints
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class MatchSettings:
    """How lines are laid on lines. Lengths in rms radii unless said.

    warp_sigmas, stroke_sigmas: standard deviations of the expected distance: while all strokes move by one
        warp, and while each moves by itself.
    grid: knots of the warp along each axis; knot_reach: standard deviation of the bump at a knot.
    partings: shares of the extent, along each axis, at which the warp may bend sharply: a part that is
        too wide bends it there and nowhere else.
    shift_cost, affine_cost, bend_cost: ridge penalties of the warp on shifts, affine moves and bending, in
        points; shifts and affine moves are small, since the strokes are registered already.
    warp_penalties: ridge penalties, in points, of a stroke that takes on the warp: on turning or stretching,
        and on shifting.
    stroke_travel, stroke_turn: how far a stroke is expected to leave the warp, and to turn or stretch;
        stroke_penalty: how much that expectation is trusted, in points.
    crossing_penalty: of a perpendicular direction, in the exponent. outlier_sigmas: standard deviations from
        which a point counts as explained by nothing. gather_sigmas: standard deviations over which a line
        gathers points: several of its points contribute to a point beside it.
    fork_weight: weight of a point near a fork when lines settle on their ink, since thinning pulls lines
        together there; settle_penalty, settle_turn_penalty: points' worth of ink that hold a line where it
        was, and as it was turned. settle_reach: distance from its line beyond which ink hardly counts then.
    """

    warp_sigmas: tuple[float, ...] = (0.22, 0.18, 0.15, 0.12)
    stroke_sigmas: tuple[float, ...] = (0.14, 0.12, 0.1, 0.085, 0.07, 0.06, 0.05)
    grid: int = 4
    knot_reach: float = 1.0
    partings: tuple[float, ...] = (0.35, 0.5, 0.65)
    shift_cost: float = 5.0
    affine_cost: float = 20.0
    bend_cost: float = 30.0
    warp_penalties: tuple[float, float] = (1.0, 1e-3)
    stroke_travel: float = 0.2
    stroke_turn: float = 0.25
    stroke_penalty: float = 6.0
    crossing_penalty: float = 2.5
    outlier_sigmas: float = 2.6
    gather_sigmas: float = 2.5
    fork_weight: float = 0.05
    settle_penalty: float = 1.0
    settle_turn_penalty: float = 0.05
    settle_reach: float = 0.03


@dataclass(frozen=True, slots=True)
class CoverSettings:
    """When a point of the copy belongs to a stroke, and when a point of the master is found.

    min_explained: responsibility of all strokes together from which a point of the copy belongs to the
        strongest. min_ink: points' worth of ink, from which a point of the master has some of its own.
    min_reach_spacings: reach of a stroke at least, in distances between neighbouring points; beside_factor:
        reach, over the reach of a stroke, within which a point of the copy may belong to it.
    explained_slope, ink_slope, reach_slope: how far below and above these limits a point counts in part where
        points are weighed, of the reaches as a share of them.
    """

    min_explained: float = 0.4
    min_ink: float = 0.15
    min_reach_spacings: float = 1.6
    beside_factor: float = 1.5
    explained_slope: float = 0.2
    ink_slope: float = 0.1
    reach_slope: float = 0.3


COVER = CoverSettings()


@dataclass(frozen=True, slots=True, eq=False)
class LineMatch:
    """Where each point of the master's lines lies in the copy.

    moved: (n, 2) the master's points in the copy, stroke by stroke affine. responsibility: (n, m) how much
        each point of the copy belongs to each of the master's; columns sum to at most 1.
    """

    moved: FloatArray
    responsibility: FloatArray


def match_lines(master: LinePoints, copy: LinePoints, *, settings: MatchSettings | None = None) -> LineMatch:
    """Find the master's points in the copy."""
    s = settings or MatchSettings()
    y, double, ink = master.xy, master.double, SoughtInk(copy, s)
    basis, cost = _warp_basis(y, s)
    crossing = ink.crossing(double)
    for sigma in s.warp_sigmas:
        P = ink.responsibilities(y, crossing, sigma)
        y = master.xy + _fit_warp(master.xy, P, copy.xy, basis, cost * sigma**2)
    local, owner = _local_coordinates(master, master.xy), master.owner
    turn, shift = s.warp_penalties
    followed = _ridge(local, owner, np.ones(len(y)), y - master.xy, hold=np.diag([turn, turn, shift]))
    base = np.einsum("nj,njd->nd", local, followed[owner])
    directions = _Directions(master)
    for sigma in s.stroke_sigmas:
        P = ink.responsibilities(y, crossing, sigma)
        hold = (
            s.stroke_penalty
            * sigma**2
            * np.array([s.stroke_turn**-2, s.stroke_turn**-2, s.stroke_travel**-2])
        )
        weight = P.sum(axis=1)
        target = _weighted_mean(P, copy.xy, weight) - master.xy
        moves = followed + _ridge(local, owner, weight, target - base, hold=np.diag(hold))
        y = master.xy + np.einsum("nj,njd->nd", local, moves[owner])
        double = directions.turned(moves[owner, :2])
        crossing = ink.crossing(double)
    P = ink.responsibilities(y, crossing, s.stroke_sigmas[-1])
    return LineMatch(_settle(y, double, master, copy, responsibility=P, settings=s), P)


def find_covered(
    found: LineMatch, copy: LinePoints, master: LinePoints, *, near: float
) -> tuple[BoolArray, IntArray]:
    """Which of the master's points the copy has, and which stroke each of the copy's belongs to, or -1.

    near: rms radii within which ink is a stroke's own.
    """
    P, squared = found.responsibility, squared_distances(found.moved, copy.xy)
    owner = np.where(P.sum(axis=0) > COVER.min_explained, master.owner[P.argmax(axis=0)], -1)
    reach = max(near, COVER.min_reach_spacings * master.spacing)
    mine = owner[None, :] == master.owner[:, None]
    nearest = np.where(mine, squared, np.inf).min(axis=1)
    covered = (nearest < reach**2) & (P.sum(axis=1) > COVER.min_ink)
    owner = np.where(squared.min(axis=0) < (COVER.beside_factor * reach) ** 2, owner, -1)
    return np.asarray(covered), owner


def weigh_cover(
    found: LineMatch, copy: LinePoints, master: LinePoints, *, near: float
) -> tuple[FloatArray, FloatArray]:
    """How far the copy has each of the master's points, and strokes explain each of the copy's: 0 to 1.

    Where `find_covered` says yes or no, a point near a limit counts in part, so that sums of points hardly
    change when ink hardly does. near: as there.
    """
    P, away, c = found.responsibility, np.sqrt(squared_distances(found.moved, copy.xy)), COVER
    reach = max(near, c.min_reach_spacings * master.spacing)
    beside = away.min(axis=0) / (c.beside_factor * reach)
    explained = slope(P.sum(axis=0), c.min_explained, c.explained_slope) * slope(-beside, -1.0, c.reach_slope)
    own = master.owner[P.argmax(axis=0)][None, :] == master.owner[:, None]
    near_own = (own * explained * slope(-away / reach, -1.0, c.reach_slope)).max(axis=1)
    return slope(P.sum(axis=1), c.min_ink, c.ink_slope) * near_own, explained


def slope(values: FloatArray, limit: float, width: float) -> FloatArray:
    """0 below limit - width, 1 above limit + width, and straight between."""
    return np.asarray(np.clip((values - limit) / (2.0 * width) + 0.5, 0.0, 1.0))


def _settle(
    y: FloatArray,
    double: FloatArray,
    master: LinePoints,
    copy: LinePoints,
    *,
    responsibility: FloatArray,
    settings: MatchSettings,
) -> FloatArray:
    """(n, 2): each line pushed aside and turned, as it is, to where the ink that was given to it lies.

    The expectation that a line keeps to its warp has led it to its ink, but leaves it short of it: a
    turned line comes out turned by three quarters.
    """
    given = responsibility * np.where(copy.clear, np.float32(1.0), np.float32(settings.fork_weight))
    weight = given.sum(axis=1)
    off = _weighted_mean(given, copy.xy, weight) - y
    # a line that found next to nothing stays where its neighbours suggest
    weight = weight * np.minimum(weight, 1.0) * np.where(master.clear, 1.0, settings.fork_weight)
    c, s = double.T
    half = np.arctan2(s, c) / 2
    aside = np.column_stack([-np.sin(half), np.cos(half)]) * np.hypot(c, s)[:, None]
    local, owner = _local_coordinates(master, y), master.owner
    swing = np.column_stack([-local[:, 1], local[:, 0]])
    basis = np.column_stack([aside, (swing * aside).sum(axis=1)])  # right, down, radians
    away = (off * aside).sum(axis=1)
    hold = settings.settle_penalty * np.diag([1.0, 1.0, settings.settle_turn_penalty])
    move = _ridge(basis, owner, weight, away[:, None], hold=hold)[:, :, 0]
    left = away - (basis * move[owner]).sum(axis=1)
    weight = weight / (1.0 + (left / settings.settle_reach) ** 2)
    move = _ridge(basis, owner, weight, away[:, None], hold=hold)[owner, :, 0]
    return np.asarray(y + move[:, :2] + move[:, 2:] * swing)


class SoughtInk:
    """The m points of a copy, to be asked again and again to which of a master's n points they belong."""

    def __init__(self, copy: LinePoints, settings: MatchSettings) -> None:
        self.settings, self.spacing = settings, copy.spacing
        self.xy, self.double = copy.xy.astype(np.float32), copy.double.T.astype(np.float32)

    def crossing(self, double: FloatArray) -> FloatArray:
        """(n, m) float32, 0 or less: what the exponent loses where directions, (n, 2) doubled, cross."""
        along = double.astype(np.float32) @ self.double
        along -= np.float32(1.0)
        along *= np.float32(self.settings.crossing_penalty / 2)
        return np.asarray(along)

    def responsibilities(self, y: FloatArray, crossing: FloatArray, sigma: float) -> FloatArray:
        """(n, m) float32: how much each point of the copy belongs to each of the master's points, (n, 2)."""
        s, G = self.settings, squared_distances(y, self.xy)
        G *= np.float32(-0.5 / sigma**2)
        G += crossing
        np.exp(G, out=G)
        line = max(s.gather_sigmas * sigma / self.spacing, 1.0)
        nothing = np.float32(math.exp(-0.5 * s.outlier_sigmas**2) * line)
        G /= G.sum(axis=0) + nothing
        return G


def squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n, m) float32, from each of (n, 2) points to each of (m, 2)."""
    a, b = a.astype(np.float32, copy=False), b.astype(np.float32, copy=False)
    away = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None]
    away -= 2.0 * (a @ b.T)
    return np.asarray(np.maximum(away, np.float32(0.0), out=away))


def _weighted_mean(P: FloatArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    """(n, 2): of (m, 2) values with weights (n, m); weight: (n,) the sums of P's rows."""
    return np.asarray((P @ values.astype(np.float32)) / np.maximum(weight, 1e-6)[:, None], dtype=float)


def _warp_basis(xy: FloatArray, s: MatchSettings) -> tuple[FloatArray, FloatArray]:
    """(n, b) values of the warp's functions, affine ones first, and (b,) what each costs."""
    low, high = xy.min(axis=0), xy.max(axis=0)
    knots = np.stack(np.meshgrid(*np.linspace(low, high, s.grid).T), axis=-1).reshape(-1, 2)
    bumps = np.exp(-0.5 * ((xy[:, None] - knots) ** 2).sum(axis=2) / s.knot_reach**2)
    partings = low + np.array(s.partings)[:, None] * (high - low)
    bent = np.maximum(xy[:, :, None] - partings.T, 0.0).reshape(len(xy), -1)
    basis = np.column_stack([np.ones(len(xy)), xy, bent, bumps])
    bends = bent.shape[1] + len(knots)
    return basis, np.array([s.shift_cost, *[s.affine_cost] * 2, *[s.bend_cost] * bends])


def _fit_warp(
    xy: FloatArray, P: FloatArray, data: FloatArray, basis: FloatArray, cost: FloatArray
) -> FloatArray:
    """(n, 2): how the warp that best takes (n, 2) points to the data given to them moves them."""
    weight = P.sum(axis=1).astype(float)
    target = _weighted_mean(P, data, weight) - xy
    weighted = basis * weight[:, None]
    return np.asarray(basis @ np.linalg.solve(basis.T @ weighted + np.diag(cost), weighted.T @ target))


def _local_coordinates(points: LinePoints, xy: FloatArray) -> FloatArray:
    """(n, 3): x and y from the middle of the own line, and 1."""
    count = np.bincount(points.owner).astype(float)
    middle = np.column_stack([np.bincount(points.owner, xy[:, k]) / count for k in (0, 1)])
    return np.column_stack([xy - middle[points.owner], np.ones(len(xy))])


def _ridge(
    basis: FloatArray, owner: IntArray, weight: FloatArray, target: FloatArray, *, hold: FloatArray
) -> FloatArray:
    """(k, 3, d): ridge regression of (n, d) targets on a basis (n, 3), for each line by itself."""
    starts = np.flatnonzero(
        np.concatenate([[True], owner[1:] != owner[:-1]])
    )  # a line's points stand together
    weighted = (basis * weight[:, None])[:, :, None]
    left = np.add.reduceat(weighted * basis[:, None, :], starts)
    aim = np.add.reduceat(weighted * target[:, None, :], starts)
    return np.asarray(np.linalg.solve(left + hold, aim))


class _Directions:
    """The directions of a master's points, ready to be turned."""

    def __init__(self, points: LinePoints) -> None:
        c, s = points.double.T
        half = np.arctan2(s, c) / 2
        self.along = np.column_stack([np.cos(half), np.sin(half)])
        self.length = np.hypot(c, s)

    def turned(self, linear: FloatArray) -> FloatArray:
        """(n, 2): doubled directions after (n, 2, 2) linear moves beyond the identity."""
        along = self.along + np.einsum("nj,njd->nd", self.along, linear)
        angle = 2 * np.arctan2(along[:, 1], along[:, 0])
        return np.column_stack([self.length * np.cos(angle), self.length * np.sin(angle)])
