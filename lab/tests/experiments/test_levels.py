"""Levels: counted right, by script, and against people where there are any."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.assessment.calibration import CUT_OFFS
from rumu_lab.experiments import human_marks, levels
from rumu_lab.experiments.levels import DEGREES
from rumu_lab.experiments.marked_copies import chosen_copies

MIDDLES = dict(zip(DEGREES, (0.2, 0.5, 0.58, 0.85), strict=True))


@pytest.fixture
def measured(monkeypatch, graded):
    """Every copy gets the middle of its level, but seal script is marked one level too low."""

    def measure(work, tasks, settings):
        marks = []
        for task in tasks:
            degree = task.key.split("/")[2]
            if "seal" in task.key:
                degree = DEGREES[max(DEGREES.index(degree) - 1, 0)]
            marks.append(graded(task, MIDDLES[degree]))
        return marks

    monkeypatch.setattr(levels, "measure_each", measure)


def test_levels_by_script(measured, quick):
    facts = levels.run(quick).facts
    rows = {row["where"]: row for row in facts["scripts"]}
    assert rows["regular"]["accuracy"] == 100 and rows["regular"]["kappa"] == 1
    assert rows["seal"]["right"] == 1 and rows["seal"]["n"] == 4
    assert rows["seal"]["low"] < 25 < rows["seal"]["high"]
    assert rows["all five"]["right"] == 17 and rows["all five"]["far"] == 0
    assert facts["confusion"] == [[5, 0, 0, 0], [1, 4, 0, 0], [0, 1, 4, 0], [0, 0, 1, 4]]


def test_without_people_it_says_so(measured, quick):
    found = levels.run(quick)
    assert found.facts["human"] == [] and "scores.csv" in found.facts["human_missing"]
    assert [table.name for table in found.tables] == ["table-1-scripts", "table-1-methods"]


def test_with_people(measured, quick, e3c_data, graded, monkeypatch):
    people, ours = (sorted(cuts.values()) for cuts in (quick.protocol.cut_offs, CUT_OFFS["panel"]))
    copies = {
        f"human/{c.image.name}": np.interp(c.mark, [0, *people, 100], [0, *ours, 100]) / 100
        for c in chosen_copies(quick)
    }
    monkeypatch.setattr(
        human_marks,
        "measure_each",
        lambda work, tasks, settings: [graded(t, copies[t.key]) for t in tasks],
    )
    found = levels.run(quick)
    ours, rater, common = found.facts["human"]
    assert ours["n"] == 18 and ours["accuracy"] == 100
    assert rater["accuracy"] < 100 and common["accuracy"] < 100
    assert "table-1-human" in [table.name for table in found.tables]


def test_level_numbers():
    cuts = {"excellent": 69.0, "good": 56.0, "medium": 41.0}
    assert [levels.level_number(mark, cuts) for mark in (0, 40.9, 41, 56, 69, 100)] == [0, 0, 1, 2, 3, 3]
    assert levels.level_number(float("nan"), cuts) == 0
    assert levels.level_middles(cuts) == [20.5, 48.5, 62.5, 84.5]
