"""lamps: an .lp from photographs with a sphere, which `reconstruct` then reads."""

from __future__ import annotations

import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.capture.lights import direction
from rumu_lab.simulation.lamps import NearLamp, render
from rumu_lab.simulation.phone import wavy_sheet

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


@pytest.mark.parametrize("sphere", ["auto", "60,50,30"])
def test_reconstruct_takes_the_lamps_of_a_sphere(rumu, photographs, tmp_path, sphere):
    """In one step as in two, with the lamps beside the result, and without the sphere."""
    (photographs / "wrong.lp").write_text("5\n" + "".join(f"{i}.png 0 0 1\n" for i in range(5)))
    out = tmp_path / "out"
    ended = rumu(
        "reconstruct", photographs, "-o", out, "--sphere", sphere, "--write", "normals,mesh", "--json"
    )
    assert ended.code == 0 and "mirror spheres show" in ended.facts["notes"][0]["en"]
    lines = (out / "lamps.lp").read_text().splitlines()
    assert lines[0] == "5"
    found = np.array([line.split()[1:] for line in lines[1:]], float)
    assert np.degrees(np.arccos(np.clip((found * LIGHTS).sum(axis=1), -1, 1))).max() < 2
    surface = read_surface_normals(out)
    assert not surface[1][50, 60] and surface[1][10, 140]
    slope = np.array([-0.2, 0.1, 1]) / np.linalg.norm([-0.2, 0.1, 1])
    away = np.degrees(np.arccos(np.clip(surface[0][surface[1]] @ slope, -1, 1)))
    assert np.median(away) < 1.5


def read_surface_normals(folder):
    """Normals and mask of a result."""
    stored = np.asarray(tifffile.imread(folder / "normals.tif"))
    return stored, np.asarray(Image.open(folder / "mask.png")) > 127


def test_a_frame_without_its_lamp_and_too_few_of_them(rumu, photographs, tmp_path):
    page = np.asarray(Image.open(photographs / "2.png")).copy()
    page[20:80, 30:90] = np.minimum(page[20:80, 30:90], 20)  # no highlight
    Image.fromarray(page).save(photographs / "2.png")
    options = ("--sphere", "auto", "--write", "normals")
    ended = rumu("reconstruct", photographs, "-o", tmp_path / "out", *options, "--json")
    assert any("no highlight is seen in 2.png" in note["en"] for note in ended.facts["notes"])
    assert [row["name"] for row in ended.facts["photographs"]] == ["0.png", "1.png", "3.png", "4.png"]
    assert (tmp_path / "out" / "lamps.lp").read_text().splitlines()[0] == "4"
    kept = ("--leave-out", "3", "--leave-out", "4.png", "--sphere", "60,50,30")
    rumu("reconstruct", photographs, "-o", tmp_path / "few", *kept).failed_with("at least 3", "got 2")
    rumu("reconstruct", photographs / "0.png", "-o", tmp_path / "x", "--sphere", "auto").failed_with("folder")
    too_small = ("--sphere", "60,50,5")
    rumu("reconstruct", photographs, "-o", tmp_path / "x", *too_small).failed_with("12 pixels or more")


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


def test_lamps_that_nothing_tells(rumu, tmp_path):
    sheet = wavy_sheet(size=(60, 60), spacing=0.25, relief=0.3, seed=5)
    folder = tmp_path / "sheet"
    folder.mkdir()
    for number, tilt in enumerate(np.radians(range(15, 375, 60))):
        slant = np.radians(38 + 3 * number)
        toward = np.array([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)])
        lamp, options = NearLamp(tuple(260 * toward), 0.9), {"spacing": 0.25, "normals": sheet.normals}
        light = render(sheet.height, sheet.albedo, lamp=lamp, **options)
        Image.fromarray(np.round(light * 65535).astype(np.uint16)).save(folder / f"{number}.png")
    out = tmp_path / "out"
    ended = rumu("reconstruct", folder, "-o", out, "--lamps-unknown", "--write", "normals", "--json")
    assert any("photographs alone" in note["en"] for note in ended.facts["notes"])
    normals, _ = read_surface_normals(out)
    off = np.degrees(np.arccos(np.clip((normals * sheet.normals).sum(axis=2), -1, 1)))
    assert off[15:-15, 15:-15].mean() < 3
    assert (out / "lamps.lp").is_file()
    for options in (
        ("--inside-out",),
        ("--lamps-unknown", "--card"),
        ("--lamps-unknown", "--sphere", "auto"),
    ):
        assert rumu("reconstruct", folder, "-o", out, *options).code == 2
