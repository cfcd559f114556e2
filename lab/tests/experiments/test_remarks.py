"""Faults that the remarks name: what the shares are shares of, and one real master."""

from __future__ import annotations

import csv
from dataclasses import replace

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments import remarks
from rumu_lab.experiments.fault_answers import ANSWERS
from rumu_lab.experiments.remarks import FaultTrial, RemarkMaster


def named(fault: str, position: int | None, *, seen=False, severity=3.0, kinds=(), master="m") -> FaultTrial:
    return FaultTrial(master, seen, fault, severity, position, tuple(kinds))


def test_shares_are_of_held_out_and_of_seen_masters_apart():
    some = [named("shift", 0), named("shift", 1), named("shift", None), named("shift", None, seen=True)]
    shift = remarks.figures(some)["faults"]["shift"]
    assert shift["held_out"] == pytest.approx({"copies": 3, "told": 2 / 3, "first": 1 / 3})
    assert shift["seen"] == {"copies": 1, "told": 0.0, "first": 0.0}
    assert shift["by_severity"]["3"]["copies"] == 3


def test_faults_that_nobody_sees_are_counted_apart():
    some = [named("short", 0), replace(named("short", None), visible=False)]
    short = remarks.figures(some)["faults"]["short"]
    assert short["held_out"] == {"copies": 1, "told": 1.0, "first": 1.0}
    assert short["too_small"] == {"copies": 1, "told": 0.0, "first": 0.0}


def test_faults_that_take_ink_far_off_its_place_are_counted_besides():
    some = [replace(named("angle", 0), moved=0.03), named("angle", None)]
    angle = remarks.figures(some)["faults"]["angle"]
    assert angle["held_out"] == {"copies": 2, "told": 0.5, "first": 0.5}
    assert angle["moved"] == {"copies": 1, "told": 1.0, "first": 1.0}


def test_a_severity_that_was_asked_for_besides_counts_in_its_own_row():
    faults = remarks.figures([named("lean", 0, severity=1.5), named("lean", None, severity=3.0)])["faults"]
    assert faults["lean"]["held_out"]["copies"] == 1 and faults["lean"]["held_out"]["told"] == 0.0
    assert faults["lean 1.5"]["held_out"]["told"] == 1.0


def test_false_alarms_tell_a_stroke_from_the_whole():
    clean = [named("clean half", None, kinds=["size"]), named("clean half", None, kinds=["stroke_long"]),
             named("clean half", None)]  # fmt: skip
    assert remarks.figures(clean)["clean"] == {"copies": 3, "any": 2, "stroke": 1, "refused": 0}


def test_the_text_and_the_table_say_what_was_found(tmp_path):
    some = (named("shift", 1, kinds=["lean", "displaced"]), named("clean half", None, kinds=["missing"]))
    text = remarks.text(remarks.figures(some))
    line = next(line for line in text.splitlines() if line.startswith("shift"))
    assert line.split() == ["shift", "1", "100%", "0%", *["0%", "of", "0"] * 3]
    assert "1, of which 1 got a remark on a stroke" in text
    remarks.write_table(some, tmp_path / "remarks.csv")
    with (tmp_path / "remarks.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["fault"], row["told"], row["kinds"]) for row in rows] == [
        ("shift", "2", "lean displaced"), ("clean half", "", "missing"),
    ]  # fmt: skip


def test_a_folder_without_masters_is_said_to_be_one(tmp_path):
    with pytest.raises(CalibrationError, match="masters/regular"):
        remarks.standard_masters(tmp_path)


def test_a_real_master_is_asked_for_every_fault_and_for_clean_copies(monkeypatch):
    from rumu.gallery.starter import starter_works

    monkeypatch.setattr(remarks, "ANSWERS", {name: ANSWERS[name] for name in ("missing", "thick", "lean")})
    monkeypatch.setattr(remarks, "ASKED", (("lean", 1.5),))
    work = next(w for w in starter_works() if w.id == "regular-shui")
    found = remarks.try_master(RemarkMaster(work.id, work.path, True), (3.0,))
    assert [t.fault for t in found] == [
        "missing", "thick", "lean", "lean", "clean half", "clean larger", "clean aside",
    ]  # fmt: skip
    assert [t.position is not None for t in found[:4]] == [True] * 4
    assert all(t.refused is None for t in found)
