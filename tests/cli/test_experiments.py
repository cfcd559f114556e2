"""experiments run: the door only; what it prints is tested in its own room."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class _Result:
    pairs: int

    def summary(self):
        return {"pairs": self.pairs}

    def text(self):
        return f"{self.pairs} pairs"


def test_the_experiment_gets_its_data_and_its_place(rumu, tmp_path, monkeypatch):
    asked = []

    def run(data, *, out, progress):
        asked.append((data, out))
        progress(1, 2)
        return _Result(652)

    monkeypatch.setattr("rumu.experiments.e3c.run", run)
    assert rumu("experiments", "run", "e3c", "--data", tmp_path, "--json").facts == {"pairs": 652}
    assert rumu("experiments", "run", "e3c", "--data", "d", "-o", "o").out == "652 pairs\n"
    monkeypatch.setenv("RUMU_DATA", "elsewhere")
    rumu("experiments", "run", "e3c")
    assert asked == [(tmp_path, None), (Path("d"), Path("o")), (Path("elsewhere"), None)]


def test_an_experiment_that_does_not_exist(rumu):
    assert rumu("experiments", "run", "everything").code == 2


def test_data_that_are_not_there(rumu, tmp_path):
    ended = rumu("experiments", "run", "e3c", "--data", tmp_path, "--json")
    ended.failed_with(str(tmp_path))
    assert "error" in ended.facts
