"""The declaration holds together, agrees with the code that carries it out, and cannot change unseen."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from rumu.gallery.starter import starter_works
from rumu_lab.experiments import protocol
from rumu_lab.simulation.copies import RECIPES
from rumu_lab.simulation.severity import GREATEST, KINDS

FULL = protocol.declared()
FILE = Path(protocol.__file__).with_name("protocol.json")


def test_it_is_named_by_the_hash_of_its_file():
    assert FULL.sha256 == hashlib.sha256(FILE.read_bytes()).hexdigest()
    assert protocol.declared(quick=True).sha256 == FULL.sha256


def test_the_simulation_still_makes_what_was_declared():
    simulated, levels = FULL.plain["simulated"], FULL.plain["levels"]
    made = {name: {"step": KINDS[name].step, "unit": KINDS[name].unit} for name in simulated["faults"]}
    assert made == simulated["faults"]  # families that were added since are not among them
    for scores in FULL.expected_scores.values():
        assert len(scores) == int(GREATEST) + 1
        assert list(scores) == sorted(scores, reverse=True)
    assert {d: json.loads(json.dumps(r)) for d, r in RECIPES.items()} == levels["recipes"]


def test_the_works_are_those_of_the_starter_gallery():
    assert FULL.works == tuple(work.id for work in starter_works())
    assert set(protocol.declared(quick=True).works) < set(FULL.works)


def test_every_script_meets_every_fault():
    by_script = {}
    for number, work in enumerate(FULL.works):
        by_script.setdefault(work.split("-")[0], set()).update(protocol.share_faults(number, protocol=FULL))
    assert set(by_script) == set(FULL.scripts)
    assert all(found == set(FULL.faults) for found in by_script.values())


def test_expected_scores_fall_and_share_their_ends():
    tables = FULL.expected_scores
    assert len(tables) == 3
    for scores in tables.values():
        assert (scores[0], scores[-1]) == (100.0, 40.0)
        assert sorted(scores, reverse=True) == list(scores) and len(set(scores)) == 6


def test_the_lists_of_characters_share_nothing():
    lists = FULL.plain["characters"]
    chosen = lists["development"] + lists["validation"]
    known = FULL.plain["human"]["characters"] + "".join(w.character for w in starter_works())
    assert (len(lists["development"]), len(lists["validation"])) == (200, 100)
    assert len(set(chosen)) == 300
    assert not set(chosen) & set(known)
