"""Ablations: a part that helps is shown to help, one that does nothing is not."""

from __future__ import annotations

import numpy as np

from rumu_lab.experiments import ablation, variants

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
    groups = [{"what": "group plane", "clear": "helps"}, {"what": "group whole", "clear": "not shown"}]
    facts = {"third_dimension": third, "gains": [third, *groups]}
    alone, left_out = ablation._sentences(facts)
    assert "NOT shown" in alone.en and "+0.050 [-0.010, +0.100]" in alone.zh
    assert "shown to help plane; not shown whole" in left_out.en
    helps = {**facts, "third_dimension": {**third, "low": 0.01, "clear": "helps"}, "gains": [third]}
    (only,) = ablation._sentences(helps)
    assert only.en.startswith("The third dimension helps")
