"""calibrate: marks in, a calibration or a plain no out; whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rumu.assessment.calibration import load_calibration, panel
from rumu.assessment.features import RESIDUALS, Features, Residuals
from rumu.cli.calibrate import MarkedRow, MeasuredRow, measure_row, read_marks
from rumu.errors import CalibrationError

HEADER = "image,reference,mark"
COMMON = np.array([0.2, 0.14, 0.18, 0.2, 0.12, 0.18, 0.26, 0.22, 0.28, 0.3, 0.17, 0.15, 0.09, 0.28])
"""What registration commonly leaves, in the order of RESIDUALS."""


def table(desk: Path, *rows: str, header: str = HEADER) -> Path:
    path = desk / "marks.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def made_up(k: int) -> Features:
    """Copy k, better and worse; its number is its quality's seed."""
    rng = np.random.default_rng(k)
    size = COMMON * np.exp(0.2 * rng.normal() + 0.05 * rng.normal(size=len(RESIDUALS)))
    return Features(Residuals(*size), lean=0.0, offset=0.0, size=0.0, weight=0.0)


def made_up_row(row: MarkedRow, *, root: Path) -> MeasuredRow:
    if "bad" in row.image:
        return MeasuredRow(None, refused="blank: nothing is written in the picture")
    return MeasuredRow(made_up(int(Path(row.image).stem)), str(root / row.reference))


@pytest.fixture
def unseen(monkeypatch):
    """Copies that need no pictures: what is tested is what becomes of their marks."""
    monkeypatch.setattr("rumu.cli.calibrate.measure_row", made_up_row)


def strict(n: int, *, masters: int = 4) -> list[str]:
    marks = np.clip([panel().score(made_up(k)) - 20 for k in range(n)], 0, 100)
    return [f"{k}.png,m{k % masters}.png,{mark:.1f}" for k, mark in enumerate(marks)]


# what comes of marks


def test_a_strict_teacher_is_followed_and_a_copy_is_marked_so(rumu, desk, unseen):
    marks = table(desk, *strict(60), "bad.png,m0.png,50")
    ended = rumu("calibrate", marks, "-o", desk / "mine.json", "--jobs", 1, "--json")
    facts = ended.facts
    assert (ended.code, ended.err) == (0, "")
    assert {name: facts[name] for name in ("kept", "marks", "masters", "held_out", "weights")} == {
        "kept": "scale",
        "marks": 60,
        "masters": 4,
        "held_out": "masters",
        "weights": None,
    }
    assert facts["scale"]["error"] < 0.5 * facts["default"]["error"]
    assert facts["left_out"] == [
        {
            "line": 62,
            "image": "bad.png",
            "reference": "m0.png",
            "refused": "blank: nothing is written in the picture",
        }
    ]
    own = load_calibration(desk / "mine.json")
    assert own.provenance == facts["provenance"] and "marks.csv" in own.provenance
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png", "--json")
    before, after = rumu(*pair).facts, rumu(*pair, "--calibration", desk / "mine.json").facts
    assert before["score"] - 25 < after["score"] < before["score"] - 5
    assert after["calibration"] == own.provenance and before["calibration"] is None


def test_for_people(rumu, desk, unseen):
    ended = rumu("calibrate", table(desk, *strict(40)), "-o", desk / "mine.json", "--jobs", 1)
    for words in (
        "40 marks of copies of 4 masters",
        "whole masters held out",
        "default",
        "<- kept",
        "誤差",
        "% of the marks lie",
    ):
        assert words in ended.out
    assert f"--calibration {desk / 'mine.json'}" in ended.out


@pytest.mark.parametrize("n", [1, 19])
def test_few_marks_write_nothing_and_say_so(rumu, desk, unseen, n):
    before = sorted(desk.iterdir())
    ended = rumu("calibrate", table(desk, *strict(n)), "-o", desk / "mine.json", "--jobs", 1, "--json")
    assert (ended.code, ended.facts["kept"], ended.facts["out"]) == (0, "default", None)
    assert f"{n} marks are too few" in ended.facts["why"] and "太" not in ended.facts["why"]
    assert sorted(desk.iterdir()) == sorted([*before, desk / "marks.csv"])
    told = rumu("calibrate", desk / "marks.csv", "-o", desk / "mine.json", "--jobs", 1)
    assert told.code == 0 and "nothing was written" in told.out and "保留默認" in told.out


def test_an_earlier_calibration_outlives_a_later_no(rumu, desk, unseen):
    (desk / "mine.json").write_text("an earlier one")
    rumu("calibrate", table(desk, *strict(5)), "-o", desk / "mine.json", "--jobs", 1)
    assert (desk / "mine.json").read_text() == "an earlier one"


def test_when_no_copy_can_be_measured(rumu, desk, unseen):
    marks = table(desk, "bad.png,m.png,50", "bad2.png,m.png,60")
    ended = rumu("calibrate", marks, "-o", desk / "mine.json", "--jobs", 1, "--json")
    ended.failed_with("no copy of the 2", "nothing is written in the picture")
    assert ended.facts["marks"] == 0 and len(ended.facts["left_out"]) == 2


# pictures


def test_pictures_are_measured_as_for_a_mark(rumu, desk):
    """Real pictures in two processes: a few rows, of which some are none."""
    marks = table(
        desk,
        "copy.png,master.png,60",
        f"{desk / 'a copy.png'},master.png,70",
        "blank.png,master.png,0",
        "gone.png,master.png,50",
        "copy.png,nowhere,50",
        "master.png,./master.png,100",
    )
    facts = rumu("calibrate", marks, "-o", desk / "mine.json", "--jobs", 2, "--json").facts
    assert (facts["marks"], facts["masters"], facts["kept"]) == (3, 1, "default")
    assert [row["line"] for row in facts["left_out"]] == [4, 5, 6]
    assert "gone.png" in facts["left_out"][1]["refused"] and "nowhere" in facts["left_out"][2]["refused"]


def test_each_mark_stays_with_its_copy_in_whatever_order_masters_come(rumu, desk, unseen):
    rows = strict(60)
    told = []
    for order in (rows, sorted(rows, key=lambda row: row.split(",")[1])):
        rumu("calibrate", table(desk, *order), "-o", desk / "mine.json", "--jobs", 1)
        told.append(load_calibration(desk / "mine.json").scale)
    assert np.array(told[0].anchors) == pytest.approx(np.array(told[1].anchors))


def test_features_are_those_of_the_mark(rumu, desk):
    looked = measure_row(MarkedRow("copy.png", "master.png", 50.0, 2), root=desk)
    facts = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json").facts
    assert panel().score(looked.features) == pytest.approx(facts["score"])
    assert looked.master == str((desk / "master.png").resolve())


def test_a_row_survives_a_fault_of_ours(monkeypatch, desk):
    def stumble(*_args, **_kwargs):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr("rumu.pipeline.surface_of", stumble)
    looked = measure_row(MarkedRow("copy.png", "half.png", 50.0, 2), root=desk)
    assert looked.features is None and looked.refused == "unexpected ZeroDivisionError: division by zero"


# tables


def test_a_table_from_a_spreadsheet(desk):
    path = desk / "marks.csv"
    path.write_bytes(b"\xef\xbb\xbfpupil, image ,mark,reference\r\nLi,a copy.png, 71.5 ,m.png\r\n\r\n")
    assert read_marks(path)[1] == [MarkedRow("a copy.png", "m.png", 71.5, 2)]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("a.png,m.png,101", "line 3: expected a mark from 0 to 100, got '101'"),
        ("a.png,m.png,-1", "line 3: expected a mark from 0 to 100, got '-1'"),
        ("a.png,m.png,good", "line 3: expected a mark from 0 to 100, got 'good'"),
        ("a.png,m.png,nan", "line 3: expected a mark from 0 to 100, got 'nan'"),
        ("a.png,m.png,", "line 3: expected a mark from 0 to 100, got 'nothing'"),
        ("a.png,m.png", "line 3: expected a mark from 0 to 100, got 'nothing'"),
        (",m.png,50", "line 3: expected an image and a reference"),
        ("a.png,,50", "line 3: expected an image and a reference"),
    ],
)
def test_a_row_that_is_none_is_named(rumu, desk, row, words):
    marks = table(desk, "b.png,m.png,50", row)
    rumu("calibrate", marks, "-o", desk / "mine.json").failed_with("marks.csv", words)
    assert not (desk / "mine.json").exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("expected the columns image,reference,mark", "found nothing")),
        (b"copy,reference,mark\na,b,1\n", ("expected the columns image,reference,mark", "copy, reference")),
        (b"image,reference,mark\n", ("at least one row",)),
        (b"image,reference,mark\n\xff\xfe\x00,b,1\n", ("UTF-8",)),
    ],
)
def test_a_table_that_is_none(desk, content, words):
    (desk / "marks.csv").write_bytes(content)
    with pytest.raises(CalibrationError) as caught:
        read_marks(desk / "marks.csv")
    assert all(word in str(caught.value) for word in ("marks.csv", *words))


def test_a_table_that_is_not_there(rumu, desk):
    rumu("calibrate", desk / "gone.csv", "-o", desk / "mine.json").failed_with("gone.csv", "No such file")


@pytest.mark.parametrize("place", ["{desk}/file.txt/mine.json", "/proc/mine.json", "{desk}"])
def test_a_place_that_cannot_be_written_is_told_before_the_work(rumu, desk, monkeypatch, place):
    monkeypatch.setattr("rumu.cli.calibrate.measure_row", lambda *a, **k: pytest.fail("measured in vain"))
    place = place.format(desk=desk)
    rumu("calibrate", table(desk, *strict(3)), "-o", place, "--jobs", 1).failed_with(place)


def test_wrong_usage(rumu, desk):
    marks = table(desk, *strict(3))
    before = marks.read_bytes()
    for arguments in ((marks,), (marks, "-o", marks), (marks, "-o", desk / "x.json", "--jobs", 0), ()):
        assert rumu("calibrate", *arguments).code == 2
    assert marks.read_bytes() == before


def test_an_interrupted_run_leaves_nothing(rumu, desk, monkeypatch):
    def interrupt(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("rumu.cli.calibrate.measure_row", interrupt)
    marks = table(desk, *strict(3))
    before = sorted(desk.iterdir())
    assert rumu("calibrate", marks, "-o", desk / "mine.json", "--jobs", 1).code == 130
    assert sorted(desk.iterdir()) == before


def test_what_is_written_is_what_ships_in_form(rumu, desk, unseen):
    rumu("calibrate", table(desk, *strict(40)), "-o", desk / "mine.json", "--jobs", 1)
    from rumu.assessment import calibration

    shipped = json.loads((Path(calibration.__file__).parent / "panel.json").read_text("utf-8"))
    assert json.loads((desk / "mine.json").read_text("utf-8")).keys() == shipped.keys()


def test_marks_of_a_spreadsheet_in_china_and_in_europe(desk):
    (desk / "marks.csv").write_bytes(
        "圖片;範本;分數\r\n張三.png;m.png;７１,5\r\nb.png;m.png;80分\r\n".encode("cp950")
    )
    table, rows = read_marks(desk / "marks.csv")
    assert (table.encoding, table.separator) == ("Big5", ";")
    assert rows == [MarkedRow("張三.png", "m.png", 71.5, 2), MarkedRow("b.png", "m.png", 80.0, 3)]
    (desk / "marks.csv").write_bytes(b"image,reference,mark\na.png,m.png,71,5\n")
    with pytest.raises(CalibrationError, match="line 2: expected 3 cells, got 4"):
        read_marks(desk / "marks.csv")
