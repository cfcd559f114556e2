"""Which stroke of the copy is which of the master's, and how it differs.

The master's strokes are laid on the copy's ink (see `matching`); what the whole character does - lean, size,
place, a squeezed part - is taken out first (see `pose`), so that a stroke is blamed for its own fault alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from rumu.assessment.lines import Drawing, Line, copy_drawing, master_drawing
from rumu.assessment.matching import Match, Points, match, squared_distances
from rumu.assessment.pose import Pose, Squeeze, find_squeeze, in_place, robust_pose, squeezed
from rumu.assessment.sheets import RADIUS, SIDE, Sheet, copy_sheet, master_sheet
from rumu.assessment.stroke_measures import (
    StrokeFound,
    StrokeSettings,
    View,
    breadths,
    edge_tremor,
    half_widths,
)
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Registration, Surface

_SHAKEN = ((0.96, 1.0), (1.03, 0.6), (1.0, 0.8))
"""Sizes at which a master is measured against itself, to see what is no fault; how fine its picture is then,
in pixels for each of its own."""
_TAPERS = 0.05
"""Share of a stroke's width by which a tip must be finer than its stroke to be called tapering."""
_WELL = 0.9
"""Share of the strokes in their place from which nothing else is looked for."""
_RATIOS = ("length", "width")
"""What is measured of a stroke as a ratio to the master's."""
_ENDS = ("entry", "exit")
"""What is measured of a stroke as a difference from the master's."""


@dataclass(frozen=True, slots=True)
class Blunted:
    """What became of the tips that taper in the master, all together.

    share: of their taper that most of them have lost; below 0 when they are finer. most: share of the tips
        that lost any. ends: (stroke, 0 for its entry or 1 for its exit) of those.
    """

    share: float
    most: float
    ends: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """The whole correspondence.

    strokes: one for each of the master's, longest first. pose: of the copy against the master's place in its
        cell. width: median width of the copy's strokes over the master's. squeeze: a part too wide, if one
        is. explained: (m,) which points of the copy's lines belong to some stroke.
    moved: (n, 2) the master's points on the copy's sheet; covered: (n,) which of them the copy has; radius:
        (n,) the copy's half-width there, or what it should be; places: (n, 2) where the same measurement has
        them in the master itself; in_cell: (n, 2) where the copy has them in a cell like the master's.
    blunted: None where fewer than two of the master's tips taper.
    """

    strokes: tuple[StrokeFound, ...]
    pose: Pose
    width: float
    squeeze: Squeeze | None
    master: Drawing
    copy: Drawing
    sheets: tuple[Sheet, Sheet]
    moved: FloatArray
    covered: BoolArray
    explained: BoolArray
    radius: FloatArray
    places: FloatArray
    in_cell: FloatArray
    blunted: Blunted | None = None

    @property
    def grain(self) -> float:
        """Doubt in the logarithm of a common width: three tenths of a pixel of the coarser picture."""
        return 0.3 / (float(np.median(self.master.points.radius)) * RADIUS) * self.enlarged

    def grain_of(self, line: Line) -> float:
        """The same for one stroke."""
        return 0.3 / (float(np.median(line.radius)) * RADIUS) * self.enlarged

    @property
    def enlarged(self) -> float:
        """How many times the coarser picture was enlarged for its sheet; 1 when it was not."""
        return max(1.0, *(sheet.share for sheet in self.sheets))


@dataclass(frozen=True, eq=False)
class MasterStrokes:
    """A master's strokes with what copies are compared with, to be made once for all copies.

    surface, reference: the master and its ink points.
    """

    surface: Surface
    reference: PointSet
    settings: StrokeSettings = field(default_factory=StrokeSettings)

    @cached_property
    def sheet(self) -> Sheet:
        """Its ink in the common frame."""
        return master_sheet(self.surface, self.reference)

    @cached_property
    def drawing(self) -> Drawing:
        """Its centre lines."""
        return master_drawing(self.sheet)

    @cached_property
    def itself(self) -> Strokes:
        """Its strokes as the measurement of copies finds them in the master itself."""
        return _measured(self.sheet, self, places=None)

    @cached_property
    def doubts(self) -> tuple[_Doubt, ...]:
        """The doubt of each stroke: what small changes of size bring about, the worst two together."""
        shaken = [_shaken(self, scale=scale, grain=grain).strokes for scale, grain in _SHAKEN]
        rows = zip(self.itself.strokes, *shaken, strict=True)
        return tuple(_doubt([_less(s, own) for s in others]) for own, *others in rows)

    @cached_property
    def tremor(self) -> float:
        """How much its edges swing, in pixels of its sheet."""
        return edge_tremor(self.sheet)


def find_strokes(copy: Surface, registration: Registration, master: MasterStrokes) -> Strokes:
    """The master's strokes in the copy; `registration` is that of the two surfaces.

    What the same measurement makes of the master itself is taken out, so that of a perfect copy nothing is
    left: a fork that thinning draws aside is drawn aside in both.
    """
    itself = master.itself
    found = _measured(copy_sheet(copy, registration), master, places=itself.moved)
    known = zip(found.strokes, itself.strokes, master.doubts, strict=True)
    return replace(
        found,
        strokes=tuple(_beyond_doubt(_less(a, b), doubt) for a, b, doubt in known),
        blunted=_blunted(found.strokes, itself.strokes),
    )


def _blunted(found: tuple[StrokeFound, ...], itself: tuple[StrokeFound, ...]) -> Blunted | None:
    """Doubt is not taken out: over many tips it cancels, and what all of them lost is seen the sooner."""
    tips = [
        (k, end, getattr(a, name) - getattr(b, name), -getattr(b, name))
        for k, (a, b) in enumerate(zip(found, itself, strict=True))
        for end, name in enumerate(_ENDS)
        if a.present and getattr(b, name) < -_TAPERS  # not so where it is NaN
    ]
    if len(tips) < 2:
        return None
    lost, taper = np.array([tip[2] / tip[3] for tip in tips]), np.array([tip[3] for tip in tips])
    order = np.argsort(lost)
    half = int(np.argmax(np.cumsum(taper[order]) >= 0.5 * taper.sum()))
    ends = tuple((k, end) for k, end, gain, _ in tips if gain > 0)
    return Blunted(float(lost[order][half]), len(ends) / len(tips), ends)


@dataclass(frozen=True, slots=True)
class _Doubt:
    """How much a stroke of a master differs from itself where nothing was changed.

    shift: rms radii; turn: degrees; ratios: logarithm by name of the field, NaN where it
    was not always seen; ends: by name of the field.
    """

    shift: float
    turn: float
    ratios: dict[str, float]
    ends: dict[str, float]


def _doubt(shaken: list[StrokeFound]) -> _Doubt:
    ratios = {name: [_log(getattr(s, name)) for s in shaken] for name in _RATIOS}
    return _Doubt(
        shift=_two_largest([float(np.hypot(*s.shift)) for s in shaken]),
        turn=_two_largest([s.turn for s in shaken]),
        ratios={name: _two_largest(logs) for name, logs in ratios.items()},
        ends={name: max(abs(getattr(s, name)) for s in shaken) for name in _ENDS},
    )


def _two_largest(values: list[float]) -> float:
    """NaN where any is."""
    return float(np.sort(np.abs(values))[-2:].sum())


def _log(ratio: float) -> float:
    return float(np.log(max(ratio, 1e-6)))


def _shaken(master: MasterStrokes, *, scale: float, grain: float) -> Strokes:
    """A master's strokes in the master itself, moved by half a pixel and made a little smaller or larger.

    What differs then is no fault: thinning takes another way through rough ink.
    """
    import cv2

    half = (SIDE - 1) / 2
    M = np.array([[scale, 0.0, (1 - scale) * half + 0.5], [0.0, scale, (1 - scale) * half + 0.37]])
    ink = 255 * master.sheet.ink.view(np.uint8)
    if grain < 1.0:
        coarse = cv2.resize(ink, None, fx=grain, fy=grain, interpolation=cv2.INTER_AREA)
        ink = cv2.resize(coarse, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
    moved = cv2.warpAffine(ink, M, (SIDE, SIDE), flags=cv2.INTER_LINEAR)
    other = replace(master.sheet, ink=np.asarray(moved > 127))
    return _measured(other, master, places=master.itself.moved)


def _beyond_doubt(found: StrokeFound, doubt: _Doubt) -> StrokeFound:
    """What was found, drawn toward no fault by as much as the master differs from itself."""
    away = float(np.hypot(*found.shift))
    keep = max(away - doubt.shift, 0.0) / max(away, 1e-9)
    changed: dict[str, Any] = {}
    for name, least in doubt.ratios.items():
        log = _log(getattr(found, name))
        changed[name] = float(np.exp(_toward_nought(log, least)))
    for name, least in doubt.ends.items():
        changed[name] = _toward_nought(getattr(found, name), least)
    turn = _toward_nought(found.turn, 0.4 * doubt.turn)
    return replace(found, shift=found.shift * keep, turn=turn, **changed)


def _toward_nought(value: float, by: float) -> float:
    """NaN stays NaN."""
    return float(np.sign(value) * np.maximum(abs(value) - by, 0.0))


def _less(found: StrokeFound, itself: StrokeFound) -> StrokeFound:
    """Ratios to what was found, in the same way, in the master itself, and differences from it."""
    ratios = {
        name: getattr(found, name) / getattr(itself, name) for name in _RATIOS if getattr(itself, name) > 1e-6
    }
    ends: dict[str, Any] = {name: getattr(found, name) - getattr(itself, name) for name in _ENDS}
    return replace(found, **ratios, **ends)


def _measured(sheet: Sheet, master: MasterStrokes, *, places: FloatArray | None) -> Strokes:
    """Strokes of one sheet against a master's.

    places: (n, 2) where the same measurement has the master's own points; None when this is the master.
    """
    mine, model, settings = copy_drawing(sheet), master.drawing, master.settings
    found = match(model.points, mine.points)
    near = settings.near * max(model.width, mine.width)
    covered, owner = covered_by(found, mine.points, model.points, near=near)
    in_cell = upright = _in_the_masters_cell(found.moved, sheet, master.sheet)
    pose, squeeze = Pose(np.eye(2), np.zeros(2)), None
    if places is None:
        places = upright
    elif covered.any():
        pose, squeeze = _stance(places[covered], upright[covered], model.points, covered)
        upright = pose.undone(upright)
    view = View(
        sheet, mine, model, settings, found.moved, covered, owner,
        expected=squeezed(places, squeeze), upright=upright, squeeze=squeeze,
        widths=half_widths(found, mine, model, covered), breadths=breadths(sheet, found.moved),
    )  # fmt: skip
    whole, ratio, ink = view.whole, view.ratio, view.ink
    radius = np.where(np.isfinite(view.widths), view.widths, whole / view.scale * model.points.radius)
    return Strokes(
        tuple(view.stroke(k, ratio, ink) for k in range(len(model.lines))),
        pose, whole, squeeze, model, mine, (sheet, master.sheet), found.moved, covered, owner >= 0, radius,
        places, in_cell,
    )  # fmt: skip


def _stance(
    places: FloatArray, copy: FloatArray, points: Points, covered: BoolArray
) -> tuple[Pose, Squeeze | None]:
    """How the whole stands; places, copy: (n, 2), those of the master's points that are covered.

    A squeeze keeps the outer edges and draws the middle along, so that a pose may take most of it for its
    own: it is looked for in the copy as it stands too.
    """
    owner, double = points.owner[covered], points.double[covered]
    pose = robust_pose(places, copy, owner=owner)
    upright = pose.undone(copy)
    squeeze = find_squeeze(places, upright, owner=owner, double=double)
    well = in_place(upright - squeezed(places, squeeze), owner)
    if squeeze is None and well < _WELL and pose.shift.any():
        other = find_squeeze(places, copy, owner=owner, double=double)
        if other is not None and in_place(copy - squeezed(places, other), owner) > well:
            return Pose(np.eye(2), np.zeros(2)), other
    return pose, squeeze


def covered_by(found: Match, copy: Points, master: Points, *, near: float) -> tuple[BoolArray, IntArray]:
    """Which of the master's points the copy has, and which stroke each of the copy's belongs to, or -1.

    near: rms radii within which ink is a stroke's own.
    """
    own = master.owner
    strongest = found.share.argmax(axis=0)
    owner = np.where(found.share.sum(axis=0) > 0.4, own[strongest], -1)
    squared = squared_distances(found.moved, copy.xy)
    reach = max(near, 1.6 * master.spacing)
    mine = owner[None, :] == own[:, None]
    covered = (np.where(mine, squared, np.inf).min(axis=1) < reach**2) & (found.share.sum(axis=1) > 0.15)
    owner = np.where(squared.min(axis=0) < (1.5 * reach) ** 2, owner, -1)
    return np.asarray(covered), owner


def _in_the_masters_cell(points: FloatArray, copy: Sheet, master: Sheet) -> FloatArray:
    """Points of the common frame, moved to where a cell of the master's size would have them."""
    fractions = points @ copy.to_picture[:, :2].T + copy.to_picture[:, 2]
    back = np.linalg.inv(master.to_picture[:, :2])
    # pictures of unlike shape: the longer sides are taken for one another
    return np.asarray((fractions - master.to_picture[:, 2]) @ back.T)
