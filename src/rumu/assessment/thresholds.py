"""From which size a fault is worth a remark."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Noticeable:
    """The smallest fault that is worth a remark.

    lean: degrees. offset: fraction of the cell. size: relative. weight: natural logarithm of the width.
    squeeze: how much wider one part is than the other, relative to the master.
    missing: share of a stroke, in one run, that must be wanting. extra, blot: share of the copy's ink.
    displaced: rms radii; every stroke wanders by half of that in good copies. turn: degrees. length:
        relative. stroke: logarithm of one stroke's width over that of the whole; entry, exit: logarithm of
        the width of an end over that of its stroke. gap: relative.
    bare: share of the strokes' inside. tremor: rms radii. pale: relative. round: how slender a blot may be.
    of_a_kind: remarks of one kind; at_most: remarks in all.
    """

    lean: float = 3.0
    offset: float = 0.04
    size: float = 0.08
    weight: float = 0.14
    squeeze: float = 0.15
    missing: float = 0.35
    extra: float = 0.012
    blot: float = 0.009
    displaced: float = 0.07
    turn: float = 4.5
    length: float = 0.13
    stroke: float = 0.2
    entry: float = 0.25
    exit: float = 0.35
    gap: float = 0.25
    bare: float = 0.03
    tremor: float = 0.0018
    pale: float = 0.15
    round: float = 2.6
    of_a_kind: int = 3
    at_most: int = 5
