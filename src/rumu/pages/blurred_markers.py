"""Whether a picture whose markers cannot be read shows a sheet all the same: one that is blurred.

Blur takes the pattern of a marker long before it takes the dark square. Dark spots of the size of markers
that stand where those of a sheet stand are one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from rumu.pages.marker_light import PER_MODULE, cut_marker, measure_markers
from rumu.pages.sheet_layout import MARKER, PAPERS, Paper, marker_boxes
from rumu.pages.sheet_markers import SIDE
from rumu.values import FloatArray

_SQRT_2PI = float(np.sqrt(2 * np.pi))
_CORNERS = (0, 6, 9, 4)  # markers that are tried in four places, clockwise; that beside the code runs into it


@dataclass(frozen=True, slots=True)
class BlurredMarkerSettings:
    """When dark spots are the markers of a sheet.

    look: longer side, in pixels, of the reduced picture. smooth: pixels by which it is blurred, so that white
        within a marker is none. paper: side, in its pixels, of the square in which what is brightest is
        paper. dark: share by which a spot is darker than it. light: least brightness of that paper, over what
        is bright in the picture.
    smallest, largest: width and height of a spot, in pixels. filled: share of its box that it fills.
    hull: so many of the outermost spots are tried as corners. least: share of the picture that the sheet
        covers.
    off: sides of a marker that one may lie beside its place. size: ratio of its width to that of a marker,
        and its inverse, at most. found: markers, of all, that must be there.
    soft: smear that the steepest edges within the markers allow, over that of their outer edges, at least.
    """

    look: int = 480
    smooth: float = 1.5
    paper: int = 41
    dark: float = 0.12
    light: float = 0.6
    smallest: int = 3
    largest: int = 30
    filled: float = 0.55
    hull: int = 9
    least: float = 0.12
    off: float = 0.6
    size: float = 1.7
    found: int = 9
    soft: float = 0.4


def blur_of_unread_markers(
    picture: npt.NDArray[np.uint8], *, settings: BlurredMarkerSettings | None = None
) -> float | None:
    """Millimetres by which the edges of markers are smeared that cannot be read; None where there are none.

    picture: (H, W, 3) uint8 sRGB.
    """
    import cv2

    settings = settings or BlurredMarkerSettings()
    factor = settings.look / max(picture.shape[:2])
    # in the red channel neither grid nor models are dark
    small = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)[:, :, 0]
    spots = _find_spots(np.ascontiguousarray(small), settings)
    if len(spots) < settings.found:
        return None
    for corners in _corner_choices(spots[:, :2], small.shape[0] * small.shape[1], settings):
        for paper in PAPERS:
            homography = _fit_sheet(spots, corners, paper, settings)
            if homography is not None:
                return _measure(picture, homography, paper, factor, settings)
    return None


def _find_spots(small: npt.NDArray[np.uint8], settings: BlurredMarkerSettings) -> FloatArray:
    """(n, 3): x, y and width of the dark spots of a picture that may be markers."""
    import cv2

    small = cv2.GaussianBlur(small, (0, 0), settings.smooth)
    level = cv2.morphologyEx(small, cv2.MORPH_CLOSE, np.ones((settings.paper, settings.paper), np.uint8))
    dark = small < (1 - settings.dark) * level.astype(np.float32)
    _, _, stats, centres = cv2.connectedComponentsWithStats(dark.astype(np.uint8), connectivity=4)
    wide, high, area = stats[1:, 2], stats[1:, 3], stats[1:, 4]
    shorter, longer = np.minimum(wide, high), np.maximum(wide, high)
    fits = (shorter >= settings.smallest) & (longer <= settings.largest) & (longer <= 2 * shorter)
    fits &= area >= settings.filled * wide * high
    column, row = centres[1:].astype(int).T
    fits &= level[row, column] > settings.light * np.quantile(level, 0.9)  # on paper, not on the desk
    return np.asarray(np.column_stack([centres[1:], np.sqrt(area)])[fits])


def _corner_choices(places: FloatArray, pixels: int, settings: BlurredMarkerSettings) -> Iterator[FloatArray]:
    """Four of the outermost spots at a time, clockwise, (4, 2), each of them first once."""
    import cv2

    hull = cv2.convexHull(places.astype(np.float32), clockwise=False)[:, 0]  # it counts y upward
    while len(hull) > settings.hull:  # the flattest corner is the least of one
        before, after = np.roll(hull, 1, axis=0) - hull, np.roll(hull, -1, axis=0) - hull
        bend = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        hull = np.delete(hull, int(np.argmin(bend)), axis=0)
    for four in combinations(hull, 4):
        corners = np.array(four)
        if cv2.contourArea(corners) >= settings.least * pixels:
            for turn in range(4):
                yield np.roll(corners, turn, axis=0)


def _fit_sheet(
    spots: FloatArray, corners: FloatArray, paper: Paper, settings: BlurredMarkerSettings
) -> FloatArray | None:
    """The map from millimetres to pixels that brings four markers there; None where others are not seen."""
    import cv2

    boxes = marker_boxes(paper)
    on_paper = np.array([boxes[number].corners.mean(axis=0) for number in sorted(boxes)])
    chosen = on_paper[list(_CORNERS)].astype(np.float32)
    homography = cv2.getPerspectiveTransform(chosen, corners.astype(np.float32))
    beside = np.concatenate([on_paper + step for step in ((0.0, 0.0), (MARKER, 0.0), (0.0, MARKER))])
    seen, right, below = cv2.perspectiveTransform(beside[None], homography)[0].reshape(3, -1, 2)
    across, down = right - seen, below - seen
    side = np.sqrt(np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0]))
    distance = np.hypot(*(seen[:, None] - spots[None, :, :2]).transpose(2, 0, 1))
    nearest = distance.argmin(axis=1)
    ratio = spots[nearest, 2] / np.maximum(side, 1e-6)
    there = distance.min(axis=1) < settings.off * side
    there &= (ratio < settings.size) & (ratio > 1 / settings.size)
    return np.asarray(homography) if np.count_nonzero(there) >= settings.found else None


def _measure(
    picture: npt.NDArray[np.uint8],
    homography: FloatArray,
    paper: Paper,
    factor: float,
    settings: BlurredMarkerSettings,
) -> float | None:
    """Millimetres by which the edges of the markers are smeared, by their places in the reduced picture.

    None where edges within them are steep: characters and stains stand there, in a picture that is sharp.
    """
    import cv2

    gray = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)
    markers, steepest = [], []
    for number, box in marker_boxes(paper).items():
        places = cv2.perspectiveTransform(box.corners[None], homography)[0]
        corners = (places + 0.5) / factor - 0.5
        markers.append((number, corners))
        steepest.append(_steepness(cut_marker(gray, corners)))
    seen = measure_markers(gray, markers)
    smear = seen.blur / seen.side
    sharpest = 1 / (_SQRT_2PI * max(float(np.median(steepest)), 1e-9) * SIDE * PER_MODULE)
    return smear * MARKER if sharpest >= settings.soft * smear else None


def _steepness(patch: npt.NDArray[np.float32]) -> float:
    """How steep the steepest edges in a patch are: share of its contrast for each of its pixels."""
    import cv2

    smooth = cv2.GaussianBlur(patch, (0, 0), 1.0)
    slope = np.hypot(*np.gradient(smooth))
    contrast = float(np.quantile(patch, 0.95) - np.quantile(patch, 0.05))
    return float(np.quantile(slope, 0.98)) / max(contrast, 1.0)
