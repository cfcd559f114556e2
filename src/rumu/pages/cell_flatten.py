"""One cell of a photograph, seen from straight above: by its four corners, given or found by its lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.errors import ImageError
from rumu.pages.line_evidence import Picture
from rumu.values import FloatArray

SMALLEST = 32.0
"""Pixels of the shortest side of a cell that can be flattened."""


@dataclass(frozen=True, slots=True)
class CellLineSettings:
    """How the printed sides of a cell are found near a square that somebody laid on it.

    near: from a side of the square, and lean: of degrees against it, within which a straight piece may
    belong to the printed side. thick: pieces so near to each other are one line; support: least length of
    the pieces of a line; pieces: the longest so many are looked at. Lengths are shares of the square's side.
    growth: how many times as large as the square around writing a cell is sought, one after another.
    """

    near: float = 0.14
    lean: float = 16.0
    thick: float = 0.012
    support: float = 0.45
    pieces: int = 40
    growth: tuple[float, ...] = (1.0, 1.15, 1.3, 1.5, 1.75, 2.0)


def flatten_cell(picture: Picture, corners: FloatArray, *, most: int = 1200) -> Picture:
    """The cell between four corners as a square picture, without perspective.

    Parameters
    ----------
    picture
        (H, W, 3) uint8 sRGB.
    corners
        (4, 2) x and y in pixels: upper left, upper right, lower right, lower left of the cell. They may lie
        beyond the picture, which is continued by its edge.
    most
        Pixels of the square's side at most; else it has the mean length of the sides.

    Returns
    -------
    Picture
        (n, n, 3) uint8.

    Raises
    ------
    ImageError
        When the corners are not those of a convex cell in this order, or it is too small.
    """
    import cv2

    corners = np.asarray(corners, np.float64)
    _check_corners(corners)
    sides = np.hypot(*(corners - np.roll(corners, -1, axis=0)).T)
    side = int(min(most, round(float(sides.mean()))))
    scale = side / float(sides.mean())
    if scale < 1:  # area averaging, which a warp does not do
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.5 / scale), np.uint8)
    square = np.array([[0, 0], [side, 0], [side, side], [0, side]], np.float32) - 0.5
    matrix = cv2.getPerspectiveTransform(square, (corners - 0.5).astype(np.float32))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    flat = cv2.warpPerspective(picture, matrix, (side, side), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(flat, np.uint8)


def refine_corners(
    picture: Picture, corners: FloatArray, *, settings: CellLineSettings | None = None
) -> FloatArray | None:
    """The corners of the printed cell near the corners (4, 2) of a square; None where no lines show it."""
    corners = np.asarray(corners, np.float64)
    _check_corners(corners)
    return _corners_near(_straight_pieces(picture), corners, settings or CellLineSettings())


def find_cell_around(
    picture: Picture, corners: FloatArray, *, settings: CellLineSettings | None = None
) -> FloatArray | None:
    """The corners of the printed cell around the corners (4, 2) of a square on the writing, or None.

    The smallest that lines show counts: what is larger may be the edge of the sheet.
    """
    settings = settings or CellLineSettings()
    corners = np.asarray(corners, np.float64)
    _check_corners(corners)
    pieces, middle = _straight_pieces(picture), corners.mean(axis=0)
    for times in settings.growth:
        found = _corners_near(pieces, middle + times * (corners - middle), settings)
        if found is not None:
            return found
    return None


def _straight_pieces(picture: Picture) -> FloatArray:
    """(n, 2, 2): both ends, x and y, of what is straight in a picture."""
    import cv2

    detected = cv2.createLineSegmentDetector().detect(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))[0]
    return np.zeros((0, 2, 2)) if detected is None else np.asarray(detected, float).reshape(-1, 2, 2) + 0.5


def _corners_near(pieces: FloatArray, corners: FloatArray, settings: CellLineSettings) -> FloatArray | None:
    """The corners between the printed lines near the sides of a square."""
    if not len(pieces):
        return None
    lines = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        line = _line_near(pieces, start, end, settings)
        if line is None:
            return None
        lines.append(line)
    points = np.cross(np.roll(lines, 1, axis=0), lines)  # each corner lies on the side before and its own
    if (np.abs(points[:, 2]) < 1e-12).any():
        return None
    found = points[:, :2] / points[:, 2:]
    side = float(np.hypot(*(corners[1] - corners[0])))
    return found if np.hypot(*(found - corners).T).max() < 2 * settings.near * side else None


def _line_near(
    pieces: FloatArray, start: FloatArray, end: FloatArray, settings: CellLineSettings
) -> FloatArray | None:
    """(3,) the printed line near a side, from the pieces (n, 2, 2) along it that agree best."""
    side = float(np.hypot(*(end - start)))
    along = (end - start) / side
    across = np.array([-along[1], along[0]])
    ways = pieces[:, 1] - pieces[:, 0]
    lengths = np.hypot(*ways.T)
    off = (pieces - start) @ across
    at = (pieces.mean(axis=1) - start) @ along
    lean = np.abs(ways @ across) / np.maximum(lengths, 1e-9)
    chosen = (np.abs(off).max(axis=1) < settings.near * side) & (at > 0) & (at < side)
    chosen &= (lean < np.sin(np.radians(settings.lean))) & (lengths > 0.03 * side)
    chosen &= lengths >= np.sort(np.where(chosen, lengths, 0))[-settings.pieces :][0]
    if not chosen.any():
        return None
    ends, weights = pieces[chosen].reshape(-1, 2), np.repeat(lengths[chosen], 2)
    places = np.stack([(ends - start) @ along, (ends - start) @ across])
    best, support = None, settings.support * side
    for first in range(0, len(ends), 2):
        for last in range(first + 1, len(ends), 2):
            (x0, y0), (x1, y1) = places[:, first], places[:, last]
            if abs(x1 - x0) < 0.2 * side:
                continue
            slope = (y1 - y0) / (x1 - x0)
            near = np.abs(places[1] - y0 - slope * (places[0] - x0)) < settings.thick * side
            held = float(weights[near].sum()) / 2
            if held > support:
                best, support = near, held
    if best is None:
        return None
    slope, level = np.polyfit(places[0, best], places[1, best], 1, w=np.sqrt(weights[best]))
    points = [start + x * along + (level + slope * x) * across for x in (0.0, side)]
    return np.asarray(np.cross([*points[0], 1.0], [*points[1], 1.0]))


def _check_corners(corners: FloatArray) -> None:
    """Raise ImageError unless they are those of a convex cell, clockwise from the upper left."""
    right = corners.shape == (4, 2) and bool(np.isfinite(corners).all())
    if right:
        ways = np.roll(corners, -1, axis=0) - corners
        following = np.roll(ways, -1, axis=0)
        turns = ways[:, 0] * following[:, 1] - ways[:, 1] * following[:, 0]
        right = bool((turns > 0).all()) and float(np.hypot(*ways.T).min()) >= SMALLEST
    if not right:
        raise ImageError(
            "expected four corners of a cell, clockwise from the upper left, at least "
            f"{SMALLEST:.0f} pixels apart, got {corners.round(1).tolist()}",
            zh="四個角要圍成一格，左上角起順時針，每邊至少 32 像素。",
        )
