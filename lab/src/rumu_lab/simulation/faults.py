"""Known faults in a glyph: what a learner does wrong, at a declared severity.

    apply(mask, "shift", severity=3, seed=1).mask

The families and their sizes are in `severity`; this file knows how a fault reaches the ink. Everything is
our own reconstruction of how copies go wrong; it says what was done to a glyph, never what a person
would mark it. Ink that is moved beyond the picture is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation import ink_faults, stroke_faults, structure_faults
from rumu_lab.simulation.glyph import ChangedGlyph, Glyph, Region, region_of
from rumu_lab.simulation.ink import coverage
from rumu_lab.simulation.severity import GREATEST, KINDS, size_of

Maker = Callable[[Glyph, float, np.random.Generator], ChangedGlyph]

_MAKERS: Mapping[str, Maker] = {
    "shift": stroke_faults.shift,
    "angle": stroke_faults.angle,
    "short": stroke_faults.short,
    "stroke_thin": stroke_faults.thin,
    "stroke_thick": stroke_faults.thick,
    "missing": stroke_faults.missing,
    "extra": stroke_faults.extra,
    "thin": structure_faults.thin,
    "thick": structure_faults.thick,
    "lean": structure_faults.lean,
    "off_centre": structure_faults.off_centre,
    "small": structure_faults.small,
    "squeeze": structure_faults.squeeze,
    "uneven": structure_faults.uneven,
    "wobble": ink_faults.wobble,
    "blunt": ink_faults.blunt,
    "blot": ink_faults.blot,
    "pale": ink_faults.pale,
    "dry": ink_faults.dry,
    "horizontal": stroke_faults.horizontal,
    "entry": ink_faults.entry,
    "narrow": structure_faults.narrow,
}
FAULTS: tuple[str, ...] = tuple(KINDS)


@dataclass(frozen=True, slots=True, eq=False)
class FaultyGlyph:
    """A glyph with one fault that is known.

    mask: (H, W) bool. ink: (H, W) float32 in [0, 1], the darkness, with soft edges.
    fault: name in `severity.KINDS`. severity: 0 to 5.
    size: how large it came out, in `unit`; angles positive clockwise, pixels those of a picture 512 wide.
    strokes: numbers of the strokes that have it, counted from 0 as `Glyph.strokes` does.
    region: (x0, y0, x1, y1) in fractions of the picture, origin top left.
    description, description_zh: what was done, where and how much. apart: see `ChangedGlyph`.
    """

    mask: BoolArray
    ink: FloatArray
    fault: str
    severity: float
    size: float
    unit: str
    strokes: tuple[int, ...]
    region: Region
    description: str
    description_zh: str
    apart: float = 0.0


def apply(mask: BoolArray, fault: str, *, severity: float, seed: int = 0) -> FaultyGlyph:
    """Put one fault into an ink mask (H, W) bool; the same seed puts the same fault into the same glyph.

    severity: 0 (the mask comes back as it is) to 5. The seed chooses the stroke, the side and the noise,
    and does so alike at every severity, so that a series differs in size alone (or in number).
    Raises SurfaceError for an unknown fault, a severity out of range or an empty mask.
    """
    if fault not in KINDS:
        raise SurfaceError(f"expected a fault among {', '.join(FAULTS)}, got {fault!r}")
    if not 0.0 <= severity <= GREATEST:
        raise SurfaceError(f"expected a severity from 0 to {GREATEST:g}, got {severity}")
    glyph = Glyph(np.asarray(mask))
    if severity == 0.0:
        change = ChangedGlyph(glyph.depth, 0.0, (), region_of(glyph.mask), en="nothing", zh="無")
        return _with_ink(change, glyph.mask.copy(), fault, severity)
    size = size_of(fault, severity=severity)
    change = _MAKERS[fault](glyph, size, np.random.default_rng([seed, FAULTS.index(fault)]))
    return _with_ink(change, np.asarray(change.depth > 0), fault, severity)


def _with_ink(change: ChangedGlyph, mask: BoolArray, fault: str, severity: float) -> FaultyGlyph:
    ink = coverage(change.depth) * np.float32(1.0 if change.density is None else change.density)
    return FaultyGlyph(
        mask=mask,
        ink=ink,
        fault=fault,
        severity=severity,
        size=change.size,
        unit=KINDS[fault].unit,
        strokes=change.strokes,
        region=change.region,
        description=change.en,
        description_zh=change.zh,
        apart=change.apart,
    )
