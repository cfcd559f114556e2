"""Known faults in a glyph: what a learner does wrong, at a declared severity.

    apply(mask, "shift", severity=3, seed=1).mask

The families and their sizes are in `severity`; this file knows how a fault reaches the ink. Everything is
our own reconstruction of how copies go wrong; it says what was done to a glyph, never what a person
would mark it. Ink that is moved beyond the picture is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import SurfaceError
from rumu_lab.simulation import faults_of_ink, faults_of_strokes, faults_of_structure
from rumu_lab.simulation.change import Change
from rumu_lab.simulation.glyph import Glyph, Region, region_of
from rumu_lab.simulation.ink import coverage
from rumu_lab.simulation.severity import GREATEST, KINDS, size_of

FloatArray = npt.NDArray[np.floating[Any]]
BoolArray = npt.NDArray[np.bool_]
Maker = Callable[[Glyph, float, np.random.Generator], Change]

_MAKERS: Mapping[str, Maker] = {
    "shift": faults_of_strokes.shift,
    "angle": faults_of_strokes.angle,
    "short": faults_of_strokes.short,
    "stroke_thin": faults_of_strokes.thin,
    "stroke_thick": faults_of_strokes.thick,
    "missing": faults_of_strokes.missing,
    "extra": faults_of_strokes.extra,
    "thin": faults_of_structure.thin,
    "thick": faults_of_structure.thick,
    "lean": faults_of_structure.lean,
    "off_centre": faults_of_structure.off_centre,
    "small": faults_of_structure.small,
    "squeeze": faults_of_structure.squeeze,
    "uneven": faults_of_structure.uneven,
    "wobble": faults_of_ink.wobble,
    "blunt": faults_of_ink.blunt,
    "blot": faults_of_ink.blot,
    "pale": faults_of_ink.pale,
    "dry": faults_of_ink.dry,
    "horizontal": faults_of_strokes.horizontal,
    "entry": faults_of_ink.entry,
}
FAULTS: tuple[str, ...] = tuple(KINDS)


@dataclass(frozen=True, slots=True, eq=False)
class Faulted:
    """A glyph with one fault that is known.

    mask: (H, W) bool. ink: (H, W) float32 in [0, 1], the darkness, with soft edges.
    fault: name in `severity.KINDS`. severity: 0 to 5.
    size: how large it came out, in `unit`; angles positive clockwise, pixels those of a picture 512 wide.
    strokes: numbers of the strokes it struck, counted from 0 as `Glyph.strokes` does.
    region: (x0, y0, x1, y1) in fractions of the picture, origin top left.
    description, description_zh: what was done, where and how much.
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


def apply(mask: BoolArray, fault: str, *, severity: float, seed: int = 0) -> Faulted:
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
        change = Change(glyph.depth, 0.0, (), region_of(glyph.mask), en="nothing", zh="無")
        return _faulted(change, glyph.mask.copy(), fault, severity)
    size = size_of(fault, severity=severity)
    change = _MAKERS[fault](glyph, size, np.random.default_rng([seed, FAULTS.index(fault)]))
    return _faulted(change, np.asarray(change.depth > 0), fault, severity)


def _faulted(change: Change, mask: BoolArray, fault: str, severity: float) -> Faulted:
    ink = coverage(change.depth) * np.float32(1.0 if change.density is None else change.density)
    return Faulted(
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
    )
