"""Results come back as they were, say what they rest on, and are strict JSON."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from rumu.values import Bilingual
from rumu_lab.experiments import results
from rumu_lab.experiments.findings import Column, Findings, Table

TABLE = Table(
    "levels",
    Bilingual("表", "A table"),
    (Column("method", Bilingual("方法", "method")), Column("mae", Bilingual("誤差", "error"), 1)),
    ({"method": "MBSE", "mae": 9.87654}, {"method": "constant", "mae": None}),
    (Bilingual("注", "A note."),),
)
FOUND = Findings("levels", {"n": np.int64(3), "bad": float("nan")}, (TABLE,), (Bilingual("話", "Said."),))


@pytest.fixture
def written(quick):
    """A result under OUT."""
    results.write_result(FOUND, results.origin_of(quick, seconds=1.25), quick)
    return quick


def test_it_comes_back(written):
    plain = results.read_result("levels", out=written.out)
    again = results.findings_from(plain)
    assert again.facts == {"n": 3, "bad": None}
    assert again.tables == FOUND.tables and again.sentences == FOUND.sentences
    assert plain["seconds"] == 1.2 and plain["quick"] is True
    assert plain["protocol_sha256"] == written.protocol.sha256 and len(plain["code_sha256"]) == 64
    assert results.read_result("human", out=written.out) is None


def test_every_table_carries_the_protocol(written):
    with (written.out / "tables" / "levels.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert rows[0] == {
        "method": "MBSE",
        "mae": "9.87654",
        "protocol_sha256": written.protocol.sha256,
        "quick": "1",
    }
    assert rows[1]["mae"] == ""


def test_a_broken_result_is_none(quick):
    (quick.out / "results").mkdir(parents=True)
    (quick.out / "results" / "levels.json").write_text('{"facts": ')
    assert results.read_result("levels", out=quick.out) is None


def test_json_is_strict(written):
    text = (written.out / "results" / "levels.json").read_text("utf-8")
    json.loads(text, parse_constant=pytest.fail)
