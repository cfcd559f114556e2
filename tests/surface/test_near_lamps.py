"""Lamps near the sheet: normals against a simulation written apart from the solver; RelightLab's .dome."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from rumu.capture.dome import read_dome, without_fall_off
from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack
from rumu.pipeline import reconstruct
from rumu.surface.folder import read_surface
from rumu.surface.near_lamps import NearSettings, shading, solve_near
from rumu.surface.photograph_table import photograph_table
from rumu.surface.solve import solve
from rumu.values import Capture
from rumu_lab.simulation.lamps import NearLamp, normals_of, render

SIDE = 160


def lamps_at(distance: float, *, count: int = 8, strength: float = 0.5) -> list[NearLamp]:
    """Lamps at slants of 45 and 35 degrees, at a distance from the middle in sheet sides."""
    found = []
    for number in range(count):
        tilt, slant = 2 * np.pi * number / count, np.radians(45 if number % 2 else 35)
        place = np.array([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)])
        found.append(NearLamp(tuple(distance * SIDE * place), strength=strength))
    return found


def relief(*, side: int = SIDE) -> np.ndarray:
    y, x = np.mgrid[:side, :side]
    return 1.0 * np.sin(x / 9.0) * np.cos(y / 11.0) + 0.6 * np.sin(x / 3.3 + y / 5)


def photographs(lamps: list[NearLamp], albedo=0.8) -> np.ndarray:
    return np.stack([render(relief(), albedo, lamp=one, cast_shadows=False) for one in lamps])


def of_simulation(distance: float, albedo=0.8) -> tuple[ImageStack, np.ndarray, np.ndarray]:
    """The photographs without fall-off, directions from the middle, positions."""
    lamps = lamps_at(distance)
    positions = np.array([one.position for one in lamps])
    stack = without_fall_off(ImageStack.of_arrays(photographs(lamps, albedo)), positions)
    return stack, np.array([one.direction for one in lamps]), positions


def angles(normals: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip((normals * normals_of(relief())).sum(axis=2), -1, 1)))


def test_flat_paper_is_evenly_bright_without_the_fall_off():
    lamps = lamps_at(1.0)
    flat = np.stack([render(np.zeros((SIDE, SIDE)), 0.8, lamp=one) for one in lamps])
    even = without_fall_off(ImageStack.of_arrays(flat), np.array([one.position for one in lamps])).floats()
    assert flat[0].max() > 3 * flat[0].min()
    spread = even.max(axis=(1, 2)) / even.min(axis=(1, 2))
    assert spread == pytest.approx(np.ones(8), abs=1e-3) and even.max() <= 1
    assert even[0].mean() / even[1].mean() == pytest.approx(
        lamps[0].direction[2] / lamps[1].direction[2], abs=0.01
    )


@pytest.mark.parametrize("solver", ["least_squares", "trimmed", "l1", "robust"])
@pytest.mark.parametrize("distance", [1.0, 2.0])
def test_normals_under_near_lamps(solver, distance):
    """Within a degree at one sheet side (relief of 2 % of it), where far lamps are wrong by up to ten."""
    stack, lights, positions = of_simulation(distance)
    mask = np.ones((SIDE, SIDE), bool)
    far = angles(solve(stack, lights, solver=solver).normals)
    near = angles(solve_near(stack, lights, positions, solver=solver, mask=mask).normals)
    assert near.mean() < 0.4 / distance and np.quantile(near, 0.99) < 1 and near.max() < 1.4
    assert near.mean() < 0.6 * far.mean() and near.max() < 0.4 * far.max()


def test_lamps_far_away_are_the_same_near_or_far():
    stack, lights, positions = of_simulation(400.0)
    mask = np.ones((SIDE, SIDE), bool)
    near = solve_near(stack, lights, positions, solver="robust", mask=mask)
    far = solve(stack, lights, solver="robust")
    assert (near.normals * far.normals).sum(axis=2).min() > np.cos(np.radians(0.1))
    assert near.residual == pytest.approx(far.residual, abs=1e-3)


def test_blocks_leave_no_seams_and_masks_and_colours_hold():
    albedo = np.dstack([np.full((SIDE, SIDE), level) for level in (0.8, 0.5, 0.3)])
    stack, lights, positions = of_simulation(1.0, albedo)
    mask = np.zeros((SIDE, SIDE), bool)
    mask[20:140, 30:150] = True
    found = {
        side: solve_near(
            stack, lights, positions, solver="least_squares", mask=mask, near=NearSettings(side=side)
        )
        for side in (16, 7)
    }
    one, other = found.values()
    assert (one.normals * other.normals).sum(axis=2)[mask].min() > np.cos(np.radians(0.05))
    assert (one.normals[~mask] == (0, 0, 1)).all() and not one.confidence[~mask].any()
    assert angles(one.normals)[mask].max() < 1.2
    ratio = one.albedo[mask].mean(axis=0)
    assert ratio / ratio[0] == pytest.approx([1, 0.5 / 0.8, 0.3 / 0.8], rel=0.01)


def test_shading_is_what_the_photographs_show():
    stack, lights, positions = of_simulation(1.0)
    capture = Capture(images=stack, lights=lights, mask=np.ones((SIDE, SIDE), bool), positions=positions)
    pixels = np.arange(0, SIDE * SIDE, 37)
    shown = shading(capture, normals_of(relief()).reshape(-1, 3)[pixels].astype(np.float32), pixels)
    ratio = (stack.at(pixels) / shown)[shown > 0.1]
    assert np.std(ratio) / np.mean(ratio) < 0.01


def dome_folder(folder, lamps: list[NearLamp], **entries) -> None:
    folder.mkdir()
    for number, image in enumerate(photographs(lamps)):
        Image.fromarray(np.round(image.clip(0, 1) * 65535).astype(np.uint16)).save(
            folder / f"shot{number}.png"
        )
    positions = [dict(zip("xyz", (0.05 * np.array(one.position)).tolist(), strict=True)) for one in lamps]
    told = {"lightConfiguration": "lights3d", "imageWidth": 0.05 * SIDE, "positions3d": positions, **entries}
    (folder / "my.dome").write_text(json.dumps(told))


def test_a_folder_with_a_dome_becomes_a_surface_in_millimetres(tmp_path):
    """Lamps at one sheet side, positions in mm at .05 mm for each pixel, all checks on."""
    dome_folder(tmp_path / "capture", lamps_at(1.0))
    capture = read_capture(tmp_path / "capture")
    assert capture.spacing == pytest.approx(0.05)
    assert capture.positions == pytest.approx(np.array([one.position for one in lamps_at(1.0)]))
    surface = reconstruct(capture)
    assert surface.unit == "mm" and angles(surface.normals).mean() < 0.4
    rows = photograph_table(capture, surface)
    assert max(row.residual for row in rows) < 0.02 and not any(row.faults for row in rows)
    short = read_capture(tmp_path / "capture", leave_out=["shot3"])
    assert len(short.positions) == 7 and short.positions[3] == pytest.approx(capture.positions[4])


def test_a_dome_that_does_not_say_how_wide_a_photograph_is(rumu, tmp_path):
    """The scale tells it; without one the lamps count as far away, which is said."""
    dome_folder(tmp_path / "capture", lamps_at(1.0), imageWidth=0)
    places = np.array([one.position for one in lamps_at(1.0)])
    scaled = read_capture(tmp_path / "capture", mm_per_pixel=0.05)
    assert scaled.positions == pytest.approx(places) and scaled.spacing == 0.05 and not scaled.notes
    far = read_capture(tmp_path / "capture")
    assert far.positions is None and far.lights == pytest.approx(places / SIDE) and far.spacing is None
    assert '"imageWidth" is 0' in far.notes[0].en and "--mm-per-pixel" in far.notes[0].zh
    options = ("-o", tmp_path / "out", "--write", "floats", "--mm-per-pixel", "0.05", "--json")
    assert rumu("reconstruct", tmp_path / "capture", *options).facts["notes"] == []
    assert angles(read_surface(tmp_path / "out").normals).mean() < 0.4


def vectors(rows, names="xyz"):
    return [dict(zip(names, row, strict=True)) for row in rows]


FOUR = [(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 2)]


def test_the_kinds_of_a_dome(tmp_path):
    def dome(**entries):
        (tmp_path / "a.dome").write_text(json.dumps(entries))
        return read_dome(tmp_path / "a.dome")

    far = dome(directions=vectors(FOUR), imageWidth=200)
    assert far.positions is None and far.width == 200 and far.strengths is None
    assert far.lights[0] == pytest.approx([0.70710678, 0, 0.70710678])
    unit = (np.array(FOUR) / np.linalg.norm(FOUR, axis=1, keepdims=True)).tolist()
    ball = {"directions": vectors(unit), "imageWidth": 200, "lightConfiguration": "spherical"}
    around = dome(**ball, domeDiameter=600, verticalOffset=10)
    assert around.positions[0] == pytest.approx([300 * 0.70710678, 0, 300 * 0.70710678 + 10])
    assert np.linalg.norm(around.lights, axis=1) == pytest.approx(np.ones(4))
    told = dome(**ball, positionsSphere=vectors([[200 * v for v in row] for row in FOUR]))
    assert told.positions == pytest.approx(200 * np.array(FOUR, float))
    nowhere = dome(**ball, domeDiameter=0, positionsSphere=vectors([(0, 0, 0)] * 4))  # as RelightLab has it
    assert nowhere.positions is None and nowhere.lights == pytest.approx(np.array(unit))
    old = dome(lightConfiguration="lights3d", positions=vectors(FOUR), imageWidth=4)
    assert old.positions == pytest.approx(np.array(FOUR, float))
    led = dome(
        directions=vectors(FOUR), ledAdjust=vectors([(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1)], "rgb")
    )
    assert led.strengths == pytest.approx(np.array([1, 0.5, 1, 1]) / 0.875)


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"lightConfiguration": "ring"}, '"lightConfiguration" among'),
        (
            {"lightConfiguration": "lights3d", "positions3d": vectors(FOUR), "imageWidth": -2},
            '"imageWidth" above 0',
        ),
        ({"directions": vectors([(1, 0, -1)] * 4)}, "above the sheet"),
        ({"directions": []}, "above the sheet"),
        ({"directions": [1, 2]}, "a list of"),
        ({"directions": [{"x": "one", "y": 0, "z": 1}]}, "expected numbers"),
        ({"directions": vectors(FOUR)}, "holds 4 lamps, but 3 images"),
    ],
)
def test_a_dome_that_is_wrong_says_where(tmp_path, entries, words):
    for number in range(3):
        Image.new("L", (20, 16), 90 + 20 * number).save(tmp_path / f"{number}.png")
    (tmp_path / "a.dome").write_text(json.dumps(entries))
    with pytest.raises(CaptureError, match=words) as refused:
        read_capture(tmp_path)
    assert "a.dome" in str(refused.value)


def test_positions_belong_to_their_lamps():
    stack, lights, positions = of_simulation(1.0)
    with pytest.raises(CaptureError, match="8 positions above the sheet"):
        Capture(images=stack, lights=lights, mask=np.ones((SIDE, SIDE), bool), positions=-positions)
