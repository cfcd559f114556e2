"""One scale for every method: its raw grade put on the marks' scale by the same curve of two parameters.

    mark = 100 / (1 + exp(-(offset + slope raw))),  slope >= 0

A rising curve keeps the order of the raw grades, so a calibration can hide no bad method: report the rank
correlation of the raw grade beside the error of the calibrated one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rumu.errors import CalibrationError
from rumu.values import FloatArray

NO_SPREAD = 1e-6
"""Standard deviation of the raw grades below which they say nothing and the median mark is all there is."""
SOFT = 10.0
"""Points of error up to which the fit counts squares; beyond, it grows ever more like the plain distance."""
STEEPEST = 50.0
"""Greatest slope for each standard deviation of the raw grade: raw grades that part the marks without error
would else ask for an infinite one."""


@dataclass(frozen=True, slots=True)
class Calibrator:
    """offset and slope (0 or more) of the logistic, in units of the raw grade."""

    offset: float
    slope: float

    def read(self, raw: float) -> float:
        """The mark, 0 to 100, of a raw grade; any number that is one, infinities too.

        Raises CalibrationError for NaN.
        """
        if math.isnan(raw):
            raise CalibrationError("expected a raw grade to read, got NaN")
        exponent = self.offset + (self.slope * raw if self.slope else 0.0)
        return 100.0 / (1.0 + math.exp(min(max(-exponent, -700.0), 700.0)))


def fit(raw: FloatArray, marks: FloatArray) -> Calibrator:
    """The curve through (N,) raw grades and (N,) marks of 0 to 100: least squares, soft beyond SOFT points.

    Falls back to a constant, the median mark, where the raw grades have no spread or fall with the marks.
    Raises CalibrationError for fewer than two pairs, unequal numbers, NaN, or marks off the scale.
    """
    from scipy.optimize import least_squares

    x, y = np.asarray(raw, float), np.asarray(marks, float)
    _check(x, y)
    middle, spread = float(x.mean()), float(x.std())
    share = min(max(float(np.median(y)) / 100.0, 1e-6), 1.0 - 1e-6)
    level = math.log(share / (1.0 - share))
    if spread < NO_SPREAD:
        return Calibrator(level, 0.0)
    z = (x - middle) / spread

    def errors(p: FloatArray) -> FloatArray:
        return np.asarray(100.0 / (1.0 + np.exp(-(p[0] + p[1] * z))) - y)

    bounds = ([-20.0, 0.0], [20.0, STEEPEST])
    found = least_squares(errors, (level, 0.5), bounds=bounds, loss="soft_l1", f_scale=SOFT)
    offset, slope = map(float, found.x)
    if slope < NO_SPREAD:
        return Calibrator(level, 0.0)
    return Calibrator(offset - slope * middle / spread, slope / spread)


def _check(raw: FloatArray, marks: FloatArray) -> None:
    if raw.ndim != 1 or raw.shape != marks.shape or len(raw) < 2:
        raise CalibrationError(
            f"expected two raw grades or more and as many marks, got {raw.shape}, {marks.shape}"
        )
    if not (np.isfinite(raw).all() and np.isfinite(marks).all()):
        raise CalibrationError("expected raw grades and marks that are finite, got NaN or infinite ones")
    if marks.min() < 0 or marks.max() > 100:
        raise CalibrationError(f"expected marks from 0 to 100, got {marks.min():g} to {marks.max():g}")
