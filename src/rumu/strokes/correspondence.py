"""Which stroke of the copy is which of the master's, and how it differs.

The master's strokes are laid on the copy's ink (see `matching`). Lean, size and position of the whole
character and a squeezed part are removed first (see `pose`), so that only a stroke's own faults are
attributed to it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter
from rumu.registration.points import ink_mask
from rumu.strokes.canonical import LaidCharacter, lay_character
from rumu.strokes.centre_lines import (
    SCALE,
    CentreLine,
    CentreLines,
    FramedInk,
    LinePoints,
    find_segments,
    find_strokes,
    frame_copy,
    frame_ink,
)
from rumu.strokes.edges import EdgeLook, InnerWhite, find_whites, look_at_edge
from rumu.strokes.ink_differences import InkComparison, InkDifference, MasterStrips, cut_strips
from rumu.strokes.measures import MatchedStroke, StrokeMeasurer, edge_tremor
from rumu.strokes.placement import Compared, Placement, lay_rest, perturb_ink, place_lines
from rumu.strokes.pose import NO_POSE, CharacterPose
from rumu.strokes.presence import find_missing
from rumu.strokes.stance import Squeeze, find_stance
from rumu.strokes.uncertainty import ENDS, StrokeUncertainty, relative_to, surely, uncertainty_of
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Registration, Surface


@dataclass(frozen=True, slots=True)
class StrokeMatchSettings:
    """How strokes are matched.

    perturbations: (scale, resolution) of the pictures of a master that are measured against itself, to see
        how much differs where nothing is at fault; resolution in pixels for each of its own. nudge: pixels
        (x, y) by which they are moved.
    taper: share of a stroke's width by which a tip must be finer than its stroke to be called tapering;
        blunt: share of that from whose loss one tip is called blunt.
    pixel_share: of a pixel of the coarser picture, by which a width may be wrong.
    """

    perturbations: tuple[tuple[float, float], ...] = ((0.96, 1.0), (1.03, 0.6), (1.0, 0.8))
    taper: float = 0.05
    blunt: float = 0.35
    pixel_share: float = 0.3


CORRESPONDENCE = StrokeMatchSettings()


@dataclass(frozen=True, slots=True)
class BluntTips:
    """What became of the tips that taper in the master, all together.

    lost: share of their taper that most of them have lost; below 0 when they are finer. blunted: share of the
        tips that lost any. ends: (stroke, 0 for its entry or 1 for its exit) of those that lost much.
    """

    lost: float
    blunted: float
    ends: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeMatch:
    """The strokes of a master and those of a copy, matched.

    strokes: one for each of the master's, longest first. pose: of the copy against the master's place in its
        cell. width: median width of the copy's strokes over the master's. squeeze: a part too wide, if one
        is. master, copy: their lines; framed, framed_master: their ink in the common frame.
    moved: (n, 2) the master's points in the copy; covered: (n,) which of them the copy has; radius:
        (n,) the copy's half-width there, or what it should be; places: (n, 2) where the same measurement has
        them in the master itself; in_cell: (n, 2) where the copy has them in a cell like the master's.
    owner: (m,) number of the line that each of the copy's points belongs to, or -1.
    missing: numbers of the strokes that the copy lacks: canonical ones from 1, or else lines, from -1 down.
    laid: the canonical strokes that the master's lines are; None where they are not known.
    tips: None where fewer than two of the master's taper.
    """

    strokes: tuple[MatchedStroke, ...]
    pose: CharacterPose
    width: float
    squeeze: Squeeze | None
    master: CentreLines
    copy: CentreLines
    framed: FramedInk
    framed_master: FramedInk
    moved: FloatArray
    covered: BoolArray
    owner: IntArray
    radius: FloatArray
    places: FloatArray
    in_cell: FloatArray
    missing: tuple[int, ...] = ()
    laid: LaidCharacter | None = None
    tips: BluntTips | None = None

    @property
    def extent(self) -> tuple[float, FloatArray]:
        """Size of the copy over the master's, and (2,) how far its middle is off, by their outermost points.

        A second reading beside the pose, which is what most strokes agree upon.
        """
        if not self.covered.any():
            return 1.0, np.zeros(2)
        master, copy = self.places[self.covered], self.in_cell[self.covered]
        size = float(
            np.sqrt(np.prod(np.ptp(copy, axis=0)) / max(float(np.prod(np.ptp(master, axis=0))), 1e-9))
        )
        away = copy.min(axis=0) + copy.max(axis=0) - master.min(axis=0) - master.max(axis=0)
        return size, np.asarray(away / 2)

    @property
    def spread(self) -> tuple[float, FloatArray]:
        """The same by the middle of all its points and their distances from it."""
        if not self.covered.any():
            return 1.0, np.zeros(2)
        master, copy = self.places[self.covered], self.in_cell[self.covered]
        size = np.sqrt(copy.var(axis=0).sum() / max(float(master.var(axis=0).sum()), 1e-9))
        return float(size), np.asarray((copy - master).mean(axis=0))

    @property
    def by_extent(self) -> FloatArray:
        """(n, 2) where the copy has the master's points, that size and shift taken out."""
        if not self.covered.any():
            return self.in_cell
        size, away = self.extent
        master = self.places[self.covered]
        middle = (master.min(axis=0) + master.max(axis=0)) / 2
        each = max(size, 1e-3) * np.exp(np.array([0.5, -0.5]) * self.pose.aspect)
        return np.asarray((self.in_cell - away - middle) / each + middle)

    @property
    def enlargement(self) -> float:
        """How many times the coarser picture was enlarged for the common frame; 1 when it was not."""
        return max(1.0, self.framed.enlargement, self.framed_master.enlargement)

    def width_error(self, line: CentreLine | LinePoints) -> float:
        """How far the logarithm of a width may be wrong, of a line or of all, since pictures are coarse."""
        return CORRESPONDENCE.pixel_share / (float(np.median(line.radius)) * SCALE) * self.enlargement


@dataclass(frozen=True, eq=False)
class MasterStrokes:
    """A master's strokes with what copies are compared with, to be made once for all copies.

    surface, reference: the master and its ink points. character: None when it is not known.
    """

    surface: Surface
    reference: PointSet
    character: CanonicalCharacter | None = None

    @cached_property
    def framed(self) -> FramedInk:
        """Its ink in the common frame."""
        return frame_ink(ink_mask(self.surface), self.reference)

    @cached_property
    def laid(self) -> LaidCharacter | None:
        """The canonical strokes of its character on it; None where they are not known or do not fit."""
        laid = None if self.character is None else lay_character(self.character, self.framed)
        return laid if laid is not None and laid.is_confident else None

    @cached_property
    def lines(self) -> CentreLines:
        """Its strokes' centre lines: the canonical ones where they are known."""
        return find_strokes(self.framed) if self.laid is None else self.laid.lines

    @cached_property
    def itself(self) -> StrokeMatch:
        """Its strokes as the measurement of copies finds them in the master itself."""
        return _match_framed(self.framed, self, places=None)

    @cached_property
    def uncertainties(self) -> tuple[StrokeUncertainty, ...]:
        """The uncertainty of each stroke, from small changes of the master's size."""
        changed = [_match_perturbed(self, *change).strokes for change in CORRESPONDENCE.perturbations]
        strokes = zip(self.itself.strokes, *changed, strict=True)
        return tuple(uncertainty_of([relative_to(own, s) for s in others]) for own, *others in strokes)

    @cached_property
    def strips(self) -> MasterStrips:
        """Its ink along each stroke."""
        return cut_strips(self.lines, self.framed)

    @cached_property
    def tremor(self) -> float:
        """How much its edges swing, see `measures.edge_tremor`."""
        return edge_tremor(self.framed)

    @cached_property
    def edge(self) -> EdgeLook:
        """How even its edges are."""
        return look_at_edge(ink_mask(self.surface), self.reference)

    @cached_property
    def whites(self) -> tuple[InnerWhite, ...]:
        """The white that its ink encloses, in the common frame."""
        return find_whites(self.framed.ink)


@dataclass(frozen=True, eq=False)
class CopyStrokes:
    """A master's strokes on a copy, to be found once for the mark and the remarks.

    surface: the copy. registration: of the two surfaces.
    """

    surface: Surface
    registration: Registration
    master: MasterStrokes

    @cached_property
    def compared(self) -> Compared:
        """The copy's lines beside the master's."""
        framed = frame_copy(self.surface, self.registration)
        return Compared(self.master.lines, find_segments(framed), framed, self.master.itself.moved)

    @cached_property
    def found(self) -> tuple[dict[int, float], Placement]:
        """The strokes that it lacks, how surely, and all lines on it, see `find_missing`."""
        return find_missing(self.compared)


def match_strokes(copy: CopyStrokes) -> StrokeMatch:
    """Find the master's strokes in the copy, and how each differs.

    The master measured against itself in the same way is subtracted, so that a perfect copy has no
    differences: a fork that thinning displaces is displaced in both.
    """
    itself, framed, lines = copy.master.itself, copy.compared.framed, copy.compared.copy
    lacking, laid = copy.found
    missing = tuple(lacking)
    if missing:
        framed, lines, laid = lay_rest(copy.compared, missing)
    found = _measure_laid(framed, lines, laid, copy.master, places=itself.moved, missing=missing)
    ink = _compare_ink(found, copy.master)
    known = zip(found.strokes, itself.strokes, copy.master.uncertainties, ink, strict=True)
    return replace(
        found,
        strokes=tuple(
            replace(surely(relative_to(own, stroke), doubt), ink=seen) for stroke, own, doubt, seen in known
        ),
        tips=_blunt_tips(found.strokes, itself.strokes),
    )


def _compare_ink(found: StrokeMatch, master: MasterStrokes) -> tuple[InkDifference, ...]:
    return InkComparison(
        master.strips,
        found.master,
        found.framed_master,
        found.framed,
        found.pose,
        found.squeeze,
        found.places,
        found.moved,
    ).differences()


def _blunt_tips(found: tuple[MatchedStroke, ...], itself: tuple[MatchedStroke, ...]) -> BluntTips | None:
    """What the tips have lost; uncertainty is not subtracted, since it averages out over many tips.

    Beside the master's middle and beside their own stroke, the lesser: a thin stroke with a sharp tip has
    lost nothing, nor has a heavy one whose tip is as fine as the master's.
    """
    tips = []
    for k, (a, b) in enumerate(zip(found, itself, strict=True)):
        for end, name in enumerate(ENDS):
            now, own = getattr(a, name), getattr(b, name)
            if a.present and own < -CORRESPONDENCE.taper:  # not so where it is NaN
                lesser = min(now, now / a.width) if a.width > 0 else now
                tips.append((k, end, lesser - own, -own))
    if len(tips) < 2:
        return None
    lost, taper = np.array([tip[2] / tip[3] for tip in tips]), np.array([tip[3] for tip in tips])
    order = np.argsort(lost)
    half = int(np.argmax(np.cumsum(taper[order]) >= 0.5 * taper.sum()))
    blunted = lost >= CORRESPONDENCE.blunt
    ends = tuple((k, end) for (k, end, *_), blunt in zip(tips, blunted, strict=True) if blunt)
    return BluntTips(float(lost[order][half]), float((lost > 0).mean()), ends)


def _match_perturbed(master: MasterStrokes, scale: float, resolution: float) -> StrokeMatch:
    """A master's strokes in the master itself, moved by half a pixel and made a little smaller or larger.

    The differences are measurement error: thinning takes another way through rough ink.
    """
    changed = perturb_ink(master.framed, 0.0, scale, resolution)
    return _match_framed(changed, master, places=master.itself.moved)


def _match_framed(framed: FramedInk, master: MasterStrokes, *, places: FloatArray | None) -> StrokeMatch:
    """A master's strokes in framed ink that lacks none of them; places: as of `_measure_laid`."""
    copy = find_segments(framed)
    return _measure_laid(framed, copy, place_lines(master.lines, copy), master, places=places)


def _measure_laid(
    framed: FramedInk,
    copy: CentreLines,
    laid: Placement,
    master: MasterStrokes,
    *,
    places: FloatArray | None,
    missing: tuple[int, ...] = (),
) -> StrokeMatch:
    """A master's strokes against those of some ink, on whose lines they are laid.

    places: (n, 2) where the same measurement has the master's own points; None when this is the master.
    """
    model, found, covered = master.lines, laid.found, laid.covered
    in_cell = upright = to_master_cell(found.moved, framed, master.framed)
    pose, squeeze = NO_POSE, None
    if places is None:
        places = upright
    elif covered.any():
        owner, double = model.points.owner[covered], model.points.double[covered]
        pose, squeeze = find_stance(places[covered], upright[covered], owner=owner, double=double)
        upright = pose.undo(upright)
    expected = places if squeeze is None else squeeze.apply(places)
    measurer = StrokeMeasurer(
        framed, copy, model, found, covered, laid.owner, expected, upright, squeeze, pose.aspect
    )
    return StrokeMatch(
        strokes=tuple(measurer.stroke(k) for k in range(len(model.lines))),
        pose=pose,
        width=measurer.whole_width,
        squeeze=squeeze,
        master=model,
        copy=copy,
        framed=framed,
        framed_master=master.framed,
        moved=found.moved,
        covered=covered,
        owner=laid.owner,
        radius=measurer.radii(),
        places=places,
        in_cell=in_cell,
        missing=missing,
        laid=master.laid,
    )


def to_master_cell(points: FloatArray, copy: FramedInk, master: FramedInk) -> FloatArray:
    """Points of the common frame, moved to where a cell of the master's size would have them."""
    back = np.linalg.inv(master.to_picture[:, :2])
    # pictures of unlike shape: the longer sides are taken for one another
    return np.asarray((copy.on_picture(points) - master.to_picture[:, 2]) @ back.T)
