"""Where other materials are not looked for, gloss is told of; matt ground and near lamps are not."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.surface.gloss_check import gloss_notes
from rumu.surface.photometric import photometric
from rumu.values import Capture
from rumu_lab.simulation.lamps import NearLamp, from_slopes, render
from rumu_lab.simulation.reflectances import photograph_material, spread_lamps

SIDE = 64


def capture_of(material: str, lamps: int) -> Capture:
    """A wavy sheet of one material, 8 bits."""
    y, x = np.mgrid[:SIDE, :SIDE] * (12 / SIDE)
    normals = from_slopes(0.4 * np.cos(x) * np.cos(0.75 * y), 0.3 * np.sin(x) * np.sin(0.75 * y))
    lights = spread_lamps(lamps)
    light = photograph_material(normals, lights, material)
    levels = np.round(np.clip(0.9 * light / light.max(), 0, 1) * 255) / 255
    return Capture(images=levels.astype(np.float32), lights=lights, mask=np.ones((SIDE, SIDE), bool))


@pytest.mark.parametrize("material", ["Phong, exponent 20", "Beckmann, slope .22"])
def test_gloss_under_few_lamps_is_told_of(material):
    capture = capture_of(material, 6)
    (note,) = gloss_notes(capture, photometric(capture))
    assert (
        "seems to shine" in note.en and "there are 6 lamps, and it takes 8" in note.en and "光澤" in note.zh
    )


@pytest.mark.parametrize(
    ("material", "lamps"), [("Lambert", 6), ("Oren-Nayar, slope .6", 5), ("Phong, exponent 20", 12)]
)
def test_matt_ground_and_enough_lamps_are_left_alone(material, lamps):
    capture = capture_of(material, lamps)
    assert gloss_notes(capture, photometric(capture)) == ()


@pytest.mark.parametrize("away", [1.5, 3.0])
def test_lamps_that_are_near_are_not_taken_for_gloss(away):
    y, x = np.mgrid[:SIDE, :SIDE]
    height = 0.4 * np.sin(x / 9.0) * np.cos(y / 11.0)
    lights = spread_lamps(6)
    images = [
        render(height, 0.8, lamp=NearLamp(tuple(away * SIDE * one), strength=0.5), cast_shadows=False)
        for one in lights
    ]
    capture = Capture(
        images=np.array(images, np.float32),
        lights=lights,
        mask=np.ones((SIDE, SIDE), bool),
        lamps_as_given=True,
    )
    assert gloss_notes(capture, photometric(capture)) == ()


@pytest.mark.parametrize("lamps", [5, 12])
@pytest.mark.parametrize("shines", [True, False])
def test_colours_of_a_flat_sheet_that_shines_are_said_to_be_doubtful(lamps, shines):
    albedo = np.full((SIDE, SIDE), 0.7)
    albedo[:, ::2], albedo[::2] = 0.05, 0.3
    rng, lights = np.random.default_rng(0), spread_lamps(lamps)
    matt = albedo * lights[:, 2][:, None, None]
    halfway = np.cos(np.arccos(lights[:, 2]) / 2)
    gloss = np.where(shines, 0.2, 0.0) * halfway**40  # every place mirrors the same of a lamp
    images = matt + gloss[:, None, None] + rng.normal(0, 0.004, matt.shape)
    capture = Capture(images.clip(0, 1).astype(np.float32), lights, np.ones((SIDE, SIDE), bool))
    surface = photometric(capture)
    notes = gloss_notes(capture, surface)
    assert ["flat" in note.en and "cannot be trusted" in note.en for note in notes] == [True] * shines
    if lamps >= 8:  # else gloss is taken for a level below black, and ink for more than three times as bright
        ink = float(np.median(surface.albedo[albedo == 0.05])) * surface.quality["brightness"]
        assert 0.03 < ink < 0.1
