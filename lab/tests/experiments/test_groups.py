"""Groups of evidence, named by the code: what carries the marks is missed, and no character sees itself."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.assessment.features import EVIDENCE, GROUPS
from rumu.assessment.fitting import WEIGHED
from rumu_lab.experiments import groups
from rumu_lab.experiments.people import Marked


@pytest.fixture(scope="module")
def marked() -> Marked:
    """Marks that follow the group 'whole' alone; everything else is noise."""
    rng = np.random.default_rng(2)
    characters = [f"c{k % 5}" for k in range(100)]
    quality = rng.normal(size=100)
    evidence = 0.3 * rng.normal(size=(100, len(EVIDENCE)))
    for name in GROUPS["whole"]:
        evidence[:, EVIDENCE.index(name)] = -quality + 0.1 * rng.normal(size=100)
    panel = np.clip(55 + 12 * quality, 0, 100)
    return Marked(
        tuple(f"{k}.png" for k in range(100)),
        tuple(characters),
        tuple(panel.tolist()),
        tuple(panel.tolist()),
        tuple(map(tuple, evidence.tolist())),
        {},
        "",
    )


def test_the_groups_are_those_of_the_code():
    found = groups.variants()
    assert found[groups.WHOLE] == WEIGHED
    for group, names in GROUPS.items():
        used = [name for name in names if name in WEIGHED]
        assert (groups.alone(group) in found) == bool(used)
        if used:
            assert not set(found[groups.without(group)]) & set(names)


def test_the_group_that_carries_the_marks_is_missed(marked, quick):
    given = groups.predictions(marked)
    rows, gains = groups.group_rows(given, marked, quick)
    by_group = {row["what"]: row for row in gains}
    assert by_group["group whole"]["clear"] == "helps" and by_group["group whole"]["gain"] > 0.3
    assert abs(by_group["group fullness"]["gain"]) < 0.1
    by_name = {row["method"]: row for row in rows}
    assert by_name[groups.alone("whole")]["within"] > 0.9


def test_a_character_s_own_marks_do_not_count(marked):
    from dataclasses import replace

    own = np.array(marked.characters) == "c2"
    moved = np.where(own, np.array(marked.panel)[::-1], marked.panel)
    only = {groups.WHOLE: WEIGHED}
    before = groups.predictions(marked, chosen=only)[groups.WHOLE]
    after = groups.predictions(replace(marked, panel=tuple(moved.tolist())), chosen=only)[groups.WHOLE]
    np.testing.assert_allclose(after[own], before[own])
    assert np.abs(after[~own] - before[~own]).max() > 0.1
