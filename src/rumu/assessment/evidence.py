"""What speaks against marking a copy: is it whole, one character, written solid, and the master's at all?

Nothing here knows a character. Everything is asked of the pair: how the copy lies on the master after
registration, and whether the master mirrored, or turned, or a part of the picture alone, is more alike.
Each figure is measured when it is first asked for, since most copies need none but the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from rumu.errors import RumuError
from rumu.registration.descriptor import (
    beyond_others,
    describe,
    describe_canvas,
    likeness,
    mirror,
    turn_upside_down,
)
from rumu.registration.icp import NearestPoint, pose_probe
from rumu.registration.points import INFLATION_TOP, canvas_of, ink_mask
from rumu.values import BoolArray, FloatArray, PointSet, Registration, Surface

NEAR = 0.1
"""Distance in rms radii within which ink lies on ink: about a stroke's half-width."""
GAP = 0.02
"""Least blank between two parts of a picture, as a share of the extent of its ink."""
PART = 0.12
"""Least share of the ink that may be a character of its own."""


@dataclass(frozen=True, eq=False)
class MasterOutline:
    """What refusal compares copies with: a master's ink points and the clearness of its ink."""

    points: PointSet
    clearness: float

    @cached_property
    def vector(self) -> FloatArray:
        """Descriptor of the outlines, see `registration.descriptor`."""
        return describe(self.points)

    @cached_property
    def mirrored(self) -> FloatArray:
        """The same of the master seen from behind."""
        return describe(mirror(self.points))

    @cached_property
    def turned(self) -> FloatArray:
        """The same of the master upside down."""
        return describe(turn_upside_down(self.points))


@dataclass(frozen=True, eq=False)
class RefusalFigures:
    """Figures of one copy laid on its master, each computed when it is first asked for."""

    copy: Surface
    master: MasterOutline
    registration: Registration

    @cached_property
    def position(self) -> float:
        """Rms distance in the plane, both ways, in rms radii."""
        p, x = pose_probe(self.registration)[:, :2], self.registration.reference.xyz[:, :2]
        i, j = self.registration.forward_index, self.registration.backward_index
        space = np.vstack([p - x[i], p[j] - x])
        return float(np.sqrt(np.mean(np.sum(space * space, axis=1))))

    @cached_property
    def clearness(self) -> float:
        """Contrast of the ink over the paper's own spread, of the worse picture; photographs are below 25."""
        return min(self.copy.quality.get("noise", np.inf), self.master.clearness)

    @cached_property
    def likeness(self) -> float:
        """Of the outlines: 1 for the same, about 0 for any two characters."""
        return float(likeness(self._vector, self.master.vector))

    @cached_property
    def mirrored(self) -> float:
        """How much more alike the copy is to the master seen from behind."""
        return float(likeness(self._vector, self.master.mirrored)) - self.likeness

    @cached_property
    def turned(self) -> float:
        """How much more alike the copy is to the master upside down."""
        return float(likeness(self._vector, self.master.turned)) - self.likeness

    @cached_property
    def beyond_others(self) -> float:
        """Likeness beyond what other characters reach with either: below 0 for most pairs of two."""
        return beyond_others(self._vector, self.master.vector)

    @cached_property
    def strangeness(self) -> float:
        """Grows with what registration leaves and falls with likeness; the weight is chosen, see refusal."""
        return 0.2 * float(np.log(self.position + 0.02)) - self.beyond_others

    @cached_property
    def in_place(self) -> float:
        """Share of the copy's ink that lies on the master's where both stand in their cells, or the other
        way round, whichever is more: 1 for a copy that lacks strokes, or has too many, and is else right."""
        x, p = self.registration.reference, self.registration.probe
        at = (p.xyz[:, :2] * p.radius + p.centre - x.centre) / x.radius
        return max(_covered(at[::3], x.xyz[:, :2], NEAR), _covered(x.xyz[::3, :2], at, NEAR))

    @cached_property
    def lightness(self) -> float:
        """Mean height of the copy's ink over the master's: below 1 its strokes are thinner, or hollow."""
        p, x = (
            float(points.xyz[:, 2].mean())
            for points in (self.registration.probe, self.registration.reference)
        )
        return p / max(x, 1e-6)

    @cached_property
    def hollowness(self) -> float:
        """How much better the copy covers the edges of the master's strokes than their middle, -1 to 1."""
        p, x = pose_probe(self.registration), self.registration.reference.xyz
        low, high = np.percentile(x[:, 2], (30, 70))
        edge, middle = x[x[:, 2] <= low], x[x[:, 2] >= high]
        reach = 0.5 * INFLATION_TOP * float(np.median(middle[:, 2]))  # half of a stroke's half-width
        return _covered(edge[::2, :2], p[:, :2], reach) - _covered(middle[::2, :2], p[:, :2], reach)

    @cached_property
    def filling(self) -> tuple[float, float]:
        """What filling the copy's closed lines would change: (share of the filled ink that is new, likeness
        gained). Hollow strokes become the strokes; a square written with a thin pen becomes a blot."""
        ink = ink_mask(self.copy)
        full = filled(ink)
        vector = describe_canvas(canvas_of(full).solid)
        gained = float(likeness(vector, self.master.vector)) - self.likeness
        return 1.0 - float(np.count_nonzero(ink) / np.count_nonzero(full)), gained

    @cached_property
    def beyond(self) -> float:
        """Share of the master's ink that falls outside the copy's picture, across a border with ink on it."""
        registration = self.registration
        p, T = registration.probe, registration.T_reference_probe
        back = (registration.reference.xyz[:, :2] - T[:2, 3]) @ T[:2, :2]
        at = back * p.radius + p.centre
        half = np.array(p.cell) / 2
        sides = np.stack([at[:, 0] < -half[0], at[:, 0] > half[0], at[:, 1] > half[1], at[:, 1] < -half[1]])
        return float((sides.T & self._inked_sides).any(axis=1).mean())

    @cached_property
    def part_gain(self) -> tuple[float, float]:
        """(likeness of the part of the picture that is most like the master, how much more than the whole).

        Parts stand clear of each other, side by side, one above the other, or both. (0, -1) without parts.
        """
        best = -1.0
        for part in parts_of(ink_mask(self.copy)):
            try:
                vector = describe_canvas(canvas_of(part).solid)
            except RumuError:
                continue
            best = max(best, float(likeness(vector, self.master.vector)))
        return (best, best - self.likeness) if best > -1.0 else (0.0, -1.0)

    @cached_property
    def _vector(self) -> FloatArray:
        return describe(self.registration.probe)

    @cached_property
    def _inked_sides(self) -> BoolArray:
        """(4,) left, right, top, bottom: a stroke's width of ink lies on that border."""
        ink = ink_mask(self.copy)
        strips = (ink[:, :2].any(axis=1), ink[:, -2:].any(axis=1), ink[:2].any(axis=0), ink[-2:].any(axis=0))
        return np.array([strip.sum() >= 0.015 * max(ink.shape) for strip in strips])


def _covered(points: FloatArray, ink: FloatArray, reach: float) -> float:
    """Share of the points, (N, 2), that have a point of the ink, (M, 2), nearer than `reach`."""
    return float(np.mean(NearestPoint(ink)(points)[0] < reach**2))


def filled(ink: BoolArray) -> BoolArray:
    """The ink (H, W) with the inside of its closed lines, and within that, what further lines spare."""
    import cv2

    page = ink.astype(np.uint8)
    contours, family = cv2.findContours(page, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    outer = [c for c, (_, _, _, parent) in zip(contours, family[0], strict=True) if parent < 0]
    inside = np.zeros_like(page)
    cv2.fillPoly(inside, outer, 1)  # even and odd: a line within a line takes away again
    return np.asarray(ink | (inside > 0))


def parts_of(ink: BoolArray) -> list[BoolArray]:
    """Parts of an ink mask (H, W) that stand clear of each other: rows, columns, and columns of rows."""
    columns, rows = _bands(ink, axis=0), _bands(ink, axis=1)
    cells = [part for row in rows for part in _bands(row, axis=0)] if len(rows) > 1 else []
    found = [part for group in (columns, rows, cells) if len(group) > 1 for part in group]
    return [part for part in found if np.count_nonzero(part) >= PART * np.count_nonzero(ink)]


def _bands(ink: BoolArray, *, axis: int) -> list[BoolArray]:
    """The ink cut at every blank band across an axis (0: between columns) that is wide enough."""
    used: BoolArray = np.asarray(ink.any(axis=axis))
    at = np.flatnonzero(used)
    if len(at) < 2:
        return [ink]
    breaks = np.flatnonzero(np.diff(at) > max(GAP * (at[-1] - at[0]), 2))
    edges = [0, *(int(at[k] + 1) for k in breaks), len(used)]
    bands = []
    for first, last in pairwise(edges):
        band = np.zeros_like(ink)
        where = (slice(None), slice(first, last)) if axis == 0 else (slice(first, last), slice(None))
        band[where] = ink[where]
        bands.append(band)
    return bands
