"""Which remarks name a simulated fault, and whether the fault is large enough to be seen at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from rumu.strokes.stance import ASPECT
from rumu.values import Remark
from rumu_lab.simulation.faults import FaultyGlyph
from rumu_lab.simulation.glyph import Glyph

PICTURE = 512
"""Pixels of the side of a picture that sizes of faults are given for."""

ANSWERS: Mapping[str, tuple[str, ...]] = {
    "missing": ("missing",),
    "squeeze": ("squeeze",),
    "lean": ("lean",),
    "entry": ("entry_heavy",),
    "blunt": ("exit_blunt", "entry_heavy"),
    "small": ("size",),
    "shift": ("displaced",),
    "angle": ("stroke_angle",),
    "horizontal": ("stroke_angle",),
    "thick": ("heavy",),
    "thin": ("thin",),
    "stroke_thick": ("stroke_heavy",),
    "stroke_thin": ("stroke_thin",),
    "short": ("stroke_short",),
    "extra": ("extra",),
    "off_centre": ("offset",),
    "uneven": ("spacing", "displaced"),
    "wobble": ("rough",),
    "blot": ("blot",),
    "pale": ("pale",),
    "dry": ("dry",),
    "narrow": ("aspect",),
}
"""The kinds of remark that name a fault, the faults that were asked for first.

A tip that is blunt at the beginning of a stroke is one that begins too heavily, where ink was added there.
"""
SEEN_INK = 0.01
"""Share of the ink that blunt tips must add to be there at all."""
SEEN_CHANGE = 0.15
"""Share of its stroke's ink that a fault of one stroke must add and take away together to be seen: about what
a turn of 3 degrees does to a stroke six widths long, or a push of a seventh of its width aside."""
SEEN_PUSH = 0.02
"""Fraction of the picture by which a stroke must stand off where the others do to be seen."""
_OF_ONE_STROKE = ("shift", "angle", "horizontal", "short", "stroke_thin", "stroke_thick")
_MOST = 0.5
"""Share of all strokes, by length, from which the others stand off when one stroke is pushed."""
NEAR = 0.07
"""Fraction of the picture within which a remark's outline must keep to the struck stroke's path."""


def can_be_named(copy: FaultyGlyph, glyph: Glyph, character: str | None) -> bool:
    """Whether a fault is of a kind that its character has."""
    if copy.fault == "squeeze":
        return has_halves(character)  # without a left and a right part nothing is said of them
    if copy.fault == "narrow":
        return len(glyph.strokes) >= ASPECT.strokes
    if copy.fault == "blunt":  # no tip that tapers, as in seal script
        return bool((copy.mask ^ glyph.mask).sum() >= SEEN_INK * glyph.mask.sum())
    return True


def is_seen(copy: FaultyGlyph, glyph: Glyph) -> bool:
    """Whether a fault is as large as what the eye notices; one that closed joints have hidden is not."""
    if copy.fault == "uneven":
        return copy.apart >= SEEN_PUSH * PICTURE
    if copy.fault not in _OF_ONE_STROKE:
        return True
    own = sum(int(glyph.strokes[k].ink.sum()) for k in copy.strokes)
    return bool((copy.mask ^ glyph.mask).sum() >= SEEN_CHANGE * own)


def farthest_change(copy: FaultyGlyph, glyph: Glyph) -> float:
    """How far ink of the copy lies off the master's at most, or the other way; fraction of the picture."""
    import cv2

    ways = ((copy.mask, glyph.mask), (glyph.mask, copy.mask))
    away = (cv2.distanceTransform((~of).astype(np.uint8), cv2.DIST_L2, 5)[ink] for ink, of in ways)
    return float(max(each.max(initial=0.0) for each in away) / max(glyph.mask.shape))


def find_position(
    remarks: Sequence[Remark], untold: Sequence[Remark], copy: FaultyGlyph, glyph: Glyph
) -> int | None:
    """Number of the remark that names a fault, from 0, as its first or as its second half; None for none."""
    for position, remark in enumerate(remarks):
        told = [remark, *(other for other in untold if _is_mentioned(other, remark))]
        if any(one.kind in ANSWERS[copy.fault] and speaks_of(one, copy, glyph) for one in told):
            return position
    return None


def _is_mentioned(other: Remark, remark: Remark) -> bool:
    """Whether a fault without a remark of its own is told in one sentence with another of its stroke."""
    sentence, also = (one.zh.split("。")[0] for one in (remark, other))
    _, joined, second = sentence.rpartition("，又")
    return bool(joined) and also.endswith(second) and other.master_outline == remark.master_outline


def speaks_of(remark: Remark, copy: FaultyGlyph, glyph: Glyph) -> bool:
    """Whether a remark speaks of strokes that the fault struck, or of the place where it is."""
    if not copy.strokes:
        return remark.region is None or copy.fault not in ("extra", "blot") or _meet(remark, copy)
    if not remark.outline:
        return False
    if copy.fault == "entry" and not _meet(remark, copy):
        return False  # a heavy beginning, but of another stroke or at the wrong end
    if copy.fault == "blunt" and remark.kind == "entry_heavy" and not _is_added(remark, copy, glyph):
        return False
    lengths = [stroke.length for stroke in glyph.strokes]
    if copy.fault == "shift" and sum(lengths[k] for k in copy.strokes) >= _MOST * sum(lengths):
        return True  # beside a stroke that is most of the character it is the others that stand off
    points = np.concatenate([np.array(line) for line in remark.outline])
    size = np.array(glyph.mask.shape, float)
    paths = np.concatenate([(glyph.strokes[k].points / size)[:, ::-1] for k in copy.strokes])
    away = np.sqrt(((points[:, None] - paths[None]) ** 2).sum(axis=2)).min(axis=1)
    return float((away < NEAR).mean()) >= 0.6


def _is_added(remark: Remark, copy: FaultyGlyph, glyph: Glyph) -> bool:
    """Whether at least a quarter of what a blunt tip has on average lies in the region of a remark."""
    added = copy.mask & ~glyph.mask
    x0, y0, x1, y1 = remark.region or copy.region
    height, width = added.shape
    here = added[int(y0 * height) : int(y1 * height) + 1, int(x0 * width) : int(x1 * width) + 1]
    return bool(here.sum() >= 0.25 * added.sum() / max(len(copy.strokes), 1) > 0)


def _meet(remark: Remark, copy: FaultyGlyph) -> bool:
    a, b = remark.region or copy.region, copy.region
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def has_halves(character: str | None) -> bool:
    """Whether a character is made of a left and a right part."""
    from rumu.assessment.part_measures import AXES
    from rumu.characters.stroke_data import find_character

    known = find_character(character) if character else None
    return known is not None and known.structure is not None and AXES.get(known.structure) == "across"
