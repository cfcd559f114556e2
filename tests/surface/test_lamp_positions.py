"""Lamps near a flat sheet, placed from its photographs and the directions; and lamps that are not near."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.surface.lamp_positions import near_notes, place_lamps
from rumu.surface.photometric import photometric, surface_normals
from rumu.values import Capture
from rumu_lab.simulation.lamps import DistantLamp, NearLamp, Sensor, normals_of, render

SHAPE = (100, 140)


def height() -> np.ndarray:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 0.8 * np.sin(x / 9.0) * np.cos(y / 11.0) + 0.4 * np.sin(x / 3.3 + y / 5)


def directions(count: int, slants: tuple[float, ...]) -> np.ndarray:
    tilt, slant = np.arange(count) * 2 * np.pi / count + 0.2, np.radians(np.resize(slants, count))
    return np.stack([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)], axis=1)


def near(lights: np.ndarray, distance: np.ndarray, *, strengths: np.ndarray | float = 0.5) -> Capture:
    """A sheet under lamps at these distances, in widths of the photograph; `lights` told, a degree off."""
    rng = np.random.default_rng(2)
    power = np.broadcast_to(strengths, len(lights))
    lamps = [
        NearLamp(tuple(SHAPE[1] * d * light), strength=float(s))
        for d, light, s in zip(distance, lights, power, strict=True)
    ]
    images = [
        render(height(), 0.8, lamp=one, cast_shadows=False, sensor=Sensor(noise=0.003, seed=number))
        for number, one in enumerate(lamps)
    ]
    told = lights + rng.normal(0, np.radians(0.6), lights.shape)
    told /= np.linalg.norm(told, axis=1, keepdims=True)
    return Capture(images=np.array(images), lights=told, mask=np.ones(SHAPE, bool))


def degrees_off(capture: Capture) -> float:
    normals = surface_normals(capture)[0]
    cosine = (normals * normals_of(height())).sum(axis=2)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


def test_many_lamps_are_placed_in_little_memory():
    capture = near(directions(80, (35.0, 55.0)), np.full(80, 1.2))
    tracemalloc.start()
    placed = place_lamps(capture)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 200e6
    assert np.abs(np.linalg.norm(placed.positions, axis=1) / SHAPE[1] / 1.2 - 1).max() < 0.12


@pytest.mark.parametrize(
    ("count", "slants", "distances"),
    [
        (9, (35.0, 55.0), (1.2, 1.2)),
        (8, (45.0,), (1.5, 1.5)),
        (4, (45.0,), (1.0, 1.0)),
        (12, (30.0, 50.0), (1.2, 2.0)),
    ],
)
def test_near_lamps_are_placed(count, slants, distances):
    lights = directions(count, slants)
    wanted = np.resize(distances, count)
    capture = near(lights, wanted)
    placed = place_lamps(capture)
    found = np.linalg.norm(placed.positions, axis=1) / SHAPE[1]
    assert np.abs(found / wanted - 1).max() < 0.12
    assert degrees_off(placed) < 2.2
    assert degrees_off(capture) > 10
    assert "from the middle of the sheet" in placed.notes[-1].en


def test_strengths_of_near_lamps_are_found_with_them():
    strengths = np.resize([0.4, 0.55], 9)
    placed = place_lamps(near(directions(9, (35.0, 55.0)), np.full(9, 1.3), strengths=strengths))
    assert placed.strengths == pytest.approx(strengths / strengths.mean(), rel=0.04)


def test_near_lamps_that_are_taken_as_far_are_noted():
    capture = near(directions(9, (35.0, 55.0)), np.full(9, 1.2))
    (note,) = near_notes(capture, photometric(capture))
    assert "--near-lamps" in note.en and "--near-lamps" in note.zh
    placed = place_lamps(capture)
    assert near_notes(placed, photometric(placed)) == []


def test_lamps_far_away_are_refused_and_not_noted():
    tilts, slants = np.arange(9) * 40.0, np.resize([35.0, 55.0], 9)
    lamps = [DistantLamp(tilt, slant, strength=0.9) for tilt, slant in zip(tilts, slants, strict=True)]
    images = [render(height(), 0.8, lamp=one, sensor=Sensor(noise=0.003, seed=3)) for one in lamps]
    lights = np.array([one.direction for one in lamps])
    capture = Capture(images=np.array(images), lights=lights, mask=np.ones(SHAPE, bool))
    with pytest.raises(CaptureError, match="expected lamps near the sheet"):
        place_lamps(capture)
    assert near_notes(capture, photometric(capture)) == []


def test_what_cannot_be_placed():
    three = near(directions(3, (45.0,)), np.full(3, 1.2))
    with pytest.raises(CaptureError, match="expected four lamps or more"):
        place_lamps(three)
    capture = near(directions(9, (35.0, 55.0)), np.full(9, 1.2))
    with pytest.raises(CaptureError, match="told already"):
        place_lamps(place_lamps(capture))
    with pytest.raises(CaptureError, match="pixels that every lamp lights"):
        place_lamps(capture.changed(images=capture.images * np.float32(0.01)))


@pytest.mark.parametrize("name", ["uw-psm/gray", "uw-psm/buddha", "psbox-cat", "bunny/bunny_lambert"])
def test_nothing_is_said_of_real_captures_of_round_objects(data, name):
    capture = read_capture(data / "photometric" / name)
    assert near_notes(capture, photometric(capture)) == []
