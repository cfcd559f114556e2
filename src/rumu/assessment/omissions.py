"""Strokes that a copy lacks, and ink that it has too much: what is left when strokes are laid on strokes.

Copies that people wrote stand a little aside everywhere, so that distances alone take every displaced stroke
for a missing one. The master's strokes are therefore matched with the copy's (see `matching`): ink that one
stroke explains is taken, and where a stroke was left out nothing is left for it. First quickly, with the
ridges of the copy's ink; what seems to lack then is asked again, with its centre lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rumu.assessment.lines import Drawing, Line, copy_drawing, master_drawing, points_along
from rumu.assessment.matching import MatchSettings, Points, match
from rumu.assessment.sheets import RADIUS, SIDE, Sheet, pixels
from rumu.assessment.similarity import posed
from rumu.assessment.strokes import covered_by
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Registration

OFF = 0.05
"""Rms radii off the copy's ink from which a point that matching moved there counts as unfound."""


@dataclass(frozen=True, slots=True)
class Sought:
    """What counts as wanting when strokes were laid on strokes. Lengths in rms radii unless said.

    moved, still: how far a point that found no ink of its own must lie off the copy's ink, where matching
        has put it, or where the master has it. share: points' worth of ink below which it found none.
    run: stroke widths that such a run must be long; dot: share of a stroke that joins no other which does
        as well; bridge: widths that a run may be broken.
    spare: how much of the copy's unexplained ink is taken for what seems to be missing.
    """

    moved: float = OFF
    still: float = 0.04
    share: float = 0.15
    run: float = 1.5
    dot: float = np.inf
    bridge: float = 0.6
    lost: tuple[float, float] = (0.25, 0.5)
    spare: float = 1.0


QUICK = Sought(still=0.0, share=0.35, dot=0.8, spare=0.5)
"""The first look, which is to miss nothing."""
QUICK_POINTS = 120
"""Points on the master's lines, for the first look."""
QUICK_MATCH = MatchSettings(smooth=(0.22, 0.16, 0.12), single=(0.13, 0.1, 0.075, 0.055))
PLAIN = (0.1, 0.005)
"""Rms radii within which all ink of either has ink of the other when a copy plainly lacks nothing, but for
such a share of it."""
DOUBT, SLACK_DOUBT = 0.015, (0.08, 1.2)
"""Share of the ink that must be missing at the first look for a second to be taken; see SLACK_MISSING."""
FAR = 0.12
"""Rms radii off the master's ink from which unexplained ink is too much."""
SLACK_MISSING, SLACK_EXTRA = (0.08, 0.5), (0.1, 1.0)
"""Displacement, in rms radii, that strokes commonly have, from which matching may err; and how much of the
ink is then not believed to be missing, or too much, for each rms radius beyond."""
LEAST_USUAL = 0.05
"""Share of the ink that a usual stroke has at least: of very many strokes one is not seen so surely."""
_NEAR = 0.75
"""Stroke widths within which ink is a stroke's own."""


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """What is left over.

    missing, extra: shares of the master's and of the copy's ink; usual: share of the master's ink in a usual
    stroke. missing_at, extra_at: (n, 2) where, rms radii of the master, y up.
    """

    missing: float
    extra: float
    usual: float
    missing_at: FloatArray
    extra_at: FloatArray


def left_over(registration: Registration, master: MasterLines) -> Left | None:
    """What strokes laid on strokes leave; None for a copy that plainly lacks nothing and has no more, and for
    one whose strokes are hairs without a ridge."""
    if _plainly_whole(registration):
        return None
    copy = _cloud_of_copy(registration)
    ridges = copy.ridges()
    if not len(ridges.xy):
        return None
    quick = _laid(copy, ridges, master, points=master.few, settings=QUICK_MATCH)
    extra = max(quick.extra - _doubtful(quick, SLACK_EXTRA), 0.0)
    missing, at = _confirmed(copy, master, quick)
    up = np.array([1.0, -1.0])
    return Left(missing, extra, master.usual, at * up, quick.copy.xy[quick.unexplained] * up)


def _confirmed(copy: _Cloud, master: MasterLines, quick: _Laid) -> tuple[float, FloatArray]:
    """The share of the master's ink that is missing at both looks, and where, (n, 2), y down."""
    first, _ = quick.missing(QUICK, master.drawing.lines)
    if first - _doubtful(quick, SLACK_DOUBT) <= DOUBT:
        return 0.0, np.zeros((0, 2))
    full = _laid(copy, copy_drawing(copy.sheet).points, master, points=master.drawing.points, settings=None)
    second, gone = full.missing(Sought(), master.drawing.lines)
    return max(min(first, second) - _doubtful(full, SLACK_MISSING), 0.0), full.master.xy[gone]


def _doubtful(laid: _Laid, slack: tuple[float, float]) -> float:
    common, rate = slack
    return rate * max(laid.slack - common, 0.0)


def _plainly_whole(registration: Registration) -> bool:
    p, x = (cloud[:, :2] for cloud in posed(registration))
    near, share = PLAIN
    apart = (x - p[registration.backward_index], p - x[registration.forward_index])
    return all(float((np.einsum("ij,ij->i", a, a) > near**2).mean()) < share for a in apart)


@dataclass(frozen=True, slots=True, eq=False)
class _Cloud:
    """Ink points on a sheet. at: (n, 2) rms radii, y down; double: (n, 2) their direction, y down;
    ink: (SIDE, SIDE) bool; off: (SIDE, SIDE) distance to the ink, rms radii."""

    at: FloatArray
    double: FloatArray
    ink: BoolArray
    off: FloatArray

    @property
    def sheet(self) -> Sheet:
        return Sheet(self.ink, np.eye(2, 3), 1.0)

    def ridges(self) -> Points:
        """Points where its ink is deepest, one in each small square: rougher than centre lines, but quick."""
        import cv2

        depth = cv2.distanceTransform(np.pad(self.ink.view(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
        ridge = (depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8)) - _FLAT) & (depth >= 3 * _FLAT)
        on = ridge[_pixel(self.at)]
        square = np.floor(self.at[on] / _SQUARE).astype(np.intp) @ np.array([1000, 1])
        _, which, count = np.unique(square, return_inverse=True, return_counts=True)
        xy, double = (
            np.column_stack([np.bincount(which, part[on, k]) / count for k in (0, 1)])
            for part in (self.at, self.double)
        )
        length = np.hypot(*double.T)[:, None]
        double = np.where(length > 0.3, double / np.maximum(length, 1e-9), 0.0)
        crowd = max(len(xy) / (1.3 * QUICK_POINTS), 1.0)
        kept = np.round(np.linspace(0, len(xy) - 1, round(len(xy) / crowd))).astype(np.intp)
        xy, radius = xy[kept], depth[_pixel(xy[kept])] / RADIUS
        return Points(
            xy, double[kept], radius, np.zeros(len(xy), np.intp), np.ones(len(xy), bool), 0.05 * crowd
        )


def _cloud(xy: FloatArray, direction: FloatArray) -> _Cloud:
    """xy, direction: (n, 2), y up."""
    import cv2

    down = np.array([1.0, -1.0])
    page = np.zeros((SIDE, SIDE), np.uint8)
    page[_pixel(xy * down)] = 1
    # points lie a pixel and a half apart
    ink = cv2.morphologyEx(page, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    off = cv2.distanceTransform(1 - ink, cv2.DIST_L2, 5) / np.float32(RADIUS)
    return _Cloud(xy * down, direction * down, ink > 0, off)


def _cloud_of_copy(registration: Registration) -> _Cloud:
    p, _ = posed(registration)
    a = 2 * np.deg2rad(registration.angle)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    return _cloud(p[:, :2], registration.probe.direction @ turn)


_FLAT = 0.5
"""Pixels by which a ridge may lie below its neighbours."""
_SQUARE = 3.0 / 32.0
"""Side of a square that holds one point of a ridge, rms radii."""


def _pixel(at: FloatArray) -> tuple[IntArray, IntArray]:
    """Row and column on a sheet, (n,) each."""
    column, row = np.clip(np.round(pixels(at)).astype(np.intp), 0, SIDE - 1).T
    return row, column


@dataclass(frozen=True, eq=False)
class MasterLines:
    """A master's centre lines, from its ink points (`reference`): what copies are searched for."""

    reference: PointSet

    @cached_property
    def cloud(self) -> _Cloud:
        """Its ink points in the common frame."""
        return _cloud(self.reference.xyz[:, :2], self.reference.direction)

    @cached_property
    def drawing(self) -> Drawing:
        """Its lines."""
        return master_drawing(self.cloud.sheet)

    @cached_property
    def few(self) -> Points:
        """Fewer points along the lines, for the first look."""
        return points_along(self.drawing.lines, most=QUICK_POINTS)

    @cached_property
    def usual(self) -> float:
        """Share of the ink in a usual stroke."""
        points = self.drawing.points
        shares = np.bincount(points.owner, _weight(points), minlength=len(self.drawing.lines))
        return max(float(np.median(shares)), LEAST_USUAL)


def _weight(points: Points) -> FloatArray:
    """(n,) share of the ink at each."""
    return np.asarray(points.radius / points.radius.sum())


@dataclass(frozen=True, slots=True, eq=False)
class _Laid:
    """The master's points laid on the copy's.

    covered: (n,) which found ink of their own; found: (n,) how many points' worth; moved, still: (n,) how
    far off the copy's ink they lie, where matching put them and where the master has them. spare: (m,) which
    of the copy's points belong to no stroke; beyond: (m,) how far off the master's ink those lie.
    slack: by how much covered points commonly moved.
    """

    master: Points
    copy: Points
    width: float
    covered: BoolArray
    found: FloatArray
    moved: FloatArray
    still: FloatArray
    spare: BoolArray
    beyond: FloatArray
    slack: float

    def missing(self, sought: Sought, lines: tuple[Line, ...]) -> tuple[float, BoolArray]:
        """Share of the master's ink that the copy lacks and does not have elsewhere; (n,) which points."""
        bare = (~self.covered | (self.found < sought.share)) & (
            (self.moved > sought.moved) | (self.still > sought.still)
        )
        weight, counted = _weight(self.master), np.zeros(len(bare))
        wide = self.width / self.master.spacing
        for k, line in enumerate(lines):
            own = np.flatnonzero(self.master.owner == k)
            least = min(sought.run * wide, sought.dot * len(own) if all(line.free) else np.inf)
            runs = _runs(bare[own], bridge=sought.bridge * wide)
            long = [run for run in runs if run[-1] - run[0] + 1 >= least]
            if long:
                lost = float(np.average(~self.covered[own], weights=weight[own]))
                counted[own[np.concatenate(long)]] = np.interp(lost, sought.lost, (0.0, 1.0))
        share = float(weight @ counted) - sought.spare * float(self.spare.mean())
        return max(share, 0.0), counted > 0

    @property
    def unexplained(self) -> BoolArray:
        """(m,) which of the copy's points no stroke of the master explains."""
        return np.asarray(self.spare & (self.beyond > FAR))

    @property
    def extra(self) -> float:
        """Share of the copy's ink that is unexplained and not what some stroke did not find."""
        unfound = float(_weight(self.master)[~self.covered & (self.moved > OFF)].sum())
        return float(self.unexplained.mean()) - unfound


def _laid(
    cloud: _Cloud, copy: Points, master: MasterLines, *, points: Points, settings: MatchSettings | None
) -> _Laid:
    found = match(points, copy, settings=settings)
    covered, owner = covered_by(found, copy, points, near=_NEAR * master.drawing.width)
    moved, still = (cloud.off[_pixel(at)] for at in (found.moved, points.xy))
    away = np.hypot(*(found.moved - points.xy)[covered].T)
    return _Laid(
        points, copy, master.drawing.width, covered, found.share.sum(axis=1), moved, still, owner < 0,
        master.cloud.off[_pixel(copy.xy)], float(np.median(away)) if len(away) else np.inf,
    )  # fmt: skip


def _runs(flags: BoolArray, *, bridge: float) -> list[IntArray]:
    """Indices of the runs of True; those nearer than `bridge` are one, if most of it is True."""
    at = np.flatnonzero(flags)
    if len(at) == 0:
        return []
    runs = np.split(at, np.flatnonzero(np.diff(at) > 1 + bridge) + 1)
    return [run for run in runs if len(run) >= 0.6 * (run[-1] - run[0] + 1)]
