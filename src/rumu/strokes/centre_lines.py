"""The frame that master and copy have in common, and the centre lines of their ink in it.

The frame of everything that speaks of strokes: (x, y) in rms radii of the master's ink, origin at its
centroid, x right and y DOWN as on the page. The registration brings the copy's ink into it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from rumu.registration.points import ink_mask
from rumu.surface.skeleton import Skeleton, Stroke, as_written, skeletonise, strokes
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Polyline, Registration, Surface

SIDE = 256
"""Pixels along each side of a picture of the frame."""
SCALE = 48.0
"""Pixels of that picture for one rms radius of the master's ink."""


@dataclass(frozen=True, slots=True)
class LineSettings:
    """How centre lines are cut into strokes and sampled. Lengths in stroke widths unless said.

    shortest: a line shorter than this that joins another is a corner of it and no stroke.
    speck: share of the ink below which a lone dot is no stroke.
    corner: degrees of turning, over a stroke's width to each side, at which one stroke becomes two.
    shortest_arm: pixels, at least, of the two sides between which turning is measured.
    uncut: length of a line, and of what is left at its ends, in those sides, below which nothing is cut.
    rising, taper: slope from which a line that rises to the right may be a left-falling stroke, written from
        the right; and the width of its left third over its right third below which it is one.
    fork: distance from a fork up to which the half-width is not that of one stroke.
    spacing: distance of sampled points, rms radii. most_points: on all lines of a picture together, so that
        matching takes the same time for every character.
    """

    shortest: float = 0.9
    speck: float = 0.008
    corner: float = 50.0
    shortest_arm: int = 3
    uncut: tuple[float, float] = (4.0, 1.3)
    rising: float = 0.45
    taper: float = 0.85
    fork: float = 0.75
    spacing: float = 0.05
    most_points: int = 180


LINES = LineSettings()


@dataclass(frozen=True, eq=False)
class FramedInk:
    """Ink in the common frame.

    ink: (SIDE, SIDE) bool. to_picture: (2, 3), takes (x, y) of the frame to fractions of the picture that the
        ink came from, origin top left. enlargement: pixels here for one of that picture; below 1 it shrank.
    """

    ink: BoolArray
    to_picture: FloatArray
    enlargement: float

    @cached_property
    def skeleton(self) -> Skeleton:
        """The skeleton of the ink, in pixels of the frame."""
        return skeletonise(self.ink)

    @cached_property
    def pieces(self) -> IntArray:
        """(SIDE, SIDE): the number of the connected piece of ink that each pixel belongs to, 0 for paper."""
        import cv2

        return np.asarray(cv2.connectedComponents(self.ink.view(np.uint8), connectivity=8)[1])

    @cached_property
    def off_ink(self) -> FloatArray:
        """(SIDE, SIDE): how far off the ink each pixel lies, in pixels."""
        import cv2

        return np.asarray(cv2.distanceTransform((~self.ink).view(np.uint8), cv2.DIST_L2, 5))

    def outline_of(self, part: BoolArray) -> FloatArray:
        """(n, 2) the longest edge of some pixels of the frame, on the picture, closed."""
        import cv2

        edges, _ = cv2.findContours(part.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        edge = max(edges, key=len)[:, 0, :].astype(float)
        return self.on_picture(from_pixels(np.concatenate([edge, edge[:1]])))

    def on_picture(self, points: FloatArray) -> FloatArray:
        """(n, 2) of the frame -> (n, 2) fractions of the picture, origin top left."""
        return np.asarray(points @ self.to_picture[:, :2].T + self.to_picture[:, 2])


@dataclass(frozen=True, slots=True, eq=False)
class CentreLine(Polyline):
    """A line in the middle of the ink, in the common frame: one stroke of the master, between corners.

    points run as a stroke is written: from left to right, or downward.
    free: whether its beginning and its end join no other line. clear: (n,) away from forks, where the
    half-width is the stroke's own. arc: (n,) length of the line up to each point, rms radii.
    number: of the canonical stroke that it is, or is a part of, from 1; 0 when that is not known.
    """

    free: tuple[bool, bool]
    clear: BoolArray
    arc: FloatArray
    number: int = 0

    @property
    def length(self) -> float:
        return float(self.arc[-1])


@dataclass(frozen=True, slots=True, eq=False)
class LinePoints:
    """Points along lines, evenly spaced.

    xy: (n, 2) rms radii. double: (n, 2) (cos 2t, sin 2t) of the line's direction, 0 for a dot.
    radius: (n,) half-width, rms radii. owner: (n,) number of the line. clear: (n,) away from forks, so that
        the half-width is that of one stroke. spacing: between neighbours, rms radii.
    """

    xy: FloatArray
    double: FloatArray
    radius: FloatArray
    owner: IntArray
    clear: BoolArray
    spacing: float


@dataclass(frozen=True, slots=True, eq=False)
class CentreLines:
    """All lines of a picture. points: along the lines; width: of a common stroke, rms radii."""

    lines: tuple[CentreLine, ...]
    points: LinePoints
    width: float


def frame_ink(mask: BoolArray, points: PointSet, *, pose: FloatArray | None = None) -> FramedInk:
    """Ink, (H, W), drawn into the common frame.

    points: of that ink. pose: (4, 4) that lays them on the master's, see `Registration`; None for the master.
    """
    import cv2

    to_picture = _frame_to_picture(points, np.eye(4) if pose is None else pose)
    h, w = mask.shape
    to_pixel = np.array([[w, 0.0], [0.0, h]]) @ to_picture  # continuous, pixel centres at a half
    linear = to_pixel[:, :2] / SCALE
    offset = to_pixel[:, 2] - 0.5 - linear @ np.full(2, (SIDE - 1) / 2)
    shrinkage = float(np.sqrt(abs(np.linalg.det(linear))))
    image = mask.view(np.uint8) * np.uint8(255)
    if shrinkage > 1.0:  # smooth before shrinking, or edges alias
        image = cv2.GaussianBlur(image, (0, 0), 0.4 * shrinkage)
    M = np.column_stack([linear, offset])
    flat = cv2.warpAffine(image, M, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    return FramedInk(np.asarray(flat > 127), to_picture, 1.0 / shrinkage)


def frame_copy(copy: Surface, registration: Registration) -> FramedInk:
    """The copy's ink as it lies on the master when lean, place and size are taken out."""
    return frame_ink(ink_mask(copy), registration.probe, pose=registration.T_reference_probe)


def _frame_to_picture(points: PointSet, pose: FloatArray) -> FloatArray:
    """(2, 3): (x, y down) of the frame -> fractions of the picture, origin top left."""
    R, t = pose[:2, :2], pose[:2, 3]
    flip = np.diag([1.0, -1.0])
    # frame -> y up -> before the pose -> fractions of the longer side from the middle -> fractions
    linear = points.radius * R.T @ flip
    constant = -points.radius * R.T @ t + points.centre
    cell = np.array(points.cell)
    linear, constant = (flip @ linear) / cell[:, None], 0.5 + flip @ constant / cell
    return np.column_stack([linear, constant])


def to_pixels(points: FloatArray) -> FloatArray:
    """(n, 2) of the frame -> (n, 2) (column, row) of its picture."""
    return np.asarray(points * SCALE + (SIDE - 1) / 2)


def from_pixels(points: FloatArray) -> FloatArray:
    """(n, 2) (column, row) of a picture of the frame -> (n, 2) of the frame."""
    return np.asarray((points - (SIDE - 1) / 2) / SCALE)


def pixels_at(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Row and column, (n,) each, of the pixels nearest to (n, 2) points of the frame."""
    column, row = np.clip(np.round(to_pixels(points)).astype(np.intp), 0, SIDE - 1).T
    return row, column


def find_strokes(framed: FramedInk) -> CentreLines:
    """The strokes of a master, longest first, cut at corners; spurs at corners are dropped."""
    skeleton = framed.skeleton
    pieces = [piece for stroke in strokes(skeleton) for piece in _cut_at_corners(stroke, skeleton)]
    least = LINES.shortest * skeleton.width
    longest = max(pieces, key=lambda piece: piece.length)
    speck = LINES.speck * framed.ink.sum()
    chosen = [
        piece
        for piece in pieces
        if piece.length >= least
        or (all(_free_ends(piece, skeleton)) and _ink_area(piece) > speck)
        or piece is longest
    ]
    lines = tuple(
        _in_writing_direction(piece, skeleton) for piece in sorted(chosen, key=lambda piece: -piece.length)
    )
    return CentreLines(lines, sample_lines(lines), skeleton.width / SCALE)


def find_segments(framed: FramedInk) -> CentreLines:
    """All lines of a copy, from fork to fork: which strokes they belong to is what matching finds out."""
    skeleton = framed.skeleton
    lines = tuple(_centre_line(segment, (False, False), skeleton) for segment in skeleton.segments)
    return CentreLines(lines, sample_lines(lines), skeleton.width / SCALE)


def _ink_area(stroke: Stroke) -> float:
    """Of a stroke with round ends, in pixels."""
    r = float(stroke.radius.mean())
    return 2.0 * r * stroke.length + np.pi * r**2


def _cut_at_corners(stroke: Stroke, skeleton: Skeleton) -> list[Stroke]:
    """A stroke in pieces, from corner to corner."""
    pieces = between_corners(stroke.points, arm=max(round(skeleton.width), LINES.shortest_arm))
    return [stroke] if len(pieces) == 1 else [as_written(stroke.part(a, b)) for a, b in pieces]


def between_corners(points: FloatArray, *, arm: int) -> list[tuple[int, int]]:
    """First and last point of each piece of an evenly spaced line, (n, 2), that is cut at its corners.

    arm: points of the two sides between which turning is measured.
    """
    n, (whole, margin) = len(points), LINES.uncut
    if n < whole * arm:
        return [(0, n - 1)]
    before, after = points[arm:-arm] - points[: -2 * arm], points[2 * arm :] - points[arm:-arm]
    cos = (before * after).sum(axis=1) / np.maximum(np.hypot(*before.T) * np.hypot(*after.T), 1e-9)
    turning = np.zeros(n)
    turning[arm:-arm] = np.degrees(np.arccos(np.clip(cos, -1.0, 1.0)))
    turning[: int(margin * arm)] = turning[n - int(margin * arm) :] = 0.0
    cuts: list[int] = []
    while turning.max() >= LINES.corner:
        k = int(turning.argmax())
        cuts.append(k)
        turning[max(k - 2 * arm, 0) : k + 2 * arm] = 0.0
    return list(pairwise([0, *sorted(cuts), n - 1]))


def _free_ends(stroke: Stroke, skeleton: Skeleton) -> tuple[bool, bool]:
    """Whether its beginning and its end join nothing."""
    first, last = (end >= 0 and bool(skeleton.degree[end] < 2) for end in stroke.ends)
    return first, last


def _in_writing_direction(stroke: Stroke, skeleton: Skeleton) -> CentreLine:
    """A stroke's centre line in the direction of writing."""
    (right, down), third = stroke.chord, max(len(stroke.points) // 3, 1)
    start, end = (float(part.mean()) for part in (stroke.radius[:third], stroke.radius[-third:]))
    if right > 0 and down < -LINES.rising * right and start < LINES.taper * end:
        stroke = stroke.reversed()  # a left-falling stroke that lies flat
    return _centre_line(stroke, _free_ends(stroke, skeleton), skeleton)


def _centre_line(line: Polyline, free: tuple[bool, bool], skeleton: Skeleton) -> CentreLine:
    """A line in pixels as a line in the common frame."""
    clear = np.ones(len(line.points), bool)
    forks = skeleton.nodes[skeleton.degree > 2]
    if len(forks):
        x, y = (line.points[:, k, None] - forks[:, k] for k in (0, 1))
        squared = (x * x + y * y).min(axis=1)
        clear = np.asarray(squared > (LINES.fork * skeleton.width) ** 2)
    step = line.points[1:] - line.points[:-1]
    arc = np.concatenate([[0.0], np.cumsum(np.sqrt((step * step).sum(axis=1)) / SCALE)])
    return CentreLine(from_pixels(line.points), line.radius / SCALE, free, clear, arc)


def doubled_directions(points: FloatArray) -> FloatArray:
    """(n, 2) (cos 2t, sin 2t) of the direction of a line at its points, (n, 2); 0 where it has none."""
    return _doubled(_ways(points))


def _ways(points: FloatArray) -> FloatArray:
    """(n, 2): at each point of a line, (n, 2), the mean of the steps before and after it."""
    ways = np.zeros_like(points)
    ways[1:-1] = (points[2:] - points[:-2]) / 2.0
    if len(points) > 1:
        ways[0], ways[-1] = points[1] - points[0], points[-1] - points[-2]
    return ways


def _doubled(ways: FloatArray) -> FloatArray:
    angle, known = 2 * np.arctan2(ways[:, 1], ways[:, 0]), np.hypot(*ways.T) > 1e-9
    return np.asarray(np.column_stack([np.cos(angle), np.sin(angle)]) * known[:, None])


def sample_lines(lines: tuple[CentreLine, ...], *, most: int = LINES.most_points) -> LinePoints:
    """Points on lines at the usual spacing, or about `most` where the lines are long."""
    total = sum(line.length for line in lines)
    spacing = max(LINES.spacing, total / most)
    xy, ways, radius, owner, clear = [], [], [], [], []
    for k, line in enumerate(lines):
        arc = line.arc
        count = max(round(arc[-1] / spacing) + 1, 2) if arc[-1] > 0 else 1
        at = np.linspace(0.0, arc[-1], count)
        points = np.column_stack([np.interp(at, arc, line.points[:, i]) for i in (0, 1)])
        xy.append(points)
        ways.append(_ways(points))
        radius.append(np.interp(at, arc, line.radius))
        owner.append(np.full(len(at), k))
        clear.append(np.interp(at, arc, line.clear.astype(float)) > 0.5)
    return LinePoints(
        xy=np.concatenate(xy),
        double=_doubled(np.concatenate(ways)),
        radius=np.concatenate(radius),
        owner=np.concatenate(owner),
        clear=np.concatenate(clear),
        spacing=spacing,
    )
