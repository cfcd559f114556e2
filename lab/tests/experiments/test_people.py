"""The mark against people is measured once and found again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rumu.assessment.features import EVIDENCE, Features, Residuals
from rumu_lab.experiments import e3c, people


@dataclass(frozen=True)
class _Result:
    measured: tuple
    scores: tuple = (51.5,)

    def summary(self):
        return {"copies": 1}

    def text(self):
        return "one copy"


def test_it_is_measured_once(monkeypatch, quick):
    features = Features(Residuals(0.1), lean=1.0, offset=0.0, size=0.1, weight=0.0)
    copy = e3c.Copy(Path("a/1.png"), Path("a/t.png"), "十", 50.0, (5.0,))
    asked = []

    def run(data, *, out, progress):
        asked.append((data, out))
        return _Result((e3c.Measured(copy, features),))

    monkeypatch.setattr(e3c, "run", run)
    first = people.marked_copies(quick)
    again = people.marked_copies(quick)
    assert asked == [(quick.data, quick.out / "tables")]
    assert first == again
    assert first.images == ("1.png",) and first.scores == (51.5,) and first.panel == (50.0,)
    assert len(first.evidence[0]) == len(EVIDENCE)
    found = people.run(quick)
    assert found.name == "e3c" and found.facts == {"copies": 1} and found.text() == "one copy"
