"""What the ink itself shows: ink beside the strokes, bare streaks within them, trembling edges, paleness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import SCALE, SIDE, FramedInk, from_pixels, to_pixels
from rumu.strokes.correspondence import CharacterMatch, MasterStrokes
from rumu.strokes.measures import edge_tremor
from rumu.values import BoolArray, FloatArray, Surface


@dataclass(frozen=True, slots=True)
class InkSettings:
    """What makes a patch of ink, and how the ink is looked at. Lengths in stroke widths.

    beside: distance from a stroke's own edge from which ink is beside it. deep: how far a patch must reach
        beyond that. share: of the copy's ink that it must hold.
    inner: share of a stroke's half-width that is its inside. streak: width up to which bare paper between ink
        is a streak. least_tremor: pixels that a master's edges are taken to swing at least.
    """

    beside: float = 0.18
    deep: float = 0.16
    share: float = 0.008
    inner: float = 0.6
    streak: float = 0.45
    least_tremor: float = 0.05


INK = InkSettings()


@dataclass(frozen=True, slots=True, eq=False)
class InkPatch:
    """Ink of the copy that belongs to none of the master's strokes.

    share: of the copy's ink. slender: its area over that of its largest disc; a disc is 1.
    attached: whether it touches a stroke. outline: (n, 2) its edge on the copy's picture, closed, in
    fractions of it, origin top left.
    """

    share: float
    slender: float
    attached: bool
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class InkMeasures:
    """What is measured of the copy's ink.

    patches: ink that no stroke explains, largest first; blots and extra strokes alike.
    bare: share of the inside of its strokes that is bare, beyond the master's. tremor: how much more than the
        master's its edges swing about their own smoothed line, rms radii; rough: so many times the master's.
    darkness: of the ink over the master's.
    """

    patches: tuple[InkPatch, ...]
    bare: float
    tremor: float
    rough: float
    darkness: float


def measure_ink(strokes: CharacterMatch, copy: Surface, master: MasterStrokes) -> InkMeasures:
    """Measure the ink of a copy whose strokes are matched."""
    framed, itself = strokes.framed, master.itself
    beside = INK.beside * strokes.master.width * SCALE
    tube = _draw_strokes(strokes.moved, strokes.radius * SCALE + beside)
    tube |= _unexplained_in_master(master, beside)
    tremor = edge_tremor(framed)
    # median darkness of the ink against its paper, 0 to 1; 1 where it is not known
    darkness, darkness_master = (float(s.quality.get("contrast", 1.0)) for s in (copy, master.surface))
    return InkMeasures(
        patches=_find_patches(framed, tube, strokes.copy.width * SCALE),
        bare=_bare(strokes, framed.ink, strokes.covered) - _bare(itself, master.framed.ink, strokes.covered),
        tremor=(tremor - master.tremor) / SCALE,
        rough=tremor / max(master.tremor, INK.least_tremor),
        darkness=darkness / max(darkness_master, 1e-6),
    )


def _draw_strokes(points: FloatArray, radius: FloatArray) -> BoolArray:
    """(SIDE, SIDE) bool: discs about points of the frame, radius in pixels."""
    import cv2

    page = np.zeros((SIDE, SIDE), np.uint8)
    at = np.round(to_pixels(points) * 16).astype(np.int64)
    for (x, y), r in zip(at.tolist(), np.round(radius * 16).astype(int).tolist(), strict=True):
        cv2.circle(page, (x, y), r, 1, -1, cv2.LINE_8, 4)
    return page.astype(bool)


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
        own, area = labels == k, int(stats[k, cv2.CC_STAT_AREA])
        if area < INK.share * total or float(away[own].max()) < INK.deep * width:
            continue
        slender = area / (np.pi * float(inside[own].max()) ** 2)
        around = cv2.dilate(own.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
        attached = bool((around & framed.ink & tube).any())
        edges, _ = cv2.findContours(own.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        edge = max(edges, key=len)[:, 0, :].astype(float)
        outline = framed.on_picture(from_pixels(np.concatenate([edge, edge[:1]])))
        found.append(InkPatch(area / total, slender, attached, outline))
    return tuple(sorted(found, key=lambda p: -p.share))


def _unexplained_in_master(master: MasterStrokes, beside: float) -> BoolArray:
    """The master's ink that its own strokes do not explain, and a margin: in a copy it is no fault."""
    import cv2

    itself = master.itself
    spare = master.framed.ink & ~_draw_strokes(itself.moved, itself.radius * SCALE + beside)
    return np.asarray(cv2.dilate(spare.view(np.uint8), np.ones((5, 5), np.uint8)) > 0)


def _bare(strokes: CharacterMatch, ink: BoolArray, seen: BoolArray) -> float:
    """Share of the inside of the strokes that holds no ink, though there is ink on both sides of it."""
    import cv2

    inner = _draw_strokes(strokes.moved[seen], INK.inner * SCALE * strokes.radius[seen])
    reach = max(round(INK.streak * strokes.master.width * SCALE), 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    closed = cv2.morphologyEx(ink.view(np.uint8), cv2.MORPH_CLOSE, disc) > 0
    return float((inner & closed & ~ink).sum() / max(inner.sum(), 1))
