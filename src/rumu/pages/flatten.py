"""A photograph of a page becomes the page as it lies flat: by printed lines, or the edge of its paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.errors import ImageError
from rumu.pages.line_evidence import Picture
from rumu.values import BoolArray, FloatArray

FoundBy = Literal["lines", "paper", "picture"]


@dataclass(frozen=True, slots=True)
class FlattenSettings:
    """How a page is found in a photograph.

    side: longer side, in pixels, of the reduced picture that is searched. segment: least length of a straight
        piece, as a share of it. pieces: least number of pieces along each way. lean: most lean of a family of
        lines, in degrees. agreeing: a piece belongs to a vanishing point that lies in its direction within
        so many degrees; share: least share of a family's length that does. draws: pairs of pieces tried.
    steepest: most tilt of the page against the camera, in degrees.
    focal: focal length over the longer side where the picture does not say; least_focal, most_focal: it may
        have.
    slight: corners that move by less than this share of the longer side are left where they are. least_paper:
        least share of the picture that is paper. margin: around what was found, as a share of it.
    largest: most pixels of the flat page over the photograph's.
    """

    side: int = 900
    segment: float = 0.055
    pieces: int = 5
    lean: float = 34.0
    agreeing: float = 1.5
    share: float = 0.55
    draws: int = 600
    steepest: float = 50.0
    focal: float = 0.8
    least_focal: float = 0.5
    most_focal: float = 4.0
    slight: float = 0.05
    least_paper: float = 0.1
    margin: float = 0.06
    largest: float = 1.6


@dataclass(frozen=True, slots=True, eq=False)
class FlatPhoto:
    """A page as it lies flat.

    Parameters
    ----------
    picture
        (h, w, 3) uint8 sRGB, the page seen from straight above.
    photo_from_flat
        Points (n, 2), x and y in pixels of the flat page -> the same points in the photograph.
    found_by
        "lines": two families of straight lines, a frame, a grid or ruled lines; "paper": its edge; "picture":
        nothing was found, and the picture is as it was.
    """

    picture: Picture
    photo_from_flat: Callable[[FloatArray], FloatArray]
    found_by: FoundBy


def flatten_photo(picture: Picture, *, settings: FlattenSettings | None = None) -> FlatPhoto:
    """Turn a photograph of a page into the page seen from straight above.

    Parameters
    ----------
    picture
        (H, W, 3) uint8 sRGB.
    settings
        How a page is found.

    Returns
    -------
    FlatPhoto
        The picture itself where nothing shows how the page lies, or where it lies flat already.

    Raises
    ------
    ImageError
        If it is no such picture.
    """
    import cv2

    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
        raise ImageError(f"expected a (H, W, 3) uint8 picture, got {picture.shape} {picture.dtype}")
    settings = settings or FlattenSettings()
    scale = min(1.0, settings.side / max(picture.shape[:2]))
    small = (
        cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) if scale < 1 else picture
    )
    if min(small.shape[:2]) < 32:
        return FlatPhoto(picture, np.asarray, "picture")
    gray = cv2.cvtColor(small, cv2.COLOR_RGB2GRAY)
    found = _by_lines(gray, settings) or _by_paper(gray, settings)
    if found is None:
        return FlatPhoto(picture, np.asarray, "picture")
    matrix, region, found_by = found
    return _flat(picture, matrix @ np.diag([scale, scale, 1.0]), region / scale, found_by, settings)


Found = tuple[FloatArray, FloatArray, FoundBy]
"""(3, 3) flat from photograph, points (n, 2) in the photograph of the page, and what showed it."""


def _by_lines(gray: Picture, settings: FlattenSettings) -> Found | None:
    """The view from above by the vanishing points of two families of lines; None where there are none."""
    import cv2

    longer = max(gray.shape)
    detected = cv2.createLineSegmentDetector().detect(gray)[0]
    if detected is None:
        return None
    pieces = np.asarray(detected, np.float64).reshape(-1, 4) - np.tile(np.array(gray.shape[::-1]) / 2, 2)
    pieces = pieces[np.hypot(*(pieces[:, 2:] - pieces[:, :2]).T) >= settings.segment * longer]
    angle = np.degrees(np.arctan2(pieces[:, 3] - pieces[:, 1], pieces[:, 2] - pieces[:, 0]))
    level = np.abs((angle + 90) % 180 - 90) < settings.lean
    points = []
    upright = np.abs(np.abs(angle) - 90) < settings.lean
    for family in (pieces[level], pieces[upright]):
        point = _vanishing_point(family, longer, settings)
        if point is None:
            return None
        points.append(point)
    matrix = _view_from_above(points[0], points[1], longer, settings)
    if matrix is None:
        return None
    centre = np.array(gray.shape[::-1]) / 2
    to_centre = np.array([[1, 0, -centre[0]], [0, 1, -centre[1]], [0, 0, 1.0]])
    return matrix @ to_centre, pieces.reshape(-1, 2) + centre, "lines"


def _vanishing_point(pieces: FloatArray, longer: int, settings: FlattenSettings) -> FloatArray | None:
    """(3,) homogeneous, where most of the pieces (n, 4) run to; None where they do not agree."""
    if len(pieces) < settings.pieces:
        return None
    flat = pieces.reshape(-1, 2) / longer
    ends = np.hstack([flat, np.ones((len(flat), 1))]).reshape(-1, 2, 3)
    lines = np.cross(ends[:, 0], ends[:, 1])
    middles, ways = ends.mean(axis=1)[:, :2], ends[:, 1, :2] - ends[:, 0, :2]
    lengths = np.hypot(*ways.T)
    ways = ways / lengths[:, None]
    draw = np.random.default_rng(0).integers(0, len(lines), (settings.draws, 2))
    candidates = np.cross(lines[draw[:, 0]], lines[draw[:, 1]])
    candidates = candidates[np.linalg.norm(candidates, axis=1) > 1e-9]
    if not len(candidates):
        return None
    allowed = np.sin(np.radians(settings.agreeing))
    votes = [float(lengths[_towards(one, middles, ways) < allowed].sum()) for one in candidates]
    best = candidates[int(np.argmax(votes))]
    for _ in range(3):  # the point that lies best on all lines that run to it
        near = _towards(best, middles, ways) < allowed
        weighted = lines[near] / np.hypot(lines[near, 0], lines[near, 1])[:, None] * lengths[near, None]
        best = np.linalg.svd(weighted, full_matrices=False)[2][-1]
    near = _towards(best, middles, ways) < allowed
    if near.sum() < settings.pieces or lengths[near].sum() < settings.share * lengths.sum():
        return None
    return np.asarray(best * [longer, longer, 1.0])


def _towards(point: FloatArray, middles: FloatArray, ways: FloatArray) -> FloatArray:
    """(n,) sine of the angle between each way and the direction to a homogeneous point."""
    to = point[:2] - point[2] * middles
    across = np.abs(ways[:, 0] * to[:, 1] - ways[:, 1] * to[:, 0])
    return np.asarray(across / np.maximum(np.hypot(*to.T), 1e-12))


def _view_from_above(
    right: FloatArray, down: FloatArray, longer: int, settings: FlattenSettings
) -> FloatArray | None:
    """(3, 3) the view of a camera turned so that both vanishing points lie at infinity, along x and y."""
    right, down = (one / np.linalg.norm(one / [longer, longer, 1]) for one in (right, down))
    focal = settings.focal * longer
    if abs(right[2] * down[2]) > 1e-3:
        square = -(right[0] * down[0] + right[1] * down[1]) / (right[2] * down[2])
        if square > 0 and settings.least_focal < np.sqrt(square) / longer < settings.most_focal:
            focal = float(np.sqrt(square))
    camera = np.diag([focal, focal, 1.0])
    first, second = (np.linalg.solve(camera, one) for one in (right, down))
    first, second = (
        first / np.linalg.norm(first) * np.sign(first[0]),
        second / np.linalg.norm(second) * np.sign(second[1]),
    )
    turned = np.stack([first, second, np.cross(first, second)], axis=1)
    if abs(np.linalg.det(turned)) < 0.5 or turned[2, 2] < np.cos(np.radians(settings.steepest)):
        return None
    return np.asarray(camera @ np.linalg.inv(turned) @ np.linalg.inv(camera))


def _by_paper(gray: Picture, settings: FlattenSettings) -> Found | None:
    """The corners of a bright sheet on a darker ground, with four straight edges, or None."""
    import cv2

    smooth = cv2.morphologyEx(gray, cv2.MORPH_CLOSE, np.ones((15, 15), np.uint8))
    level, bright = cv2.threshold(smooth, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    outside = smooth[bright == 0]
    if not len(outside) or np.median(outside) > 0.8 * np.median(smooth[bright > 0]) or level < 40:
        return None
    contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    sheet = cv2.convexHull(max(contours, key=cv2.contourArea))
    area = float(cv2.contourArea(sheet))
    corners = (
        cv2.approxPolyDP(sheet, 0.03 * cv2.arcLength(sheet, True), True).reshape(-1, 2).astype(np.float64)
    )
    if (
        len(corners) != 4
        or area < settings.least_paper * gray.size
        or _at_border(corners, gray.shape).sum() > 1
    ):
        return None
    if cv2.contourArea(corners.astype(np.float32)) < 0.93 * area:
        return None
    corners = corners[np.argsort(np.arctan2(*(corners - corners.mean(axis=0)).T[::-1]))]
    corners = np.roll(corners, -int(np.argmin(corners.sum(axis=1))), axis=0)
    centred = np.hstack([corners - np.array(gray.shape[::-1]) / 2, np.ones((4, 1))])
    lines = np.cross(centred, np.roll(centred, -1, axis=0))
    right, down = np.cross(lines[0], lines[2]), np.cross(lines[1], lines[3])
    matrix = _view_from_above(right, down, max(gray.shape), settings)
    if matrix is None:
        return None
    centre = np.array(gray.shape[::-1]) / 2
    return matrix @ np.array([[1, 0, -centre[0]], [0, 1, -centre[1]], [0, 0, 1.0]]), corners, "paper"


def _at_border(corners: FloatArray, shape: tuple[int, ...]) -> BoolArray:
    size = np.array(shape[1::-1])
    return np.asarray(((corners < 4) | (corners > size - 5)).any(axis=1))


def _flat(
    picture: Picture, matrix: FloatArray, region: FloatArray, found_by: FoundBy, settings: FlattenSettings
) -> FlatPhoto:
    """The part of a photograph around a region (n, 2), seen through a matrix, at about its own size."""
    import cv2

    height, width = picture.shape[:2]
    frame = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    middle = np.median(region, axis=0)
    matrix = matrix / _scale_at(matrix, middle)
    depths = _depths(matrix, np.vstack([middle, region, frame]))
    if (depths[0] * depths[: -len(frame)]).min() <= 0:
        return FlatPhoto(picture, np.asarray, "picture")
    moved = _transformed(matrix, region)
    back = moved - moved.mean(axis=0) - (region - region.mean(axis=0))
    if np.abs(back).max() < settings.slight * max(height, width):
        return FlatPhoto(picture, np.asarray, "picture")
    low, high = np.percentile(moved, [1, 99], axis=0)
    around = settings.margin * (high - low)
    low, high = low - around, high + around
    if (depths[0] * depths[-len(frame) :]).min() > 0:  # else the photograph reaches beyond the horizon
        moved_frame = _transformed(matrix, frame)
        low, high = np.maximum(low, moved_frame.min(axis=0)), np.minimum(high, moved_frame.max(axis=0))
    size = np.maximum(1, np.ceil(high - low)).astype(int)
    shrunk = min(1.0, float(np.sqrt(settings.largest * width * height / (float(size[0]) * size[1]))))
    place = np.array([[shrunk, 0, -shrunk * low[0]], [0, shrunk, -shrunk * low[1]], [0, 0, 1]])
    whole = place @ matrix
    output = int(np.ceil(shrunk * size[0])), int(np.ceil(shrunk * size[1]))
    flat = cv2.warpPerspective(
        picture, whole, output, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    inverse = np.linalg.inv(whole)
    return FlatPhoto(flat, lambda points: _transformed(inverse, np.asarray(points, float)), found_by)


def _depths(matrix: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(points @ matrix[2, :2] + matrix[2, 2])


def _transformed(matrix: FloatArray, points: FloatArray) -> FloatArray:
    moved = points @ matrix[:2, :2].T + matrix[:2, 2]
    return np.asarray(moved / _depths(matrix, points)[:, None])


def _scale_at(matrix: FloatArray, point: FloatArray) -> FloatArray:
    """(3, 1) what the rows of a matrix are divided by, so that a point's surroundings keep their size."""
    near = _transformed(matrix, np.array([point, point + np.array([1, 0]), point + np.array([0, 1])]))
    area = abs(float(np.linalg.det(near[1:] - near[0])))
    return np.array([[np.sqrt(area)], [np.sqrt(area)], [1.0]])
