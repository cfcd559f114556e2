"""What the ink itself shows: ink beside the strokes, bare streaks within them, trembling edges, paleness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.registration.points import ink_mask
from rumu.strokes.centre_lines import SCALE, FramedInk, from_pixels, pixels_at
from rumu.strokes.correspondence import MasterStrokes, StrokeMatch
from rumu.strokes.edges import InnerWhite, look_at_edge, white_left
from rumu.strokes.measures import edge_tremor
from rumu.strokes.openings import Opening, find_openings
from rumu.strokes.placement import draw_discs, stroke_numbers
from rumu.values import BoolArray, FloatArray, Registration, Surface


@dataclass(frozen=True, slots=True)
class InkSettings:
    """What makes a patch of ink, and how the ink is looked at. Lengths in stroke widths.

    beside: distance from a stroke's own edge from which ink is beside it. deep: how far a patch must reach
        beyond that. share: of the copy's ink that it must hold.
    inner: share of a stroke's half-width that is its inside. streak: width up to which bare paper between ink
        is a streak; in_ink: share of ink around a point of a stroke from which it lies in the stroke
        and not in a gap beside it. least_tremor: pixels that a master's edges are taken to swing at least.
    moved, turning: how much more than the master's of each makes an edge torn, see `EdgeLook`.
    half_dark: half-dark pixels for each pixel of outline, from which a picture has shades of ink; black: it
        has where even its darkest ink is lighter.
    far: rms radii from the master's ink, from which the copy's sticks out. lost: share of its half-width from
        which a white is told of at all. in_one_place: how much more than elsewhere an edge must be torn in
        one place, to say where.
    """

    beside: float = 0.18
    deep: float = 0.16
    share: float = 0.008
    inner: float = 0.6
    streak: float = 0.45
    least_tremor: float = 0.05
    in_ink: float = 0.55
    moved: float = 0.3
    turning: float = 0.02
    half_dark: float = 0.05
    black: float = 0.97
    far: float = 0.15
    lost: float = 0.3
    in_one_place: float = 1.8


INK = InkSettings()


@dataclass(frozen=True, slots=True, eq=False)
class InkPatch:
    """Ink of the copy that belongs to none of the master's strokes.

    share: of the copy's ink. slender: its area over that of its largest disc; a disc is 1. reach: how far
        from the strokes it goes, in stroke widths. attached: whether it touches a stroke. link: whether it
        leads from one stroke to another, as a brush does that is not lifted. outline: (n, 2) its edge on
        the copy's picture, closed, in fractions of it, origin top left.
    """

    share: float
    slender: float
    reach: float
    attached: bool
    link: bool
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FilledWhite:
    """White that ran shut.

    lost: share of its half-width. outline: (n, 2) its edge on the copy's picture, closed.
    """

    lost: float
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class StickingOut:
    """Ink that joins the copy's strokes and lies far from all of the master's.

    distance: of its farthest point, rms radii. tip, middle: (2,) that point, and the middle of all of it, in
    the common frame. outline: (n, 2) its edge on the copy's picture, closed.
    """

    distance: float
    tip: FloatArray
    middle: FloatArray
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class InkMeasures:
    """What is measured of the copy's ink.

    patches: ink that no stroke explains, largest first; blots and extra strokes alike. unfound: share of the
        master's ink whose strokes found none here, though they are not missing: patches may be theirs.
    bare: share of the inside of its strokes that is bare, beyond the master's. tremor: how much more than the
        master's its edges swing about their own smoothed line, rms radii; rough: so many times the master's.
    torn: how much more than the master's its edges are frayed and turn about; 1 is plainly torn.
        torn_at: (2,) where most, fractions of the copy's picture; None where it is so everywhere.
    filled: white that the master's ink encloses and the copy's has run into, the worst first.
    opened: boxes that the master closes and the copy leaves open, the widest gap first.
    sticking_out: ink far from all of the master's, the farthest first.
    has_shades: whether the picture shows ink lighter and darker at all; a binarised one does not.
    paleness: how much paler than the darkest ink of its own page the ink is, beyond the master's.
    darkness: of the ink against its paper, over the master's.
    """

    patches: tuple[InkPatch, ...]
    unfound: float
    bare: float
    tremor: float
    rough: float
    torn: float
    torn_at: FloatArray | None
    filled: tuple[FilledWhite, ...]
    opened: tuple[Opening, ...]
    sticking_out: tuple[StickingOut, ...]
    has_shades: bool
    paleness: float
    darkness: float


def measure_ink(
    strokes: StrokeMatch, copy: Surface, master: MasterStrokes, registration: Registration
) -> InkMeasures:
    """Measure the ink of a copy whose strokes are matched."""
    framed, itself = strokes.framed, master.itself
    beside = INK.beside * strokes.master.width
    tube = draw_discs(strokes.moved, strokes.radius + beside)
    tube |= _unexplained_in_master(master, beside)
    tremor = edge_tremor(framed)
    edge = look_at_edge(ink_mask(copy), registration.probe)
    torn = (edge.moved - master.edge.moved) / INK.moved + (edge.turning - master.edge.turning) / INK.turning
    # median darkness of the ink against its paper, 0 to 1; 1 where it is not known
    darkness, darkness_master = (float(s.quality.get("contrast", 1.0)) for s in (copy, master.surface))
    darkest, darkest_master = (float(s.quality.get("darkest", 1.0)) for s in (copy, master.surface))
    own, own_master = darkness / max(darkest, 1e-6), darkness_master / max(darkest_master, 1e-6)
    return InkMeasures(
        patches=_find_patches(framed, tube, strokes.copy.width * SCALE),
        unfound=_unfound_share(strokes, itself),
        bare=_bare(strokes, framed.ink, strokes.covered) - _bare(itself, master.framed.ink, strokes.covered),
        tremor=(tremor - master.tremor) / SCALE,
        rough=tremor / max(master.tremor, INK.least_tremor),
        torn=torn,
        torn_at=_on_picture(edge.worst, registration) if edge.worst_share > INK.in_one_place else None,
        filled=_find_filled(framed, master.whites),
        opened=find_openings(strokes, master.whites),
        sticking_out=_find_sticking_out(framed, master.framed),
        has_shades=float(copy.quality.get("between", 0.0)) >= INK.half_dark or darkest < INK.black,
        paleness=1.0 - own / max(own_master, 1e-6),
        darkness=darkness / max(darkness_master, 1e-6),
    )


def _on_picture(at: FloatArray, registration: Registration) -> FloatArray:
    """A point in rms radii of the copy's own ink from its middle, y down, on the copy's picture."""
    probe = registration.probe
    from_middle = at * probe.radius + probe.centre * np.array([1.0, -1.0])
    return np.asarray(0.5 + from_middle / np.array(probe.cell))


def _find_filled(framed: FramedInk, whites: tuple[InnerWhite, ...]) -> tuple[FilledWhite, ...]:
    """Those of the master's inner whites of which little is left."""
    found = []
    for white in whites:
        lost = 1.0 - white_left(white, framed.off_ink)
        if lost > INK.lost:
            own = np.zeros(framed.ink.shape, bool)
            own[tuple(white.pixels.T)] = True
            found.append(FilledWhite(lost, framed.outline_of(own)))
    return tuple(sorted(found, key=lambda white: -white.lost))


def _find_sticking_out(framed: FramedInk, master: FramedInk) -> tuple[StickingOut, ...]:
    """Ink of the copy far from the master's, where it joins ink that is not."""
    import cv2

    away = master.off_ink
    far = framed.ink & (away > INK.far * SCALE)
    count, labels = cv2.connectedComponents(far.view(np.uint8), connectivity=8)
    found = []
    for k in range(1, count):
        own = labels == k
        around = cv2.dilate(own.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
        if (around & framed.ink & ~far).any():
            pixels = np.argwhere(own)
            farthest = pixels[int(away[own].argmax())]
            tip, middle = from_pixels(np.array([farthest, pixels.mean(axis=0)])[:, ::-1])
            distance = float(away[own].max()) / SCALE
            found.append(StickingOut(distance, tip, middle, framed.outline_of(own)))
    return tuple(sorted(found, key=lambda patch: -patch.distance))


def _find_patches(framed: FramedInk, tube: BoolArray, width: float) -> tuple[InkPatch, ...]:
    """Patches of ink outside of the tube around the strokes; width: of a stroke, in pixels."""
    import cv2

    beside = framed.ink & ~tube
    count, labels, stats, _ = cv2.connectedComponentsWithStats(beside.view(np.uint8), connectivity=8)
    if count < 2:
        return ()
    away = cv2.distanceTransform((~tube).view(np.uint8), cv2.DIST_L2, 3)
    inside = cv2.distanceTransform(np.pad(beside, 1).view(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    total = int(framed.ink.sum())
    found = []
    for k in range(1, count):
        area = int(stats[k, cv2.CC_STAT_AREA])
        if area < INK.share * total:  # of most of them, there are many
            continue
        own = labels == k
        if float(away[own].max()) < INK.deep * width:
            continue
        slender = area / (np.pi * float(inside[own].max()) ** 2)
        around = cv2.dilate(own.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
        attached = bool((around & framed.ink & tube).any())
        link = attached and _is_link(own, away, tube, reach=0.6 * width)
        reach = float(away[own].max()) / width
        found.append(InkPatch(area / total, slender, reach, attached, link, framed.outline_of(own)))
    return tuple(sorted(found, key=lambda p: -p.share))


def _unfound_share(strokes: StrokeMatch, itself: StrokeMatch) -> float:
    """Share of the master's ink, without what is missing, that is found in the master and not in the copy."""
    missing = np.isin(stroke_numbers(strokes.master), strokes.missing)
    radius = strokes.master.points.radius
    return float(radius[itself.covered & ~strokes.covered & ~missing].sum() / radius.sum())


def _is_link(patch: BoolArray, away: FloatArray, tube: BoolArray, *, reach: float) -> bool:
    """Whether a patch touches strokes on both sides of where it is farthest from them; reach in pixels."""
    import cv2

    row, column = np.unravel_index(int(np.argmax(np.where(patch, away, -1.0))), patch.shape)
    rest = patch.astype(np.uint8)
    cv2.circle(rest, (int(column), int(row)), round(reach), 0, -1)
    count, labels = cv2.connectedComponents(rest, connectivity=8)
    beside = cv2.dilate(tube.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return sum(bool((beside & (labels == k)).any()) for k in range(1, count)) > 1


def _unexplained_in_master(master: MasterStrokes, beside: float) -> BoolArray:
    """The master's ink that its own strokes do not explain, and a margin: in a copy it is no fault."""
    import cv2

    itself = master.itself
    spare = master.framed.ink & ~draw_discs(itself.moved, itself.radius + beside)
    return np.asarray(cv2.dilate(spare.view(np.uint8), np.ones((5, 5), np.uint8)) > 0)


def _bare(strokes: StrokeMatch, ink: BoolArray, seen: BoolArray) -> float:
    """Share of the inside of the strokes that holds no ink, though there is ink on both sides of it.

    A point that lies beside a stroke of the copy, in the gap to the next, says nothing of its ink.
    """
    import cv2

    row, column = pixels_at(strokes.moved)
    around = max(2 * round(strokes.master.width / 2 * SCALE) + 1, 3)
    share = cv2.blur(ink.astype(np.float32), (around, around))[row, column]
    inside = seen & (share >= INK.in_ink)
    inner = draw_discs(strokes.moved[inside], INK.inner * strokes.radius[inside])
    reach = max(round(INK.streak * strokes.master.width * SCALE), 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    closed = cv2.morphologyEx(ink.view(np.uint8), cv2.MORPH_CLOSE, disc) > 0
    return float((inner & closed & ~ink).sum() / max(inner.sum(), 1))
