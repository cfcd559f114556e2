"""Disk B-spline curves: a stroke as a cubic spline of its centre and of its half-width.

A disk B-spline curve is the area that the disks <P(t); r(t)> sweep, P and r both sums of the same basis
functions. That the strokes are vectorised so is known from VICP's abstract; how they are fitted is ours:
least squares over the skeleton, parameters by chord length, knots at equal steps of the centripetal length.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from rumu.values import BoolArray, FloatArray
from rumu_lab.baselines.lines import StrokeLine

ORDER = 3
"""Degree of the spline: cubic."""


@dataclass(frozen=True, slots=True)
class SplineSettings:
    """How many control points a spline gets.

    spacing: length of curve for each control point, in stroke widths. accepted: rms distance of the
    centre line, in pixels, above which control points are added. most: control points at the most.
    """

    spacing: float = 2.0
    accepted: float = 0.5
    most: int = 32


@dataclass(frozen=True, slots=True, eq=False)
class DiskSpline:
    """A fitted disk B-spline curve.

    knots: (m + 4,), clamped to [0, 1]. control: (m, 3) float64, x, y and half-width. rms: distance of the
    fitted centre line from the skeleton, in pixels. length: of that skeleton.
    """

    knots: FloatArray
    control: FloatArray
    rms: float
    length: float

    def at(self, t: FloatArray) -> FloatArray:
        """(k, 3) float64: x, y and half-width (0 or more) at these parameters in [0, 1]."""
        from scipy.interpolate import BSpline

        disks = np.asarray(BSpline(self.knots, self.control, ORDER)(np.clip(t, 0.0, 1.0)), dtype=float)
        disks[:, 2] = np.maximum(disks[:, 2], 0.0)
        return disks

    def line(self, *, step: float = 1.0) -> StrokeLine:
        """Its centre line with a point about every `step` pixels, two at the least, and the half-widths."""
        disks = self.at(np.linspace(0.0, 1.0, max(2, ceil(self.length / step) + 1)))
        return StrokeLine(disks[:, :2], disks[:, 2])


def fit_disk_spline(line: StrokeLine, *, width: float, settings: SplineSettings | None = None) -> DiskSpline:
    """The disk B-spline through a line in pixels; width: of a stroke.

    Starts with a control point for every two stroke widths, four at the least, and adds half as many again
    while the centre line is farther off than accepted.
    """
    settings = settings or SplineSettings()
    samples, chord, root = _samples(line)
    most = min(settings.most, max(4, len(samples) // 2))
    count = min(max(4, ceil(line.length / (settings.spacing * width))), most)
    while True:
        fitted = _fit(samples, chord, root, count, line.length)
        if fitted.rms < settings.accepted or count >= most:
            return fitted
        count = min(most, count + max(1, count // 2))


def _samples(line: StrokeLine) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(k, 3) x, y, half-width, with the chord-length and the centripetal parameters, both 0 to 1."""
    shares = np.linspace(0.0, 1.0, max(12, ceil(line.length)))
    points, radius = line.at(shares), line.radius_at(shares)
    steps = np.maximum(np.hypot(*np.diff(points, axis=0).T), 1e-9)
    chord, root = (np.concatenate([[0.0], np.cumsum(s)]) for s in (steps, np.sqrt(steps)))
    return np.column_stack([points, radius]), chord / chord[-1], root / root[-1]


def _fit(samples: FloatArray, chord: FloatArray, root: FloatArray, count: int, length: float) -> DiskSpline:
    from scipy.interpolate import make_lsq_spline

    inner = np.interp(np.arange(1, count - ORDER) / (count - ORDER), root, chord)
    knots = np.concatenate([np.zeros(ORDER + 1), inner, np.ones(ORDER + 1)])
    spline: Any = make_lsq_spline(chord, samples, knots, ORDER)
    off = np.asarray(spline(chord))[:, :2] - samples[:, :2]
    rms = float(np.sqrt((off**2).sum(axis=1).mean()))
    return DiskSpline(knots, np.asarray(spline.c, dtype=float), rms, length)


def sweep(lines: Iterable[StrokeLine], *, side: int) -> BoolArray:
    """(side, side) bool: the area that the disks of these lines sweep, pixels, y downward."""
    import cv2

    canvas = np.zeros((side, side), np.uint8)
    for line in lines:
        # OpenCV's disk reaches half a pixel beyond its radius.
        disks = np.column_stack([line.points, np.maximum(line.radius - 0.5, 0.25)])
        for x, y, r in np.round(16.0 * disks).astype(int).tolist():
            cv2.circle(canvas, (x, y), r, 1, -1, cv2.LINE_8, 4)
    return np.asarray(canvas > 0)
