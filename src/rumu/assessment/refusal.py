"""When a copy is refused: cut off, several characters, outline only, mirrored, turned, another character.

No character is recognised. Copy and master are compared: how they fit after registration, and whether the
master mirrored or turned, or a part of the picture alone, fits better.

The limits were chosen on half of the characters and validated on the other half; `python
benchmarks/refusal.py` prints both. A right copy must not be refused, so each limit keeps a distance from
the worst right copy known; a wrong copy that is not refused gets a low mark.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import itemgetter

import numpy as np

from rumu.assessment.refusal_reasons import Refusal, refusal_of, thin_refusal, turned_refusal
from rumu.errors import RumuError
from rumu.registration.descriptor import (
    beyond_others,
    describe,
    describe_canvas,
    likeness,
    mirror,
    turn,
)
from rumu.registration.icp import NearestPoint, pose_probe
from rumu.registration.points import INFLATION_TOP, canvas_of, ink_mask
from rumu.values import BoolArray, FloatArray, PointSet, Registration, Surface


@dataclass(frozen=True, slots=True)
class RefusalLimits:
    """When a copy is refused. Shares are of 1; residuals are in rms radii of the ink.

    half_dark: half-dark pixels for each pixel of outline above which a picture is noise, not ink.
    small_scale: size over the master's below which writing that is like it is too small; small_radius: the
        same for the rms radius of the ink, in pixels.
    outline_height, outline_hollowness: height of the ink over the master's below which, and how much better
        the edges of strokes are covered than their middle, above which only an outline was drawn; or else
        new_ink_share: share of the ink that is new when closed lines are filled, and likeness_cost: likeness
        that this may cost. thin_height: the same height below which it was written with a pen.
    light: of the darkest part of the copy's paper, as a share of the brightest, below which it is the light
        that hides what does not fit.
    accept_residual, accept_likeness: residual in the plane up to which, and likeness from which, no further
        tests are made. accept_lean: degrees by which the registration may turn a copy of such a residual;
        what fits only when it is turned further is not upright. accept_in_place: share of the ink in its
        place from which it is the master's, whatever is missing or too much.
    cut_off_share: share of the master that falls outside the picture, over ink on the border.
    part_likeness, part_gain: likeness of a part of the picture alone, and how much more than of the whole.
    reversed_likeness, reversed_gain: likeness to the master mirrored or turned, and how much more than as it
        is. unfit_likeness: the same likeness of a copy that is refused in any case.
    clean: clearness from which ink is clean. Old silk and rubbings lie below it: their crops hold stains and
        parts of neighbours, so they are never refused as several characters or as another.
    refuse_strangeness: strangeness above which it is another character.
    cap_strangeness, cap_residual: strangeness and residual in the plane above which it may be one, so that
        its mark is capped: at cap_highest, falling to nothing at zero_strangeness.
    """

    half_dark: float = 20.0
    small_scale: float = 0.25
    small_radius: float = 8.0
    outline_height: float = 0.5
    outline_hollowness: float = 0.3
    new_ink_share: float = 0.45
    likeness_cost: float = 0.06
    thin_height: float = 0.235
    light: float = 0.4
    accept_residual: float = 0.20
    accept_likeness: float = 0.80
    accept_lean: float = 45.0
    accept_in_place: float = 0.96
    cut_off_share: float = 0.05
    part_likeness: float = 0.40
    part_gain: float = 0.25
    reversed_likeness: float = 0.45
    reversed_gain: float = 0.15
    unfit_likeness: float = 0.4
    clean: float = 25.0
    refuse_strangeness: float = -0.03
    cap_strangeness: float = -0.18
    cap_residual: float = 0.22
    cap_highest: float = 39.0
    zero_strangeness: float = 0.1


@dataclass(frozen=True, slots=True)
class FigureSettings:
    """Parameters of the measurements.

    near: distance, in rms radii, within which ink lies on ink: about a stroke's half-width.
    residual_weight, residual_offset: of the logarithm of the residual in strangeness; chosen with the limits.
    edge, middle: percentiles of height below which a stroke's edge lies, and above which its middle does.
    border_ink: ink on a border from which it counts, over the longer side of the picture; border_pixels:
        depth of the border.
    gap: least blank between two parts of a picture, as a share of the extent of its ink; gap_pixels: the same
        in pixels. part: least share of the ink that may be a character of its own.
    """

    near: float = 0.1
    residual_weight: float = 0.2
    residual_offset: float = 0.02
    edge: float = 30.0
    middle: float = 70.0
    border_ink: float = 0.015
    border_pixels: int = 2
    gap: float = 0.02
    gap_pixels: float = 2.0
    part: float = 0.12


FIGURES = FigureSettings()


@dataclass(frozen=True, eq=False)
class RefusalReference:
    """What copies are compared with: a master's ink points, and the clearness of its ink."""

    points: PointSet
    clearness: float

    @cached_property
    def vector(self) -> FloatArray:
        """Descriptor (see `registration.descriptor`) as it is."""
        return describe(self.points)

    @cached_property
    def mirrored(self) -> FloatArray:
        """Descriptor from behind."""
        return describe(mirror(self.points))

    @cached_property
    def turned(self) -> dict[int, FloatArray]:
        """Descriptors on their side and upside down, by the degrees clockwise that turn them upright."""
        return {degrees: describe(turn(self.points, degrees=360 - degrees)) for degrees in (90, 180, 270)}


@dataclass(frozen=True, eq=False)
class RefusalFigures:
    """Figures of a copy laid on its master, each computed when it is first needed; most copies need few."""

    copy: Surface
    master: RefusalReference
    registration: Registration

    @cached_property
    def plane_residual(self) -> float:
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
    def vector(self) -> FloatArray:
        """Descriptor of the copy's outlines."""
        return describe(self.registration.probe)

    @cached_property
    def upright_likeness(self) -> float:
        """Of the outlines to the master's: 1 for the same, about 0 for any two characters."""
        return float(likeness(self.vector, self.master.vector))

    @cached_property
    def mirrored_likeness(self) -> float:
        """The same to the master from behind."""
        return float(likeness(self.vector, self.master.mirrored))

    @cached_property
    def turned_likenesses(self) -> dict[int, float]:
        """The same once the copy is turned, by the degrees clockwise: 90, 180 and 270."""
        return {degrees: float(likeness(self.vector, v)) for degrees, v in self.master.turned.items()}

    @cached_property
    def likeness_beyond_others(self) -> float:
        """Likeness beyond what other characters reach with either: below 0 for most different characters."""
        return beyond_others(self.vector, self.master.vector)

    @cached_property
    def strangeness(self) -> float:
        """Grows with the residual of the registration and falls with likeness."""
        residual = np.log(self.plane_residual + FIGURES.residual_offset)
        return FIGURES.residual_weight * float(residual) - self.likeness_beyond_others

    @cached_property
    def share_in_place(self) -> float:
        """Share of the copy's ink that lies on the master's where both stand in their cells.

        Or the other way round, whichever is more: 1 for a copy that only lacks strokes, or has too many.
        """
        x, p = self.registration.reference, self.registration.probe
        at = (p.xyz[:, :2] * p.radius + p.centre - x.centre) / x.radius
        near = FIGURES.near
        return max(_covered(at[::3], x.xyz[:, :2], near), _covered(x.xyz[::3, :2], at, near))

    @cached_property
    def relative_height(self) -> float:
        """Mean height of the copy's ink over the master's: below 1 its strokes are thinner, or hollow."""
        p, x = (float(points.xyz[:, 2].mean()) for points in (self.registration.probe, self.master.points))
        return p / max(x, 1e-6)

    @cached_property
    def hollowness(self) -> float:
        """How much better the copy covers the edges of the master's strokes than their middle, -1 to 1."""
        p, x = pose_probe(self.registration), self.registration.reference.xyz
        low, high = np.percentile(x[:, 2], (FIGURES.edge, FIGURES.middle))
        edge, middle = x[x[:, 2] <= low], x[x[:, 2] >= high]
        reach = 0.5 * INFLATION_TOP * float(np.median(middle[:, 2]))  # half of a stroke's half-width
        return _covered(edge[::2, :2], p[:, :2], reach) - _covered(middle[::2, :2], p[:, :2], reach)

    @cached_property
    def filling(self) -> tuple[float, float]:
        """What filling the copy's closed lines would change.

        (share of the filled ink that is new, likeness gained). Hollow strokes become the strokes; a square
        written with a thin pen becomes a blot.
        """
        ink = ink_mask(self.copy)
        full = fill_outlines(ink)
        vector = describe_canvas(canvas_of(full).solid)
        gained = float(likeness(vector, self.master.vector)) - self.upright_likeness
        return 1.0 - float(np.count_nonzero(ink) / np.count_nonzero(full)), gained

    @cached_property
    def share_beyond_border(self) -> float:
        """Share of the master's ink that falls outside the copy's picture, across a border with ink on it."""
        p, T = self.registration.probe, self.registration.T_reference_probe
        back = (self.registration.reference.xyz[:, :2] - T[:2, 3]) @ T[:2, :2]
        at = back * p.radius + p.centre
        half, n, ink = np.array(p.cell) / 2, FIGURES.border_pixels, ink_mask(self.copy)
        left, right, top, bottom = ink[:, :n], ink[:, -n:], ink[:n].T, ink[-n:].T
        strips = [strip.any(axis=1).sum() for strip in (left, right, top, bottom)]
        is_inked = np.array(strips) >= FIGURES.border_ink * max(ink.shape)
        sides = np.stack([at[:, 0] < -half[0], at[:, 0] > half[0], at[:, 1] > half[1], at[:, 1] < -half[1]])
        return float((sides.T & is_inked).any(axis=1).mean())

    @cached_property
    def best_part(self) -> tuple[float, float]:
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
        return (best, best - self.upright_likeness) if best > -1.0 else (0.0, -1.0)


def check_copy(
    figures: RefusalFigures, *, limits: RefusalLimits | None = None
) -> tuple[Refusal | None, float]:
    """(Why the copy cannot be marked, or None; the highest mark, 0-100, that it may get).

    A copy that is hardly like its master may be another character, which a mark alone does not see when
    its strokes lie alike: its mark is capped.
    """
    limits, f = limits or RefusalLimits(), figures
    is_dim = f.copy.quality.get("light", 1.0) < limits.light
    code = _find_fault(f, limits)
    if code is not None:
        turned = _find_reversal(f, limits, least=limits.unfit_likeness) if code == "cut off" else None
        if code == "too thin":
            width = 2 * f.copy.quality.get("half_width", 0.0)
            return thin_refusal(width=width, expected=width / max(f.relative_height, 1e-6)), 0.0
        return turned or refusal_of("uneven light" if is_dim else code), 0.0
    upright = abs(f.registration.angle) <= limits.accept_lean
    if (upright and f.plane_residual < limits.accept_residual) or f.upright_likeness > limits.accept_likeness:
        return None, 100.0
    if f.share_in_place >= limits.accept_in_place:
        return None, 100.0
    refusal, highest = _find_misfit(f, limits), 100.0
    if f.strangeness > limits.cap_strangeness and f.plane_residual > limits.cap_residual:
        share = limits.zero_strangeness - f.strangeness
        share /= limits.zero_strangeness - limits.cap_strangeness
        highest = limits.cap_highest * max(share, 0.0)
    if is_dim and (refusal or highest < 100.0) and (refusal is None or refusal.turned_by is None):
        return refusal_of("uneven light"), 0.0
    return refusal, highest


def _find_fault(f: RefusalFigures, limits: RefusalLimits) -> str | None:
    """The code of a fault of the picture; asked of every copy, and quick."""
    if f.copy.quality.get("between", 0.0) > limits.half_dark:
        return "noise"
    if 1.0 / f.registration.probe.pixel < limits.small_radius:
        return "too small"
    if f.registration.scale < limits.small_scale and f.upright_likeness > limits.part_likeness:
        return "too small"  # but a single dot is not
    if f.relative_height < limits.outline_height:
        new, gained = f.filling if f.hollowness <= limits.outline_hollowness else (1.0, 0.0)
        if new > limits.new_ink_share and gained > -limits.likeness_cost:
            return "outline only"
        if f.relative_height < limits.thin_height:
            return "too thin"
    return "cut off" if f.share_beyond_border > limits.cut_off_share else None


def _find_misfit(f: RefusalFigures, limits: RefusalLimits) -> Refusal | None:
    """What else was written, or how it is turned, of a copy that neither fits nor stands in its place."""
    if f.clearness >= limits.clean:
        part, gain = f.best_part
        if gain > limits.part_gain and part > limits.part_likeness:
            return refusal_of("several characters")
    unfit = f.clearness >= limits.clean and f.strangeness > limits.refuse_strangeness
    least = limits.unfit_likeness if unfit else limits.reversed_likeness
    return _find_reversal(f, limits, least=least) or (refusal_of("another character") if unfit else None)


def _find_reversal(f: RefusalFigures, limits: RefusalLimits, *, least: float) -> Refusal | None:
    """The refusal of a copy that is clearly more like the master mirrored or turned; least: likeness."""
    degrees, reversed_likeness = max(f.turned_likenesses.items(), key=itemgetter(1))
    if f.mirrored_likeness > reversed_likeness:
        degrees, reversed_likeness = 0, f.mirrored_likeness
    if reversed_likeness <= max(least, f.upright_likeness + limits.reversed_gain):
        return None
    return turned_refusal(degrees) if degrees else refusal_of("mirrored")


def _covered(points: FloatArray, ink: FloatArray, reach: float) -> float:
    """Share of the points, (N, 2), that have a point of the ink, (M, 2), nearer than `reach`."""
    return float(np.mean(NearestPoint(ink)(points)[0] < reach**2))


def fill_outlines(ink: BoolArray) -> BoolArray:
    """The ink (H, W) with the inside of its closed lines, but not within further lines in there."""
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
    parts = [part for group in (columns, rows, cells) if len(group) > 1 for part in group]
    return [part for part in parts if np.count_nonzero(part) >= FIGURES.part * np.count_nonzero(ink)]


def _bands(ink: BoolArray, *, axis: int) -> list[BoolArray]:
    """The ink cut at every blank band across an axis (0: between columns) that is wide enough."""
    used: BoolArray = np.asarray(ink.any(axis=axis))
    at = np.flatnonzero(used)
    if len(at) < 2:
        return [ink]
    breaks = np.flatnonzero(np.diff(at) > max(FIGURES.gap * (at[-1] - at[0]), FIGURES.gap_pixels))
    edges = [0, *(int(at[k] + 1) for k in breaks), len(used)]
    bands = []
    for first, last in pairwise(edges):
        band = np.zeros_like(ink)
        where = (slice(None), slice(first, last)) if axis == 0 else (slice(first, last), slice(None))
        band[where] = ink[where]
        bands.append(band)
    return bands
