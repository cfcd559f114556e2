"""Times side by side."""

from __future__ import annotations

import pytest

from rumu_lab.baselines.methods import METHODS
from rumu_lab.experiments import runtime
from rumu_lab.experiments.grading import OURS


def test_ratios_are_of_the_same_turn():
    """A machine that turns slow slows both: the ratio stays."""
    rows = runtime.time_rows({OURS: [0.1, 0.1, 0.4], "other": [0.2, 0.2, 0.8]})
    assert [row["method"] for row in rows] == [OURS, "other"]
    assert rows[1]["ratio"] == pytest.approx(2.0) and rows[1]["median"] == pytest.approx(200)
    assert (rows[1]["least"], rows[1]["most"]) == pytest.approx((200, 800))


def test_every_method_is_timed(quick):
    done = []
    found = runtime.run(type(quick)(quick.data, None, True, lambda k, n: done.append((k, n))))
    names = {row["method"] for row in found.facts["methods"]}
    assert names == {OURS, *METHODS, "pictures to surfaces, for all"}
    assert done == [(1, 2), (2, 2)]
    assert all(row["median"] > 0 for row in found.facts["methods"])
