"""Simulated teachers, whose ways are known: what is found of them, and when the default is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.assessment import teacher
from rumu.assessment.calibration import Charges, panel
from rumu.assessment.features import RESIDUALS, Features, Residuals
from rumu.assessment.teacher import TeacherSettings, fit_line, fit_teacher, held_out_interval, move_scale
from rumu.errors import CalibrationError
from rumu.strokes.omissions import Region

BASE = panel()
COMMON = np.log([0.2, 0.14, 0.18, 0.2, 0.12, 0.18, 0.26, 0.22, 0.28, 0.3, 0.17, 0.15, 0.09, 0.28])
"""Logarithms of what registration commonly leaves, in the order of RESIDUALS."""


def copies(n: int = 120, *, masters: int = 6, seed: int = 0) -> tuple[list[Features], list[str]]:
    """Copies from poor to fine; how a residual differs is the copy's own, the master's, and its hand's."""
    rng = np.random.default_rng(seed)
    of_master = rng.normal(0, 0.05, (masters, len(RESIDUALS)))
    features = []
    for k in range(n):
        own = 0.2 * rng.normal() + 0.1 * rng.normal(size=len(RESIDUALS))
        logs = COMMON - own + of_master[k % masters]
        features.append(Features(Residuals(*np.exp(logs)), lean=0.0, offset=0.0, size=0.0, weight=0.0))
    return features, [f"master {k % masters}" for k in range(n)]


def scores(features: list[Features]) -> np.ndarray:
    return np.array([BASE.score(f) for f in features])


def noisy(marks: np.ndarray, *, points: float = 5.0, seed: int = 1) -> np.ndarray:
    return np.clip(marks + np.random.default_rng(seed).normal(0, points, len(marks)), 0, 100)


TEACHERS = {"strict": (-18.0, 1.0), "generous": (16.0, 1.0), "compressed": (38.0, 0.45), "wide": (-26.0, 1.4)}


# teachers with a scale of their own


@pytest.mark.parametrize("kind", TEACHERS)
def test_the_scale_of_a_teacher_is_found(kind):
    a, b = TEACHERS[kind]
    features, masters = copies()
    marks = noisy(a + b * scores(features))
    fit = fit_teacher(features, marks, masters, base=BASE, name=kind)
    assert (fit.chosen, fit.held_out, fit.copies, fit.masters) == ("scale", "masters", 120, 6)
    assert fit.scale.error < 5 < fit.default.error
    fresh, _ = copies(60, seed=9)  # copies that the fit has not seen, without noise
    told = np.array([fit.calibration.score(f) for f in fresh])
    assert np.abs(told - np.clip(a + b * scores(fresh), 0, 100)).mean() < 3.5
    assert f"120 marks of copies of 6 masters ({kind})" in fit.calibration.provenance
    assert f"{fit.scale.error:.1f}" in fit.why and f"{fit.default.error:.1f}" in fit.why_zh


def test_the_order_of_copies_and_the_ends_are_untouched():
    features, _ = copies()
    for a, b in (*TEACHERS.values(), (300.0, 1.0), (-300.0, 1.0), (0.0, 0.01)):
        own = move_scale(BASE, a, b)
        for scale, old in ((own.scale, BASE.scale), *((own.parts[n], BASE.parts[n]) for n in own.parts)):
            sums, marks = np.array(scale.anchors).T
            assert (marks[0], marks[-1]) == (0.0, 100.0)
            assert np.diff(marks).min() >= 1.0 - 1e-9
            np.testing.assert_array_equal(sums, np.array(old.anchors)[:, 0])
        order = np.argsort([own.scale.read(f) for f in features], kind="stable")
        np.testing.assert_array_equal(order, np.argsort(scores(features), kind="stable"))


def test_few_marks_move_the_scale_less():
    """As if twenty copies had been marked as the default does: twenty marks go half of the way."""
    features, _ = copies(400)
    read = scores(features)
    for n in (20, 100, 400):
        a, b = fit_line(features[:n], read[:n] - 12.0, base=BASE)
        assert b == pytest.approx(1.0)
        assert a == pytest.approx(-12.0 * n / (n + 20))


def test_what_is_charged_apart_does_not_bend_the_scale():
    """A leaning copy, marked down for its lean alone, says that the scale is right."""
    features, _ = copies(60)
    leaning = [replace(f, lean=Charges().lean_free + 5.0 * (k % 2)) for k, f in enumerate(features)]
    assert fit_line(leaning, scores(leaning), base=BASE) == pytest.approx((0.0, 1.0))
    lacking = [
        replace(f, regions=(Region("missing", np.zeros((3, 2)), 0.4 * (k % 2), 3.0 * (k % 2)),))
        for k, f in enumerate(features)
    ]
    assert fit_line(lacking, scores(lacking), base=BASE) == pytest.approx((0.0, 1.0))


# a teacher with weights of their own


def other_taste(features: list[Features]) -> np.ndarray:
    """Looks at nothing but the directions of the ink, from which the default reads little."""
    return np.array([50 - 40 * (np.log(f.residuals.directions + 0.05) + 1.1) for f in features])


def test_weights_are_fitted_where_marks_are_many():
    features, masters = copies(400, masters=10)
    features = [
        replace(f, residuals=replace(f.residuals, directions=float(np.exp(-1.3 + 0.5 * e))))
        for f, e in zip(features, np.random.default_rng(3).normal(size=len(features)), strict=True)
    ]
    marks = noisy(np.clip(other_taste(features), 0, 100))
    fit = fit_teacher(features, marks, masters, base=BASE)
    assert fit.chosen == "weights"
    assert fit.weights.error < 0.8 * min(fit.scale.error, fit.default.error)
    assert fit.weights.spearman > fit.default.spearman + 0.1
    weights = dict(zip(fit.calibration.scale.names, fit.calibration.scale.weights, strict=True))
    assert min(weights, key=weights.get) == "directions"
    perfect = Features(Residuals(), lean=0.0, offset=0.0, size=0.0, weight=0.0)
    assert fit.calibration.score(perfect) == pytest.approx(100.0)


@pytest.mark.parametrize(("n", "masters"), [(180, 9), (220, 7)])
def test_weights_are_not_even_tried_where_marks_or_masters_are_few(n, masters):
    features, names = copies(n, masters=masters)
    fit = fit_teacher(features, noisy(scores(features) - 15), names, base=BASE)
    assert fit.weights is None and fit.chosen == "scale"


# the default is kept


@pytest.mark.parametrize("n", [0, 1, 2, 19])
def test_few_marks_keep_the_default_and_say_so(n):
    features, masters = copies(n) if n else ([], [])
    fit = fit_teacher(features, noisy(scores(features) / 2), masters, base=BASE)
    assert (fit.calibration, fit.chosen, fit.held_out, fit.scale) == (None, "default", "none", None)
    assert f"{n} marks are too few: 20" in fit.why and f"只有 {n} 個評分" in fit.why_zh
    assert (fit.default is None) == (n == 0)


def test_marks_without_spread_keep_the_default():
    features, masters = copies()
    fit = fit_teacher(features, [70.0] * 119 + [71.0], masters, base=BASE)
    assert fit.calibration is None and "all but the same" in fit.why and "幾乎全部相同" in fit.why_zh


@pytest.mark.parametrize("seed", range(2))
def test_random_marks_keep_the_default(seed):
    """A constant would err less than the default; but marks that follow no copy carry no calibration."""
    features, masters = copies(240, masters=8)
    marks = np.random.default_rng(seed).uniform(0, 100, len(features))
    fit = fit_teacher(features, marks, masters, base=BASE)
    assert fit.calibration is None and fit.chosen == "default"


def test_marks_that_fall_as_copies_get_better_keep_the_default():
    features, masters = copies()
    fit = fit_teacher(features, 100 - scores(features), masters, base=BASE)
    assert fit.calibration is None and fit.scale is None


def test_a_teacher_who_marks_as_the_panel_does_keeps_the_default():
    features, masters = copies()
    fit = fit_teacher(features, noisy(scores(features), points=8.0), masters, base=BASE)
    assert fit.calibration is None and "clearly nearer" in fit.why and "默認" in fit.why_zh
    low, high = np.array([BASE.interval_of(s) for s in scores(features)]).T
    marks = noisy(scores(features), points=8.0)
    assert fit.inside == pytest.approx(np.mean((low <= marks) & (marks <= high)))
    assert 0.8 < fit.inside < 1.0


def test_one_master_who_is_marked_otherwise_moves_nothing():
    """What all gain comes from one of four masters: no clear margin."""
    features, masters = copies(120, masters=4)
    marks = scores(features) - 25.0 * (np.array(masters) == "master 0")
    assert fit_teacher(features, noisy(marks), masters, base=BASE).chosen == "default"


# held out means held out


def test_with_two_masters_copies_are_held_out_and_it_says_so():
    features, masters = copies(80, masters=2)
    fit = fit_teacher(features, noisy(scores(features) - 18), masters, base=BASE)
    assert (fit.chosen, fit.held_out, fit.masters) == ("scale", "copies", 2)
    assert "copies held out, of the same masters" in fit.calibration.provenance


@pytest.mark.parametrize("masters", [2, 5])
def test_no_copy_is_scored_by_a_fit_that_has_seen_it_or_its_master(masters, monkeypatch):
    features, names = copies(60, masters=masters)
    marks = noisy(scores(features) - 18)
    seen: list[set[int]] = []

    def watched(known, values, **options):
        seen.append({id(f) for f in known})
        return fit_line(known, values, **options)

    monkeypatch.setattr(teacher, "fit_line", watched)
    fit_teacher(features, marks, names, base=BASE)
    *folds, whole = seen
    assert whole == {id(f) for f in features}
    left_out = [{k for k, f in enumerate(features) if id(f) not in fold} for fold in folds]
    assert sorted(k for out in left_out for k in out) == list(range(60))  # each once
    assert len(folds) == 5
    if masters == 5:
        assert [{names[k] for k in out} for out in left_out] == [{f"master {m}"} for m in range(5)]


# the interval


def test_the_interval_is_no_narrower_than_the_errors_say():
    rng = np.random.default_rng(0)
    for n in (20, 50, 200):
        inside = []
        for _ in range(400):
            low, high = held_out_interval(rng.normal(0, 8, n))
            inside.append(np.mean((rng.normal(0, 8, 50) > low) & (rng.normal(0, 8, 50) < high)))
        assert np.mean(inside) > 0.79, n


def test_the_interval_of_a_fit_comes_from_what_was_held_out():
    features, masters = copies(200)
    marks = noisy(25 + 0.5 * scores(features), points=9.0)
    low, high = fit_teacher(features, marks, masters, base=BASE).calibration.interval
    assert low == pytest.approx(-1.28 * 9, rel=0.3) and high == pytest.approx(1.28 * 9, rel=0.3)
    assert held_out_interval(np.full(30, 4.0)) == (0.0, 4.0)  # it holds the score itself


# what is no evidence


def test_what_does_not_belong_together_is_refused():
    features, masters = copies(30)
    with pytest.raises(CalibrationError, match="as many copies as marks and masters"):
        fit_teacher(features, [50.0] * 29, masters, base=BASE)
    for wrong in (-1.0, 101.0, float("nan")):
        with pytest.raises(CalibrationError, match="marks from 0 to 100"):
            fit_teacher(features, [50.0] * 29 + [wrong], masters, base=BASE)


def test_settings_are_the_teacher_s_school_s():
    features, masters = copies(30)
    marks = noisy(scores(features) - 25, points=2.0)
    assert fit_teacher(features, marks, masters, base=BASE).chosen == "scale"
    strict = TeacherSettings(fewest=40)
    assert fit_teacher(features, marks, masters, base=BASE, settings=strict).chosen == "default"
