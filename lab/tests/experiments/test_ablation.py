"""Ablations: a part that helps is shown to help, one that does nothing is not, no character sees itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from rumu.assessment import fitting
from rumu.assessment.features import FEATURE_GROUPS, FEATURE_NAMES
from rumu_lab.experiments import ablation, variants
from rumu_lab.experiments.e3c import HeldOutMarks, MeasuredCopy
from rumu_lab.experiments.grading import Grades
from rumu_lab.experiments.marked_copies import Copy
from rumu_lab.experiments.severities import starter_subjects

CHARACTERS = np.repeat([f"c{k}" for k in range(12)], 10)
RNG = np.random.default_rng(5)
MARKS = RNG.uniform(20, 80, len(CHARACTERS))


def test_gains(quick):
    names = [variants.variant(*w) for w in variants.weights()]
    raw = {name: MARKS / 100 + 0.3 * RNG.normal(size=len(MARKS)) for name in names}
    raw |= {variants.FORWARD: raw[variants.base_variant()].copy(), variants.BACKWARD: -MARKS}
    height, direction = variants.base_weights()
    raw[variants.variant(height, direction)] = MARKS / 100
    found = {row["what"]: row for row in ablation.gain_rows(raw, MARKS, list(CHARACTERS), quick)}
    helped = found["both ways, against master to copy"]
    assert helped["clear"] == "helps" and helped["low"] > 1.9 and helped["n"] == 12
    assert found[f"direction x {direction:g}"]["clear"] == "helps"
    raw[variants.FORWARD] = raw[variants.base_variant()]
    same = {row["what"]: row for row in ablation.gain_rows(raw, MARKS, list(CHARACTERS), quick)}
    assert same["both ways, against copy to master"]["clear"] == "not shown"


def test_the_sentence_follows_the_intervals():
    third = {"what": "height x 1", "gain": 0.05, "low": -0.01, "high": 0.1, "clear": "not shown"}
    groups = [{"what": "group plane", "clear": "helps"}, {"what": "group form", "clear": "not shown"}]
    facts = {"third_dimension": third, "gains": [third, *groups]}
    alone, left_out = ablation._sentences(facts)
    assert "NOT shown" in alone.en and "+0.050 [-0.010, +0.100]" in alone.zh
    assert "shown to help plane; not shown form" in left_out.en
    helps = {**facts, "third_dimension": {**third, "low": 0.01, "clear": "helps"}, "gains": [third]}
    (only,) = ablation._sentences(helps)
    assert only.en.startswith("The third dimension helps")


@dataclass(frozen=True)
class KnownFeatures:
    """Stands for the features of a copy."""

    values: tuple[float, ...]

    def vector(self) -> tuple[float, ...]:
        return self.values


@pytest.fixture(scope="module")
def held_out() -> HeldOutMarks:
    """Marks that follow the group 'form' alone; everything else is noise."""
    rng = np.random.default_rng(2)
    quality = rng.normal(size=100)
    evidence = 0.3 * rng.normal(size=(100, len(FEATURE_NAMES)))
    for name in FEATURE_GROUPS["form"]:
        evidence[:, FEATURE_NAMES.index(name)] = -quality + 0.1 * rng.normal(size=100)
    panel = np.clip(55 + 12 * quality, 0, 100)
    copies = [Copy(Path(f"{k}.png"), Path("t.png"), f"c{k % 5}", float(panel[k]), ()) for k in range(100)]
    measured = [MeasuredCopy(c, KnownFeatures(tuple(row))) for c, row in zip(copies, evidence, strict=True)]
    characters = np.array([c.character for c in copies])
    return HeldOutMarks(tuple(measured), (), panel, characters, panel, panel, panel, None)


def test_the_groups_are_those_of_the_code():
    found = ablation.group_variants()
    assert found[ablation.WHOLE] == fitting.WHOLE
    for group in FEATURE_GROUPS:
        assert (f"{group} alone" in found) == (group in fitting.WHOLE)
        if group in fitting.WHOLE:
            assert set(found[f"without {group}"]) == set(fitting.WHOLE) - {group}


def test_the_group_that_carries_the_marks_is_missed(held_out, quick):
    rows, gains = ablation.group_rows(held_out, quick)
    by_group = {row["what"]: row for row in gains}
    assert by_group["group form"]["clear"] == "helps" and by_group["group form"]["gain"] > 0.3
    assert abs(by_group["group fullness"]["gain"]) < 0.1
    assert {row["method"]: row for row in rows}["form alone"]["within"] > 0.9


def test_a_character_s_own_marks_do_not_count(held_out):
    own = held_out.characters == "c2"
    moved = np.where(own, held_out.panel[::-1], held_out.panel)
    only = {ablation.WHOLE: fitting.WHOLE}
    before = ablation.group_marks(held_out, chosen=only)[ablation.WHOLE]
    after = ablation.group_marks(replace(held_out, panel=moved), chosen=only)[ablation.WHOLE]
    np.testing.assert_allclose(after[own], before[own])
    assert np.abs(after[~own] - before[~own]).max() > 0.1


def test_heights_are_compared_on_whole_series(quick, monkeypatch):
    def grade(work, tasks, settings):
        grades = []
        for task in tasks:
            refused = "too pale" if "seal-tian/pale/5" in task.key else None
            raw = {"inflation": 1.0, "density": 1.0 - 0.1 * int(task.key[-1])}
            grades.append(Grades(task.key, task.cluster, {} if refused else raw, refused=refused))
        return grades

    monkeypatch.setattr(ablation, "measure_each", grade)
    subjects = [s for s in starter_subjects(quick.protocol) if s.name in ("seal-tian", "regular-tian")]
    assert ablation.height_rows([replace(s, faults=("pale",)) for s in subjects], quick) == [
        {"fault": "pale", "n": 2, "whole": 1, "inflation": 0.0, "density": pytest.approx(1.0)},
    ]
