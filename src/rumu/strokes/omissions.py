"""Missing strokes and surplus ink: what remains unmatched when the master's strokes are laid on the copy's.

Strokes that people write are a little displaced everywhere, so distances alone would take every displaced
stroke for a missing one. The master's strokes are therefore matched with the copy's ink (see `matching`):
ink that one stroke explains is not available to another, and a missing stroke finds no ink. A coarse pass
with the ridges of the copy's ink finds candidates. Where the canonical strokes are known the answer is then
that of `presence`, the same that remarks give; else a fine pass with the ink's centre lines confirms them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from rumu.registration.icp import pose_probe
from rumu.strokes.centre_lines import (
    LINES,
    SCALE,
    SIDE,
    CentreLine,
    CentreLines,
    FramedInk,
    LinePoints,
    find_segments,
    find_strokes,
    pixels_at,
    sample_lines,
)
from rumu.strokes.correspondence import CopyStrokes
from rumu.strokes.matching import MatchSettings, find_covered, match_lines, slope, weigh_cover
from rumu.strokes.placement import stroke_numbers
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Registration

RegionKind = Literal["missing", "extra"]


@dataclass(frozen=True, slots=True)
class MissingSettings:
    """What counts as missing when strokes were laid on strokes. Lengths in rms radii unless said.

    min_ink: points' worth of ink below which a point found none of its own. min_moved_distance,
        min_master_distance: how far off the copy's ink such a point must lie, where matching has put it, or
        where the master has it.
    min_run: stroke widths that a run of such points must be long; min_stroke_share: share of a stroke that
        joins no other which does as well. max_gap: widths that a run may be broken; min_missing_share: share
        of a run that must be missing.
    lost_share: shares of a stroke that found no ink, at which none of it counts as missing, and all of it.
    surplus_weight: how much of the copy's unexplained ink is taken for what seems to be missing.
    """

    min_moved_distance: float = 0.05
    min_master_distance: float = 0.04
    min_ink: float = 0.15
    min_run: float = 1.5
    min_stroke_share: float = np.inf
    max_gap: float = 0.6
    min_missing_share: float = 0.6
    lost_share: tuple[float, float] = (0.25, 0.5)
    surplus_weight: float = 1.0


_QUICK = MissingSettings(min_master_distance=0.0, min_ink=0.35, min_stroke_share=0.8, surplus_weight=0.5)
_QUICK_MATCH = MatchSettings(warp_sigmas=(0.22, 0.16, 0.12), stroke_sigmas=(0.13, 0.1, 0.075, 0.055))
_FULL = MissingSettings()


@dataclass(frozen=True, slots=True)
class OmissionSettings:
    """How missing and extra ink is looked for. Lengths in rms radii unless said.

    own_ink_reach: stroke widths within which ink is a stroke's own.
    complete_distance: distance within which all ink of either has ink of the other when a copy is complete,
        but for complete_share of it.
    quick_points, quick_match, quick: points on the master's lines, matching, and what counts, in the first
        pass, which is to miss nothing. second_pass_share: share of the ink missing in it from which there is
        a second, and presence_share: from which canonical strokes are asked for. full: what counts in the
        second.
    surplus_distance: distance off the master's ink from which unexplained ink is too much. unfound_distance:
        distance off the copy's ink from which a point counts as not found where that is weighed.
        distance_slope: how far below and above these a point counts in part.
    first_discount, missing_discount, extra_discount: displacement that strokes commonly have, from which
        matching may err; and how much of the ink is then not believed to be missing in the first pass,
        missing in both, or too much, for each rms radius beyond.
    min_usual_share: least share of the ink in a usual stroke: of very many, one is not seen so surely.
    ridge_tolerance, min_ridge_depth: pixels by which a ridge may lie below its neighbours, and that it must
        be deep. grid_step: side of a square that holds one point of a ridge. max_crowding: points on ridges
        at most, over quick_points.
    min_agreement: length of the mean doubled direction in a square from which it is one.
    """

    own_ink_reach: float = 0.75
    complete_distance: float = 0.1
    complete_share: float = 0.005
    quick_points: int = 120
    quick_match: MatchSettings = _QUICK_MATCH
    quick: MissingSettings = _QUICK
    full: MissingSettings = _FULL
    second_pass_share: float = 0.015
    presence_share: float = 0.005
    surplus_distance: float = 0.12
    unfound_distance: float = 0.05
    distance_slope: float = 0.04
    first_discount: tuple[float, float] = (0.08, 1.2)
    missing_discount: tuple[float, float] = (0.08, 0.5)
    extra_discount: tuple[float, float] = (0.1, 1.0)
    min_usual_share: float = 0.05
    ridge_tolerance: float = 0.5
    min_ridge_depth: float = 1.5
    grid_step: float = 3.0 / 32.0
    max_crowding: float = 1.3
    min_agreement: float = 0.3


OMISSIONS = OmissionSettings()


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Ink that one has and the other lacks.

    kind: 'missing' from the copy, or 'extra' in it. points: (n, 2) where, on centre lines, rms radii of the
    master, y up. share: of the ink, of the copy for 'extra', of the master for 'missing'. strokes: how many
    usual strokes of the master that is.
    """

    kind: RegionKind
    points: FloatArray
    share: float
    strokes: float


def find_regions(
    registration: Registration, master: MasterInk, *, strokes: CopyStrokes | None = None
) -> tuple[Region, ...]:
    """Missing strokes and surplus ink, less what displacement may explain.

    strokes: the master's strokes on the copy where its character is known: then whole strokes are missing, or
    none. Nothing for a copy that is plainly complete, and for one whose strokes are too thin to have a ridge.
    """
    if _is_plainly_whole(registration):
        return ()
    ink = _ink_points(pose_probe(registration)[:, :2], _posed_directions(registration))
    ridges = ink.ridges()
    if not len(ridges.xy):
        return ()
    quick = _lay(ink, ridges, master, points=master.sparse_points, settings=OMISSIONS.quick_match)
    extra, extra_at = (
        quick.extra - _displacement_discount(quick, OMISSIONS.extra_discount),
        quick.copy.xy[quick.unexplained > 0.5],
    )
    first, _ = quick.missing(OMISSIONS.quick, master.lines.lines)
    if strokes is not None and first > OMISSIONS.presence_share and strokes.master.laid:
        missing, missing_at = _missing_strokes(strokes)
    else:
        missing, missing_at = _confirm_missing(ink, master, quick, first)
    up = np.array([1.0, -1.0])
    found = (
        Region("missing", missing_at * up, missing, missing / master.usual_stroke_share),
        Region("extra", extra_at * up, extra, extra / master.usual_stroke_share),
    )
    return tuple(region for region in found if region.share > 0.0)


def _missing_strokes(strokes: CopyStrokes) -> tuple[float, FloatArray]:
    """The share of the master's ink in the canonical strokes that a copy lacks, and where, (n, 2), y down.

    Each stroke counts as far as it is surely missing.
    """
    lines, (missing, _) = strokes.master.lines, strokes.found
    numbers, shares = stroke_numbers(lines), _ink_shares(lines.points)
    lost = sum(certainty * float(shares[numbers == number].sum()) for number, certainty in missing.items())
    return lost, lines.points.xy[np.isin(numbers, list(missing))]


def _confirm_missing(
    copy: InkPoints, master: MasterInk, quick: InkCoverage, first: float
) -> tuple[float, FloatArray]:
    """The share of the master's ink that is missing in both passes, and where, (n, 2), y down.

    first: the share that the quick pass says.
    """
    if first - _displacement_discount(quick, OMISSIONS.first_discount) <= OMISSIONS.second_pass_share:
        return 0.0, np.zeros((0, 2))
    segments = find_segments(copy.framed).points
    full = _lay(copy, segments, master, points=master.lines.points, settings=None)
    second, gone = full.missing(OMISSIONS.full, master.lines.lines)
    return min(first, second) - _displacement_discount(full, OMISSIONS.missing_discount), full.master.xy[gone]


def _displacement_discount(laid: InkCoverage, common_and_rate: tuple[float, float]) -> float:
    """Share of the ink that may only seem missing or surplus, because strokes are displaced."""
    common, rate = common_and_rate
    return rate * max(laid.displacement - common, 0.0)


def _is_plainly_whole(registration: Registration) -> bool:
    p, x = pose_probe(registration)[:, :2], registration.reference.xyz[:, :2]
    apart = (x - p[registration.backward_index], p - x[registration.forward_index])
    far = (float((np.einsum("ij,ij->i", a, a) > OMISSIONS.complete_distance**2).mean()) for a in apart)
    return all(share < OMISSIONS.complete_share for share in far)


def _posed_directions(registration: Registration) -> FloatArray:
    """(n, 2) doubled stroke directions of the copy, turned as it is laid on the master."""
    a = 2 * np.deg2rad(registration.angle)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    return np.asarray(registration.probe.direction @ turn)


@dataclass(frozen=True, slots=True, eq=False)
class InkPoints:
    """Ink points in the common frame.

    at: (n, 2) rms radii, y down; double: (n, 2) their doubled direction, y down; ink: (SIDE, SIDE) bool;
    off: (SIDE, SIDE) distance to the ink, rms radii.
    """

    at: FloatArray
    double: FloatArray
    ink: BoolArray
    off: FloatArray

    @property
    def framed(self) -> FramedInk:
        """Its ink, without the picture that it came from."""
        return FramedInk(self.ink, np.eye(2, 3), 1.0)

    def ridges(self) -> LinePoints:
        """Points where its ink is deepest, one in each small square: rougher than centre lines, but quick."""
        import cv2

        depth = cv2.distanceTransform(np.pad(self.ink.view(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
        highest = cv2.dilate(depth, np.ones((3, 3), np.uint8))
        ridge = (depth >= highest - OMISSIONS.ridge_tolerance) & (depth >= OMISSIONS.min_ridge_depth)
        on = ridge[pixels_at(self.at)]
        square = np.floor(self.at[on] / OMISSIONS.grid_step).astype(np.intp) @ np.array([1000, 1])
        _, which, count = np.unique(square, return_inverse=True, return_counts=True)
        xy, double = (
            np.column_stack([np.bincount(which, part[on, k]) / count for k in (0, 1)])
            for part in (self.at, self.double)
        )
        length = np.hypot(*double.T)[:, None]
        double = np.where(length > OMISSIONS.min_agreement, double / np.maximum(length, 1e-9), 0.0)
        crowd = max(len(xy) / (OMISSIONS.max_crowding * OMISSIONS.quick_points), 1.0)
        chosen = np.round(np.linspace(0, len(xy) - 1, round(len(xy) / crowd))).astype(np.intp)
        xy, double = xy[chosen], double[chosen]
        owner, clear = np.zeros(len(xy), np.intp), np.ones(len(xy), bool)
        return LinePoints(xy, double, depth[pixels_at(xy)] / SCALE, owner, clear, LINES.spacing * crowd)


def _ink_points(xy: FloatArray, direction: FloatArray) -> InkPoints:
    """Of (n, 2) points and doubled directions, y up."""
    import cv2

    down = np.array([1.0, -1.0])
    page = np.zeros((SIDE, SIDE), np.uint8)
    page[pixels_at(xy * down)] = 1
    # points lie a pixel and a half apart
    ink = cv2.morphologyEx(page, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    off = cv2.distanceTransform(1 - ink, cv2.DIST_L2, 5) / np.float32(SCALE)
    return InkPoints(xy * down, direction * down, ink > 0, off)


@dataclass(frozen=True, eq=False)
class MasterInk:
    """A master's ink points (`reference`) and centre lines: what copies are searched for."""

    reference: PointSet

    @cached_property
    def points(self) -> InkPoints:
        """Its ink points in the common frame."""
        return _ink_points(self.reference.xyz[:, :2], self.reference.direction)

    @cached_property
    def lines(self) -> CentreLines:
        """Its strokes' centre lines."""
        return find_strokes(self.points.framed)

    @cached_property
    def sparse_points(self) -> LinePoints:
        """Fewer points along the lines, for the first look."""
        return sample_lines(self.lines.lines, most=OMISSIONS.quick_points)

    @cached_property
    def usual_stroke_share(self) -> float:
        """Share of the ink in a usual stroke."""
        points = self.lines.points
        shares = np.bincount(points.owner, _ink_shares(points), minlength=len(self.lines.lines))
        return max(float(np.median(shares)), OMISSIONS.min_usual_share)


def _ink_shares(points: LinePoints) -> FloatArray:
    """(n,) share of the ink at each point."""
    return np.asarray(points.radius / points.radius.sum())


@dataclass(frozen=True, slots=True, eq=False)
class InkCoverage:
    """What ink the master's points found in a copy, and what the copy has besides. Lengths in rms radii.

    width: of the master's strokes. covered: (n,) which points found ink of their own; ink: (n,) how many
    points' worth; moved_distance, master_distance: (n,) how far off the copy's ink they lie, where matching
    put them and where the master has them. surplus: (m,) which of the copy's points belong to no stroke;
    surplus_distance: (m,) how far off the master's ink they lie. found, explained: (n,) and (m,), 0 to 1, how
    far the copy has the master's points, and strokes explain the copy's. displacement: by how much covered
    points commonly moved.
    """

    master: LinePoints
    copy: LinePoints
    width: float
    covered: BoolArray
    ink: FloatArray
    moved_distance: FloatArray
    master_distance: FloatArray
    surplus: BoolArray
    surplus_distance: FloatArray
    found: FloatArray
    explained: FloatArray
    displacement: float

    def missing(self, s: MissingSettings, lines: tuple[CentreLine, ...]) -> tuple[float, BoolArray]:
        """Share of the master's ink that the copy lacks and does not have elsewhere; (n,) which points."""
        unfound = ~self.covered | (self.ink < s.min_ink)
        bare = unfound & (
            (self.moved_distance > s.min_moved_distance) | (self.master_distance > s.min_master_distance)
        )
        weight, counted = _ink_shares(self.master), np.zeros(len(bare))
        wide = self.width / self.master.spacing
        for k, line in enumerate(lines):
            own = np.flatnonzero(self.master.owner == k)
            least = min(s.min_run * wide, s.min_stroke_share * len(own) if all(line.free) else np.inf)
            runs = [
                run
                for run in _runs(bare[own], s.max_gap * wide, s.min_missing_share)
                if np.ptp(run) + 1 >= least
            ]
            if runs:
                lost = float(np.average(~self.covered[own], weights=weight[own]))
                counted[own[np.concatenate(runs)]] = np.interp(lost, s.lost_share, (0.0, 1.0))
        share = float(weight @ counted) - s.surplus_weight * float(self.surplus.mean())
        return max(share, 0.0), counted > 0

    @property
    def unexplained(self) -> FloatArray:
        """(m,) how far each of the copy's points is one that no stroke of the master explains, 0 to 1."""
        o = OMISSIONS
        return (1.0 - self.explained) * slope(self.surplus_distance, o.surplus_distance, o.distance_slope)

    @property
    def extra(self) -> float:
        """Share of the copy's ink that is unexplained and not what some stroke did not find."""
        o = OMISSIONS
        unfound = (1.0 - self.found) * slope(self.moved_distance, o.unfound_distance, o.distance_slope)
        return float(self.unexplained.mean()) - float(_ink_shares(self.master) @ unfound)


def _lay(
    ink: InkPoints, copy: LinePoints, master: MasterInk, *, points: LinePoints, settings: MatchSettings | None
) -> InkCoverage:
    """Lay points of the master on lines of the copy, whose ink is given too."""
    found, width = match_lines(points, copy, settings=settings), master.lines.width
    near = OMISSIONS.own_ink_reach * width
    covered, owner = find_covered(found, copy, points, near=near)
    has, explained = weigh_cover(found, copy, points, near=near)
    moved_distance, master_distance = (ink.off[pixels_at(at)] for at in (found.moved, points.xy))
    away = np.hypot(*(found.moved - points.xy)[covered].T)
    return InkCoverage(
        master=points,
        copy=copy,
        width=width,
        covered=covered,
        ink=found.responsibility.sum(axis=1),
        moved_distance=moved_distance,
        master_distance=master_distance,
        surplus=owner < 0,
        surplus_distance=master.points.off[pixels_at(copy.xy)],
        found=has,
        explained=explained,
        displacement=float(np.median(away)) if len(away) else np.inf,
    )


def _runs(flags: BoolArray, bridge: float, whole: float) -> list[IntArray]:
    """Indices of the runs of True; those nearer than `bridge` are one, if the share `whole` of it is True."""
    at = np.flatnonzero(flags)
    if len(at) == 0:
        return []
    runs = np.split(at, np.flatnonzero(np.diff(at) > 1 + bridge) + 1)
    return [run for run in runs if len(run) >= whole * (run[-1] - run[0] + 1)]
