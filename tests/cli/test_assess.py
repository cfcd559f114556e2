"""assess, one pair: the mark, the page, and everything that can be wrong with a pair."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

KEYS = {
    "copy",
    "reference",
    "score",
    "level",
    "percentile",
    "interval",
    "sim_paper",
    "similarity",
    "parts",
    "deductions",
    "remarks",
} | {
    "pose",
    "praise",
    "source",
    "refused",
    "refused_zh",
    "turned_by",
    "report",
    "interval_note",
    "interval_note_zh",
    "script",
    "character",
    "weights",
    "calibration",
}


def test_a_copy_is_marked(rumu, desk):
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json")
    facts = ended.facts
    assert (ended.code, ended.err, set(facts)) == (0, "", KEYS)
    low, high = facts["interval"]
    assert 0 <= low <= facts["score"] <= high <= 100
    assert facts["level"] in ("excellent", "good", "medium", "bad")
    assert set(facts["parts"]) == {"brushwork", "structure", "ink"}
    assert facts["source"] == ["inflation", "inflation"] and facts["refused"] is None
    assert facts["character"] is None or len(facts["character"]) == 1


def test_the_master_itself_beats_a_crooked_copy_and_that_a_half_one(rumu, desk):
    scores = [
        rumu("assess", desk / name, "--reference", desk / "master.png", "--json").facts["score"]
        for name in ("master.png", "copy.png", "half.png")
    ]
    assert scores[0] > scores[1] > scores[2]


def test_for_people(rumu, desk):
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "master.png")
    assert ended.code == 0
    assert "of 100" in ended.out and "brushwork" in ended.out and "not measured relief" in ended.out


def test_a_page_is_written(rumu, desk):
    target = desk / "mark.html"
    ended = rumu(
        "assess", desk / "copy.png", "--reference", desk / "master.png", "--report", target, "--json"
    )
    page = target.read_text(encoding="utf-8")
    assert ended.facts["report"] == str(target)
    assert page.count("data:image/") >= 7 and "http" not in page
    assert f">{ended.facts['score']:.0f} <small>" in page


def test_the_master_may_be_a_starter_work(rumu, tmp_path):
    rumu("gallery", "show", "regular-shui", "-o", tmp_path / "shui.png")
    facts = rumu("assess", tmp_path / "shui.png", "--reference", "regular-shui", "--json").facts
    assert facts["level"] == "excellent" and facts["reference"] == "regular-shui"


def test_a_surface_folder_may_be_compared(rumu, desk):
    rumu("relief", desk / "master.png", "-o", desk / "out")
    facts = rumu("assess", desk / "copy.png", "--reference", desk / "out", "--json").facts
    straight = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json").facts
    assert facts["score"] == pytest.approx(straight["score"], abs=1)


@pytest.mark.parametrize("kind", ["blank", "black", "noise"])
def test_a_copy_that_holds_nothing_is_refused_with_a_reason_and_a_page(rumu, desk, kind):
    page = {"blank": np.full((160, 160), 250), "black": np.full((160, 160), 4)}.get(kind)
    if page is None:
        page = np.random.default_rng(7).integers(0, 256, (160, 160))
    Image.fromarray(page.astype(np.uint8)).save(desk / "nothing.png")
    target = desk / "mark.html"
    ended = rumu(
        "assess", desk / "nothing.png", "--reference", desk / "master.png", "--report", target, "--json"
    )
    ended.failed_with("nothing.png")
    facts = ended.facts
    assert facts["score"] is None and facts["level"] is None and facts["refused"]
    assert "This copy was not marked" in target.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["empty.png", "cut.png", "words.png", "gone.png"])
@pytest.mark.parametrize("role", ["copy", "reference"])
def test_a_file_that_is_no_picture(rumu, desk, name, role):
    copy, master = ("master.png", name) if role == "reference" else (name, "master.png")
    target = desk / "mark.html"
    ended = rumu("assess", desk / copy, "--reference", desk / master, "--report", target, "--json")
    ended.failed_with(name)
    assert "error" in ended.facts
    assert not target.exists()


def test_a_blank_master_is_an_error(rumu, desk):
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "blank.png", "--json")
    ended.failed_with("blank.png")


def test_a_master_that_is_neither_file_nor_work(rumu, desk):
    ended = rumu("assess", desk / "copy.png", "--reference", "regular-shiu")
    ended.failed_with("regular-shiu", "did you mean", "regular-shui")


@pytest.mark.parametrize("place", ["{desk}/file.txt/mark.html", "/proc/mark.html", "{desk}"])
def test_a_page_that_cannot_be_written(rumu, desk, place):
    place = place.format(desk=desk)
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--report", place)
    ended.failed_with(place)


def test_levels_are_a_teacher_s_choice(rumu, desk):
    (desk / "strict.json").write_text(json.dumps({"excellent": 100, "good": 99.9, "medium": 99.8}))
    (desk / "kind.json").write_text(json.dumps({"excellent": 1, "good": 0.9, "medium": 0.8}))
    told = {
        name: rumu(
            *("assess", desk / "copy.png", "--reference", desk / "master.png", "--json"),
            *("--levels", desk / f"{name}.json"),
        ).facts
        for name in ("strict", "kind")
    }
    assert told["strict"]["score"] == told["kind"]["score"]
    assert (told["strict"]["level"], told["kind"]["level"]) == ("bad", "excellent")


@pytest.mark.parametrize("name", ["panel", "rubric"])
def test_named_levels(rumu, desk, name):
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png")
    assert rumu(*pair, "--levels", name).code == 0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "cannot read"),
        ("[]", "expected a JSON object"),
        ('{"excellent": 80, "good": 60}', "100 >= excellent > good > medium >= 0"),
        ('{"excellent": 60, "good": 80, "medium": 40}', "excellent > good > medium"),
        ('{"excellent": "a", "good": 60, "medium": 40}', "excellent > good > medium"),
        ('{"excellent": NaN, "good": 60, "medium": 40}', "excellent > good > medium"),
    ],
)
def test_levels_that_are_none(rumu, desk, content, words):
    (desk / "mine.json").write_text(content)
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png")
    rumu(*pair, "--levels", desk / "mine.json").failed_with("mine.json", words)


def test_an_unknown_set_of_levels_names_the_known_ones(rumu, desk):
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png")
    rumu(*pair, "--levels", "harsh").failed_with("harsh", "panel", "rubric")
    rumu(*pair, "--levels", desk / "gone.json").failed_with("gone.json", "no such file")


# weights, script, calibration


def told(rumu, desk, *options: object) -> dict:
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png", "--json")
    return rumu(*pair, *options).facts


@pytest.mark.parametrize("by", ["words", "file"])
def test_a_teacher_weighs_the_parts(rumu, desk, by):
    (desk / "mine.json").write_text('{"ink": 3, "brushwork": 0, "structure": 1}')
    weights = desk / "mine.json" if by == "file" else " structure=1, ink=3,brushwork=0"
    facts = told(rumu, desk, "--weights", weights)
    parts = facts["parts"]
    assert facts["weights"] == {"brushwork": 0, "structure": 1, "ink": 3}
    assert facts["score"] == pytest.approx((parts["structure"] + 3 * parts["ink"]) / 4)
    assert facts["score"] != pytest.approx(told(rumu, desk)["score"], abs=0.1)
    assert "only a guide" in facts["interval_note"] and "僅供參考" in facts["interval_note_zh"]


@pytest.mark.parametrize(
    "weights",
    [
        "brushwork=50",
        "brushwork=50,structure=50,ink=0,taste=3",
        "brushwork=50,structure=50,ink=-1",
        "brushwork=0,structure=0,ink=0",
        "brushwork=much,structure=50,ink=0",
        "brushwork=nan,structure=50,ink=0",
        "brushwork=inf,structure=50,ink=0",
        "brushwork=1,structure=50,ink=0,ink=5",
        "equal",
        "",
    ],
)
def test_weights_that_are_none(rumu, desk, weights):
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png")
    rumu(*pair, "--weights", weights).failed_with("weights", "brushwork", "structure", "ink")


def test_the_interval_by_script(rumu, desk):
    (low, high), note = told(rumu, desk, "--script", "regular")["interval"], None
    seal, unknown = told(rumu, desk, "--script", "seal"), told(rumu, desk)
    assert told(rumu, desk, "--script", "regular")["interval_note"] is note
    assert unknown["interval"] == [low, high] and "regular script" in unknown["interval_note"]
    wide_low, wide_high = seal["interval"]
    assert wide_low < low < high <= wide_high
    assert (seal["script"], seal["score"]) == ("seal", unknown["score"])
    assert "1.5 times" in seal["interval_note"] and "1.5 倍" in seal["interval_note_zh"]
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--script", "seal")
    assert seal["interval_note"] in ended.out and seal["interval_note_zh"] in ended.out


def test_a_starter_work_knows_its_script(rumu, tmp_path):
    rumu("gallery", "show", "clerical-ren", "-o", tmp_path / "ren.png")
    pair = ("assess", tmp_path / "ren.png", "--reference", "clerical-ren", "--json")
    assert "clerical script" in rumu(*pair).facts["interval_note"]
    assert rumu(*pair, "--script", "regular").facts["interval_note"] is None


def test_another_calibration_is_used_and_named(rumu, desk):
    from dataclasses import replace

    from rumu.assessment.calibration import panel, write_calibration

    scale = replace(panel().scale, anchors=((0.0, 0.0), (1e-6, 99.0), (200.0, 100.0)))
    kind = replace(panel(), scale=scale, interval=(-5.0, 5.0), provenance="marks of a kind teacher")
    write_calibration(kind, desk / "kind.json")
    facts = told(rumu, desk, "--calibration", desk / "kind.json", "--script", "seal")
    low, high = facts["interval"]
    assert facts["score"] > told(rumu, desk)["score"] + 5
    assert facts["score"] - low == pytest.approx(5) and high <= facts["score"] + 5
    assert facts["calibration"] == "marks of a kind teacher"
    page = desk / "mark.html"
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png", "--report", page)
    ended = rumu(*pair, "--calibration", desk / "kind.json")
    assert "marks of a kind teacher" in ended.out and "marks of a kind teacher" in page.read_text("utf-8")


@pytest.mark.parametrize(("content", "words"), [("{", "cannot read"), ("[]", "scale"), ("{}", "interval")])
def test_a_calibration_that_is_none(rumu, desk, content, words):
    (desk / "mine.json").write_text(content)
    pair = ("assess", desk / "copy.png", "--reference", desk / "master.png")
    rumu(*pair, "--calibration", desk / "mine.json").failed_with("mine.json", "expected a calibration", words)
    rumu(*pair, "--calibration", desk / "gone.json").failed_with("gone.json", "no such file")


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("copy.png",),
        ("copy.png", "--reference", "master.png", "--script", "printed"),
        ("copy.png", "--reference", "master.png", "-o", "x.csv"),
        ("copy.png", "--reference", "master.png", "--jobs", "2"),
        ("--pairs", "pairs.csv"),
        ("copy.png", "--pairs", "pairs.csv", "-o", "x.csv"),
        ("--pairs", "pairs.csv", "-o", "pairs.csv"),
        ("--pairs", "pairs.csv", "-o", "x.csv", "--jobs", "0"),
        ("copy.png", "--reference", "master.png", "--report", "master.png"),
        ("copy.png", "--reference", "master.png", "--report", "copy.png"),
    ],
)
def test_wrong_usage(rumu, desk, monkeypatch, arguments):
    monkeypatch.chdir(desk)
    (desk / "pairs.csv").write_text("copy,reference\ncopy.png,master.png\n")
    before = {path.name: path.read_bytes() for path in desk.iterdir()}
    ended = rumu("assess", *arguments)
    assert ended.code == 2 and ended.out == "" and ended.err
    assert {path.name: path.read_bytes() for path in desk.iterdir()} == before


@pytest.mark.parametrize("number", range(4))
def test_the_level_is_the_same_here_and_on_the_page(rumu, number):
    """Two doors, one mark: what the command line says of a copy is what the service says of it."""
    from rumu import pipeline
    from rumu.gallery.starter import find_work, starter_samples
    from rumu.studio.marking import mark_copy

    work, sample = find_work("regular-tian"), starter_samples(work="regular-tian")[number]
    here = rumu("assess", sample.path, "--reference", work.path, "--script", "regular", "--json").facts
    master = pipeline.prepare_master(work.path)
    page = mark_copy(sample.path.read_bytes(), master, script="regular", calibration=None).facts
    assert page["level"] == here["level"]
    assert page["score"] == pytest.approx(here["score"], abs=0.3)
    assert page["percentile"] == pytest.approx(here["percentile"], abs=1.0)


def test_what_a_small_copy_in_a_large_picture_loses_is_told(rumu, desk, tmp_path):
    whole = np.asarray(Image.open(desk / "master.png").convert("L"))
    side = max(whole.shape)
    page = np.full((3 * side, 3 * side), 255, np.uint8)
    page[side : side + whole.shape[0], side : side + whole.shape[1]] = whole
    Image.fromarray(page).save(tmp_path / "loose.png")
    pair = ("assess", tmp_path / "loose.png", "--reference", desk / "master.png")
    facts = rumu(*pair, "--json").facts
    assert facts["deductions"]["size"] > 10
    ended = rumu(*pair)
    assert "points for its size" in ended.out and "大小" in ended.out
    assert not rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json").facts[
        "deductions"
    ]
