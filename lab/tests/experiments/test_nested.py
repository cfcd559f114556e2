"""Nested validation: what is left out touches neither fit nor choice, and the better candidate wins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.assessment.features import FEATURE_NAMES, RESIDUALS, Features, Residuals
from rumu_lab.experiments import nested
from rumu_lab.experiments.nested import Candidate, MarkedFeatures

CUTS = (41.0, 56.0, 69.0)
GOOD = Candidate("good", {"plane": 50.0}, charged=False)
WORSE = Candidate("worse", {"whole": 50.0}, charged=False)


@pytest.fixture
def known() -> MarkedFeatures:
    """Marks of five characters follow the distances in the plane; those of the whole hardly."""
    rng = np.random.default_rng(4)
    n = 150
    quality = rng.normal(size=n)
    vectors = -1.5 + 0.3 * rng.normal(size=(n, len(FEATURE_NAMES)))
    vectors[:, :4] = -1.5 - 0.3 * quality[:, None] + 0.03 * rng.normal(size=(n, 4))
    vectors[:, 6:10] = -1.5 - 0.3 * quality[:, None] + 0.3 * rng.normal(size=(n, 4))
    wrong = Features(Residuals(*[0.9] * len(RESIDUALS)), lean=0.0, offset=0.0, size=0.0, weight=0.0)
    return MarkedFeatures(
        vectors,
        np.clip(52 + 14 * quality + rng.normal(size=n), 5, 95),
        np.arange(n) % 5,
        tuple("天地玄黃宇"),
        np.zeros((n, 2)),
        np.full(n, 100.0),
        np.full(n, 100.0),
        (wrong,) * 3,
    )


def apart(known: MarkedFeatures) -> dict[str, np.ndarray]:
    return {c.name: nested.marks_apart(known, c) for c in (WORSE, GOOD)}


def test_the_better_candidate_is_chosen_without_the_character(known):
    found = nested.mark_nested(known, apart(known), CUTS)
    assert found.chosen == ("good",) * 5
    assert np.abs(found.marks - known.marks).mean() < 5
    assert ((found.low <= known.marks) & (known.marks <= found.high)).mean() == pytest.approx(0.8, abs=0.1)
    assert set(found.levels) == {0, 1, 2, 3}


def test_a_character_s_own_marks_touch_neither_its_marks_nor_its_choice(known):
    own = known.characters == 2
    spoilt = replace(known, marks=np.where(own, known.marks + 4 * (-1.0) ** np.arange(150), known.marks))
    before, after = (nested.mark_nested(k, apart(k), CUTS) for k in (known, spoilt))
    for name in ("marks", "low", "high", "levels"):
        np.testing.assert_array_equal(getattr(after, name)[own], getattr(before, name)[own])
    assert after.chosen[2] == before.chosen[2]
    assert np.abs(after.marks[~own] - before.marks[~own]).max() > 0.1


def test_charges_are_taken_where_a_candidate_has_them(known):
    charged = replace(known, points=np.full((150, 2), 3.0), ceilings=np.full(150, 40.0))
    bare = nested.marks_apart(charged, GOOD)
    less = nested.marks_apart(charged, replace(GOOD, charged=True))
    np.testing.assert_allclose(less, np.clip(np.minimum(bare - 3.0, 40.0) - 3.0, 0, 100), atol=1e-9)


def test_the_findings_hold_what_was_found(known):
    facts = nested.findings_of(known, apart(known)).facts
    assert facts["chosen"] == {"good": 5}
    assert sum(map(sum, facts["confusion"])) == 150
    assert sum(row["n"] for row in facts["fifths"]) == 2 * 150
    assert [row["times"] for row in facts["candidates"]] == [5, 0, 5]
