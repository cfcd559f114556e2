"""Lines of the master laid on lines of the copy: first as one smooth sheet, then each stroke by itself.

Expectation-maximisation after coherent point drift (Myronenko and Song 2010): each point of the copy is
shared out among the points of the master that may explain it, or none; then the master moves to what it was
given. Because ink that one stroke explains is taken, a stroke that the copy lacks finds nothing and stays
where its neighbours suggest. Positions in rms radii, see `sheets`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class MatchSettings:
    """How lines are laid on lines.

    smooth, single: standard deviations of the expected distance, rms radii: the first while all strokes move
        as one sheet, the second while each moves by itself. grid: knots of the sheet on each axis; bend: how
        far a knot reaches, rms radii; stiff: a sheet's resistance.
    travel: how far a stroke is expected to leave the sheet, rms radii; warp: how far it is expected to turn
        or stretch. hold: how much that expectation is trusted, in points.
    crossing: what a perpendicular direction costs, in the exponent. beyond: standard deviations from which
        a point counts as explained by nothing.
    fork: weight of a point near a fork when lines settle on their ink; settle: points' worth of ink that
        holds a line where it was; stray: rms radii from its line beyond which ink hardly counts then.
    """

    smooth: tuple[float, ...] = (0.22, 0.18, 0.15, 0.12)
    single: tuple[float, ...] = (0.14, 0.12, 0.1, 0.085, 0.07, 0.06, 0.05)
    grid: int = 4
    bend: float = 1.0
    stiff: float = 1.0
    travel: float = 0.2
    warp: float = 0.25
    hold: float = 6.0
    crossing: float = 2.5
    beyond: float = 2.6
    fork: float = 0.05
    settle: float = 1.0
    stray: float = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Points along lines, evenly spaced.

    xy: (n, 2) rms radii. double: (n, 2) (cos 2t, sin 2t) of the line's direction, 0 for a dot.
    radius: (n,) half-width, rms radii. owner: (n,) number of the line. clear: (n,) away from forks, so that
        the half-width is that of one stroke. spacing: between neighbours.
    """

    xy: FloatArray
    double: FloatArray
    radius: FloatArray
    owner: IntArray
    clear: BoolArray
    spacing: float


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Where each point of the master's lines lies in the copy.

    moved: (n, 2) the master's points in the copy, stroke by stroke affine. linear: (k, 2, 2), what that does
        to each stroke beyond the identity. share: (n, m) how much each point of the copy belongs to each of
        the master's; columns sum to at most 1.
    """

    moved: FloatArray
    linear: FloatArray
    share: FloatArray


def match(master: Points, copy: Points, *, settings: MatchSettings | None = None) -> Match:
    """The master's points where the copy has them."""
    settings = settings or MatchSettings()
    y, double = master.xy, master.double
    basis, penalty = _sheet_basis(y, settings)
    for sigma in settings.smooth:
        P = _share(y, double, copy, sigma, settings)
        y = master.xy + _smooth_step(master.xy, P, copy.xy, basis, penalty * sigma**2)
    local, owner = _local(master, master.xy)
    fit = _ridge(local, owner, np.ones(len(y)), y - master.xy, hold=np.diag([1.0, 1.0, 1e-3]))
    moves = fit
    for sigma in settings.single:
        P = _share(y, double, copy, sigma, settings)
        hold = (
            settings.hold * sigma**2 * np.array([settings.warp**-2, settings.warp**-2, settings.travel**-2])
        )
        weight = P.sum(axis=1)
        target = _mean(P, copy.xy, weight) - master.xy
        base = np.einsum("nj,njd->nd", local, fit[owner])
        moves = fit + _ridge(local, owner, weight, target - base, hold=np.diag(hold))
        y = master.xy + np.einsum("nj,njd->nd", local, moves[owner])
        double = _turned(master, moves[owner, :2])
    P = _share(y, double, copy, settings.single[-1], settings)
    y = _settled(y, double, master, copy, share=P, settings=settings)
    return Match(y, moves[:, :2].transpose(0, 2, 1), P)


def _settled(
    y: FloatArray,
    double: FloatArray,
    master: Points,
    copy: Points,
    *,
    share: FloatArray,
    settings: MatchSettings,
) -> FloatArray:
    """(n, 2): each line pushed aside and turned, as it is, to where the ink that was given to it lies.

    The expectation that a line keeps to its sheet has led it to its ink, but leaves it short of it: a
    turned line comes out turned by three quarters. Thinning pulls lines together where they meet, so that
    points near a fork hardly count.
    """
    faint = np.float32(settings.fork)
    given = share * np.where(copy.clear, np.float32(1.0), faint)
    weight = given.sum(axis=1)
    off = _mean(given, copy.xy, weight) - y
    # a line that found next to nothing stays where its neighbours suggest
    weight = weight * np.minimum(weight, 1.0) * np.where(master.clear, 1.0, settings.fork)
    c, s = double.T
    half = np.arctan2(s, c) / 2
    aside = np.column_stack([-np.sin(half), np.cos(half)]) * np.hypot(c, s)[:, None]
    local, owner = _local(master, y)
    swing = np.column_stack([-local[:, 1], local[:, 0]])
    basis = np.column_stack([aside, (swing * aside).sum(axis=1)])  # right, down, radians
    away = (off * aside).sum(axis=1)
    hold = settings.settle * np.diag([1.0, 1.0, 0.05])
    move = _ridge(basis, owner, weight, away[:, None], hold=hold)[:, :, 0]
    left = away - (basis * move[owner]).sum(axis=1)
    weight = weight / (1.0 + (left / settings.stray) ** 2)
    move = _ridge(basis, owner, weight, away[:, None], hold=hold)[owner, :, 0]
    return np.asarray(y + move[:, :2] + move[:, 2:] * swing)


def _share(y: FloatArray, double: FloatArray, copy: Points, sigma: float, s: MatchSettings) -> FloatArray:
    """(n, m): how much each point of the copy belongs to each of the master's points."""
    squared = squared_distances(y, copy.xy)
    along = double.astype(np.float32) @ copy.double.T.astype(np.float32)
    G = np.exp(squared * np.float32(-0.5 / sigma**2) + np.float32(s.crossing / 2) * (along - 1))
    # a line gives a point beside it more than one of its own points does
    line = max(2.5 * sigma / copy.spacing, 1.0)
    nothing = np.float32(np.exp(-0.5 * s.beyond**2) * line)
    return np.asarray(G / (G.sum(axis=0) + nothing))


def squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n, m) float32, from each of (n, 2) points to each of (m, 2)."""
    a, b = a.astype(np.float32), b.astype(np.float32)
    away = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None] - 2.0 * (a @ b.T)
    return np.asarray(np.maximum(away, np.float32(0.0)))


def _mean(P: FloatArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    return np.asarray((P @ values.astype(np.float32)) / np.maximum(weight, 1e-6)[:, None], dtype=float)


def _sheet_basis(xy: FloatArray, s: MatchSettings) -> tuple[FloatArray, FloatArray]:
    """(n, b) values of the sheet's functions, affine ones first, and (b,) what each costs."""
    axes = [np.linspace(xy[:, k].min(), xy[:, k].max(), s.grid) for k in (0, 1)]
    knots = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    bumps = np.exp(-0.5 * ((xy[:, None] - knots) ** 2).sum(axis=2) / s.bend**2)
    # a part too wide bends the sheet at its parting and nowhere else
    partings = [np.quantile(axis, (0.35, 0.5, 0.65)) for axis in axes]
    bent = np.concatenate([np.maximum(xy[:, k, None] - partings[k], 0.0) for k in (0, 1)], axis=1)
    basis = np.column_stack([np.ones(len(xy)), xy, bent, bumps])
    # the registration has settled the place already, so that even the affine part is held a little
    cost = s.stiff * np.array([5.0, *[20.0] * 2, *[30.0] * bent.shape[1], *[30.0] * len(knots)])
    return basis, cost


def _smooth_step(
    xy: FloatArray, P: FloatArray, data: FloatArray, basis: FloatArray, cost: FloatArray
) -> FloatArray:
    weight = P.sum(axis=1).astype(float)
    target = _mean(P, data, weight) - xy
    weighted = basis * weight[:, None]
    return np.asarray(basis @ np.linalg.solve(basis.T @ weighted + np.diag(cost), weighted.T @ target))


def _local(points: Points, xy: FloatArray) -> tuple[FloatArray, IntArray]:
    """(n, 3): x and y from the middle of the own line, and 1; and the owners."""
    count = np.bincount(points.owner).astype(float)
    middle = np.column_stack([np.bincount(points.owner, xy[:, k]) / count for k in (0, 1)])
    return np.column_stack([xy - middle[points.owner], np.ones(len(xy))]), points.owner


def _ridge(
    local: FloatArray, owner: IntArray, weight: FloatArray, target: FloatArray, *, hold: FloatArray
) -> FloatArray:
    """(k, 3, d): of each line the move that best takes its points to (n, d) targets, held at zero."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(owner)) + 1])  # a line's points stand together
    weighted = (local * weight[:, None])[:, :, None]
    left = np.add.reduceat(weighted * local[:, None, :], starts)
    aim = np.add.reduceat(weighted * target[:, None, :], starts)
    return np.asarray(np.linalg.solve(left + hold, aim))


def _turned(points: Points, linear: FloatArray) -> FloatArray:
    """(n, 2): doubled directions after (n, 2, 2) linear moves beyond the identity."""
    c, s = points.double.T
    half = np.arctan2(s, c) / 2
    along = np.column_stack([np.cos(half), np.sin(half)])
    along = along + np.einsum("nj,njd->nd", along, linear)
    angle = 2 * np.arctan2(along[:, 1], along[:, 0])
    length = np.hypot(c, s)
    return np.column_stack([length * np.cos(angle), length * np.sin(angle)])
