"""The markers of a sheet in a photograph, and the map from millimetres on the paper to pixels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import RefusedImage
from rumu.pages.sheet_layout import MARKER, PAPERS, Paper, marker_boxes
from rumu.values import BoolArray, FloatArray

Degrees = tuple[tuple[int, int], ...]
"""Degrees in x and in y of the polynomials of a bend."""

EVERYWHERE: Degrees = tuple((i, total - i) for total in range(7) for i in range(total + 1))
"""What the sides of cells all over a page determine: all polynomials of sixth degree."""
_BY_MARKERS: Degrees = (*((i, j) for i in (0, 1) for j in range(5)), (2, 0), (2, 1))  # as the markers stand
_BY_FEW: Degrees = ((0, 0), (0, 1), (1, 0), (1, 1), (0, 2))

SIDE = 7  # modules along the side of a marker, its black border among them


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """How markers are found.

    look: longer side, in pixels, of the reduced picture in which they are sought. fewest: of them that fix
    a page. bend: millimetres by which a marker may lie beside its place on a flat paper; off: the same on one
    that may be bent; beyond, it belongs to another sheet. strangers: markers of another sheet from which
    there are two in the picture. usual: millimetres that a marker may be off without counting less.
    """

    look: int = 2200
    fewest: int = 4
    bend: float = 22.0
    off: float = 4.0
    usual: float = 1.0
    strangers: int = 3


@dataclass(frozen=True, eq=False)
class PaperMap:
    """From millimetres on the paper to pixels of the photograph.

    homography: (3, 3), of a flat paper. bend_x, bend_y: coefficients of what the paper's bend adds before it,
    in millimetres, of the polynomials of `degrees`. paper: its size.
    """

    homography: FloatArray
    bend_x: FloatArray
    bend_y: FloatArray
    paper: Paper
    degrees: Degrees = ()

    def pixels(self, points: FloatArray) -> FloatArray:
        """(n, 2): where points (n, 2) of the paper, in millimetres, lie in the photograph, x right, y down.

        (0, 0) is the middle of its upper left pixel.
        """
        moved = points.astype(np.float64).copy()
        for axis, bend in enumerate((self.bend_x, self.bend_y)):
            if len(bend):
                moved[:, axis] += _basis(points, self.paper, self.degrees) @ bend
        return _project(self.homography, moved)

    def scale(self) -> float:
        """Pixels for each millimetre in the middle of the paper, the mean of both directions."""
        middle = np.array(PAPERS[self.paper]) / 2
        square = middle + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        x, y = self.pixels(square).T
        area = abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / 2
        return float(np.sqrt(area)) / 2


def marker_modules(number: int) -> BoolArray:
    """(SIDE, SIDE): a marker, True where it is dark."""
    import cv2

    picture = cv2.aruco.generateImageMarker(_dictionary(), number, SIDE)
    return np.asarray(picture < 128)


def find_markers(
    gray: npt.NDArray[np.uint8],
    *,
    among: Collection[int] | None = None,
    settings: MarkerSettings | None = None,
) -> list[tuple[int, FloatArray]]:
    """The numbers of the markers in a picture (H, W), and their corners (4, 2), the upper left first.

    among: the numbers that are looked for; those of a practice sheet unless they are given.
    """
    import cv2

    settings = settings or MarkerSettings()
    longest = max(gray.shape)
    factor = min(1.0, settings.look / longest)
    size = [round(side * factor) for side in gray.shape[::-1]]
    small = gray if factor == 1.0 else cv2.resize(gray, size, interpolation=cv2.INTER_AREA)
    parameters = cv2.aruco.DetectorParameters()
    parameters.minMarkerPerimeterRate = 0.02
    parameters.adaptiveThreshWinSizeMin, parameters.adaptiveThreshWinSizeMax = 7, 47
    parameters.adaptiveThreshWinSizeStep = 20
    # the middle of a module alone is read: in a small or blurred marker its rim is the next one's
    parameters.perspectiveRemovePixelPerCell, parameters.perspectiveRemoveIgnoredMarginPerCell = 8, 0.3
    found, numbers, _ = cv2.aruco.ArucoDetector(_dictionary(), parameters).detectMarkers(small)
    if numbers is None:
        return []
    known = marker_boxes("A4") if among is None else among
    markers = []
    for corners, number in zip(found, numbers.ravel().tolist(), strict=True):
        if number in known:
            places = (corners.reshape(4, 2) + 0.5) / factor - 0.5
            markers.append((number, _refine(gray, places.astype(np.float32))))
    return markers


def map_paper(
    markers: list[tuple[int, FloatArray]], paper: Paper, *, settings: MarkerSettings | None = None
) -> PaperMap:
    """The map that the markers of one page give.

    Raises RefusedImage, with reason 'two sheets' or 'cut off', where they give none.
    """
    import cv2

    settings = settings or MarkerSettings()
    twice = [number for number, times in Counter(number for number, _ in markers).items() if times > 1]
    if twice:
        raise refuse_two_sheets()
    if len(markers) < settings.fewest:
        raise refuse_cut_off()
    boxes = marker_boxes(paper)
    on_paper = np.concatenate([boxes[number].corners for number, _ in markers])
    in_picture = np.concatenate([corners for _, corners in markers]).astype(np.float64)
    side = np.median([np.hypot(*(corners - np.roll(corners, 1, axis=0)).T) for _, corners in markers])
    near = settings.bend * float(side) / MARKER
    homography, _ = cv2.findHomography(on_paper, in_picture, cv2.RANSAC, near)
    if homography is None or not np.isfinite(homography).all():
        raise refuse_cut_off()
    flat = PaperMap(homography, np.zeros(0), np.zeros(0), paper)
    fits = _distances(flat, on_paper, in_picture) < settings.bend
    count = np.count_nonzero(fits)
    degrees = _BY_MARKERS if count >= 9 else _BY_FEW if count >= 6 else ()
    if degrees:
        pairs = _middles(on_paper, fits), _middles(in_picture, fits)
        flat = bend_map(flat, along_x=pairs, along_y=pairs, degrees=degrees, usual=settings.usual)
        fits &= _distances(flat, on_paper, in_picture) < settings.off
    if np.count_nonzero(~fits) >= settings.strangers:
        raise refuse_two_sheets()
    chosen = np.repeat(fits, 4)
    spread = np.ptp(on_paper[chosen], axis=0) / np.array(PAPERS[paper]) if chosen.any() else np.zeros(2)
    if np.count_nonzero(fits) < settings.fewest or spread.min() < 0.5:
        raise refuse_cut_off()
    homography, _ = cv2.findHomography(on_paper[chosen], in_picture[chosen], 0)
    even = PaperMap(homography, np.zeros(0), np.zeros(0), paper)
    pairs = _middles(on_paper, fits), _middles(in_picture, fits)
    return bend_map(even, along_x=pairs, along_y=pairs, degrees=degrees, usual=settings.usual)


def _middles(corners: FloatArray, fits: BoolArray) -> FloatArray:
    """(n, 2): where the diagonals of markers cross; blur moves corners inward, but not that point.

    corners: (4 m, 2), those of each marker one after another. fits: (m,) which of them count.
    """
    a, b, c, d = corners.reshape(-1, 4, 2)[fits].transpose(1, 0, 2)
    one, other, between = c - a, d - b, b - a
    along = (between[:, 0] * other[:, 1] - between[:, 1] * other[:, 0]) / (
        one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    )
    return np.asarray(a + along[:, None] * one)


def _distances(places: PaperMap, on_paper: FloatArray, in_picture: FloatArray) -> FloatArray:
    """(n,): millimetres by which each marker lies beside its place in a map, at its farthest corner."""
    seen = _unproject(places.homography, in_picture)
    expected = _unproject(places.homography, places.pixels(on_paper))
    return np.asarray(np.hypot(*(seen - expected).T).reshape(-1, 4).max(axis=1))


Pairs = tuple[FloatArray, FloatArray]
"""(n, 2) points on the paper in millimetres, and where they lie in the photograph."""


def bend_map(flat: PaperMap, *, along_x: Pairs, along_y: Pairs, degrees: Degrees, usual: float) -> PaperMap:
    """The map with a bend that brings points where they were seen, by robust least squares.

    along_x, along_y: points whose place is known in that direction of the paper. degrees: of the polynomials;
    none leaves the paper flat. usual: millimetres that a point may be off without counting less.
    """
    if not degrees:
        return flat
    bends: list[FloatArray] = []
    for axis, (on_paper, in_picture) in enumerate((along_x, along_y)):
        missing = (_unproject(flat.homography, in_picture) - on_paper)[:, axis]
        bends.append(_robust_fit(_basis(on_paper, flat.paper, degrees), missing, usual=usual))
    return PaperMap(flat.homography, bends[0], bends[1], flat.paper, degrees)


def refuse_two_sheets() -> RefusedImage:
    """The refusal of a picture in which there is more than one sheet."""
    return RefusedImage(
        "expected one sheet in a picture, found the markers of two; photograph each alone",
        reason="two sheets",
        zh="照片裡有兩張練習紙；請一張一張拍。",
    )


def refuse_cut_off() -> RefusedImage:
    """The refusal of a picture in which a part of the sheet is missing."""
    return RefusedImage(
        "expected the whole sheet with its black squares, a part of it is cut off or covered",
        reason="cut off",
        zh="練習紙沒有拍全，或被遮住了；請把四邊的黑色方塊都拍進去。",
    )


def _refine(gray: npt.NDArray[np.uint8], corners: npt.NDArray[np.float32]) -> FloatArray:
    """Corners to a fraction of a pixel, as they lie in the whole picture."""
    import cv2

    module = float(np.hypot(*(corners - np.roll(corners, 1, axis=0)).T).min()) / SIDE
    reach = int(np.clip(round(0.7 * module), 2, 14))
    low = np.floor(corners.min(axis=0) - 2 * reach - 4).astype(int)
    high = np.ceil(corners.max(axis=0) + 2 * reach + 4).astype(int)
    x0, y0 = np.maximum(low, 0)
    part = np.ascontiguousarray(gray[y0 : max(high[1], y0 + 1), x0 : max(high[0], x0 + 1)])
    shifted = (corners - np.array([x0, y0], np.float32)).reshape(-1, 1, 2).copy()
    if min(part.shape) < 2 * reach + 6:
        return corners.astype(np.float64)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 0.005)
    refined = cv2.cornerSubPix(part, shifted, (reach, reach), (-1, -1), criteria).reshape(4, 2)
    refined = np.where(np.abs(refined - shifted.reshape(4, 2)) < 2 * reach, refined, shifted.reshape(4, 2))
    return np.asarray(refined + np.array([x0, y0]), np.float64)


def _dictionary() -> Any:
    import cv2

    return cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)


def _basis(points: FloatArray, paper: Paper, degrees: Degrees) -> FloatArray:
    """(n, terms): products of Chebyshev polynomials in x and y, at points on the paper."""
    from numpy.polynomial.chebyshev import chebvander

    x, y = (2 * points / np.array(PAPERS[paper]) - 1).T
    highest = max(max(pair) for pair in degrees)
    in_x, in_y = chebvander(x, highest), chebvander(y, highest)
    return np.stack([in_x[:, i] * in_y[:, j] for i, j in degrees], axis=1)


def _robust_fit(basis: FloatArray, values: FloatArray, *, usual: float, ridge: float = 1e-4) -> FloatArray:
    """Coefficients by least squares, weighed anew so that what lies far off counts little."""
    weights: FloatArray = np.ones(len(values))
    solution: FloatArray = np.zeros(basis.shape[1])
    penalty = ridge * np.eye(basis.shape[1])
    for _ in range(6):
        weighed = basis * weights[:, None]
        solution = np.linalg.solve(weighed.T @ basis + penalty, weighed.T @ values)
        off = np.abs(basis @ solution - values)
        spread = max(1.4826 * float(np.median(off)), usual)
        weights = 1 / (1 + (off / (2.5 * spread)) ** 2) ** 2
    return solution


def _project(homography: FloatArray, points: FloatArray) -> FloatArray:
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return np.asarray(mapped[:, :2] / mapped[:, 2:])


def _unproject(homography: FloatArray, points: FloatArray) -> FloatArray:
    return _project(np.linalg.inv(homography), points)
