"""How sure the measurement of a stroke is: what small changes of the master itself make of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from rumu.strokes.measures import MatchedStroke

_RATIOS = ("length", "width")
"""What is measured of a stroke as a ratio to the master's."""
ENDS = ("entry", "exit")
_DIFFERENCES = (*ENDS, "entry_alone", "exit_alone")
"""What is measured of a stroke as a difference from the master's."""


@dataclass(frozen=True, slots=True)
class SureSettings:
    """Shares of a stroke's uncertainty that are subtracted from its differences.

    shift, turn, length, width, end: of each. Little is taken from what is looked for in the ink besides, see
    `ink_differences`.
    """

    shift: float = 0.4
    turn: float = 0.4
    length: float = 0.5
    width: float = 0.5
    end: float = 1.0


SURE = SureSettings()


@dataclass(frozen=True, slots=True)
class StrokeUncertainty:
    """Measurement error of a stroke, from small perturbations of the master.

    shift: rms radii; turn: degrees; ratios: logarithm by name of the field, NaN where it was not always
    seen; ends: by name of the field.
    """

    shift: float
    turn: float
    ratios: dict[str, float]
    ends: dict[str, float]


def uncertainty_of(changed: list[MatchedStroke]) -> StrokeUncertainty:
    """Uncertainty of a stroke from its perturbed measurements: the sum of the worst two."""

    def worst(values: list[float]) -> float:
        return math.nan if any(map(math.isnan, values)) else sum(sorted(map(abs, values))[-2:])

    return StrokeUncertainty(
        shift=worst([math.hypot(*s.shift) for s in changed]),
        turn=worst([s.turn for s in changed]),
        ratios={name: worst([_log(getattr(s, name)) for s in changed]) for name in _RATIOS},
        ends={name: max(abs(getattr(s, name)) for s in changed) for name in _DIFFERENCES},
    )


def _log(ratio: float) -> float:
    return math.log(max(ratio, 1e-6))


def surely(found: MatchedStroke, doubt: StrokeUncertainty) -> MatchedStroke:
    """A stroke with each difference soft-thresholded by shares of its uncertainty: what is sure of it."""

    def shrink(value: float, by: float) -> float:
        if math.isnan(value) or math.isnan(by):
            return math.nan
        return math.copysign(max(abs(value) - by, 0.0), value)

    away = math.hypot(*found.shift)
    kept = max(away - SURE.shift * doubt.shift, 0.0) / max(away, 1e-9)
    shares = {"length": SURE.length, "width": SURE.width}
    ratios: dict[str, Any] = {
        name: math.exp(shrink(_log(getattr(found, name)), shares[name] * by))
        for name, by in doubt.ratios.items()
    }
    ends: dict[str, Any] = {
        name: shrink(getattr(found, name), SURE.end * by) for name, by in doubt.ends.items()
    }
    turn = shrink(found.turn, SURE.turn * doubt.turn)
    return replace(found, shift=found.shift * kept, turn=turn, **ratios, **ends)


def relative_to(itself: MatchedStroke, found: MatchedStroke) -> MatchedStroke:
    """Differences from the master measured against itself: ratios of lengths and widths, else differences."""
    ratios = {
        name: getattr(found, name) / getattr(itself, name) for name in _RATIOS if getattr(itself, name) > 1e-6
    }
    ends: dict[str, Any] = {name: getattr(found, name) - getattr(itself, name) for name in _DIFFERENCES}
    return replace(found, **ratios, **ends)
