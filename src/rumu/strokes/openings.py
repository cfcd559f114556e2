"""Boxes such as 口 and 日 that the master closes and a copy leaves open at a corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rumu.characters.stroke_data import find_character
from rumu.strokes.centre_lines import SCALE, SIDE, from_pixels, pixels_at
from rumu.strokes.correspondence import StrokeMatch
from rumu.strokes.edges import InnerWhite, find_whites
from rumu.strokes.placement import stroke_numbers
from rumu.values import BoolArray, FloatArray

_TOUCHES = 4.0
"""Pixels of the common frame beyond a stroke's edge within which white lies at it."""
_POINTS = 3
"""Points of a line that must lie at a white for the line to be a side of it."""
_SIDES = 3
"""Strokes at least that make a box."""
_RASTER = 256
"""Pixels along the side of the picture in which the copybook's strokes are drawn."""
_BESIDE = 7
"""Pixels there from the white of a box to its sides, which stroke and fill leave a little apart."""
_BORDER = 60
"""Pixels there of a stroke that must lie at a white for the stroke to be a side of it."""
_THERE = 0.4
"""Share of a side that must have found ink for it to be there."""
_AMONG = 0.25
"""Stroke widths beyond the outermost of a box's lines where a gap may lie."""
_WIDE = 0.35
"""Stroke widths that half of a box's white must measure, for an opening of it to be seen."""
_MARGIN = 0.03
"""Rms radii by which a gap is drawn larger."""
_STEP = 0.5
"""Pixels by which ink is grown until it closes a box."""


@dataclass(frozen=True, slots=True, eq=False)
class Opening:
    """A box that is open.

    gap: in widths of the copy's strokes; across: the same in rms radii. towards: (2,) where it is from the
    middle of the white, in widths and heights of it, y down. box, at: (2,) the middle of the white and of the
    gap, in fractions of the copy's picture; outline: (n, 2) a circle about the gap, closed.
    """

    gap: float
    across: float
    towards: FloatArray
    box: FloatArray
    at: FloatArray
    outline: FloatArray


def find_openings(match: StrokeMatch, whites: tuple[InnerWhite, ...]) -> tuple[Opening, ...]:
    """The boxes of the master that the copy leaves open, the widest gap first.

    whites: that the master's ink encloses. Its sides must be those of a box of three strokes or more in the
    character as copybooks print it, and the copy must have them: strokes that only happen to meet make none.
    """
    depth, found = match.framed.off_ink, []
    for white in whites:
        sides = _points_at(match, white)
        strokes = _sides_of_box(match, sides)
        if white.half_width < _WIDE * match.master.width * SCALE or not strokes:
            continue
        known = sides & match.covered
        affine = np.column_stack([match.places[known], np.ones(known.sum())])
        move, _, rank, _ = np.linalg.lstsq(affine, match.moved[known], rcond=None)
        if rank < 3:
            continue
        own = from_pixels(white.pixels[:, ::-1].astype(float)) @ move[:2] + move[2]
        deepest = own[int(np.argmax(depth[pixels_at(own)]))]
        way_out = _way_out(depth, deepest)
        if way_out is not None and _is_within(match, strokes, deepest, way_out[0]):
            found.append(_opening(match, own, *way_out))
    return tuple(sorted(found, key=lambda opening: -opening.gap))


def _points_at(match: StrokeMatch, white: InnerWhite) -> BoolArray:
    """(n,) which points of the master's strokes lie at a white."""
    import cv2

    away = np.ones((SIDE, SIDE), np.uint8)
    away[tuple(white.pixels.T)] = 0
    distance = cv2.distanceTransform(away, cv2.DIST_L2, 5)[pixels_at(match.places)]
    return np.asarray(distance < match.master.points.radius * SCALE + _TOUCHES)


def _sides_of_box(match: StrokeMatch, sides: BoolArray) -> frozenset[int]:
    """The strokes at a white if they are the sides of boxes and the copy has them; else none."""
    if match.laid is None:
        return frozenset()
    numbers = stroke_numbers(match.master)
    strokes = {int(k) for k in np.unique(numbers[sides]) if (sides & (numbers == k)).sum() >= _POINTS}
    boxes = [box for box in boxes_of(match.laid.character.character) if box <= strokes]
    there = all(match.covered[numbers == number].mean() > _THERE for number in strokes)
    found = frozenset().union(*boxes)
    return found if there and found == strokes else frozenset()


def _is_within(match: StrokeMatch, strokes: frozenset[int], *points: FloatArray) -> bool:
    """Whether points of the frame lie among some strokes of the copy, and not beside them."""
    import cv2

    own = np.isin(stroke_numbers(match.master), list(strokes))
    hull = cv2.convexHull(match.moved[own].astype(np.float32))
    near = -_AMONG * match.master.width
    return all(cv2.pointPolygonTest(hull, tuple(map(float, at)), True) > near for at in points)


@lru_cache(maxsize=64)
def boxes_of(character: str) -> tuple[frozenset[int], ...]:
    """The numbers of the strokes, from 1, that enclose each white of a character as copybooks print it."""
    import cv2

    known = find_character(character)
    if known is None:
        return ()
    ink = np.zeros((len(known.strokes), _RASTER, _RASTER), np.uint8)
    for page, stroke in zip(ink, known.strokes, strict=True):
        cv2.fillPoly(page, [np.round(stroke.polygon() * _RASTER).astype(np.int32)], 1)
    near = np.ones((2 * _BESIDE + 1, 2 * _BESIDE + 1), np.uint8)
    boxes = []
    for white in find_whites(ink.max(axis=0) > 0):
        around = np.zeros((_RASTER, _RASTER), np.uint8)
        around[tuple(white.pixels.T)] = 1
        around = cv2.dilate(around, near)
        sides = [n for n, page in enumerate(ink, start=1) if np.count_nonzero(page & around) > _BORDER]
        if len(sides) >= _SIDES:
            boxes.append(frozenset(sides))
    return tuple(boxes)


def _way_out(depth: FloatArray, inside: FloatArray) -> tuple[FloatArray, float] | None:
    """The narrowest place on the widest way out of the white about a point: (2,) where, and half its width.

    depth: (SIDE, SIDE) distance of the white to the ink, pixels. None where the ink lets nothing out.
    """
    import cv2

    row, column = (int(v[0]) for v in pixels_at(inside[None]))
    radius = 0.0
    while True:
        labels = cv2.connectedComponents((depth > radius).view(np.uint8), connectivity=4)[1]
        if 0 in (labels[row, column], labels[0, 0]):
            return None  # it lies on ink, or all of the white is as narrow as the way out
        if labels[row, column] != labels[0, 0]:
            break
        radius += _STEP
    if radius == 0.0:
        return None
    within, beyond = (
        cv2.distanceTransform((labels != k).view(np.uint8), cv2.DIST_L2, 5)
        for k in (labels[row, column], labels[0, 0])
    )
    between = np.where(depth > 0, within + beyond, np.inf)
    at = np.array(np.unravel_index(int(between.argmin()), between.shape), float)[::-1]
    return from_pixels(at), radius / SCALE


def _opening(match: StrokeMatch, white: FloatArray, at: FloatArray, radius: float) -> Opening:
    """The opening of a white, (n, 2), at a place; radius: half of its width, rms radii."""
    middle = (white.min(axis=0) + white.max(axis=0)) / 2
    turn = np.linspace(0.0, 2 * np.pi, 25)
    circle = at + (radius + _MARGIN) * np.column_stack([np.cos(turn), np.sin(turn)])
    box, gap, *outline = match.framed.on_picture(np.vstack([middle, at, circle]))
    widths = 2 * radius / (match.master.width * match.width)
    return Opening(widths, 2 * radius, (at - middle) / np.ptp(white, axis=0), box, gap, np.array(outline))
