"""The lobe of gloss is learnt from pixels, and the ground under it found."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.surface.lobe import ANGLES, learn_lobe, lobe_of, part_ground_and_gloss
from rumu.surface.reflectance import LAMBERT, Lamps, Material, MaterialSettings, reflected
from rumu_lab.simulation.lamps import from_slopes
from rumu_lab.simulation.reflectances import spread_lamps

SETTINGS = MaterialSettings()


def shining(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, Lamps]:
    """Colours (P, 12, 3) under gloss that falls off as cos^30, their ground (P, 3), normals, lamps."""
    rng, lamps = np.random.default_rng(3), Lamps(spread_lamps(12))
    normals = from_slopes(*(0.3 * rng.normal(size=(2, 1, count))))[0]
    ground = rng.uniform(0.03, 0.6, (count, 3))
    gloss = np.maximum(normals @ lamps.halfway.T, 0.0) ** 30 * (normals @ lamps.directions.T > 0)
    matte = reflected(normals, lamps, LAMBERT)
    return ground[:, None] * matte[..., None] + (0.2 * gloss)[..., None], ground, normals, lamps


def test_the_learnt_lobe_is_that_of_the_surface() -> None:
    colours, ground, normals, lamps = shining(600)
    seen = lamps.relative(colours.mean(axis=2), SETTINGS)
    lobe = learn_lobe(seen, lamps, normals, 0.27, material=SETTINGS)
    truth = np.cos(np.radians(ANGLES)) ** 30
    assert np.abs(np.array(lobe) / lobe[0] - truth).max() < 0.08
    off = {}
    for name, material in {"formula": (), "learnt": lobe}.items():
        gloss = lobe_of(Material("gloss", 0.27, 1.0, material), normals, lamps)
        found, _ = part_ground_and_gloss(
            colours,
            reflected(normals, lamps, LAMBERT),
            gloss,
            np.ones(gloss.shape),
            usual=np.zeros(len(gloss)),
            prior=0.0,
        )
        off[name] = float(np.median(np.abs(found - ground)))
    assert off["learnt"] < 0.5 * off["formula"], off


@pytest.mark.parametrize("count", [0, 20])
def test_few_pixels_teach_nothing(count: int) -> None:
    colours, _, normals, lamps = shining(count)
    seen = lamps.relative(colours.mean(axis=2), SETTINGS)
    assert learn_lobe(seen, lamps, normals, 0.27, material=SETTINGS) == ()
