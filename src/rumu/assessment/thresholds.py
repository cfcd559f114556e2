"""From which size a fault is worth a remark."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Noticeable:
    """The smallest fault that is worth a remark.

    lean: degrees. offset: fraction of the cell. size: relative. weight: natural logarithm of the width.
    squeeze: how much wider one part is than the other, relative to the master.
    missing: share of a stroke, in one run, that must be wanting; inked: of a corner that was not found, share
        on ink from which it may be there. extra, blot: share of the copy's ink.
    displaced: rms radii. turn: degrees, of a stroke `slender` widths long or longer; more of a shorter one.
    length: relative. stroke: logarithm of one stroke's width over that of the whole; entry, exit: how much
        wider an end is than in the master, as a share of its stroke; faint: how much thinner an entry is;
        tips: share of the taper that most tips have lost.
    gap: relative.
    bare: share of the strokes' inside. tremor: rms radii. pale: relative. round: how slender a blot may be.
    of_a_kind: remarks of one kind; at_most: remarks in all.
    """

    lean: float = 3.0
    offset: float = 0.04
    size: float = 0.08
    weight: float = 0.14
    squeeze: float = 0.15
    missing: float = 0.35
    inked: float = 0.5
    extra: float = 0.012
    blot: float = 0.009
    displaced: float = 0.03
    turn: float = 3.0
    slender: float = 4.3
    length: float = 0.08
    stroke: float = 0.2
    entry: float = 0.1
    faint: float = 0.22
    exit: float = 0.19
    tips: float = 0.16
    gap: float = 0.25
    bare: float = 0.022
    tremor: float = 0.0014
    pale: float = 0.15
    round: float = 2.6
    of_a_kind: int = 3
    at_most: int = 5


def severity(size: float, least: float, *, rate: float, weight: float = 1.0) -> float:
    """Points of the mark, about, that a fault stands for; it orders the remarks and does nothing else.

    size, least: of the fault and of the smallest worth a remark. rate: points of that smallest one. weight:
    of its stroke against a common one. A fault twice as large is not twice as grave.
    """
    return float(rate * (abs(size) / least) ** 0.6 * np.clip(np.sqrt(weight), 0.5, 1.3))
