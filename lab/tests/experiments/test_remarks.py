"""Faults that the remarks name: what counts as named, what the shares are shares of, and one real master."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from rumu.errors import CalibrationError
from rumu.values import Remark
from rumu_lab.experiments import remarks
from rumu_lab.experiments.remarks import ANSWERS, FaultTrial, RemarkMaster
from rumu_lab.simulation.faults import FAULTS, apply
from rumu_lab.simulation.glyph import Glyph


def named(fault: str, position: int | None, *, seen=False, severity=3.0, kinds=(), master="m") -> FaultTrial:
    return FaultTrial(master, seen, fault, severity, position, tuple(kinds))


@pytest.fixture(scope="module")
def cross() -> Glyph:
    """A lying stroke over a standing one."""
    mask = np.zeros((128, 128), bool)
    mask[40:52, 16:112] = True
    mask[20:116, 60:72] = True
    return Glyph(mask)


@pytest.fixture(scope="module")
def turned(cross):
    """Its lying stroke, turned."""
    return apply(cross.mask, "horizontal", severity=5, seed=1)


def along(glyph: Glyph, k: int, kind="stroke_angle") -> Remark:
    """A remark on one stroke of a glyph."""
    points = glyph.strokes[k].points[:, ::-1] / np.array(glyph.mask.shape)
    line = tuple((float(x), float(y)) for x, y in points)
    return Remark(kind, 1.0, "degrees", 3.0, None, "橫", "A horizontal.", (line,))


def test_every_fault_of_the_simulation_has_its_answer():
    assert set(ANSWERS) == set(FAULTS)


def test_a_remark_must_speak_of_the_stroke_that_was_struck(cross, turned):
    (struck,) = turned.strokes
    other = next(k for k in range(len(cross.strokes)) if k != struck)
    assert remarks.speaks_of(along(cross, struck), turned, cross)
    assert not remarks.speaks_of(along(cross, other), turned, cross)


def test_a_remark_on_the_whole_speaks_of_no_struck_stroke(cross, turned):
    whole = Remark("lean", 6.0, "degrees", 3.0, None, "歪", "It leans.")
    assert not remarks.speaks_of(whole, turned, cross)
    assert remarks.speaks_of(whole, apply(cross.mask, "lean", severity=2), cross)


def test_an_extra_stroke_is_told_where_it_is(cross):
    extra = apply(cross.mask, "extra", severity=1, seed=2)
    x0, y0, _, y1 = extra.region
    there = Remark("extra", 0.1, "of the ink", 3.0, extra.region, "多", "One too many.")
    # a box that ends where the region begins
    elsewhere = Remark("extra", 0.1, "of the ink", 3.0, (x0 - 0.1, y0, x0, y1), "多", "One too many.")
    assert remarks.speaks_of(there, extra, cross)
    assert not remarks.speaks_of(elsewhere, extra, cross)


def test_a_heavy_entry_must_be_told_at_that_end(cross):
    heavy = apply(cross.mask, "entry", severity=4, seed=1)
    (struck,) = heavy.strokes
    _, _, x1, y1 = heavy.region
    line = along(cross, struck, "entry_heavy")
    assert remarks.speaks_of(replace(line, region=heavy.region), heavy, cross)
    assert not remarks.speaks_of(replace(line, region=(x1 + 0.1, y1 + 0.1, x1 + 0.3, y1 + 0.3)), heavy, cross)


def test_what_strikes_many_strokes_may_be_told_of_all_at_once():
    from rumu.gallery.starter import starter_works
    from rumu.pipeline import surface_of

    work = next(w for w in starter_works() if w.id == "regular-ren")
    glyph = Glyph(surface_of(work.path).mask)
    blunt = apply(glyph.mask, "blunt", severity=4)
    assert len(blunt.strokes) > 1
    lines = tuple(along(glyph, k).outline[0] for k in blunt.strokes)
    assert remarks.speaks_of(replace(along(glyph, 0, "exit_blunt"), outline=lines), blunt, glyph)


def test_shares_are_of_held_out_and_of_seen_masters_apart():
    some = [named("shift", 0), named("shift", 1), named("shift", None), named("shift", None, seen=True)]
    shift = remarks.figures(some)["faults"]["shift"]
    assert shift["held_out"] == pytest.approx({"copies": 3, "told": 2 / 3, "first": 1 / 3})
    assert shift["seen"] == {"copies": 1, "told": 0.0, "first": 0.0}
    assert shift["by_severity"]["3"]["copies"] == 3


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
    assert line.split() == ["shift", "1", "100%", "0%", "0%", "of", "0"]
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
