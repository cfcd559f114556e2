"""What the ink itself tells: ink beside the strokes, bare streaks within them, trembling edges, paleness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.assessment.sheets import RADIUS, SIDE, Sheet, pixels
from rumu.assessment.stroke_measures import edge_tremor
from rumu.assessment.strokes import MasterStrokes, Strokes
from rumu.values import BoolArray, FloatArray, Surface


@dataclass(frozen=True, slots=True)
class InkSettings:
    """What makes a patch.

    beside: stroke widths from a stroke's own edge from which ink is beside it. deep: widths that a patch
        must reach beyond that. share: of the copy's ink that it must hold.
    """

    beside: float = 0.18
    deep: float = 0.16
    share: float = 0.008


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """Ink of the copy that belongs to none of the master's strokes.

    share: of the copy's ink. slender: its area over that of its largest disc; a disc is 1.
    attached: whether it touches a stroke. outline: (n, 2)
        its edge on the copy's picture, fractions of it, origin top left.
    """

    share: float
    slender: float
    attached: bool
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Ink:
    """What is measured of the copy's ink.

    patches: ink that no stroke explains, largest first; blots and extra strokes alike.
    bare: share of the inside of its strokes that is bare, beyond the master's. tremor: how much more than the
        master's its edges swing about their own smoothed line, rms radii; rough: so
        many times the master's. pale: darkness over the master's.
    """

    patches: tuple[Patch, ...]
    bare: float
    tremor: float
    rough: float
    pale: float


def measure_ink(
    strokes: Strokes, copy: Surface, master: MasterStrokes, *, settings: InkSettings | None = None
) -> Ink:
    """The ink of a copy whose strokes are known."""
    settings = settings or InkSettings()
    mine, theirs = strokes.sheets
    beside = settings.beside * strokes.master.width * RADIUS
    itself, tremor = master.itself, edge_tremor(mine)
    tube = _drawn(strokes.moved, strokes.radius * RADIUS + beside) | _left_over(theirs, itself, beside)
    return Ink(
        patches=_patches(mine, tube, strokes.copy.width * RADIUS, settings),
        bare=_bare(strokes, mine.ink, strokes.covered) - _bare(itself, theirs.ink, strokes.covered),
        tremor=(tremor - master.tremor) / RADIUS,
        rough=tremor / max(master.tremor, 0.05),
        pale=_darkness(copy) / max(_darkness(master.surface), 1e-6),
    )


def _drawn(points: FloatArray, radius: FloatArray) -> BoolArray:
    """(SIDE, SIDE) bool: discs about points of the frame, radius in pixels."""
    import cv2

    sheet = np.zeros((SIDE, SIDE), np.uint8)
    at = np.round(pixels(points) * 16).astype(np.int64)
    for (x, y), r in zip(at.tolist(), np.round(radius * 16).astype(int).tolist(), strict=True):
        cv2.circle(sheet, (x, y), r, 1, -1, cv2.LINE_8, 4)
    return sheet.astype(bool)


def _patches(sheet: Sheet, tube: BoolArray, width: float, settings: InkSettings) -> tuple[Patch, ...]:
    import cv2

    beside = (sheet.ink & ~tube).view(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(beside, connectivity=8)
    if count < 2:
        return ()
    away = cv2.distanceTransform((~tube).view(np.uint8), cv2.DIST_L2, 3)
    inside = cv2.distanceTransform(np.pad(sheet.ink & ~tube, 1).view(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    total = int(sheet.ink.sum())
    found = []
    for k in range(1, count):
        area = int(stats[k, cv2.CC_STAT_AREA])
        if area < settings.share * total:
            continue
        own = labels == k
        if float(away[own].max()) < settings.deep * width:
            continue
        slender = area / (np.pi * float(inside[own].max()) ** 2)
        around = cv2.dilate(own.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
        attached = bool((around & sheet.ink & tube).any())
        found.append(Patch(area / total, slender, attached, _edge(own, sheet)))
    return tuple(sorted(found, key=lambda p: -p.share))


def _edge(own: BoolArray, sheet: Sheet) -> FloatArray:
    """(n, 2) the outer edge of a patch, closed, in fractions of the copy's picture."""
    import cv2

    edges, _ = cv2.findContours(own.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    line = max(edges, key=len)[:, 0, :].astype(float)
    line = (np.concatenate([line, line[:1]]) - (SIDE - 1) / 2) / RADIUS
    return np.asarray(line @ sheet.to_picture[:, :2].T + sheet.to_picture[:, 2])


def _left_over(theirs: Sheet, itself: Strokes, beside: float) -> BoolArray:
    """The master's ink that its own strokes do not explain: in a copy it is no fault."""
    import cv2

    spare = theirs.ink & ~_drawn(itself.moved, itself.radius * RADIUS + beside)
    return np.asarray(cv2.dilate(spare.view(np.uint8), np.ones((5, 5), np.uint8)) > 0)


def _bare(strokes: Strokes, ink: BoolArray, seen: BoolArray) -> float:
    """Share of the inside of the strokes that holds no ink, though there is ink on both sides of it."""
    import cv2

    inner = _drawn(strokes.moved[seen], 0.6 * RADIUS * strokes.radius[seen])
    reach = max(round(0.45 * strokes.master.width * RADIUS), 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    closed = cv2.morphologyEx(ink.view(np.uint8), cv2.MORPH_CLOSE, disc) > 0
    return float((inner & closed & ~ink).sum() / max(inner.sum(), 1))


def _darkness(surface: Surface) -> float:
    """Median darkness of the ink against its paper, 0 to 1."""
    if "contrast" in surface.quality:
        return float(surface.quality["contrast"])
    return 1.0
