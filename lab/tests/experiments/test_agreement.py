"""Methods side by side: who is better is found, by how much is not claimed beyond the figures."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.experiments import agreement
from rumu_lab.experiments.protocol import declared

QUICK = declared(quick=True)
RNG = np.random.default_rng(0)
CHARACTERS = np.repeat([f"c{k}" for k in range(14)], 12)
MARKS = np.clip(RNG.normal(55, 12, len(CHARACTERS)), 5, 95)


def method(name, noise, seed):
    raw = (MARKS + noise * np.random.default_rng(seed).normal(size=len(MARKS))) / 100.0
    return agreement.GradedMethod(name, raw, agreement.held_out(raw, MARKS, CHARACTERS))


def compared(*methods):
    return agreement.side_by_side(
        [*methods, agreement.constant(MARKS, CHARACTERS)], MARKS, CHARACTERS, ours="ours", protocol=QUICK
    )


def test_a_better_method_is_first_by_a_clear_margin():
    rows = compared(method("ours", 5, 1), method("rival", 15, 2))
    assert [row["method"] for row in rows] == ["ours", "rival", "constant"]
    found = agreement.verdict(rows, ours="ours")
    assert found["clear"] and found["rank"] == 1 and found["margin"] > 1
    assert "first by a clear margin" in agreement.verdict_sentence(found, zh="", en="On").en


def test_an_equal_method_is_not_beaten():
    rows = compared(method("ours", 10, 1), method("rival", 10, 2))
    found = agreement.verdict(rows, ours="ours")
    assert not found["clear"] and "rival" in found["ahead"] + found["not_beaten"]
    assert "NOT" in agreement.verdict_sentence(found, zh="", en="On").en


def test_a_worse_method_is_told_its_place():
    rows = compared(method("ours", 20, 1), method("rival", 4, 2))
    found = agreement.verdict(rows, ours="ours")
    assert found["rank"] == 2 and found["ahead"] == ["rival"]
    sentence = agreement.verdict_sentence(found, zh="", en="On")
    assert "NOT first but number 2 of 3" in sentence.en and "第 2" in sentence.zh


def test_our_own_other_rows_are_no_rivals():
    rows = compared(method("ours", 8, 1), method("ours too", 2, 2), method("rival", 20, 3))
    assert agreement.verdict(rows, ours="ours", besides=("ours too",))["rank"] == 1
    assert agreement.verdict(rows, ours="ours")["rank"] == 2


def test_a_mark_never_sees_its_own_fold():
    """Marks of one character moved by twenty points move what other characters' fits say, not its own."""
    raw = MARKS / 100.0
    before = agreement.held_out(raw, MARKS, CHARACTERS)
    moved = np.where(CHARACTERS == "c3", np.clip(MARKS + 20, 0, 100), MARKS)
    after = agreement.held_out(raw, moved, CHARACTERS)
    own = CHARACTERS == "c3"
    np.testing.assert_allclose(after[own], before[own])
    assert np.abs(after[~own] - before[~own]).max() > 0.01
    assert agreement.constant(moved, CHARACTERS).given[own][0] == np.median(MARKS[~own])


def test_a_constant_ranks_nothing():
    row = next(r for r in compared(method("ours", 5, 1)) if r["method"] == "constant")
    assert row.get("within") is None and row["mae"] > 5


def test_ranks_are_of_the_raw_grade():
    rows = compared(method("ours", 0, 1))
    assert rows[0]["within"] == pytest.approx(1.0) and rows[0]["order"] == pytest.approx(1.0)
