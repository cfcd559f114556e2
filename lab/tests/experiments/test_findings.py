"""Tables and sentences for a reader."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rumu.values import Bilingual
from rumu_lab.experiments.findings import Column, Findings, Table

TABLE = Table(
    "levels",
    Bilingual("表", "A table"),
    (Column("method", Bilingual("方法", "method")), Column("mae", Bilingual("誤差", "error"), 1)),
    ({"method": "MBSE", "mae": 9.87654}, {"method": "constant", "mae": None}, {"method": "x", "mae": -0.01}),
    (Bilingual("注", "A note."),),
)
FOUND = Findings("levels", {"n": np.int64(3), "bad": float("nan")}, (TABLE,), (Bilingual("話", "Said."),))


def test_for_a_reader():
    assert TABLE.formatted() == [["MBSE-based (reconstructed)", "9.9"], ["constant", "–"], ["x", "0.0"]]
    assert FOUND.text().splitlines()[0] == "A table"
    assert "A note." in FOUND.text() and FOUND.text().endswith("Said.")
    assert replace(FOUND, words="Own words.").text().startswith("Own words.")
