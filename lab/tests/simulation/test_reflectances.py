"""The materials obey what is known of all reflectances, and each what sets it apart."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.simulation.reflectances import REFLECTANCES, photograph_material, spread_lamps

UP = np.array([[[0.0, 0.0, 1.0]]])


def shown(name, normals, lights):
    return photograph_material(np.asarray(normals, float), np.asarray(lights, float), name, noise=0.0)


@pytest.mark.parametrize("name", sorted(REFLECTANCES))
def test_a_turn_about_the_camera_changes_nothing(name):
    """All are isotropic."""
    turn = np.radians(50.0)
    rotation = np.array(
        [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    normals = np.array([[[0.3, 0.2, 0.9], [-0.5, 0.1, 0.7], [0.0, 0.6, 0.8]]])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    lights = spread_lamps(20)
    before, after = shown(name, normals, lights), shown(name, normals @ rotation.T, lights @ rotation.T)
    np.testing.assert_allclose(before, after, atol=0.005)


@pytest.mark.parametrize("name", sorted(REFLECTANCES))
def test_what_is_turned_away_is_dark_and_all_is_finite(name):
    lights = np.array([[0.8, 0.0, 0.6], [0.0, 0.0, 1.0], [-0.8, 0.0, 0.6]])
    images = shown(name, [[[0.9, 0.0, np.sqrt(0.19)], [0.0, 0.0, 1.0]]], lights)
    assert np.isfinite(images).all() and images[2, 0, 0] == 0 and images.max() > 0.5


def test_gloss_and_rough_ground_depart_from_lambert_on_both_sides():
    """Gloss is bright near the mirror's direction, rough ground at grazing light."""
    slants = np.radians([0.0, 70.0])
    lights = np.stack([np.sin(slants), np.zeros(2), np.cos(slants)], axis=1)
    ratio = {name: float(np.divide(*shown(name, UP, lights)[::-1, 0, 0])) for name in REFLECTANCES}
    assert ratio["Phong, exponent 20"] < ratio["Lambert"] < ratio["cloth"]
    assert ratio["Beckmann metal, slope .3"] < ratio["Beckmann, slope .22"]


def test_lamps_are_unit_vectors_of_one_dome():
    lights = spread_lamps(30, slant=60.0)
    np.testing.assert_allclose(np.linalg.norm(lights, axis=1), 1.0)
    assert lights[:, 2].min() >= np.cos(np.radians(60.0)) - 1e-9
    assert np.abs(lights[:, :2].mean(axis=0)).max() < 0.02
