"""Every experiment can be called the way the registry calls it."""

from __future__ import annotations

import inspect
from dataclasses import replace
from importlib import import_module

import pytest

from rumu_lab.experiments import runner
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import TABLES
from rumu_lab.experiments.runner import EXPERIMENTS


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda e: e.name)
def test_every_experiment_takes_what_it_is_given(experiment):
    parameters = inspect.signature(import_module(f"rumu_lab.experiments.{experiment.module}").run).parameters
    required = {name for name, p in parameters.items() if p.default is inspect.Parameter.empty}
    assert required == ({"settings", "name"} if experiment.alone else {"settings"})


def test_what_an_experiment_needs(quick, tmp_path):
    human, runtime, e3c = (runner.find(name) for name in ("human", "runtime", "e3c"))
    assert runner.why_not(runtime, quick) is None
    assert "scores.csv" in runner.why_not(human, quick)
    for table in TABLES:
        (tmp_path / "data" / table).parent.mkdir(parents=True)
        (tmp_path / "data" / table).touch()
    assert runner.why_not(human, quick) is None
    assert runner.why_not(e3c, quick) == "not in the quick subset"
    assert runner.why_not(e3c, replace(quick, quick=False)) is None


def test_the_lists_share_a_module_and_are_told_apart(quick, monkeypatch):
    asked = []

    def run(settings, *, name, seed=None, log=None):
        asked.append((name, seed, log))
        return Findings(name, {})

    monkeypatch.setattr("rumu_lab.experiments.character_lists.run", run)
    runner.run_one("validation", quick)
    runner.run_one("locked", quick, seed="s", log="l")
    assert asked == [("validation", None, None), ("locked", "s", "l")]
    assert (quick.out / "results" / "validation.json").is_file()
