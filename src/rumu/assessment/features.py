"""Registration -> a few numbers, each with a meaning. They are measured untrimmed and both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.assessment.regions import Region, find_regions
from rumu.assessment.similarity import posed
from rumu.values import FloatArray, Registration

RESIDUALS = ("position", "height", "direction", "extra", "missing")
"""The features that the calibration weighs, in this order; the rest are charged apart."""

SOFTENING = 0.05
"""Residual, in rms radii, below which differences hardly count: a pixel and a half of the common canvas."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """What registration leaves between copy and master, in rms radii of the ink unless said.

    position: rms distance in the plane, both ways (structure).
    height: rms difference of normalised height, both ways: stroke width for an inflated height (brushwork).
    direction: rms difference of the doubled stroke direction, both ways, from 0 to 2 (brushwork).
    extra: upper quartile of the distance from the copy's points to the master, all five dimensions.
    missing: upper quartile of the distance from the master's points to the copy.
    """

    position: float
    height: float
    direction: float
    extra: float
    missing: float

    def logarithms(self) -> FloatArray:
        """(5,) natural logarithms in the order of RESIDUALS, softened near zero."""
        return np.log(np.array([getattr(self, name) for name in RESIDUALS]) + SOFTENING)


@dataclass(frozen=True, slots=True)
class Features:
    """All that a mark is made of.

    residuals: see Residuals.
    lean: degrees, positive clockwise. offset: distance from the master's place, fraction of the cell.
    size: natural logarithm of the copy's size over the master's; 0 is the same.
    weight: natural logarithm of the copy's mean normalised height over the master's; for an inflated
        height above 0 means heavier strokes.
    regions: where copy and master part.
    """

    residuals: Residuals
    lean: float
    offset: float
    size: float
    weight: float
    regions: tuple[Region, ...] = ()

    @property
    def absent(self) -> float:
        """Share of the master's ink in whole regions that the copy lacks."""
        return sum(region.share for region in self.regions if region.kind == "missing")

    @property
    def surplus(self) -> float:
        """Share of the copy's ink in whole regions where the master is blank."""
        return sum(region.share for region in self.regions if region.kind == "extra")


def measure(registration: Registration) -> Features:
    """Features of one registration."""
    heights = registration.probe.xyz[:, 2].mean(), registration.reference.xyz[:, 2].mean()
    return Features(
        residuals=residuals(registration),
        lean=registration.angle,
        offset=float(np.hypot(*registration.shift)),
        size=float(np.log(registration.scale)),
        weight=float(np.log(max(heights[0], 1e-6) / max(heights[1], 1e-6))),
        regions=find_regions(registration),
    )


def residuals(registration: Registration) -> Residuals:
    """The residuals of one registration."""
    p, x = posed(registration)
    a = 2 * np.deg2rad(registration.angle)
    d = registration.probe.direction @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    e = registration.reference.direction
    i, j = registration.forward_index, registration.backward_index
    space = np.vstack([p - x[i], p[j] - x])
    turn = np.vstack([d - e[i], d[j] - e])
    return Residuals(
        position=_rms(space[:, :2]),
        height=_rms(space[:, 2:]),
        direction=_rms(turn),
        extra=float(np.percentile(registration.forward, 75)),
        missing=float(np.percentile(registration.backward, 75)),
    )


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference * difference, axis=1))))
