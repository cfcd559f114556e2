"""A master's lines, all or some of them, laid on a copy's ink.

What is missing from a copy changes the middle and the spread of its ink, and so its frame. So lines can be
left out, and the copy framed as the rest of the master would frame it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.strokes.centre_lines import (
    SCALE,
    SIDE,
    CentreLines,
    FramedInk,
    LinePoints,
    find_segments,
    to_pixels,
)
from rumu.strokes.matching import LineMatch, MatchSettings, find_covered, match_lines, squared_distances
from rumu.strokes.measures import MEASURES
from rumu.values import BoolArray, FloatArray, IntArray

UNEVEN_WEIGHT = 2.0
"""Weight, beside shares of ink, of the mean square (rms radii) by which lines leave one affine move."""
NEAR = 0.35
"""Reach of a line's neighbours, rms radii, when its place is predicted from theirs."""
NUDGE = (0.5, 0.37)
"""Pixels (x, y) by which ink is moved when it is changed a little."""
BESIDE, BESIDE_BEFORE, ALIKE = 0.6, 0.8, 0.5
"""Stroke widths within which two points lie on the same ink; the same before they were moved, where that is
no fault; and cosine of twice the angle from which they run alike."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A master's lines on a copy's ink.

    found: where they lie. covered: (n,) which of the master's points found ink; owner: (m,) the line that
    each of the copy's belongs to, or -1. left_over: share of the master's ink that found none, of the copy's
    that is unexplained, and how unevenly strokes moved.
    """

    found: LineMatch
    covered: BoolArray
    owner: IntArray
    left_over: float


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """A copy beside its master, in the common frame.

    master, copy: their lines. framed: the copy's ink. places: (n, 2) where the master's points lie when it is
    measured in the same way.
    """

    master: CentreLines
    copy: CentreLines
    framed: FramedInk
    places: FloatArray


def place_lines(
    master: CentreLines,
    copy: CentreLines,
    *,
    kept: BoolArray | None = None,
    settings: MatchSettings | None = None,
) -> Placement:
    """Lay a master's points, all or those that are kept, (n,), on a copy's.

    What they leave over is a share of all of the master's ink.
    """
    points, ink = master.points if kept is None else _subset(master.points, kept), copy.points
    near = MEASURES.own_ink_reach * max(master.width, copy.width)
    found = match_lines(points, ink, settings=settings)
    covered, owner = find_covered(found, ink, points, near=near)
    unexplained = float(ink.radius[owner < 0].sum() / ink.radius.sum())
    lost = float(points.radius[~covered].sum()) / float(master.points.radius.sum())
    uneven = unevenness(points, found.moved, covered)
    return Placement(found, covered, owner, lost + unexplained + UNEVEN_WEIGHT * uneven)


def stroke_numbers(lines: CentreLines) -> IntArray:
    """(n,) for each point of the lines the number of its stroke; 0 for what is no canonical stroke.

    Where canonical strokes are not known, minus the number of the line, from -1.
    """
    own = np.array([line.number for line in lines.lines])
    if not own.any():
        own = -1 - np.arange(len(own))
    return np.asarray(own[lines.points.owner])


def lay_without(
    master: CentreLines, copy: CentreLines, numbers: IntArray, missing: tuple[int, ...]
) -> tuple[Placement, FloatArray]:
    """The rest of a master's lines on a copy, and the (2, 3) move of the copy's points before they are laid.

    The frame rests on all ink. Without a stroke its middle and spread are others, so the copy is tried as it
    is framed, and as the rest of the master would frame it.
    """
    kept = ~np.isin(numbers, missing)
    tried = []
    for move in (np.eye(2, 3), _move_to_frame_of(master.points, kept, copy.points)):
        moved = replace(
            copy.points,
            xy=copy.points.xy @ move[:, :2].T + move[:, 2],
            radius=copy.points.radius * move[0, 0],
        )
        tried.append((place_lines(master, replace(copy, points=moved), kept=kept), move))
    return min(tried, key=lambda pair: pair[0].left_over)


def lay_rest(compared: Compared, missing: tuple[int, ...]) -> tuple[FramedInk, CentreLines, Placement]:
    """The copy's ink framed as the master's is without what is missing, and the lines on it.

    The points of what is missing stand where their neighbours predict them.
    """
    master, copy, framed, places = compared.master, compared.copy, compared.framed, compared.places
    numbers = stroke_numbers(master)
    kept = ~np.isin(numbers, missing)
    rest, move = lay_without(master, copy, numbers, missing)
    if (move != np.eye(2, 3)).any():
        framed = move_ink(framed, move)
        copy = find_segments(framed)
        rest = place_lines(master, copy, kept=kept)
    moved, covered = fill_in(rest, kept, places)
    responsibility = np.zeros((len(places), len(copy.points.xy)), np.float32)
    responsibility[kept] = rest.found.responsibility
    lines = np.unique(master.points.owner[kept])  # the rest's lines were numbered anew
    owner = np.where(rest.owner >= 0, lines[rest.owner], -1)
    return framed, copy, replace(rest, found=LineMatch(moved, responsibility), covered=covered, owner=owner)


def move_ink(framed: FramedInk, move: FloatArray) -> FramedInk:
    """Framed ink after a (2, 3) move of the frame's points."""
    import cv2

    half = (SIDE - 1) / 2
    A, t = move[:, :2], move[:, 2]
    pixels = np.column_stack([A, t * SCALE + half - A @ np.full(2, half)])
    ink = cv2.warpAffine(255 * framed.ink.view(np.uint8), pixels, (SIDE, SIDE), flags=cv2.INTER_LINEAR)
    back = np.linalg.inv(A)
    linear = framed.to_picture[:, :2] @ back
    to_picture = np.column_stack([linear, framed.to_picture[:, 2] - linear @ t])
    return FramedInk(np.asarray(ink > 127), to_picture, framed.enlargement * float(np.sqrt(np.linalg.det(A))))


def perturb_ink(framed: FramedInk, turn: float, scale: float, resolution: float) -> FramedInk:
    """Framed ink as another picture of it would show it: the middle moved by half a pixel, and coarser.

    turn: degrees. scale: about the middle. resolution: pixels of that picture for each of the frame, at
    most 1.
    """
    import cv2

    half, (right, down) = (SIDE - 1) / 2, NUDGE
    M = cv2.getRotationMatrix2D((half, half), turn, scale)
    M[:, 2] += right, down
    ink = 255 * framed.ink.view(np.uint8)
    if resolution < 1.0:
        coarse = cv2.resize(ink, None, fx=resolution, fy=resolution, interpolation=cv2.INTER_AREA)
        ink = cv2.resize(coarse, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
    moved = cv2.warpAffine(ink, M, (SIDE, SIDE), flags=cv2.INTER_LINEAR)
    return replace(framed, ink=np.asarray(moved > 127))


def predict_places(places: FloatArray, moved: FloatArray, known: BoolArray, wanted: BoolArray) -> FloatArray:
    """(k, 2): where the wanted points should lie, moved as the known ones near them are."""
    if not known.any():
        return places[wanted]
    squared = ((places[wanted][:, None] - places[known]) ** 2).sum(axis=2)
    weight = np.exp(-0.5 * squared / NEAR**2) + 1e-6
    shift = (weight @ (moved - places)[known]) / weight.sum(axis=1)[:, None]
    return np.asarray(places[wanted] + shift)


def fill_in(rest: Placement, kept: BoolArray, places: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(n, 2) where all of the master's points lie, and (n,) which found ink, when only some were laid.

    kept: (n,) those that were laid. places: (n, 2) where all lie in the master itself. The others stand where
    their neighbours predict them, and found none.
    """
    moved, covered = places.copy(), np.zeros(len(places), bool)
    moved[kept], covered[kept] = rest.found.moved, rest.covered
    moved[~kept] = predict_places(places, moved, covered, ~kept)
    return moved, covered


def draw_discs(points: FloatArray, radius: FloatArray) -> BoolArray:
    """(SIDE, SIDE) bool: discs about points of the frame, radii in its unit."""
    import cv2

    page = np.zeros((SIDE, SIDE), np.uint8)
    at = np.round(to_pixels(points) * 16).astype(np.int64)
    for (x, y), r in zip(at.tolist(), np.round(radius * SCALE * 16).astype(int).tolist(), strict=True):
        cv2.circle(page, (x, y), r, 1, -1, cv2.LINE_8, 4)
    return page.astype(bool)


def _subset(points: LinePoints, kept: BoolArray) -> LinePoints:
    """Some of the points, their lines numbered anew."""
    _, owner = np.unique(points.owner[kept], return_inverse=True)
    return LinePoints(
        points.xy[kept],
        points.double[kept],
        points.radius[kept],
        owner,
        points.clear[kept],
        points.spacing,
    )


def _move_to_frame_of(master: LinePoints, kept: BoolArray, copy: LinePoints) -> FloatArray:
    """(2, 3): the move that gives the copy the middle and the spread that the kept part has in the master."""

    def middle_and_spread(xy: FloatArray, weight: FloatArray) -> tuple[FloatArray, float]:
        middle = np.average(xy, axis=0, weights=weight)
        return middle, float(np.sqrt(np.average(((xy - middle) ** 2).sum(axis=1), weights=weight)))

    all_middle, all_spread = middle_and_spread(master.xy, master.radius)
    kept_middle, kept_spread = middle_and_spread(master.xy[kept], master.radius[kept])
    copy_middle, _ = middle_and_spread(copy.xy, copy.radius)
    factor = kept_spread / max(all_spread, 1e-9)
    shift = kept_middle + factor * (copy_middle - all_middle) - factor * copy_middle
    return np.column_stack([factor * np.eye(2), shift])


def claimed_twice(
    points: LinePoints, moved: FloatArray, places: FloatArray, *, own: BoolArray, width: float
) -> BoolArray:
    """(k,) which of a stroke's points lie on ink that another stroke claims, though they did not before.

    moved, places: (n, 2) all points, where they lie on the ink and where they came from. own: (n,) the
    stroke's.
    """
    alike = points.double[own] @ points.double[~own].T > ALIKE
    close, before = (
        ((squared_distances(at[own], at[~own]) < (reach * width) ** 2) & alike).any(axis=1)
        for at, reach in ((moved, BESIDE), (places, BESIDE_BEFORE))
    )
    return np.asarray(close & ~before)


def unevenness(points: LinePoints, moved: FloatArray, covered: BoolArray) -> float:
    """Mean square, rms radii, by which points leave the affine move that fits them all best."""
    basis = np.column_stack([points.xy, np.ones(len(moved))])
    weight = np.sqrt(points.radius * (0.05 + covered))[:, None]
    shift = moved - points.xy
    affine, *_ = np.linalg.lstsq(basis * weight, shift * weight, rcond=None)
    off = np.hypot(*(shift - basis @ affine).T)
    return float(np.average(np.minimum(off, 0.5) ** 2, weights=points.radius))
