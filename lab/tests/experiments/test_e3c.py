"""Agreement with people, with whole characters held out: measured once, then asked from several sides."""

from __future__ import annotations

import csv
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import rankdata

from rumu.assessment.calibration import CUT_OFFS, panel
from rumu.assessment.features import RESIDUALS, Features, Residuals
from rumu.errors import CalibrationError
from rumu_lab.experiments import e3c
from rumu_lab.experiments.marked_copies import Copy, read_copies
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.protocol import declared
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.statistics import choose_cuts, level_numbers, quick_kappa


@pytest.fixture(scope="session")
def copies(data):
    return read_copies(data)


@pytest.fixture(scope="session")
def others(copies):
    return e3c.other_characters(copies)


@pytest.fixture(scope="session")
def measured(data, copies):
    """All copies against their masters: the one long measurement of the suite."""
    done = []
    settings = RunSettings(data, progress=lambda k, n: done.append((k, n)))
    found = measure_each(e3c.measure_copy, copies, settings)
    assert done == [(k, len(copies)) for k in range(1, len(copies) + 1)]
    return found


@pytest.fixture(scope="session")
def result(measured, others):
    return e3c.hold_out_characters(measured, others)


def made_up(n_characters: int = 6, each: int = 60, *, seed: int = 0) -> list[e3c.MeasuredCopy]:
    """Copies whose marks follow their residuals, so that what is tested needs no images."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(n_characters * each):
        quality = rng.normal()
        residuals = Residuals(*(0.2 * np.exp(-0.2 * quality + 0.05 * rng.normal(size=len(RESIDUALS)))))
        copy = Copy(
            Path(f"{k}.png"),
            Path(f"{k % n_characters}-master.png"),
            f"character {k % n_characters}",
            float(np.clip(52 + 14 * quality, 5, 95)),
            tuple(float(v) for v in np.clip(np.round(5.2 + quality + rng.normal(size=3)), 1, 10)),
        )
        features = Features(residuals, lean=0.0, offset=0.0, size=0.05 * float(rng.normal()), weight=0.0)
        found.append(
            e3c.MeasuredCopy(copy, features, sim_paper=99.0 + 0.1 * quality, similarity=0.8 + 0.03 * quality)
        )
    return found


def with_residuals(size: float) -> Features:
    return Features(Residuals(*[size] * len(RESIDUALS)), lean=0.0, offset=0.0, size=0.0, weight=0.0)


WRONG = [with_residuals(0.8)] * 5


# the data


def test_absent_data_is_named(tmp_path):
    with pytest.raises(CalibrationError, match=r"scores\.csv: expected the E3C marks here \(set RUMU_DATA"):
        e3c.run(RunSettings(tmp_path))


# the bars


def test_every_row_is_scored_or_refused_with_a_reason(copies, measured):
    assert [m.copy for m in measured] == copies
    for m in measured:
        assert (m.features is None) == bool(m.refused)
    assert sum(m.features is not None for m in measured) >= 803


def test_the_marks_agree_with_people_on_characters_held_out(result):
    score = result.figures["score"]
    assert score["within"] >= 0.68, score
    assert score["all"] >= 0.62, score
    assert score["mae"] < 0.8 * result.figures["constant_mae"], score


def test_the_marks_agree_better_than_the_papers_similarity(result):
    figures = result.figures
    assert figures["score"]["within"] > figures["sim_paper"]["within"] + 0.05
    assert figures["score"]["all"] > figures["sim_paper"]["all"]


def test_the_interval_holds_what_it_says(result):
    marks = np.array([m.copy.mark for m in result.measured])
    assert (result.low <= result.scores).all() and (result.scores <= result.high).all()
    inside = np.mean((result.low <= marks) & (marks <= result.high))
    assert inside == pytest.approx(0.80, abs=0.05)
    assert result.figures["interval_coverage"] == pytest.approx(inside)


def test_all_levels_are_in_use(result):
    for name in ("level_shares_of_human_marks", "level_shares_of_scores"):
        shares = result.figures[name]
        assert sum(shares.values()) == pytest.approx(1.0)
        assert min(shares.values()) > 0.08, shares


def test_levels_are_cut_where_they_agree_best_with_peoples(result):
    truth = level_numbers(result.panel, sorted(declared().cut_offs.values()))
    best = choose_cuts(result.scores, truth)
    shipped = sorted(CUT_OFFS["panel"].values())
    agreed = [quick_kappa(truth, level_numbers(result.scores, cuts)) for cuts in (best, shipped)]
    assert agreed[1] > agreed[0] - 0.01, (best, agreed)


def test_the_shipped_calibration_is_a_refit_of_the_data(result):
    """Fails when anything that a mark is made of was changed and `scripts/fit_panel.py` was not run."""
    fitted, shipped = (json.loads(json.dumps(asdict(c))) for c in (result.calibration, panel()))
    assert fitted.pop("provenance") == shipped.pop("provenance")
    assert flat(fitted).keys() == flat(shipped).keys()
    for key, value in flat(fitted).items():
        assert value == pytest.approx(flat(shipped)[key], abs=1e-6), key


def flat(plain, at: str = "") -> dict:
    if isinstance(plain, dict | list):
        pairs = plain.items() if isinstance(plain, dict) else enumerate(plain)
        return {k: v for name, part in pairs for k, v in flat(part, f"{at}.{name}").items()}
    return {at: plain}


# held out means held out


@pytest.mark.parametrize("character", ["character 0", "character 4"])
def test_a_characters_own_marks_do_not_touch_its_scores(character):
    measured = made_up()
    own = np.array([m.copy.character == character for m in measured])
    spoilt = [
        replace(m, copy=replace(m.copy, mark=100 - m.copy.mark)) if mine else m
        for m, mine in zip(measured, own, strict=True)
    ]
    before, after = (e3c.hold_out_characters(list(copies), WRONG) for copies in (measured, spoilt))
    np.testing.assert_array_equal(after.scores[own], before.scores[own])
    assert (after.scores[~own] != before.scores[~own]).all()  # the others did learn from it
    # nor its interval, as far as its own errors go: those come from the other characters' marks
    width_before, width_after = (r.high[own] - r.low[own] for r in (before, after))
    assert np.abs(width_after - width_before).max() < 15


def test_the_calibration_that_ships_uses_all(result):
    scores = np.array([result.calibration.score(m.features) for m in result.measured])
    assert np.abs(scores - result.scores).max() < 15
    assert (scores != result.scores).mean() > 0.9
    assert "810 brush copies of 25" in result.calibration.provenance


def test_marks_that_follow_the_residuals_are_predicted():
    result = e3c.hold_out_characters(made_up(), WRONG)
    assert result.figures["score"]["within"] > 0.9
    assert result.figures["score"]["mae"] < 4


def test_wrong_anchors_are_refused():
    perfect = [with_residuals(0.0)] * 3
    with pytest.raises(CalibrationError, match="expected anchors that rise"):
        e3c.fit_panel(made_up(), perfect)


# agreement


def spearman(a, b) -> float:
    a, b = rankdata(a), rankdata(b)
    return float(((a - a.mean()) * (b - b.mean())).mean() / (a.std() * b.std()))


def test_agreement_by_hand():
    """Two characters with enough copies, one rising and one falling; one with too few to rank."""
    characters = np.array(["a"] * 5 + ["b"] * 6 + ["c"] * 4)
    marks = np.array([10, 20, 30, 40, 50, 60, 50, 40, 30, 20, 10, 5, 95, 5, 95.0])
    predicted = np.array([11, 21, 31, 41, 51, 10, 20, 30, 40, 50, 60, 50, 40, 30, 20.0])
    found = e3c.agreement(predicted, marks, characters)
    assert found["within"] == pytest.approx((1.0 - 1.0) / 2)
    assert found["all"] == pytest.approx(spearman(predicted, marks))
    assert found["mae"] == pytest.approx(np.abs(predicted - marks).mean())
    assert e3c.agreement(marks, marks, characters) == pytest.approx({"all": 1.0, "within": 1.0, "mae": 0.0})


def test_a_line_through_the_other_characters_puts_a_number_on_the_scale():
    measured = made_up()
    marks = np.array([m.copy.mark for m in measured])
    characters = np.array([m.copy.character for m in measured])
    figures = e3c.hold_out_characters(measured, WRONG).figures
    own = characters == "character 2"
    values = np.array([m.sim_paper for m in measured])
    line = np.polyfit(values[~own], marks[~own], 1)
    assert np.abs(np.polyval(line, values[own]) - marks[own]).mean() == pytest.approx(
        figures["sim_paper"]["mae"], rel=0.5
    )


# what is written


def test_the_table_has_one_row_a_copy(tmp_path):
    measured = made_up()
    gone = replace(measured[3], features=None, refused="blank: expected writing")
    result = e3c.hold_out_characters([*measured[:3], gone, *measured[4:]], WRONG)
    e3c.write_table(result, tmp_path / "e3c.csv")
    rows = list(csv.DictReader((tmp_path / "e3c.csv").open(encoding="utf-8")))
    assert len(rows) == len(measured)
    assert rows[-1]["refused"] == "blank: expected writing"
    assert rows[-1]["score"] == ""
    for row, score in zip(rows, result.scores, strict=False):
        assert float(row["score"]) == pytest.approx(score, abs=0.006)
        assert float(row["low"]) <= float(row["score"]) <= float(row["high"])


def test_the_text_says_the_figures(result):
    text = result.text()
    figures = result.figures
    for value in (figures["score"]["all"], figures["score"]["within"]):
        assert f"{value:.3f}" in text
    for words in (
        "810 copies of 25 characters",
        "rumu's mark",
        "the paper's SIM",
        "constant",
        "80 % interval",
    ):
        assert words in text
    assert json.dumps(result.figures)  # plain enough for --json


def test_the_experiment_finds_and_writes_what_was_measured(monkeypatch, quick):
    measured = made_up()
    monkeypatch.setattr(e3c, "read_copies", lambda data: [m.copy for m in measured])
    monkeypatch.setattr(e3c, "measure_each", lambda work, copies, settings: measured)
    monkeypatch.setattr(e3c, "other_characters", lambda copies: WRONG)
    found = e3c.run(quick)
    assert found.name == "e3c" and found.facts["copies"] == len(measured)
    assert f"{len(measured)} copies of 6 characters" in found.text()
    assert (quick.out / "tables" / "e3c.csv").is_file()
