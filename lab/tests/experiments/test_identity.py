"""Same or other character: pairs are what they say, the area is right, and a sample is parted well."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from rumu_lab.experiments import identity
from rumu_lab.experiments.identity import MEASURES, area, interval
from rumu_lab.experiments.run_settings import RunSettings


def test_the_area_is_the_share_of_pairs_in_order():
    rng = np.random.default_rng(1)
    same, other = rng.normal(1, 1, 40), rng.normal(0, 1, 30).round(1)
    by_hand = np.mean([(s > o) + 0.5 * (s == o) for s in same for o in other])
    assert area(same, other) == pytest.approx(by_hand)
    assert area(np.array([2.0, 3.0]), np.array([0.0, 1.0])) == 1.0
    assert area(np.array([1.0]), np.array([1.0])) == 0.5


def test_the_interval_draws_characters_and_not_pairs():
    """A hundred equal pairs of one character tell no more than one: the interval must stay wide."""
    rng = np.random.default_rng(2)
    values, same = rng.normal(size=40), np.arange(40) % 2 == 0
    values[same] += 1.0
    names = np.repeat(np.arange(20).astype(str), 2)
    low, high = interval(values, same, names, seed=0)
    many = [np.repeat(x, 100) for x in (values, same, names)]
    low_many, high_many = interval(*many, seed=0)
    assert low < area(values[same], values[~same]) < high
    assert high_many - low_many == pytest.approx(high - low, abs=0.03)
    apart = interval(*(np.repeat(x, 100) for x in (values, same)), np.arange(4000).astype(str), seed=0)
    assert apart[1] - apart[0] < 0.3 * (high - low)


def test_pairs_of_one_character_come_from_two_works(data):
    found = list(identity.pairs(data, most=20, seed=0))
    for pair in found:
        assert pair.copy != pair.master and pair.copy.is_file() and pair.master.is_file()
        if pair.where.startswith("regular"):
            assert pair.copy.parent != pair.master.parent
    for where in {pair.where for pair in found}:
        mine = [pair for pair in found if pair.where == where]
        assert sum(pair.same for pair in mine) == len(mine) / 2
    assert len({pair.where for pair in found}) == 4
    assert not any("dingwu" in str(p.copy) for p in found if "three" in p.where)
    assert found == list(identity.pairs(data, most=20, seed=0))
    assert found != list(identity.pairs(data, most=20, seed=1))


def test_a_sample_is_parted(data, tmp_path):
    pairs = list(identity.pairs(data, most=12))
    found = identity.run(RunSettings(data, tmp_path), chosen=pairs)
    facts = found.facts
    assert json.loads(json.dumps(facts)) == facts
    for where in ("regular, six works", "E3C copies and templates"):
        for name in ("likeness", "familiarity"):
            figures = facts[where][name]
            assert figures["low"] <= figures["auc"] <= figures["high"]
            assert figures["auc"] > 0.95
    rows = list(csv.DictReader((tmp_path / "tables" / "identity.csv").open(encoding="utf-8")))
    assert len(rows) == len(pairs) and set(MEASURES) < set(rows[0])
    for meaning in MEASURES.values():
        assert meaning in found.text()
