"""What is kept comes back as it was, says what it rests on, and holds no longer than that does."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from rumu.values import Bilingual
from rumu_lab.experiments import findings as f
from rumu_lab.experiments.findings import Column, Findings, Table

TABLE = Table(
    "levels",
    Bilingual("表", "A table"),
    (Column("method", Bilingual("方法", "method")), Column("mae", Bilingual("誤差", "error"), 1)),
    ({"method": "MBSE", "mae": 9.87654}, {"method": "constant", "mae": None}, {"method": "x", "mae": -0.01}),
    (Bilingual("注", "A note."),),
)
FOUND = Findings("levels", {"n": np.int64(3), "bad": float("nan")}, (TABLE,), (Bilingual("話", "Said."),))


def test_it_comes_back(quick):
    f.keep(FOUND, settings=quick, seconds=1.25)
    plain = f.kept("levels", out=quick.out)
    again = f.findings_of(plain)
    assert again.facts == {"n": 3, "bad": None}
    assert again.tables == FOUND.tables and again.sentences == FOUND.sentences
    assert plain["seconds"] == 1.2 and plain["quick"] is True
    assert f.kept("human", out=quick.out) is None


def test_every_table_carries_the_protocol(quick):
    f.keep(FOUND, settings=quick, seconds=1)
    with (quick.out / "tables" / "levels.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert rows[0] == {
        "method": "MBSE",
        "mae": "9.87654",
        "protocol_sha256": quick.protocol.sha256,
        "quick": "1",
    }
    assert rows[1]["mae"] == ""


@pytest.mark.parametrize("changed", ["code", "quick", "protocol"])
def test_it_holds_as_long_as_what_it_rests_on(quick, monkeypatch, changed):
    f.keep(FOUND, settings=quick, seconds=1)
    plain = f.kept("levels", out=quick.out)
    assert f.still_holds(plain, settings=quick)
    if changed == "code":
        monkeypatch.setattr(f, "code_hash", lambda parts: "f" * 64)
    elif changed == "protocol":
        plain |= {"protocol_sha256": "f" * 64}
    assert not f.still_holds(plain, settings=replace(quick, quick=changed != "quick"))


def test_a_broken_result_is_none(quick):
    (quick.out / "results").mkdir(parents=True)
    (quick.out / "results" / "levels.json").write_text('{"facts": ')
    assert f.kept("levels", out=quick.out) is None


def test_for_a_reader():
    assert TABLE.shown() == [["MBSE-based (reconstructed)", "9.9"], ["constant", "–"], ["x", "0.0"]]
    assert FOUND.text().splitlines()[0] == "A table"
    assert "A note." in FOUND.text() and FOUND.text().endswith("Said.")
    assert replace(FOUND, words="Own words.").text().startswith("Own words.")


def test_json_is_strict(quick):
    f.keep(FOUND, settings=quick, seconds=1)
    text = (quick.out / "results" / "levels.json").read_text("utf-8")
    json.loads(text, parse_constant=pytest.fail)
