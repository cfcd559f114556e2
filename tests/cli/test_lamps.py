"""lamps: an .lp from photographs with a sphere, which `reconstruct` then reads."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.capture.lights import direction

LIGHTS = [direction(tilt=72 * i, slant=40) for i in range(5)]


@pytest.fixture
def photographs(tmp_path):
    """Five photographs of a slope of paper beside a mirror ball at 60, 50 of radius 30."""
    folder = tmp_path / "photographs"
    folder.mkdir()
    rows, columns = np.mgrid[:100, :160]
    x, y = (columns - 60) / 30, -(rows - 50) / 30
    z = np.sqrt(np.clip(1 - x * x - y * y, 0, 1))
    mirrored = np.stack([2 * z * x, 2 * z * y, 2 * z * z - 1], axis=-1)
    slope = np.array([-0.2, 0.1, 1]) / np.linalg.norm([-0.2, 0.1, 1])
    for number, light in enumerate(LIGHTS):
        ball = 0.03 + np.exp(-((1 - mirrored @ light) / 0.01))
        image = np.where(x * x + y * y < 1, ball, 0.6 * (slope @ light))
        Image.fromarray(np.round(image.clip(0, 1) * 255).astype(np.uint8)).save(folder / f"{number}.png")
    return folder


@pytest.mark.parametrize("options", [[], ["--sphere", "auto"], ["--sphere", "60,50,30"]])
def test_lamps_are_written_and_read(rumu, photographs, tmp_path, options):
    ended = rumu("lamps", photographs, *options, "--json")
    assert ended.code == 0 and ended.facts["left_out"] == []
    found = np.array([lamp["direction"] for lamp in ended.facts["lamps"]])
    assert np.degrees(np.arccos((found * LIGHTS).sum(axis=1))).max() < 2
    (sphere,) = ended.facts["spheres"]
    assert (sphere["x"], sphere["y"], sphere["radius"]) == pytest.approx((60, 50, 30), abs=0.6)
    assert (photographs / "lamps.lp").read_text().splitlines()[0] == "5"
    assert rumu("reconstruct", photographs, "-o", tmp_path / "out", "--write", "normals", "--json").code == 0


def test_lamps_says_what_it_found(rumu, photographs, tmp_path):
    ended = rumu("lamps", photographs, "-o", tmp_path / "mine.lp")
    assert ended.code == 0 and "5 lamps" in ended.out and "sphere at 60" in ended.out
    assert "0.png: tilt" in ended.out and "slant 4" in ended.out


def test_a_list_of_lamps_is_not_written_over_by_chance(rumu, photographs):
    (photographs / "lamps.lp").write_text("mine")
    rumu("lamps", photographs).failed_with("lamps.lp", "is there already")
    assert (photographs / "lamps.lp").read_text() == "mine"
    assert rumu("lamps", photographs, "-o", photographs / "lamps.lp").code == 0


@pytest.mark.parametrize("sphere", ["ball", "1,2", "1,2,3,4", "1..2,3,4"])
def test_a_sphere_that_is_none_is_wrong_usage(rumu, photographs, sphere):
    assert rumu("lamps", photographs, "--sphere", sphere).code == 2


def test_photographs_without_a_sphere_and_a_folder_without_photographs(rumu, capture, tmp_path):
    rumu("lamps", capture).failed_with("expected a mirror sphere")
    (tmp_path / "none").mkdir()
    rumu("lamps", tmp_path / "none").failed_with("none", "expected photographs")
