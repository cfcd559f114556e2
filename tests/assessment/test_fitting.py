"""Fitting weights to marks: what they follow is found, what would raise a fault is not, anchors rise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.assessment.calibration import Scale
from rumu.assessment.features import FEATURE_NAMES, RESIDUALS, Features, Residuals
from rumu.assessment.fitting import HUMAN_RANGE, anchor_scale, fit_scale
from rumu.errors import CalibrationError

PERFECT = Features(Residuals(), lean=0.0, offset=0.0, size=0.0, weight=0.0)
COMMON = Residuals(0.2, 0.14, 0.18, 0.2, 0.12, 0.18, 0.26, 0.22, 0.28, 0.3, 0.17, 0.12, 0.1, 0.3)


def marked(n: int, *, seed: int = 0) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Made-up vectors and marks of copies of four masters, which differ in vectors but not in marks."""
    rng = np.random.default_rng(seed)
    masters = [f"master {k % 4}" for k in range(n)]
    vectors = rng.normal(0.0, 0.3, (n, len(FEATURE_NAMES)))
    marks = 50 - 30 * vectors[:, 0] + 20 * vectors[:, 3] - 24 * vectors[:, FEATURE_NAMES.index("fullness")]
    vectors[:, 1] = vectors[:, 0] + rng.normal(0, 2.0, 4)[np.arange(n) % 4]  # as good, but for the master
    return vectors, marks + rng.normal(0, 1, n), masters


def weights_of(scale) -> dict[str, float]:
    """Points for one unit of vectors."""
    return {name: w / s for name, w, s in zip(scale.names, scale.weights, scale.spread, strict=True)}


def test_a_fit_finds_what_marks_follow_and_refuses_what_would_raise_them():
    weights = weights_of(fit_scale(*marked(2000), names=(*RESIDUALS, "fullness"), shrinkage=1.0))
    assert weights["position"] == pytest.approx(-30, rel=0.1)
    assert weights["plane_missing"] == 0.0  # those marks rise with it; a fault must not earn points
    assert weights["fullness"] == pytest.approx(-24, rel=0.1)  # may have either sign
    assert min(weights[name] for name in RESIDUALS[4:]) > -2


def test_evidence_that_tells_masters_apart_is_trusted_less():
    weights = weights_of(fit_scale(*marked(2000), names=RESIDUALS, shrinkage=1.0))
    assert weights["plane_mean"] > 0.1 * weights["position"]  # that is, nearer nought


def test_shrinkage_draws_weights_to_nought():
    loose, tight = (fit_scale(*marked(400), names=RESIDUALS, shrinkage=s).weights[0] for s in (1.0, 4000.0))
    assert 0.2 * loose < tight < 0


def test_a_scale_of_some_evidence_reads_only_that():
    scale = fit_scale(*marked(100), names=("position", "missing"))
    assert scale.names == ("position", "missing")
    copy = replace(PERFECT, residuals=COMMON)
    assert scale.read(replace(copy, residuals=replace(COMMON, height=2.0, extra=2.0))) == scale.read(copy)
    assert scale.read(replace(copy, residuals=replace(COMMON, position=0.4))) < scale.read(copy)


def test_too_few_marks_are_no_calibration():
    vectors, marks, masters = marked(19)
    with pytest.raises(CalibrationError, match="expected at least 20 marks to fit a scale, got 19"):
        fit_scale(vectors, marks, masters, names=RESIDUALS)
    fit_scale(*marked(20), names=RESIDUALS)


# anchors


def test_a_scale_is_anchored_where_the_marks_reach():
    scale = fit_scale(*marked(400), names=RESIDUALS)
    for reach in (HUMAN_RANGE, (42.0, 70.0)):
        (_, zero), *middle, (perfect, full) = anchor_scale(scale, reach=reach).anchors
        assert (zero, full) == (0.0, 100.0)
        assert middle == [(mark, mark) for mark in reach]
        assert perfect == scale.weighted_sum(PERFECT.vector())


def test_another_character_lies_at_ten():
    scale = Scale(("position",), (-2.0,), (1.0,), (-40.0,), mean=50.0)
    wrong = [replace(PERFECT, residuals=Residuals(*[v] * len(RESIDUALS))) for v in (0.9, 1.2, 2.0)]
    assert anchor_scale(scale, others=wrong).read(wrong[1]) == pytest.approx(10.0)


def test_anchors_that_would_not_rise_are_refused():
    with pytest.raises(CalibrationError, match="expected anchors that rise"):
        anchor_scale(fit_scale(*marked(400), names=RESIDUALS), reach=(40.0, 400.0))
