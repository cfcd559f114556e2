"""A photograph of a page becomes the page as it lies flat: by printed lines, the paper's edge, the text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from rumu.capture.image import shrink
from rumu.errors import ImageError
from rumu.pages.line_evidence import Picture
from rumu.pages.paper_edge import PaperEdgeSettings, find_paper, is_whole_sheet, view_by_paper
from rumu.pages.text_view import view_by_text
from rumu.pages.vanishing_points import VanishingSettings, view_by_lines
from rumu.values import BoolArray, FloatArray

FoundBy = Literal["lines", "paper", "text", "picture"]


@dataclass(frozen=True, slots=True)
class FlattenSettings:
    """How a page is found in a photograph.

    side: longer side, in pixels, of the reduced picture that is searched. segment: least length of a straight
        piece, as a share of it.
    slight: corners that move by less than this share of the longer side are left where they are.
    margin: around the page, as a share of it. inside: share of the lines that lie on the sheet, or the bright
        part of the picture is not the page.
    largest: most pixels of the flat page over the photograph's.
    """

    side: int = 900
    segment: float = 0.055
    slight: float = 0.008
    margin: float = 0.01
    inside: float = 0.8
    largest: float = 1.6
    vanishing: VanishingSettings = field(default_factory=VanishingSettings)
    paper: PaperEdgeSettings = field(default_factory=PaperEdgeSettings)


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
        "lines": two families of straight lines, a frame, a grid or ruled lines; "paper": its edge; "text":
        its columns and rows of characters; "picture": nothing was found, and the picture is as it was.
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
        The picture itself where nothing shows how the page lies, or where it lies flat already. The ground
        around a sheet of paper is cut off; which way up it stands is not asked, see `quarter_turns`.

    Raises
    ------
    ImageError
        If it is no such picture.
    """
    import cv2

    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
        raise ImageError(f"expected a (H, W, 3) uint8 picture, got {picture.shape} {picture.dtype}")
    settings = settings or FlattenSettings()
    small = shrink(picture, side=settings.side)
    if min(small.shape[:2]) < 32:
        return FlatPhoto(picture, np.asarray, "picture")
    gray = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), np.uint8)
    pieces = _straight_pieces(gray, settings)
    sheet = find_paper(gray, settings=settings.paper)
    whole = sheet is not None and is_whole_sheet(sheet, gray.shape, settings=settings.paper)
    if sheet is not None and whole:
        pieces = pieces[_on_sheet(sheet, pieces)]  # tiles and boards of a desk have straight lines, too
    matrix, found_by = _view(small, gray, pieces, sheet, settings)
    if matrix is None:
        return FlatPhoto(picture, np.asarray, "picture")
    height, width = small.shape[:2]
    if sheet is None or (len(pieces) and _on_sheet(sheet, pieces).mean() < settings.inside):
        sheet = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    scale = np.array(picture.shape[1::-1]) / (width, height)
    to_centre = np.array([[1, 0, -width / 2], [0, 1, -height / 2], [0, 0, 1.0]])
    matrix = matrix @ to_centre @ np.diag([*(1 / scale), 1.0])
    return _flat(picture, matrix, sheet * scale, found_by, settings, cut=whole)


def _straight_pieces(gray: Picture, settings: FlattenSettings) -> FloatArray:
    """(n, 4) both ends, x and y, of long straight edges; in pixels of the reduced picture."""
    import cv2

    detected = cv2.createLineSegmentDetector().detect(gray)[0]
    if detected is None:
        return np.zeros((0, 4))
    pieces = np.asarray(detected, np.float64).reshape(-1, 4)
    long = np.hypot(*(pieces[:, 2:] - pieces[:, :2]).T) >= settings.segment * max(gray.shape)
    return np.ascontiguousarray(pieces[long])


def _view(
    small: Picture, gray: Picture, pieces: FloatArray, sheet: FloatArray | None, settings: FlattenSettings
) -> tuple[FloatArray | None, FoundBy]:
    """(3, 3) the view from above of the reduced photograph, centred, and what showed it."""
    centre, longer = np.array(gray.shape[::-1]) / 2, max(gray.shape)
    matrix = view_by_lines(pieces - np.tile(centre, 2), longer, settings=settings.vanishing)
    if matrix is not None:
        return matrix, "lines"
    if sheet is not None:
        matrix = view_by_paper(sheet, gray.shape, settings=settings.paper, vanishing=settings.vanishing)
        if matrix is not None:
            return matrix, "paper"
    return view_by_text(small, vanishing=settings.vanishing), "text"


def _on_sheet(sheet: FloatArray, pieces: FloatArray) -> BoolArray:
    """(n,) bool: which of the straight pieces (n, 4) lie on a sheet or along its edge."""
    import cv2

    outline = sheet.astype(np.float32).reshape(-1, 1, 2)
    reach = -0.01 * cv2.arcLength(outline, True)
    middles = (pieces[:, :2] + pieces[:, 2:]) / 2
    return np.array(
        [cv2.pointPolygonTest(outline, (float(x), float(y)), True) > reach for x, y in middles], bool
    )


def _flat(
    picture: Picture,
    matrix: FloatArray,
    region: FloatArray,
    found_by: FoundBy,
    settings: FlattenSettings,
    *,
    cut: bool,
) -> FlatPhoto:
    """The part of a photograph around a region (n, 2), seen through a matrix, at about its own size.

    cut: what lies around the region is cut off even where the page lies flat already.
    """
    import cv2

    height, width = picture.shape[:2]
    frame = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    middle = region.mean(axis=0)
    matrix = matrix / _scale_at(matrix, middle)
    depths = _depths(matrix, np.vstack([middle, region, frame]))
    if (depths[0] * depths[: -len(frame)]).min() <= 0:
        return FlatPhoto(picture, np.asarray, "picture")
    moved = _transformed(matrix, region)
    back = moved - moved.mean(axis=0) - (region - region.mean(axis=0))
    if not cut and np.abs(back).max() < settings.slight * max(height, width):
        return FlatPhoto(picture, np.asarray, "picture")
    low, high = moved.min(axis=0), moved.max(axis=0)
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
