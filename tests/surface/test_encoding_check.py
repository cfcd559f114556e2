"""Photographs for a screen that were read as light are told of; those that are light are not."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.capture.stored import to_srgb
from rumu.image_stack import ImageStack, Photograph
from rumu.surface.encoding_check import encoding_notes
from rumu.surface.photometric import photometric
from rumu.values import Capture
from rumu_lab.simulation.lamps import from_slopes
from rumu_lab.simulation.reflectances import photograph_material, spread_lamps

SIDE = 48


def notes(
    material: str, *, for_screen: bool, lamps: int = 12, bits: int = 16, brightness: float = 0.9
) -> tuple:
    """Of a wavy sheet of one material, read as light."""
    y, x = np.mgrid[:SIDE, :SIDE] * (12 / SIDE)
    normals = from_slopes(0.4 * np.cos(x) * np.cos(0.75 * y), 0.3 * np.sin(x) * np.sin(0.75 * y))
    lights = spread_lamps(lamps)
    light = photograph_material(normals, lights, material).reshape(lamps, SIDE, SIDE)
    light = np.clip(brightness * light / light.max(), 0, 1)
    shown = to_srgb(light) if for_screen else light
    whole = np.round(shown * (2**bits - 1)).astype(f"uint{bits}")
    capture = Capture(
        images=ImageStack([Photograph(one) for one in whole]),
        lights=lights,
        mask=np.ones((SIDE, SIDE), bool),
        lamps_as_given=True,
    )
    return encoding_notes(capture, photometric(capture))


@pytest.mark.parametrize("bits", [8, 16])
def test_values_for_a_screen_are_told_of(bits):
    (note,) = notes("Lambert", for_screen=True, bits=bits)
    assert '"encoding": "srgb" in capture.json' in note.en and '"encoding": "srgb"' in note.zh


@pytest.mark.parametrize("material", ["Lambert", "Phong, exponent 20", "Oren-Nayar, slope .6"])
def test_light_is_left_alone(material):
    assert notes(material, for_screen=False) == ()


def test_photographs_that_are_very_dark_are_left_alone():
    assert notes("Lambert", for_screen=False, bits=8, brightness=0.02) == ()


def test_few_lamps_cannot_tell():
    assert notes("Lambert", for_screen=True, lamps=5) == ()
