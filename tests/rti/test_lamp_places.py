"""Relightable images of captures whose lamps stood near the sheet, against a simulation under far lamps."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.capture.dome import without_fall_off
from rumu.capture.lights import direction
from rumu.capture.stored import to_srgb
from rumu.image_stack import ImageStack
from rumu.rti.fitting import RtiSettings, fit_rti
from rumu.rti.image import relight_rti
from rumu.values import Capture
from rumu_lab.simulation.lamps import NearLamp, normals_of, render

SIDE = 120


def relief() -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return 2.5 * np.sin(x / 7.0) * np.cos(y / 9.0)


def near_capture(distance: float = 1.2, count: int = 24) -> tuple[Capture, Capture]:
    """The same photographs with the places of their lamps, and with directions alone. distance: in sides."""
    slants = 12 + 43 * np.arange(count) / (count - 1)
    toward = np.stack([direction(tilt=137.5 * i, slant=slant) for i, slant in enumerate(slants)])
    lamps = [NearLamp(tuple(distance * SIDE * one), strength=0.5) for one in toward]
    seen = np.stack([render(relief(), 0.8, lamp=one, cast_shadows=False) for one in lamps])
    positions = np.array([one.position for one in lamps])
    even = without_fall_off(ImageStack.of_arrays(seen.astype(np.float32)), positions)
    mask = np.ones((SIDE, SIDE), bool)
    near = Capture(images=even, lights=toward, mask=mask, positions=positions)
    return near, Capture(images=even, lights=toward, mask=mask)


@pytest.mark.parametrize(("basis", "channels"), [("ptm", "lrgb"), ("hsh", "rgb")])
def test_each_place_of_a_sheet_has_directions_of_its_own(basis, channels):
    """What the sheet shows under a lamp far away: near the truth at the corners as in the middle."""
    shade = np.clip(normals_of(relief()) @ direction(tilt=50, slant=40), 0, 1)
    errors = []
    for capture in near_capture():
        image = fit_rti(capture, basis=basis, channels=channels, settings=RtiSettings(tile=20_000)).image
        shown = relight_rti(image, direction(tilt=50, slant=40)).mean(axis=2)
        wanted = to_srgb(shade)
        wanted *= np.median(shown) / np.median(wanted)
        errors.append(np.sqrt(np.mean((shown - wanted) ** 2)))
    near, far = errors
    assert near < 0.006 and near < 0.45 * far


def test_no_edge_of_the_grid_shows():
    """Flat paper without its fall-off, which is equally bright everywhere in each photograph."""
    near, _ = near_capture()
    flat = near.changed(images=np.broadcast_to(near.lights[:, 2, None, None], (24, SIDE, SIDE)).astype("f4"))
    shown = relight_rti(fit_rti(flat, basis="ptm").image, direction(tilt=10, slant=30)).mean(axis=2)
    assert np.abs(np.diff(shown, axis=0)).max() <= 2 / 255 >= np.abs(np.diff(shown, axis=1)).max()
