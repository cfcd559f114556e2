"""The commands of `rumu experiments`; what they print is tested with each experiment."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments import runner
from rumu_lab.experiments.findings import Findings


@pytest.fixture
def data(tmp_path) -> Path:
    """A data folder in which nothing is missing, and nothing is in."""
    for name in ("e3c/scores.csv", "e3c-more/scores.csv", "masters/regular/labels.csv"):
        (tmp_path / "data" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "data" / name).touch()
    return tmp_path / "data"


@pytest.fixture
def asked(monkeypatch):
    """Every experiment replaced by one that only notes how it was called."""
    calls = []

    def module(path):
        name = path.rsplit(".", 1)[1]

        def run(settings, **more):
            calls.append((name, settings.data, settings.out))
            settings.progress(1, 2)
            if name == "nuisance":
                raise CalibrationError("nuisance went\nwrong")
            return Findings(name, {"pairs": 652}, words="652 pairs")

        return type("Module", (), {"run": staticmethod(run)})

    monkeypatch.setattr(runner, "import_module", module)
    return calls


def test_the_experiment_gets_its_data_and_its_place(rumu, asked, data, tmp_path, monkeypatch):
    assert rumu("experiments", "run", "e3c", "--data", data, "--json").facts == {"pairs": 652}
    assert rumu("experiments", "run", "e3c", "--data", data, "-o", tmp_path / "o").out == "652 pairs\n"
    monkeypatch.setenv("RUMU_DATA", str(data))
    rumu("experiments", "run", "e3c")
    assert asked == [
        ("e3c", data, None),
        ("e3c", data, tmp_path / "o"),
        ("e3c", data, None),
    ]
    kept = json.loads((tmp_path / "o" / "results" / "e3c.json").read_text())
    assert kept["facts"] == {"pairs": 652} and kept["words"] == "652 pairs"


def test_all_goes_on_where_it_stopped_and_past_what_fails(rumu, asked, data, tmp_path):
    everything = [e.name for e in runner.EXPERIMENTS if not e.alone]
    first = rumu("experiments", "run", "all", "--data", data, "-o", tmp_path / "o", "--json")
    assert first.code == 1 and "nuisance" in first.err
    facts = json.loads(first.out)["experiments"]
    assert list(facts) == everything
    assert {name for name, how in facts.items() if how["status"] != "ran"} == {"nuisance"}
    assert facts["nuisance"]["why"] == "nuisance went wrong"
    asked.clear()
    again = json.loads(rumu("experiments", "run", "all", "--data", data, "-o", tmp_path / "o", "--json").out)
    assert [name for name, *_ in asked] == ["nuisance"]
    assert {how["status"] for name, how in again["experiments"].items() if name != "nuisance"} == {"kept"}


def test_all_skips_what_has_no_data_with_one_line(rumu, asked, tmp_path):
    ended = rumu("experiments", "run", "all", "--data", tmp_path, "-o", tmp_path / "o")
    skipped = {e.name for e in runner.EXPERIMENTS if e.needs and not e.alone}
    assert {name for name, *_ in asked} == {e.name for e in runner.EXPERIMENTS if not e.alone} - skipped
    for name in skipped:
        (line,) = [line for line in ended.err.splitlines() if line.startswith(f"{name}:")]
        assert "skipped" in line and str(tmp_path) in line


def test_all_needs_a_place(rumu):
    ended = rumu("experiments", "run", "all")
    assert ended.code == 2 and "-o" in ended.err


@pytest.mark.parametrize("words", [("locked",), ("e3c", "--seed", "s")])
def test_the_seed_goes_with_the_locked_test(rumu, words):
    assert rumu("experiments", "run", *words).code == 2


def test_an_experiment_that_does_not_exist(rumu):
    assert rumu("experiments", "run", "everything").code == 2


def test_data_that_are_not_there(rumu, tmp_path):
    ended = rumu("experiments", "run", "e3c", "--data", tmp_path, "--json")
    ended.failed_with(str(tmp_path))
    assert "error" in ended.facts


def test_a_report_of_nothing(rumu, tmp_path):
    rumu("experiments", "report", tmp_path).failed_with(str(tmp_path), "experiments run all")
