"""rti: a capture as a .ptm, a .rti or planes, which `relight` then shows."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.capture.lights import direction
from rumu.capture.stored import to_srgb


@pytest.fixture
def dome(tmp_path):
    """Twelve photographs of a slope, bright toward the right."""
    folder = tmp_path / "dome"
    folder.mkdir()
    slope = np.array([0.4, 0.0, 1]) / np.linalg.norm([0.4, 0.0, 1])
    lights = [direction(tilt=137.5 * i, slant=10 + 5 * i) for i in range(12)]
    lines = ["12"]
    for number, light in enumerate(lights):
        level = round(max(0.0, 0.8 * float(slope @ light)) * 255)
        page = np.full((20, 24), level, np.uint8)
        page[:, :8] = level // 4  # a stripe of ink
        page[0] = number  # no two photographs are the same
        Image.fromarray(page).save(folder / f"{number}.png")
        lines.append(f"{number}.png {light[0]:.6f} {light[1]:.6f} {light[2]:.6f}")
    (folder / "lights.lp").write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.parametrize(
    ("arguments", "terms"),
    [
        (["a.ptm"], 6),
        (["a.PTM", "--channels", "rgb"], 6),
        (["a.rti"], 9),
        (["a.rti", "--order", "1"], 4),
        (["planes"], 6),
        (["planes", "--basis", "hsh", "--mm-per-pixel", "0.1"], 9),
    ],
)
def test_a_relightable_image_is_written_and_shown(rumu, dome, tmp_path, arguments, terms):
    name, *options = arguments
    ended = rumu("rti", dome, "-o", tmp_path / name, *options, "--json")
    facts = ended.facts
    assert (ended.code, facts["terms"], facts["shape"], facts["lamps"]) == (0, terms, [20, 24], 12)
    assert facts["residual"] < 0.06
    shown = {}
    for tilt in (0, 180):
        target = tmp_path / f"{tilt}.png"
        assert rumu("relight", tmp_path / name, "--tilt", tilt, "--slant", 45, "-o", target).code == 0
        shown[tilt] = np.asarray(Image.open(target)).astype(float)
    assert shown[0][10, 16].mean() > shown[180][10, 16].mean() + 20
    assert shown[0][10, 3].mean() < 0.7 * shown[0][10, 16].mean()


def test_rti_says_what_it_wrote_and_leaves_out(rumu, dome, tmp_path):
    ended = rumu("rti", dome, "-o", tmp_path / "a.ptm", "--leave-out", "3")
    assert ended.code == 0 and "polynomial of 6 terms" in ended.out and "11 photographs" in ended.out


@pytest.mark.parametrize(
    "wrong", [["a.ptm", "--basis", "hsh"], ["a.rti", "--channels", "lrgb"], ["a", "--order", "4"]]
)
def test_what_does_not_go_together_is_wrong_usage(rumu, dome, tmp_path, wrong):
    name, *options = wrong
    assert rumu("rti", dome, "-o", tmp_path / name, *options).code == 2
    assert not (tmp_path / name).exists()


def test_too_few_photographs_and_broken_files(rumu, capture, dome, tmp_path):
    rumu("rti", capture, "-o", tmp_path / "a.ptm").failed_with("at least 6 photographs", "got 5")
    assert not (tmp_path / "a.ptm").exists()
    (tmp_path / "b.ptm").write_text("PTM_1.2\n")
    rumu("relight", tmp_path / "b.ptm", "--tilt", 0, "--slant", 45).failed_with("b.ptm", "header")


def test_photographs_for_a_screen_that_are_read_as_light_are_told_of(rumu, dome, tmp_path):
    """Their picture would be brightened twice."""
    assert rumu("rti", dome, "-o", tmp_path / "a.ptm", "--json").facts["notes"] == []
    for path in dome.glob("*.png"):
        light = np.asarray(Image.open(path)) / 255
        Image.fromarray(np.round(to_srgb(light) * 255).astype(np.uint8)).save(path)
    (note,) = rumu("rti", dome, "-o", tmp_path / "b.ptm", "--json").facts["notes"]
    assert '"encoding": "srgb"' in note["en"]
