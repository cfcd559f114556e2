"""The lines of a character as the structural methods take them: skeleton strokes, cut where they turn.

A turning of the brush (折) is written in one go by one hand and in two by another, and a round corner or a
spur joins or parts strokes on the skeleton that were not so written. Cut at its corners, a character has
much the same lines in every hand. Our reconstruction; all three methods that use it see the same lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from rumu.surface.skeleton import Skeleton, skeletonise, strokes
from rumu.values import FloatArray, IntArray, Polyline
from rumu_lab.baselines.cell import Cell


@dataclass(frozen=True, slots=True)
class CutSettings:
    """Where strokes are joined and cut.

    continuation: most degrees that a stroke turns in a fork. corner: degrees at which a stroke is cut.
    deviation: of the polygon that corners are sought on, in sides of the ink's box. arm: length of the
    chords whose turning is taken, in stroke widths.
    """

    continuation: float = 35.0
    corner: float = 45.0
    deviation: float = 0.02
    arm: float = 1.25


@dataclass(frozen=True, slots=True, eq=False)
class StrokeLine(Polyline):
    """A line of two points or more, (x, y) in order, with y as the caller has it; it can be sampled."""

    @property
    def middle(self) -> FloatArray:
        """(2,) float64, the point half-way along."""
        return np.asarray(self.at(np.array([0.5]))[0])

    def at(self, shares: FloatArray) -> FloatArray:
        """(m, 2) float64: the points at these shares of its length, 0 to 1."""
        along = self.along
        return np.column_stack([np.interp(shares * along[-1], along, v) for v in self.points.T])

    def radius_at(self, shares: FloatArray) -> FloatArray:
        """(m,) float64: the half-widths there."""
        along = self.along
        return np.asarray(np.interp(shares * along[-1], along, self.radius))


@lru_cache(maxsize=64)
def skeleton_of(cell: Cell) -> Skeleton:
    """The skeleton of a cell's ink, remembered: each method asks for it, and masters come again."""
    return skeletonise(cell.ink)


@lru_cache(maxsize=64)
def lines_of(cell: Cell) -> tuple[StrokeLine, ...]:
    """The lines of a cell in pixels of it, y downward, longest first; one at the least."""
    return cut_lines(skeleton_of(cell))


def cut_lines(skeleton: Skeleton) -> tuple[StrokeLine, ...]:
    """Strokes by good continuation, cut at corners; pixels of the mask, y downward, longest first."""
    settings = CutSettings()
    side = box_side(np.concatenate([s.points for s in skeleton.segments]))
    found = []
    for stroke in strokes(skeleton, turn=settings.continuation):
        line = as_line(stroke.points, stroke.radius)
        cuts = corners(
            line,
            deviation=settings.deviation * side,
            arm=settings.arm * skeleton.width,
            least=settings.corner,
        )
        marks = [0, *cuts, len(line.points) - 1]
        found += [line.part(a, b) for a, b in pairwise(marks)]
    return tuple(sorted(found, key=lambda line: -line.length))


def as_line(points: FloatArray, radius: FloatArray) -> StrokeLine:
    """A line of two points or more: a round dot becomes as long as its half-width, falling to the right.

    So are most dots written; a point by itself has no direction that could be compared.
    """
    if len(points) > 1 and np.hypot(*(points.max(axis=0) - points.min(axis=0))) > 1e-6:
        return StrokeLine(points, radius)
    half = np.array([0.5, 0.5]) * max(float(radius[0]), 1.0) / np.sqrt(2.0)
    return StrokeLine(np.array([points[0] - half, points[0] + half]), np.full(2, max(float(radius[0]), 0.5)))


def box_side(points: FloatArray) -> float:
    """Longer side of the box of (n, 2) points, at least 1."""
    return max(1.0, float((points.max(axis=0) - points.min(axis=0)).max()))


def polygon(points: FloatArray, *, deviation: float) -> list[int]:
    """Numbers of the points of an (n, 2) line that a polygon keeps, both ends among them (Ramer 1972).

    No point lies farther than `deviation` from the polygon.
    """
    kept, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        away = _off_chord(points[a : b + 1])
        k = int(away.argmax())
        if away[k] > deviation:
            kept.add(a + k)
            spans += [(a, a + k), (a + k, b)]
    return sorted(kept)


def _off_chord(points: FloatArray) -> FloatArray:
    """(n,) distance of each point to the piece of straight line from the first to the last."""
    chord, rel = points[-1] - points[0], points - points[0]
    share = np.clip(rel @ chord / max(float(chord @ chord), 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(*(rel - share[:, None] * chord).T))


def corners(line: StrokeLine, *, deviation: float, arm: float, least: float) -> list[int]:
    """Numbers of the points where a line turns by `least` degrees or more, in order, its ends left out.

    Sought on the vertices of its polygon; the turning is that between the chords that reach `arm` to both
    sides, so a round corner counts whole. Nearer than an arm to an end or to a sharper corner is none.
    """
    vertices = np.array(polygon(line.points, deviation=deviation)[1:-1], dtype=np.intp)
    if len(vertices) == 0:
        return []
    along = line.along
    turning = turnings(line, vertices, arm=arm)
    found: list[int] = []
    for k in np.argsort(-turning, kind="stable"):
        place = along[vertices[k]]
        far = [0.0, along[-1], *along[found]] if found else [0.0, along[-1]]
        if turning[k] >= least and min(abs(place - other) for other in far) >= arm:
            found.append(int(vertices[k]))
    return sorted(found)


def turnings(line: StrokeLine, at: IntArray, *, arm: float) -> FloatArray:
    """(k,) degrees in [0, 180]: how far a line turns at these of its points, over chords of length `arm`."""
    along = line.along
    before, after = (
        np.column_stack([np.interp(along[at] + s * arm, along, v) for v in line.points.T]) for s in (-1, 1)
    )
    return angles_between(line.points[at] - before, after - line.points[at])


def angles_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Degrees in [0, 180] between (..., 2) vectors; 0 where one has no length."""
    cross = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.asarray(np.degrees(np.abs(np.arctan2(cross, (a * b).sum(axis=-1)))))
