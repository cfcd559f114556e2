"""Drift against a step of severity, and which nuisance moves a mark."""

from __future__ import annotations

import pytest

from rumu_lab.experiments import nuisance, severities
from rumu_lab.experiments.grading import OURS, Grades
from rumu_lab.experiments.nuisance import PLAIN, Shot


def shot(copy, name, mark, **others):
    return Shot(copy, name, Grades(f"{copy}{name}", "w", {OURS: mark / 100, **others}))


def test_rows_of_nuisances_are_moves_from_the_same_copy_as_it_is():
    shots = [
        *(shot("a", PLAIN, 80), shot("a", "blur", 78), shot("a", "grid", 50)),
        *(shot("b", PLAIN, 40), shot("b", "blur", 42)),
        Shot("b", "grid", Grades("k", "w", refused="lines")),
    ]
    grid, blur = nuisance.nuisance_rows(shots)
    assert (grid["nuisance"], grid["n"], grid["refused"]) == ("grid", 2, 1)
    assert (grid["mean"], grid["rms"], grid["most"]) == pytest.approx((-30, 30, 30))
    assert (blur["mean"], blur["rms"], blur["most"]) == pytest.approx((0, 2, 2))


def test_drift_is_measured_in_steps():
    shots = [
        shot("a", PLAIN, 80, steady=0.5, wild=0.1, flat=0.5),
        shot("a", "blur", 82, steady=0.5, wild=0.9, flat=0.5),
    ]
    rows = nuisance.method_rows(shots, {OURS: 0.05, "steady": 0.01, "wild": 0.05, "flat": 0.0}, wanted=1 / 3)
    by_name = {row["method"]: row for row in rows}
    assert by_name[OURS]["ratio"] == pytest.approx(0.2) and by_name[OURS]["kept"] == "yes"
    assert by_name["wild"]["kept"] == "NO" and by_name["steady"]["ratio"] == 0
    assert rows[-1]["method"] == "flat" and by_name["flat"]["ratio"] is None


def test_the_losers_are_named(quick, graded, monkeypatch):
    def measure(work, tasks, settings):
        found = []
        for task in tasks:
            severity = int(task.key.rsplit("/", 1)[1]) if task.key.startswith("severities") else 0
            moved = 0.2 if task.key.endswith("JPEG 50") else 0.0
            found.append(graded(task, 0.9 - 0.06 * severity - moved, noise=0.0))
        return found

    monkeypatch.setattr(severities, "measure_each", measure)
    monkeypatch.setattr(nuisance, "measure_each", measure)
    found = nuisance.run(quick)
    assert found.facts["losers"] == ["JPEG 50"]
    assert found.facts["step_of_severity"] == pytest.approx(6.0)
    assert found.facts["pictures"] == 2 * 5
    assert "JPEG 50" in found.sentences[0].en
