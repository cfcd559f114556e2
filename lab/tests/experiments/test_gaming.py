"""The anti-gaming set: trials are what they say, marks are counted, and nothing in a sample passes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from rumu.gallery.starter import find_work
from rumu_lab.experiments import gaming
from rumu_lab.experiments.gaming import OTHER, SCRIPT, ImpostorMark, Trial
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.simulation.impostors import IMPOSTORS


def trial(kind: str, work: str = "regular-shu", **more) -> Trial:
    return Trial(kind, find_work(work).path, work, **more)


def test_there_is_every_kind_of_every_master(tmp_path):
    every = list(gaming.trials(tmp_path))  # without data: the starter works alone
    assert len({t.name for t in every}) == 30
    for kind in IMPOSTORS:
        assert sum(t.kind == kind for t in every) == 30 * gaming.SEEDS.get(kind, 1)
    assert sum(t.kind == OTHER for t in every) == 30 * 5
    assert sum(t.kind == SCRIPT for t in every) == 30 * 4
    assert all((t.other is not None) == (t.kind in (OTHER, SCRIPT)) for t in every)
    assert all(t.other != t.master for t in every)


def test_the_templates_are_masters_too(data):
    every = list(gaming.trials(data))
    assert len({t.name for t in every}) == 30 + 25
    assert sum(t.kind == OTHER and t.name.startswith("template") for t in every) == 25 * 4


def test_a_mark_is_a_score_or_a_reason():
    blank = gaming.mark_trial(trial("blank"))
    assert (blank.score, blank.refused) == (None, "blank")
    stroke = gaming.mark_trial(trial("one_stroke"))
    assert stroke.refused is None and 0 <= stroke.score < 40
    other = gaming.mark_trial(trial(OTHER, other=find_work("regular-ri").path))
    assert other.refused == "another character" and not other.right


def test_a_character_that_is_its_own_mirror_image_is_right_when_mirrored():
    assert gaming.mark_trial(trial("mirrored", "clerical-tian")).right is True
    assert gaming.mark_trial(trial("mirrored", "seal-yue")).right is False


def test_a_sample_does_not_pass(tmp_path):
    done = []
    settings = RunSettings(tmp_path, tmp_path, progress=lambda k, n: done.append((k, n)))
    some = list(gaming.trials(tmp_path))[::40]
    found = gaming.run(settings, chosen=some)
    assert done == [(k, len(some)) for k in range(1, len(some) + 1)]
    assert found.facts["above"] == []
    rows = list(csv.DictReader((tmp_path / "tables" / "gaming.csv").open(encoding="utf-8")))
    assert len(rows) == len(some)
    assert all(bool(row["refused"]) != bool(row["score"]) for row in rows)


def test_what_is_above_is_named_and_what_is_right_is_apart():
    facts = gaming.figures(
        [
            ImpostorMark(trial("blank"), None, "blank"),
            ImpostorMark(trial("outline"), 47.0, None),
            ImpostorMark(trial("outline"), None, "outline only"),
            ImpostorMark(trial(SCRIPT, other=Path("x.png")), 71.0, None),
            ImpostorMark(trial("mirrored"), 80.0, None, right=True),
            ImpostorMark(trial("mirrored"), None, "mirrored"),
        ]
    )
    assert json.loads(json.dumps(facts)) == facts
    assert facts["above"] == [{"kind": "outline", "master": "regular-shu", "score": 47.0}]
    assert facts["blank_refused"] is True
    assert facts["kinds"]["outline"] == {
        "tried": 2,
        "refused": 1,
        "highest": 47.0,
        "above": 1,
        "why": {"outline only": 1},
    }
    assert facts["kinds"][SCRIPT]["highest"] == 71.0
    assert facts["right_after_all"]["mirrored"]["highest"] == 80.0
    text = gaming.text(facts, masters=1)
    assert "outline of regular-shu 47" in text and "same character other script" in text
    assert "6 impostors of 1 masters" in text
