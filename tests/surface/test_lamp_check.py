"""Lamps that are not those of the photographs are found out; right ones are never blamed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.surface.photometric import photometric, surface_normals
from rumu.values import Capture
from rumu_lab.simulation.lamps import NearLamp, Sensor, photographs, render
from rumu_lab.simulation.shapes import ridges

REAL = (
    *(f"uw-psm/{name}" for name in ("buddha", "cat", "chrome", "gray", "horse", "owl", "rock")),
    "bunny/bunny_lambert", "bunny/bunny_lambert_noshadow", "psbox-cat", "synthrti-relief/train49",
    "synthrti-relief/test20", "lion-rti",
)  # fmt: skip
RINGS = {3: (0, 90, 180), 4: (0, 90, 180, 270), 6: tuple(range(0, 360, 60)), 12: tuple(range(0, 360, 30))}
SHAPE = (240, 320)


def turn(degrees: float) -> np.ndarray:
    t = np.radians(degrees)
    return np.array([[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1]])


QUARTER = "when they are turned by -?(8.|9.) degrees"
MISTAKES = {
    "y turned": (np.diag([1.0, -1, 1]), "change the sign of every y", "請把每個 y 變號"),
    "x turned": (np.diag([-1.0, 1, 1]), "turning x instead fits as well", "x 反過來也合"),
    "exchanged": (np.array([[0, 1.0, 0], [1, 0, 0], [0, 0, 1]]), "x and y are exchanged", "x 與 y 要對調"),
    "90 degrees": (turn(90), QUARTER, "繞相機的軸逆時針轉"),
    "-90 degrees": (turn(-90), QUARTER, "繞相機的軸逆時針轉"),
}


def relief(seed: int = 0) -> np.ndarray:
    """Height of a rough stone, in pixels."""
    rough = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=SHAPE), 5)
    return rough / rough.std() * 1.0


def inked() -> np.ndarray:
    """Albedo of paper with strokes in every direction."""
    strokes = sum(ridges(SHAPE, width=9, pitch=90, angle=angle).height for angle in (0, 90, 45, 110))
    return 0.06 + 0.8 * np.exp(-strokes)


def capture_of(height, *, albedo=0.7, lamps=6, slant=45.0, noise=0.003, seed=0) -> Capture:
    images, lights = photographs(
        height,
        albedo,
        tilts=RINGS[lamps],
        slant=slant,
        cast_shadows=False,
        sensor=Sensor(noise=noise, seed=seed),
    )
    return Capture(images=images, lights=lights, mask=np.ones(SHAPE, bool))


def solved(capture: Capture) -> None:
    surface_normals(capture, solver="least_squares")


@pytest.mark.parametrize("name", REAL)
def test_right_lamps_of_real_captures_are_not_blamed(data: Path, name: str) -> None:
    solved(read_capture(data / "photometric" / name))


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("name", ["uw-psm/buddha", "uw-psm/rock", "bunny/bunny_lambert", "psbox-cat"])
def test_lamps_of_real_captures_turned_and_mirrored(data: Path, name: str, mistake: str) -> None:
    capture = read_capture(data / "photometric" / name)
    change, en, zh = MISTAKES[mistake]
    with pytest.raises(CaptureError, match=en) as found:
        solved(replace(capture, lights=capture.lights @ change.T))
    assert found.value.zh is not None and zh in found.value.zh and "--lamps-as-given" in str(found.value)


@pytest.mark.parametrize("order", ["shifted", "reversed"])
def test_lamps_of_a_real_capture_in_another_order(data: Path, order: str) -> None:
    capture = read_capture(data / "photometric" / "uw-psm" / "buddha")
    lights = np.roll(capture.lights, 1, axis=0) if order == "shifted" else capture.lights[::-1]
    with pytest.raises(
        CaptureError, match=r"another order than the photographs.*buddha\.0\.png -> buddha\.1"
    ):
        solved(replace(capture, lights=np.ascontiguousarray(lights)))


def test_lamps_of_another_capture(data: Path) -> None:
    capture = read_capture(data / "photometric" / "bunny" / "bunny_lambert_noshadow")
    mixed = np.random.default_rng(0).permutation(capture.lights)
    with pytest.raises(CaptureError, match="Are they those of another capture, or in another order"):
        solved(replace(capture, lights=mixed))


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("lamps", RINGS)
def test_simulated_stone(lamps: int, mistake: str) -> None:
    capture = capture_of(relief(), lamps=lamps)
    solved(capture)
    change, en, _ = MISTAKES[mistake]
    with pytest.raises(CaptureError, match=en):
        solved(replace(capture, lights=capture.lights @ change.T))


def test_lines_out_of_step_in_a_ring() -> None:
    capture = capture_of(relief(), lamps=6)
    with pytest.raises(
        CaptureError, match=r"turned by -?60 degrees.*so do lines that are out of step by 1"
    ) as no:
        solved(replace(capture, lights=np.roll(capture.lights, 1, axis=0)))
    assert "順序錯開 1 行" in str(no.value.zh)


def test_two_lamps_exchanged() -> None:
    capture = capture_of(relief(), lamps=6)
    order = [2, 1, 0, 3, 4, 5]
    with pytest.raises(CaptureError, match="another order than the photographs"):
        solved(replace(capture, lights=capture.lights[order]))


def test_a_half_turn_cannot_be_told_and_is_not() -> None:
    """The relief comes inside out with the same curl and residual: docs/capture.md says so."""
    capture = capture_of(relief())
    height = photometric(capture, solver="least_squares").height
    turned = photometric(replace(capture, lights=capture.lights * (-1, -1, 1)), solver="least_squares").height
    np.testing.assert_allclose(turned, -height, atol=0.02)


def test_lamps_may_be_taken_as_given() -> None:
    capture = capture_of(relief())
    wrong = replace(capture, lights=capture.lights * (1, -1, 1), lamps_as_given=True)
    assert photometric(wrong).source == "photometric"


# --- no evidence, no blame --------------------------------------------------------------------------


@pytest.mark.parametrize("lamps", RINGS)
@pytest.mark.parametrize(
    "sheet", ["clean", "noisy", "inked", "bent", "near lamps", "frames apart", "ink in relief"]
)
def test_little_or_no_relief_is_no_evidence(lamps: int, sheet: str) -> None:
    y, x = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]]
    height = {"bent": 6 * np.sin(x / 150) + 4 * np.cos(y / 120), "ink in relief": 2 * (1 - inked())}.get(
        sheet, 0 * x
    )
    albedo = 0.8 if sheet in ("clean", "noisy") else inked()
    for seed in range(3):
        rng = np.random.default_rng(seed)
        capture = capture_of(
            height * 1.0, albedo=albedo, lamps=lamps, noise=0 if sheet == "clean" else 0.004, seed=seed
        )
        images = capture.images
        if sheet == "near lamps":
            places = capture.lights * 480 + rng.normal(0, 25, capture.lights.shape)
            lit = [
                render(height * 1.0, albedo, lamp=NearLamp(tuple(map(float, place)), 0.8)) for place in places
            ]
            images = np.clip(np.stack(lit) + rng.normal(0, 0.004, images.shape), 0, 1).astype(np.float32)
        if sheet == "frames apart":
            images = np.stack(
                [ndimage.shift(one, rng.normal(0, 0.6, 2), order=1, mode="nearest") for one in images]
            )
        try:
            solved(replace(capture, images=images))
        except CaptureError as error:  # the frames may be blamed, the lamps may not
            assert sheet == "frames apart" and "moved against the other photographs" in str(error)


def test_the_case_of_y_turned(cases: Path) -> None:
    with pytest.raises(CaptureError, match="change the sign of every y"):
        photometric(read_capture(cases / "ps-yflip"))


UNEVEN = {
    "five": (0, 60, 150, 220, 290),
    "six": (0, 50, 110, 190, 240, 300),
    "eight": (0, 30, 80, 130, 190, 220, 280, 330),
}


def rig(tilts, slants, *, height=None, albedo=0.7) -> Capture:
    """A capture under lamps of any directions."""
    height = relief() if height is None else height
    shots = [
        photographs(
            height,
            albedo,
            tilts=[tilt],
            slant=slant,
            cast_shadows=False,
            sensor=Sensor(noise=0.003, seed=tilt),
        )
        for tilt, slant in zip(tilts, slants, strict=True)
    ]
    images, lights = (np.concatenate(part) for part in zip(*shots, strict=True))
    return Capture(images=images, lights=lights, mask=np.ones(SHAPE, bool))


@pytest.mark.parametrize("albedo", ["stone", "ink"])
@pytest.mark.parametrize("ring", UNEVEN)
def test_lines_out_of_step_in_a_ring_that_is_not_even(ring: str, albedo: str) -> None:
    capture = rig(UNEVEN[ring], [45] * len(UNEVEN[ring]), albedo=0.7 if albedo == "stone" else inked())
    solved(capture)
    for step in (1, -1):
        with pytest.raises(CaptureError, match="so do lines that are out of step by 1") as found:
            solved(replace(capture, lights=np.roll(capture.lights, step, axis=0)))
        assert "順序錯開 1 行" in str(found.value.zh)


@pytest.mark.parametrize("step", [1, -1])
@pytest.mark.parametrize("steepness", [1.0, 0.3])
def test_lines_out_of_step_under_lamps_of_different_slants(step: int, steepness: float) -> None:
    capture = rig(UNEVEN["six"], (30, 55, 40, 60, 35, 50), height=relief() * steepness)
    solved(capture)
    with pytest.raises(CaptureError, match="another order than the photographs") as found:
        solved(replace(capture, lights=np.roll(capture.lights, step, axis=0)))
    assert "燈的順序與照片不同" in str(found.value.zh)


def test_a_turn_that_no_order_makes_is_left_alone() -> None:
    capture = rig(UNEVEN["six"], [45] * 6)
    solved(replace(capture, lights=capture.lights @ turn(25).T))  # someone's own frame of reference


def test_a_light_of_the_room_is_named_where_the_lamps_can_tell() -> None:
    capture = rig(UNEVEN["six"], (30, 55, 40, 60, 35, 50))
    lit = capture.images + np.float32(0.35)
    with pytest.raises(
        CaptureError, match=r"a light is on in all photographs: it makes \d\d%.*named ambient"
    ) as found:
        solved(replace(capture, images=lit / lit.max()))
    assert "每張照片裡都有別的燈光" in str(found.value.zh)
