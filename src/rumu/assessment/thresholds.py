"""From which size a fault is worth a remark, how severe it is, and how it is drawn on the copy's picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rumu.values import FloatArray

Box = tuple[float, float, float, float]
Lines = tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True, slots=True)
class RemarkThresholds:
    """The smallest fault that is worth a remark: about what the eye notices.

    lean: degrees. offset: fraction of the cell. size, aspect: relative. weight: natural logarithm of the
        width.
    squeeze: how much wider one part is than the other, relative to the master; squeeze_unknown: the same
        where the character's structure is not known. part_place: fraction of the cell by which one part
        stands off the other. inner: relative size of what is enclosed; inner_place: fraction of the
        cell by which it is off its place.
    confident: share of a canonical stroke that must have been found in the master for it to be spoken of.
    border: fraction of the picture, from the border of the copy, within which a stroke is cut off by it.
    on_ink: share of a stroke's line that must lie on ink of the copy: a line that leads over bare paper, from
        one stroke to another, is neither.
    hook_bare: share of a hook that must be bare paper, and hook_covered: that may have found ink, for it not
        to have been flicked out. leg_found: share of a part of a bent stroke that may have found ink, or lie
        on any, for it to be missing; leg_share: of the ink that it must hold.
    extra, blot: share of the copy's ink; extra_reach: stroke widths that a stroke too many which joins
        another must go away from it; round: how slender a blot may be; off: what is at a stroke
        that is so many times out of its place, or too long, is that stroke and no blot.
    displaced: fraction of the cell; stretched: share of a stroke's change of length by which its middle
        may have moved along it. turn: degrees, of a stroke `slender` widths long or longer; of a shorter one
        more, up to turn_short times.
    unlike: share of its ink by which a stroke must differ from the master's, once the whole's size, place and
        lean are taken out, for its place, turn, length or width to be spoken of; unlike_end: the same of an
        end; both more where a picture had to be enlarged. taken_out: share of that which may be left when a
        stroke that is out of place is put back; put_wrong: share from which its line was laid on other ink.
    exaggerated: how many times what its line lacks the ink at its ends may lack, to be believed.
    longest: change of length above which it is not believed: the line was laid on another stroke's ink too.
    shrunk: by how much a stroke's line must be shorter for what its ink lacks at its ends to count; put_back:
        share of its ink that may differ at most then, its own shift and turn taken out.
    length: relative; length_doubt: up to which readings of it may differ in sign; length_unsure: so many
        times more for a stroke that joins others at both ends, and for one up to `short` widths long.
    small_dot: share of its ink that a dot that stands alone may hold at most to be called too small.
    sticks_out: fraction of the cell.
    stroke: logarithm of one stroke's width over the master's, and over that of the whole; believed: the same
        above which it is an error of measurement unless its ink shows so large a share, fuller, of the
        change, and somewhat_fuller of a smaller change; much_heavier: times `stroke` from which strokes are
        told together, where `several` are; entry, exit: how much wider an end is than in the master, as a
        share of its stroke; faint: how much thinner an entry; most_end: from which the end of another stroke
        was measured.
    tips: share of the taper that most tips have lost; most_tips: share of the tips that must have lost some;
        beyond_tip: stroke widths beyond a tip where no more ink lies.
    gap: relative change of the white between strokes; uneven: spread of the changes, over that.
    bare: share of the strokes' inside. tremor: rms radii, of `smooth` times more where the edges are not
        `frayed` a little, too, a least of `InkMeasures.torn`; rougher: least of it relative to the master's.
        torn: least of `InkMeasures.torn` from which they are torn.
    filled: share of its half-width that a white must have lost. open: widths of the copy's strokes that the
        gap in a box must measure. pale: relative; paler: the same where all ink
        is equally pale, which a photograph's exposure may do.
    margin: stroke widths around a stroke, of the box of a remark.
    weak: share of these sizes from which a fault may explain a part of the mark below `part_explained`, when
        no greater one does. at_most: remarks in all. slight: share of the worst one's severity below which
        another is not worth saying beside it.
    """

    lean: float = 3.0
    offset: float = 0.04
    size: float = 0.08
    aspect: float = 0.1
    weight: float = 0.14
    squeeze: float = 0.2
    squeeze_unknown: float = 0.5
    part_place: float = 0.035
    inner: float = 0.12
    inner_place: float = 0.03
    confident: float = 0.5
    border: float = 0.01
    on_ink: float = 0.7
    hook_bare: float = 0.6
    hook_covered: float = 0.3
    leg_found: float = 0.25
    leg_share: float = 0.04
    extra: float = 0.012
    extra_reach: float = 1.0
    blot: float = 0.009
    round: float = 2.6
    off: float = 2.0
    unlike: float = 0.1
    unlike_end: float = 0.1
    taken_out: float = 0.9
    displaced: float = 0.016
    put_wrong: float = 2.0
    most_end: float = 0.9
    stretched: float = 0.55
    turn: float = 3.0
    slender: float = 4.3
    turn_short: float = 2.0
    length: float = 0.08
    length_unsure: float = 1.3
    length_doubt: float = 0.04
    short: float = 4.0
    exaggerated: float = 2.5
    longest: float = 1.0
    shrunk: float = 0.03
    put_back: float = 0.6
    small_dot: float = 0.5
    sticks_out: float = 0.05
    stroke: float = 0.15
    believed: float = 0.8
    fuller: float = 0.5
    somewhat_fuller: float = 0.25
    much_heavier: float = 1.6
    several: int = 3
    entry: float = 0.1
    faint: float = 0.22
    exit: float = 0.19
    tips: float = 0.16
    most_tips: float = 0.6
    beyond_tip: tuple[float, float] = (0.6, 1.2)
    gap: float = 0.25
    uneven: float = 0.6
    bare: float = 0.022
    tremor: float = 0.0012
    rougher: float = 0.12
    frayed: float = 0.15
    smooth: float = 1.2
    torn: float = 1.2
    filled: float = 0.6
    open: float = 0.65
    pale: float = 0.15
    paler: float = 0.3
    margin: float = 0.4
    weak: float = 0.5
    part_explained: float = 50.0
    at_most: int = 3
    slight: float = 0.4


PLACE_DOUBT = 0.01
"""Fraction of the cell up to which two readings of a place may have different signs and still agree."""

SEVERITIES: Mapping[str, float] = {
    "lean": 6.0, "size": 6.0, "offset": 5.0, "aspect": 6.0, "weight": 7.0, "squeeze": 7.0,
    "part_place": 6.0, "inner": 7.0,
    "missing": 8.0, "hook": 2.4, "extra": 5.0, "blot": 4.0, "dry": 5.0, "rough": 2.2, "torn": 7.0,
    "pale": 4.5, "filled": 6.0, "open": 4.5, "displaced": 3.4, "angle": 3.0, "length": 2.6, "sticks_out": 5.0,
    "width": 3.2, "entry": 1.9, "end": 2.2, "tips": 3.2, "spacing": 4.5,
}  # fmt: skip
"""Points of the mark, about, that the smallest fault worth a remark stands for."""
GROWTH = 0.6
"""Power of its size with which a fault grows more severe: twice as large is not twice as bad."""
EDGE_GROWTH = 1.3
"""The same of edges that tremble: a little is hardly seen beside other faults, much before all of them."""
STROKE_BOUNDS = (0.5, 1.3)
"""Least and greatest factor by which a stroke's weight changes the severity of its fault."""
INK_POINTS = 60.0
"""Points for all of the ink, where a share of it is missing or too much."""


def contradict(readings: Sequence[float], *, doubt: float) -> bool:
    """Whether readings of one difference have different signs; one within `doubt` of 0 has none."""
    clear = [value for value in readings if abs(value) > doubt]
    return bool(clear) and min(clear) < 0 < max(clear)


def agreed(readings: Sequence[float], *, doubt: float) -> float:
    """What two or three readings of one difference agree upon: the lesser of two, the middle one of three.

    0 where they contradict one another.
    """
    if contradict(readings, doubt=doubt):
        return 0.0
    return float(sorted(readings, key=abs)[(len(readings) - 1) // 2])


def severity(fault: str, size: float, least: float, *, weight: float = 1.0) -> float:
    """Points of the mark, about, that a fault stands for; it orders the remarks and does nothing else.

    size, least: of the fault and of the smallest worth a remark. weight: of its stroke against a common one.
    """
    factor = np.clip(np.sqrt(weight), *STROKE_BOUNDS)
    growth = EDGE_GROWTH if fault == "rough" else GROWTH
    return float(SEVERITIES[fault] * (abs(size) / least) ** growth * factor)


def ink_severity(fault: str, share: float) -> float:
    """The same for a share of the ink that is missing or too much."""
    return SEVERITIES[fault] + INK_POINTS * share


def box(points: FloatArray, *, margin: float = 0.0) -> Box:
    """The box of (n, 2) points in fractions of a picture, widened by `margin`, cut at its edges."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    (x0, y0), (x1, y1) = np.clip(low, 0.0, 0.998), np.clip(high, 0.002, 1.0)
    return float(x0), float(y0), float(max(x1, x0 + 0.002)), float(max(y1, y0 + 0.002))


def as_lines(*lines: FloatArray) -> Lines:
    """Lines of (n, 2) points as plain numbers, a ten-thousandth of the picture fine."""
    return tuple(tuple((round(float(x), 4), round(float(y), 4)) for x, y in line) for line in lines)
