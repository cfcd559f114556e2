"""Made-up copies of a glyph at four known degrees: several faults at once, as a learner has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation.faults import FaultyGlyph, apply
from rumu_lab.simulation.glyph import Glyph
from rumu_lab.simulation.severity import GREATEST

Degree = Literal["excellent", "good", "medium", "bad"]
DEGREES: tuple[Degree, ...] = get_args(Degree)

# Fault and severity, whole character first: what is then said of a stroke is true of where it ends up.
RECIPES: Mapping[Degree, tuple[tuple[str, float], ...]] = {
    "excellent": (("wobble", 0.4), ("shift", 0.6)),
    "good": (
        ("lean", 1.0),
        ("uneven", 1.6),
        ("stroke_thick", 1.6),
        ("angle", 3.4),
        ("shift", 3.4),
        ("wobble", 1.2),
    ),
    "medium": (
        ("lean", 1.4),
        ("small", 1.0),
        ("uneven", 2.6),
        ("thin", 1.2),
        ("angle", 4.6),
        ("shift", 4.6),
        ("blunt", 2.0),
        ("wobble", 2.0),
    ),
    "bad": (
        ("lean", 3.2),
        ("off_centre", 1.5),
        ("uneven", 4.0),
        ("missing", 1.0),
        ("thick", 1.0),
        ("angle", 5.0),
        ("shift", 5.0),
        ("blunt", 4.0),
        ("wobble", 3.2),
    ),
}


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedCopy:
    """A copy that nobody wrote.

    mask: (H, W) bool. ink: (H, W) float32 in [0, 1], the darkness, with soft edges.
    degree: how bad it was made: a declared convention, not a mark. faults: in the order they were put in.
    """

    mask: BoolArray
    ink: FloatArray
    degree: Degree
    faults: tuple[FaultyGlyph, ...]


def copy_at(mask: BoolArray, degree: Degree, *, seed: int = 0) -> SimulatedCopy:
    """A copy of an ink mask (H, W) bool at one of the four degrees of `RECIPES`.

    A character of one stroke cannot lack one: its stroke comes out far too short instead.
    Raises SurfaceError for an unknown degree or an empty mask.
    """
    if degree not in RECIPES:
        raise SurfaceError(f"expected a degree among {', '.join(DEGREES)}, got {degree!r}")
    faults: list[FaultyGlyph] = []
    for number, (fault, severity) in enumerate(RECIPES[degree]):
        if fault == "missing" and len(Glyph(mask).strokes) == 1:
            fault, severity = "short", GREATEST  # noqa: PLW2901
        faults.append(apply(mask, fault, severity=severity, seed=seed * 101 + number))
        mask = faults[-1].mask
    return SimulatedCopy(mask, faults[-1].ink, degree, tuple(faults))
