"""reconstruct --again: the record in surface.json, and a result that is made again from it."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.errors import SurfaceError
from rumu.surface.processing import read_processing


@pytest.fixture
def first(rumu, capture, tmp_path):
    """A result with settings that are not the default ones."""
    options = (
        "--solver",
        "least_squares",
        "--mm-per-pixel",
        "0.05",
        "--leave-out",
        "lamp 4",
        "--by",
        "王小明",
    )
    assert rumu("reconstruct", capture, "-o", tmp_path / "first", *options, "--write", "floats").code == 0
    return tmp_path / "first"


def test_the_record_says_who_what_and_how(first, capture):
    record = read_processing(first / "surface.json")
    assert record.made_by == "王小明" and record.version and record.made.endswith("+00:00")
    assert record.settings["solver"] == "least_squares" and record.settings["leave_out"] == ["lamp 4"]
    names = {path.rsplit("/", 1)[1] for path in record.inputs}
    assert names == {"lights.lp", "lamp 0.png", "lamp 1.png", "lamp 2.png", "lamp 3.png"}
    path = capture / "lamp 2.png"
    assert record.inputs[str(path.resolve())] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert set(record.result) == {"height", "normals", "albedo", "confidence", "mask"}


def test_a_result_is_made_again_to_the_last_bit(rumu, first, tmp_path):
    ended = rumu("reconstruct", "--again", first / "surface.json", "-o", tmp_path / "second", "--json")
    assert ended.code == 0 and ended.facts["again"]["same"] and ended.facts["unit"] == "mm"
    for name in ("height.tif", "normals.tif"):
        assert (tmp_path / "second" / name).read_bytes() == (first / name).read_bytes()
    assert not (tmp_path / "second" / "report.html").exists()
    told = rumu("reconstruct", "--again", first, "-o", tmp_path / "third").out
    assert "again: the same as the earlier result, to the last bit" in told


def test_files_that_changed_or_are_gone_are_named(rumu, first, capture, tmp_path):
    page = np.asarray(Image.open(capture / "lamp 1.png")).copy()
    page[0, 0] += 1
    Image.fromarray(page).save(capture / "lamp 1.png")
    again = ("reconstruct", "--again", first / "surface.json", "-o", tmp_path / "second")
    rumu(*again).failed_with("1 of 5 files are not what they were", "lamp 1.png")
    (capture / "lights.lp").unlink()
    rumu(*again).failed_with("not there any more", "lights.lp")
    assert not (tmp_path / "second").exists()


def test_a_capture_that_was_moved_is_found_where_it_lies_now(rumu, first, capture, tmp_path):
    there = capture.rename(tmp_path / "archive")
    gone = rumu("reconstruct", "--again", first, "-o", tmp_path / "second")
    gone.failed_with("5 of 5 files are not there any more", "rumu reconstruct FOLDER --again")
    ended = rumu("reconstruct", there, "--again", first, "-o", tmp_path / "second", "--json")
    assert ended.code == 0 and ended.facts["again"]["same"]
    assert read_processing(tmp_path / "second").settings["capture"] == str(there)
    assert rumu("reconstruct", "--again", tmp_path / "second", "-o", tmp_path / "third").code == 0


def test_a_record_of_a_lamp_file_is_moved_with_what_lies_beside_it(rumu, capture, tmp_path):
    """As of RTIBuilder's folders: the file of lamps in one, the photographs in another."""
    project = tmp_path / "project"
    (project / "assembly-files").mkdir(parents=True)
    capture.rename(project / "jpeg-exports")
    lamps = (project / "jpeg-exports" / "lights.lp").rename(project / "assembly-files" / "lights.lp")
    assert rumu("reconstruct", lamps, "-o", tmp_path / "first", "--write", "floats").code == 0
    project.rename(tmp_path / "moved")
    for number, place in enumerate(("moved/assembly-files", "moved/assembly-files/lights.lp")):
        again = (
            "reconstruct",
            tmp_path / place,
            "--again",
            tmp_path / "first",
            "-o",
            tmp_path / f"out{number}",
        )
        assert rumu(*again, "--json").facts["again"]["same"]


def test_another_result_is_told_by_how_much(rumu, first, tmp_path):
    """A record whose result is another one, as of an earlier version that solved otherwise."""
    marker = first / "surface.json"
    told = json.loads(marker.read_text(encoding="utf-8"))
    told["processing"]["settings"]["solver"] = "trimmed"
    told["processing"]["result"]["height"] = "0" * 64
    told["processing"]["version"] = "0.0.1"
    marker.write_text(json.dumps(told), encoding="utf-8")
    facts = rumu("reconstruct", "--again", marker, "-o", tmp_path / "second", "--json").facts["again"]
    assert not facts["same"] and "height" in facts["differs"] and facts["versions"][0] == "0.0.1"
    assert 0 <= facts["largest"]["height"] < 1
    assert "not the same" in rumu("reconstruct", "--again", marker, "-o", tmp_path / "third").out


def test_what_does_not_go_together(rumu, first, capture, tmp_path):
    second = tmp_path / "second"
    assert rumu("reconstruct", "--again", first, "-o", second, "--solver", "l1").code == 2
    assert rumu("reconstruct", "--again", first, "-o", first).code == 2
    assert rumu("reconstruct", "-o", second).code == 2
    assert not second.exists()


@pytest.mark.parametrize("damage", [{"processing": None}, {"processing": {"inputs": 3}}, []])
def test_a_folder_without_a_record_says_so(rumu, first, tmp_path, damage):
    marker = first / "surface.json"
    told = json.loads(marker.read_text(encoding="utf-8"))
    marker.write_text(json.dumps({**told, **damage} if isinstance(damage, dict) else damage))
    with pytest.raises(SurfaceError, match="expected a record"):
        read_processing(marker)
    rumu("reconstruct", "--again", marker, "-o", tmp_path / "x").failed_with("surface.json", "processing")


def test_how_the_height_was_made_is_recorded_and_repeated(rumu, capture, tmp_path):
    options = ("--integrator", "bilateral", "--focal-length", "900", "--level", "bow", "--encoding", "srgb")
    made, plain = tmp_path / "made", tmp_path / "plain"
    assert rumu("reconstruct", capture, "-o", made, *options, "--write", "floats").code == 0
    assert rumu("reconstruct", capture, "-o", plain, "--write", "floats").code == 0
    settings = read_processing(made).settings
    told = {name: settings[name] for name in ("integrator", "focal_length", "level", "encoding")}
    assert told == {"integrator": "bilateral", "focal_length": 900.0, "level": "bow", "encoding": "srgb"}
    again = rumu("reconstruct", "--again", made, "-o", tmp_path / "again", "--json")
    assert again.code == 0 and again.facts["again"]["same"]
    assert (made / "height.tif").read_bytes() != (plain / "height.tif").read_bytes()
    refused = rumu("reconstruct", "--again", made, "-o", tmp_path / "no", "--level", "plane")
    assert refused.code == 2 and "'level': --again takes the settings of the record" in refused.err


@pytest.fixture
def near_capture(capture):
    """The same names and lamps, but photographs of a flat sheet 1.2 widths from its lamps."""
    lamps = [
        np.array(line.split()[-3:], float) for line in (capture / "lights.lp").read_text().split("\n")[1:-1]
    ]
    y, x = np.mgrid[0.5:-0.5:40j, -0.5:0.5:40j]
    for number, lamp in enumerate(lamps):
        toward = 1.2 * lamp - np.stack([x, y, np.zeros_like(x)], axis=2)
        shade = 0.5 * 1.44 * toward[..., 2] / np.linalg.norm(toward, axis=2) ** 3
        picture = Image.fromarray(np.round(np.clip(shade, 0, 1) * 65535).astype(np.uint16))
        picture.save(capture / f"lamp {number}.png")
    return capture


def test_lamps_that_are_near_are_placed_and_the_record_repeats_it(rumu, near_capture, tmp_path):
    made = rumu(
        "reconstruct", near_capture, "-o", tmp_path / "made", "--near-lamps", "--write", "floats", "--json"
    )
    assert made.code == 0 and "by the photographs the lamps stand" in made.facts["notes"][0]["en"]
    normals = tifffile.imread(tmp_path / "made" / "normals.tif")
    assert np.degrees(np.arccos(normals[..., 2].clip(-1, 1))).mean() < 1.5  # of flat paper
    assert read_processing(tmp_path / "made").settings["near_lamps"] is True
    again = rumu("reconstruct", "--again", tmp_path / "made", "-o", tmp_path / "again", "--json")
    assert again.facts["again"]["same"]


def test_lamps_that_the_card_places_are_not_placed_again(rumu, near_capture, tmp_path):
    ended = rumu("reconstruct", near_capture, "-o", tmp_path / "out", "--near-lamps", "--card")
    assert ended.code == 2 and "'--near-lamps'" in ended.err


def test_a_focal_length_of_no_camera_is_refused(rumu, capture, tmp_path):
    rumu("reconstruct", capture, "-o", tmp_path / "out", "--focal-length", "3").failed_with(
        "focal length in pixels"
    )


def test_a_record_of_before_these_settings_is_made_again(rumu, first, tmp_path):
    path = first / "surface.json"
    content = json.loads(path.read_text())
    for name in ("focal_length", "level"):
        del content["processing"]["settings"][name]
    path.write_text(json.dumps(content))
    assert rumu("reconstruct", "--again", path, "-o", tmp_path / "second", "--json").facts["again"]["same"]
