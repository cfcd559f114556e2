"""The shared calibrator: a rising curve, whatever it is given."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import CalibrationError
from rumu_lab.baselines.calibrator import Calibrator, fit


def logistic(raw: np.ndarray, offset: float, slope: float) -> np.ndarray:
    return 100 / (1 + np.exp(-(offset + slope * raw)))


def test_a_known_curve_is_found_again() -> None:
    raw = np.linspace(0.2, 0.9, 50)
    found = fit(raw, logistic(raw, -2.0, 5.0))
    assert (found.offset, found.slope) == pytest.approx((-2.0, 5.0), abs=1e-3)


def test_a_few_wild_marks_do_not_turn_it() -> None:
    raw = np.linspace(0.0, 1.0, 100)
    marks = logistic(raw, -1.0, 3.0)
    marks[:5] = 100.0
    found = fit(raw, marks)
    # plain least squares is 3.6 points off on average here
    assert np.mean(np.abs([found.read(x) for x in raw] - logistic(raw, -1.0, 3.0))) < 2.0


def test_it_never_falls() -> None:
    raw = np.random.default_rng(0).random(60)
    found = fit(raw, 100 - 90 * raw)
    assert found.slope == 0.0
    assert found.read(0.5) == pytest.approx(np.median(100 - 90 * raw), abs=1e-6)


def test_without_spread_it_is_the_median_mark() -> None:
    found = fit(np.full(5, 0.7), np.array([10.0, 40.0, 55.0, 60.0, 90.0]))
    assert found.slope == 0.0
    assert found.read(0.1) == found.read(0.9) == pytest.approx(55.0)


def test_perfectly_parted_marks_still_give_a_finite_curve() -> None:
    found = fit(np.array([0.1, 0.11, 0.89, 0.9]), np.array([0.0, 0.0, 100.0, 100.0]))
    assert np.isfinite([found.offset, found.slope]).all()
    assert found.read(0.0) < 5
    assert found.read(1.0) > 95


@pytest.mark.parametrize("slope", [0.0, 4.0, 1e4])
@pytest.mark.parametrize("raw", [-1e308, -1.0, 0.0, 1.0, 1e308, float("inf"), float("-inf")])
def test_every_number_has_a_mark_on_the_scale(slope: float, raw: float) -> None:
    assert 0.0 <= Calibrator(-2.0, slope).read(raw) <= 100.0


def test_order_is_kept() -> None:
    rng = np.random.default_rng(1)
    raw = rng.random(200)
    found = fit(raw, np.clip(20 + 60 * raw + rng.normal(0, 12, 200), 0, 100))
    marks = [found.read(x) for x in np.sort(raw)]
    assert (np.diff(marks) > 0).all()


@pytest.mark.parametrize(
    ("raw", "marks"),
    [([0.5], [50.0]), ([0.1, 0.2], [1.0, 2.0, 3.0]), ([0.1, np.nan], [1.0, 2.0]), ([0.1, 0.2], [1.0, 200.0])],
)
def test_what_carries_no_fit_is_refused(raw: list[float], marks: list[float]) -> None:
    with pytest.raises(CalibrationError, match="expected"):
        fit(np.array(raw), np.array(marks))


def test_nan_has_no_mark() -> None:
    with pytest.raises(CalibrationError, match="NaN"):
        Calibrator(0.0, 1.0).read(float("nan"))
