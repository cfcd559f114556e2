"""Connected parts of a page's ink: what may be writing, and the lines, pictures and shadows that are not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.errors import ImageError
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class PagePartSettings:
    """What counts as a line, a picture or a speck; lengths in sizes of a character.

    line: how long a straight run must be. thin: how thick a line, or a stroke, may be. long: how long a
    thin part must be for a line; flat: how wide one that lies must be, for writing runs down the page.
    picture: how wide and high a part of a picture is at least. solid: how thick ink must be that no
    brush writes. speck: the longer side of what is dirt. filled: share of its box that the ink of a
    frame takes at most. large: share of the page from which on a box is the page's own frame. lonely:
    how wide a strip around a thin line is empty but for it. hairline: how thick such a line is. gap: the
    longest gap in one that is broken.
    """

    line: float = 4.0
    thin: float = 0.25
    long: float = 2.6
    flat: float = 1.8
    picture: float = 3.2
    solid: float = 0.6
    speck: float = 0.09
    filled: float = 0.1
    large: float = 0.35
    lonely: float = 0.6
    hairline: float = 0.12
    gap: float = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class PageParts:
    """The parts of a page that may be writing, and what was taken away.

    ink: (H, W) bool, writing only. labels: (H, W) int32, 0 where there is none, else the number of the part.
    boxes: (n, 4) int, left, top, right and bottom of part 1, 2 ... n. areas: (n,) pixels. size: about what a
    character measures, in pixels. lines: (H, W) bool, ruled lines and frames. pictures: boxes of pictures.
    """

    ink: BoolArray
    labels: IntArray
    boxes: IntArray
    areas: IntArray
    size: float
    lines: BoolArray
    pictures: IntArray


def find_parts(
    ink: BoolArray, *, faint: BoolArray | None = None, settings: PagePartSettings | None = None
) -> PageParts:
    """Part the ink of a page into what may be writing and what is not.

    faint: (H, W) bool, the ink and marks nearly as dark; thin lines are followed in it.
    Raises ImageError where there is no ink.
    """
    settings = settings or PagePartSettings()
    size = character_size(ink, settings=settings)
    lines = _find_lines(ink, size, settings)
    if faint is not None:
        lines |= _find_lonely_lines(faint, size, settings)
    labels, boxes, areas = _label(ink & ~lines)
    frame, picture, kept = _choose(labels, boxes, areas, size, settings)
    lines |= _of_parts(labels, frame)
    pictures = _with_borders(boxes[picture], lines, settings)
    kept &= ~_inside(boxes, pictures)
    labels, boxes, areas = _label(_of_parts(labels, kept))
    return PageParts(labels > 0, labels, boxes, areas, size, lines, pictures)


def character_size(ink: BoolArray, *, settings: PagePartSettings | None = None) -> float:
    """About what a character measures in pixels: the shorter side of the larger parts."""
    settings = settings or PagePartSettings()
    _, boxes, areas = _label(ink)
    if not len(boxes):
        raise ImageError("expected a page with writing, got one without ink", zh="這張圖上沒有墨跡。")
    sides = boxes[:, 2:] - boxes[:, :2]
    longest = max(ink.shape)
    usual = (sides.max(axis=1) < 0.25 * longest) & (sides.max(axis=1) < 8 * sides.min(axis=1))
    usual &= sides.min(axis=1) > 2
    if not usual.any():
        return float(np.median(sides.max(axis=1)))
    return weighted_quantile(sides[usual].min(axis=1).astype(float), areas[usual].astype(float), 0.75)


def weighted_quantile(values: FloatArray, weights: FloatArray, share: float) -> float:
    """The value below which this share of the weights lies."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(reached, share * reached[-1])])


def _label(ink: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Numbers, boxes and areas of the connected parts."""
    import cv2

    _, labels, stats, _ = cv2.connectedComponentsWithStats(ink.view(np.uint8), connectivity=8)
    left, top, width, height, area = stats[1:].T
    return labels, np.column_stack([left, top, left + width, top + height]), area


def _of_parts(labels: IntArray, chosen: BoolArray) -> BoolArray:
    """(H, W) bool: the pixels of the chosen parts."""
    return np.asarray(np.concatenate([[False], chosen])[labels])


def _find_lines(ink: BoolArray, size: float, settings: PagePartSettings) -> BoolArray:
    """Straight ruled lines, also where writing touches them."""
    import cv2

    length = max(9, round(settings.line * size))
    mask = ink.view(np.uint8)
    lines = np.zeros_like(mask)
    for shape, across in (((length, 1), (1, 3)), ((1, length), (3, 1))):
        thick = cv2.dilate(mask, np.ones(across[::-1], np.uint8))  # so that a leaning line is one run
        runs = cv2.morphologyEx(thick, cv2.MORPH_OPEN, np.ones(shape[::-1], np.uint8))
        lines |= cv2.dilate(runs, np.ones(across[::-1], np.uint8))
    return (lines > 0) & ink


def _find_lonely_lines(faint: BoolArray, size: float, settings: PagePartSettings) -> BoolArray:
    """Thin lines with nothing beside them, broken ones too."""
    import cv2

    mask = faint.view(np.uint8)
    beside = max(5, round(settings.lonely * size)) | 1
    thin = max(2, round(settings.hairline * size))
    gap, length = max(3, round(settings.gap * size)), max(9, round(settings.line * size))
    lines = np.zeros_like(mask)
    for window, across in (((beside, 1), (3, 1)), ((1, beside), (1, 3))):
        around = cv2.boxFilter(mask, cv2.CV_16U, window, normalize=False, borderType=cv2.BORDER_CONSTANT)
        lonely = cv2.dilate(((around <= thin) & faint).view(np.uint8), np.ones(across[::-1], np.uint8))
        along = window[0] == 1  # the line runs from left to right
        joined = cv2.morphologyEx(lonely, cv2.MORPH_CLOSE, np.ones((1, gap) if along else (gap, 1), np.uint8))
        runs = cv2.morphologyEx(
            joined, cv2.MORPH_OPEN, np.ones((1, length) if along else (length, 1), np.uint8)
        )
        lines |= runs
    return lines > 0


def _choose(
    labels: IntArray, boxes: IntArray, areas: IntArray, size: float, settings: PagePartSettings
) -> tuple[BoolArray, BoolArray, BoolArray]:
    """(n,) bool each: the parts that are frames and lines, those of pictures, those that may be writing."""
    width, height = (boxes[:, 2:] - boxes[:, :2]).T / size
    area = areas / size**2
    longer, shorter = np.maximum(width, height), np.minimum(width, height)
    line = (longer > settings.long) & (area < 0.5 * settings.thin * longer + 0.2)
    line |= (width > settings.flat) & (height < settings.thin * width) & (area < settings.thin * longer)
    wide = shorter > settings.picture
    large = width * height * size**2 > settings.large * labels.size
    frame = line | (wide & (large | (area < settings.filled * width * height)))
    solid = _thickness(labels, len(boxes)) / size > settings.solid
    picture = wide & ~frame
    return frame, picture, ~(frame | solid | picture | (longer < settings.speck))


def _with_borders(pictures: IntArray, lines: BoolArray, settings: PagePartSettings) -> IntArray:
    """The boxes of pictures, each grown to the border drawn around it."""
    if not len(pictures):
        return pictures
    _, borders, _ = _label(lines)
    sides = borders[:, 2:] - borders[:, :2]
    borders = borders[sides.prod(axis=1) < settings.large * lines.size]
    grown = []
    for left, top, right, bottom in pictures:
        x, y = (left + right) / 2, (top + bottom) / 2
        around = borders[
            (borders[:, 0] < x) & (borders[:, 2] > x) & (borders[:, 1] < y) & (borders[:, 3] > y)
        ]
        both = np.concatenate([around, [[left, top, right, bottom]]])
        grown.append([*both[:, :2].min(axis=0), *both[:, 2:].max(axis=0)])
    return np.array(grown)


def _inside(boxes: IntArray, pictures: IntArray) -> BoolArray:
    """(n,) bool: whether the middle of each box lies in a picture."""
    inside = np.zeros(len(boxes), dtype=bool)
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    for left, top, right, bottom in pictures:
        inside |= ((middle > (left, top)) & (middle < (right, bottom))).all(axis=1)
    return inside


def _thickness(labels: IntArray, count: int) -> FloatArray:
    """(n,): the diameter of the largest disc within each part, in pixels."""
    import cv2

    inside = cv2.distanceTransform((labels > 0).view(np.uint8), cv2.DIST_L2, 3)
    if not count:
        return np.zeros(0)
    widest = np.zeros(count + 1, dtype=np.float32)
    at = inside > 3
    np.maximum.at(widest, labels[at], inside[at])
    return np.asarray(2 * widest[1:])
