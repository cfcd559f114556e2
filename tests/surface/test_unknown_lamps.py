"""Lamps that nothing tells, against a simulation written apart: sheets of known relief, and flat ones."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.errors import CaptureError
from rumu.image_stack import ImageStack
from rumu.pipeline import reconstruct
from rumu.surface.unknown_lamps import find_lamps
from rumu_lab.simulation.lamps import DistantLamp, Lamp, NearLamp, Sensor, render
from rumu_lab.simulation.phone import LaidSheet, wavy_sheet

HOLLOWS = np.array([-1, -1, 1])


@pytest.fixture(scope="module")
def sheet() -> LaidSheet:
    return wavy_sheet(size=(80, 90), spacing=0.2, relief=0.3, seed=3)


def directions(count: int, *, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    tilt = np.radians(360 * np.arange(count) / count + rng.uniform(-15, 15, count))
    slant = np.radians(rng.uniform(32, 52, count))
    return np.column_stack([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)])


def lamp(toward: np.ndarray, near: float | None) -> Lamp:
    if near:
        return NearLamp(tuple(near * toward), strength=0.9)
    tilt = np.degrees(np.arctan2(toward[1], toward[0]))
    return DistantLamp(tilt, np.degrees(np.arccos(toward[2])), strength=0.9)


def photographs(
    sheet: LaidSheet, lights: np.ndarray, *, near: float | None = None, noise: float = 0.004
) -> ImageStack:
    rng = np.random.default_rng(1)
    albedo = sheet.albedo * (1 + 0.01 * rng.standard_normal(sheet.albedo.shape))  # fibres
    options = {"spacing": sheet.spacing, "normals": sheet.normals}
    return ImageStack.of_arrays(
        [
            render(sheet.height, albedo, lamp=lamp(one, near), sensor=Sensor(noise=noise, seed=k), **options)
            for k, one in enumerate(lights)
        ]
    )


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip((one * other).sum(axis=-1), -1, 1)))


def everywhere(stack: ImageStack) -> np.ndarray:
    return np.ones(stack.shape[1:3], bool)


def test_normals_of_a_paper_sheet(sheet):
    lights = directions(8)
    stack = photographs(sheet, lights)
    found = find_lamps(stack, mask=everywhere(stack))
    assert found.sign == "rule" and found.unsure < 0.05  # lamps far away: nothing tells ridges from hollows
    turned = angles(lights, found.capture.lights).mean() > 45
    way = HOLLOWS if turned else np.ones(3)
    assert angles(lights, found.capture.lights * way).max() < 3
    off = angles(sheet.normals, reconstruct(found.capture).normals * way)[20:-20, 20:-20]
    assert off.mean() < 1.5 and np.quantile(off, 0.99) < 6
    other = find_lamps(stack, mask=everywhere(stack), inside_out=True)
    assert other.sign == "asked"
    assert angles(other.capture.lights, found.capture.lights * HOLLOWS).max() < 1e-3
    assert "--inside-out" in found.capture.notes[0].en and found.capture.notes[0].zh


def test_near_lamps_tell_ridges_from_hollows(sheet):
    lights = directions(6, seed=2)
    stack = photographs(sheet, lights, near=300.0)
    found = find_lamps(stack, mask=everywhere(stack))
    assert found.sign == "fall-off"
    assert angles(lights, found.capture.lights).max() < 8
    assert angles(sheet.normals, reconstruct(found.capture).normals)[20:-20, 20:-20].mean() < 3


def test_lamps_on_one_side_only(sheet):
    lights = directions(8, seed=4)
    lights = lights[lights[:, 1] > -0.2]
    assert len(lights) >= 4
    stack = photographs(sheet, lights)
    found = find_lamps(stack, mask=everywhere(stack))
    assert angles(lights, found.capture.lights).max() < 3  # more stand above, as the rule takes it


def through_jpeg(light: np.ndarray) -> np.ndarray:
    stream = io.BytesIO()
    Image.fromarray(np.uint8(255 * np.clip(light, 0, 1) ** (1 / 2.2))).save(stream, "JPEG", quality=90)
    return (np.asarray(Image.open(stream), np.float32) / 255) ** np.float32(2.2)


def flat_frames(albedo: np.ndarray, *, moved: float) -> list[np.ndarray]:
    rng = np.random.default_rng(6)
    x = np.indices(albedo.shape)[1] / albedo.shape[1]
    size, frames = albedo.shape[::-1], []
    for k in range(6):
        shift = np.float32([[1, 0, rng.normal(0, moved)], [0, 1, rng.normal(0, moved)]])
        here = cv2.warpAffine(albedo.astype(np.float32), shift, size, borderMode=cv2.BORDER_REFLECT)
        light = here * (0.7 + 0.1 * np.cos(k + x)) + 0.004 * rng.standard_normal(albedo.shape)
        frames.append(np.clip(light, 0, 1).astype(np.float32))
    return frames


@pytest.mark.parametrize("moved", [0.0, 0.4], ids=["still", "moved by half a pixel"])
@pytest.mark.parametrize("as_jpeg", [False, True])
def test_ink_on_flat_paper_tells_nothing(sheet, moved, as_jpeg):
    frames = flat_frames(sheet.albedo, moved=moved)
    stack = ImageStack.of_arrays([through_jpeg(one) if as_jpeg else one for one in frames])
    with pytest.raises(CaptureError, match="ink on flat paper looks the same") as caught:
        find_lamps(stack, mask=everywhere(stack))
    assert "墨" in caught.value.zh


def test_relief_in_one_direction_and_lamps_on_one_line_are_refused(sheet):
    _, x = np.indices(sheet.height.shape) * sheet.spacing
    furrows = LaidSheet(0.3 * np.sin(x), np.full_like(sheet.albedo, 0.8), sheet.spacing)
    stack = photographs(furrows, directions(6))
    with pytest.raises(CaptureError, match="expected relief"):
        find_lamps(stack, mask=everywhere(stack))
    tilts = np.radians([-50, -30, -10, 20, 45])
    in_line = np.column_stack([np.sin(tilts), np.zeros(5), np.cos(tilts)])
    stack = photographs(sheet, in_line)
    with pytest.raises(CaptureError, match="lamps from several sides"):
        find_lamps(stack, mask=everywhere(stack))


def test_too_few_and_too_dark(sheet):
    stack = photographs(sheet, directions(4))
    with pytest.raises(CaptureError, match="at least 4 photographs"):
        find_lamps(stack.chosen([0, 1, 2]), mask=everywhere(stack))
    dark = ImageStack.of_arrays([0.004 * one for one in stack])
    with pytest.raises(CaptureError, match="neither dark nor overexposed"):
        find_lamps(dark, mask=everywhere(stack))
