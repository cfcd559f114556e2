"""A bent page straightened: a smooth map under which its columns and lines run straight.

Columns of writing, ruled lines and the sides of printed cells are curves that were straight and upright, or
straight and level, on the sheet. The map is the smoothest pair of polynomials that makes them so, fitted by
robust least squares; where columns or lines were printed at equal distances, and stand closer together where
the sheet turns away, their distances are made equal again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.values import FloatArray, IntArray

Picture = npt.NDArray[np.uint8]

_BAND = 16  # rows of squares whose map is held at a time


@dataclass(frozen=True, slots=True)
class BendSettings:
    """How a page is straightened; lengths in sizes of a character, except where it says so.

    across, along: degree of the polynomials, across the curves and along them. free: in how many ways a
        line bends by chance at most, and a column of writing, which wanders by itself; the map must have
        fewer. stiff: weight of the coefficients, so that what few curves show stays small. near: how far
        from straight a curve may stay before it counts for less. curves: the fewest curves of one kind that
        say how a page bends.
    least: the largest displacement below which a page counts as flat. explained: what is left of the
        deviations at most, over what chance would leave. even: the largest deviation of curves from equal
        distances, as a share of their distance; narrower: how much their distance must change from one side
        to the other. grid: pixels between the places at which the map is computed.
    """

    across: int = 3
    along: int = 3
    free: tuple[int, int] = (10, 2)
    stiff: float = 1e-3
    near: float = 0.15
    curves: int = 2
    least: float = 0.08
    explained: float = 0.6
    even: float = 0.12
    narrower: float = 0.12
    grid: int = 16


@dataclass(frozen=True, slots=True, eq=False)
class PageCurves:
    """Curves that were straight on the sheet, each (n, 2), x and y in pixels.

    upright, level: curves that ran down the page, and across it. size: about what a character measures.
    written: how many of the upright and of the level ones are columns or rows of writing.
    """

    upright: tuple[FloatArray, ...]
    level: tuple[FloatArray, ...]
    size: float
    written: tuple[int, int] = (0, 0)


@dataclass(frozen=True, slots=True, eq=False)
class _Shift:
    """How far points move along one axis: a polynomial in both coordinates, constant beyond what was seen.

    axis: 0 moves x, 1 moves y. low, high: (2,) the box of the points that were seen. powers: (k, 2).
    even: (knots, places) of the other map, from places along the axis to evenly spaced ones; None for none.
    """

    axis: int
    low: FloatArray
    high: FloatArray
    powers: IntArray
    weights: FloatArray
    even: tuple[FloatArray, FloatArray] | None = None

    def at(self, points: FloatArray) -> FloatArray:
        """(n,): how far points (n, 2) move."""
        shift = _terms(points, self.low, self.high, self.powers) @ self.weights
        if self.even is None:
            return np.asarray(shift)
        moved = points[:, self.axis] + shift
        return np.asarray(shift + np.interp(moved, *self.even) - np.clip(moved, *self.even[0][[0, -1]]))


@dataclass(frozen=True, slots=True, eq=False)
class Straightening:
    """The map of a bent page onto a straight one of the same size."""

    shifts: tuple[_Shift, ...]
    settings: BendSettings

    def points(self, points: FloatArray) -> FloatArray:
        """Points (n, 2) of the bent page on the straight one."""
        moved = np.array(points, dtype=float)
        for shift in self.shifts:
            moved[:, shift.axis] += shift.at(np.asarray(points, dtype=float))
        return moved

    def picture(self, bent: Picture, *, scale: FloatArray | tuple[float, float] = (1.0, 1.0)) -> Picture:
        """The straight page. scale: pixels of the picture, x and y, for each pixel of the curves."""
        import cv2

        height, width = bent.shape[:2]
        grid = self.settings.grid
        # in the middle of squares of pixels, and in a row of squares around the picture
        rows, columns = (np.arange(-1, -(-side // grid) + 1) for side in (height, width))
        x, y = np.meshgrid(*(grid * (one + 0.5) - 0.5 for one in (columns, rows)))
        wanted = np.column_stack([x.ravel(), y.ravel()]) / scale
        source = wanted.copy()
        for _ in range(6):  # the inverse, by fixed points: shifts change little from place to place
            source += wanted - self.points(source)
        back = (source * scale).astype(np.float32).reshape(*x.shape, 2)
        straight = np.empty_like(bent)
        for top in range(0, height, _BAND * grid):  # the maps of a large picture take more room than itself
            first = top // grid
            nodes = back[first : first + _BAND + 2]
            places = cv2.resize(nodes, (len(columns) * grid, len(nodes) * grid))
            maps = places[grid : grid + min(_BAND * grid, height - top), grid : grid + width]
            straight[top : top + len(maps)] = cv2.remap(
                bent, maps, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
            )
        return straight


def find_straightening(curves: PageCurves, *, settings: BendSettings | None = None) -> Straightening | None:
    """The map that makes curves straight; None where they are, or where no smooth map does."""
    settings = settings or BendSettings()
    shifts = [
        shift
        for axis, own in ((0, curves.upright), (1, curves.level))
        if (shift := _fit(own, axis, curves.size, curves.written[axis], settings)) is not None
    ]
    return Straightening(tuple(shifts), settings) if shifts else None


def _fit(
    curves: tuple[FloatArray, ...], axis: int, size: float, written: int, settings: BendSettings
) -> _Shift | None:
    """How points move along an axis so that curves across it become straight; None where they need not."""
    if len(curves) < settings.curves:
        return None
    points = np.concatenate(curves)
    which = np.repeat(np.arange(len(curves)), [len(one) for one in curves])
    low, high = points.min(axis=0), points.max(axis=0)
    if (high - low).min() < size:
        return None
    freedom = settings.free[0] * (len(curves) - written) + settings.free[1] * written
    across = int(min(settings.across, len(curves) - 1, max(0, freedom // (2 * settings.along) - 1)))
    powers = np.array(
        [(i, j) if axis == 0 else (j, i) for j in range(1, settings.along + 1) for i in range(across + 1)]
    )
    terms = _terms(points, low, high, powers)
    place = points[:, axis]
    weights, off = np.ones(len(points)), place
    coefficients = np.zeros(len(powers))
    for _ in range(8):
        free = terms - _means(terms, which, weights)[which]
        target = -(place - _means(place[:, None], which, weights)[which, 0])
        stiff = settings.stiff * weights.sum() * np.eye(len(powers))
        coefficients = np.linalg.solve(
            (free * weights[:, None]).T @ free + stiff, free.T @ (weights * target)
        )
        off = free @ coefficients - target
        weights = 1 / (1 + (off / (settings.near * size)) ** 2)
    before = place - _means(place[:, None], which, weights)[which, 0]
    shift = _Shift(axis, low, high, powers, coefficients)
    even = _even_distances(curves, shift, settings)
    bent = float(np.quantile(np.abs(before), 0.95))
    by_chance = max(0.0, 1 - len(powers) / freedom) ** 0.5 * _spread(before, weights)
    is_bent = bent > settings.least * size and _spread(off, weights) < settings.explained * by_chance
    if not is_bent and even is None:
        return None
    return _Shift(axis, low, high, powers, coefficients if is_bent else 0 * coefficients, even)


def _spread(values: FloatArray, weights: FloatArray) -> float:
    return float(np.sqrt(np.average(values**2, weights=weights)))


def _means(values: FloatArray, which: npt.NDArray[np.intp], weights: FloatArray) -> FloatArray:
    """(curves, k): the weighted mean of values (n, k) over each curve."""
    total = np.bincount(which, weights)
    sums = [np.bincount(which, weights * column) for column in values.T]
    return np.asarray((np.array(sums) / np.maximum(total, 1e-9)).T)


def _terms(points: FloatArray, low: FloatArray, high: FloatArray, powers: IntArray) -> FloatArray:
    """(n, k): products of powers of both coordinates, which run from -1 to 1 over the box and stay there."""
    unit = np.clip(2 * (points - low) / (high - low) - 1, -1, 1)
    in_x, in_y = (np.vander(unit[:, axis], powers[:, axis].max() + 1, increasing=True) for axis in (0, 1))
    return np.asarray(in_x[:, powers[:, 0]] * in_y[:, powers[:, 1]])


def _even_distances(
    curves: tuple[FloatArray, ...], shift: _Shift, settings: BendSettings
) -> tuple[FloatArray, FloatArray] | None:
    """Places of curves that were at equal distances, and where they belong; None where they were not."""
    places = np.array([float(np.mean(one[:, shift.axis] + shift.at(one))) for one in curves])
    middle = np.array([float(np.mean(one[:, 1 - shift.axis])) for one in curves])
    places = places[np.argsort(places)]
    if len(places) < 6 or np.ptp(middle) > 0.5 * (shift.high - shift.low)[1 - shift.axis]:
        return None
    gaps = np.diff(places)
    usual = float(np.median(gaps))
    if gaps.min() < 0.5 * usual or gaps.max() > 1.6 * usual:
        return None
    number = np.arange(len(places), dtype=float)
    smooth = np.polyval(np.polyfit(number, places, 3), number)
    straight = np.polyval(np.polyfit(number, places, 1), number)
    step = np.diff(smooth)
    if np.abs(places - smooth).max() > settings.even * usual or np.ptp(step) < settings.narrower * usual:
        return None
    return smooth, straight
