"""Two kinds of height on faults of the ink."""

from __future__ import annotations

import pytest

from rumu.gallery.starter import find_work
from rumu_lab.experiments import density
from rumu_lab.experiments.measuring import GradingTask, Measured
from rumu_lab.experiments.severities import starter_subjects
from rumu_lab.experiments.simulated_copies import Faulty

MASTER = find_work("regular-ren").path


def test_blots_show_in_the_darkness_and_both_are_measured():
    near, far = (
        density.measure_density(GradingTask("k", "c", MASTER, Faulty(MASTER, "dry", severity, 11))).raw
        for severity in (1, 5)
    )
    assert set(near) == set(far) == set(density.METHODS)
    assert far["inflation"] < near["inflation"]


def test_rows(quick, monkeypatch):
    def measure(work, tasks, *, store, progress):
        found = []
        for task in tasks:
            severity = int(task.key[-1])
            refused = "too pale" if "seal-tian/pale/5" in task.key else None
            raw = {"inflation": 1.0, "density": 1.0 - 0.1 * severity}
            found.append(Measured(task.key, task.cluster, {} if refused else raw, refused=refused))
        return found

    monkeypatch.setattr(density, "measure_by", measure)
    subjects = [s for s in starter_subjects(quick.protocol) if s.name in ("seal-tian", "regular-tian")]
    from dataclasses import replace

    rows = density.density_rows([replace(s, faults=("pale",)) for s in subjects], quick)
    assert rows == [
        {"fault": "pale", "n": 2, "whole": 1, "inflation": 0.0, "density": pytest.approx(1.0)},
    ]
