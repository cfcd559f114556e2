"""Steps are kept by bilateral integration, and smooth surfaces come out as by least squares."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.surface.integrate import integrate
from rumu.surface.stereo import normals_from_gradients
from rumu_lab.simulation.shapes import bump

SIDE = 96


def flap():
    """A sheet with a slit along the middle of its right half, beyond which a flap rises; and its normals.

    Along the slit the height jumps, by more the farther right; around its end the sheet is smooth.
    """
    r, c = np.mgrid[:SIDE, :SIDE].astype(float)
    rising = np.maximum(c - SIDE / 2, 0.0)
    upper = r < SIDE / 2
    height = np.where(upper, 0.004 * rising**2, 0.0)
    return height, normals_from_gradients(np.where(upper, 0.008 * rising, 0.0), np.zeros_like(height))


def error(height, wanted, where=None):
    where = np.ones(wanted.shape, bool) if where is None else where
    off = (height - wanted)[where]
    return float(np.abs(off - off.mean()).mean())


def test_a_step_is_kept():
    height, normals = flap()
    bent, kept = (integrate(normals, method=method) for method in ("masked", "bilateral"))
    assert error(bent, height) > 0.5 and error(kept, height) < 0.2 * error(bent, height)
    middle, far = SIDE // 2, SIDE - 4
    step = height[middle - 1, far] - height[middle, far]
    assert kept[middle - 1, far] - kept[middle, far] == pytest.approx(step, rel=0.1)
    assert bent[middle - 1, far] - bent[middle, far] < 0.5 * step


def test_the_other_way_round_is_the_same():
    """Rows and columns, and ups and downs, are treated alike."""
    height, normals = flap()
    turned = normals[:, :, [1, 0, 2]].transpose(1, 0, 2) * [-1.0, -1.0, 1.0]  # x becomes the rows, y up
    over = integrate(turned.astype(np.float32), method="bilateral")
    assert error(over.T, height) < 0.2


def test_a_smooth_surface_is_that_of_least_squares():
    hill = bump((80, 70), peak=8.0, sigma=14.0)
    one, other = (integrate(hill.normals, method=method) for method in ("masked", "bilateral"))
    assert np.abs(one - other).max() < 0.02 * np.ptp(hill.height)


def test_noise_does_not_tear_a_sheet():
    hill = bump((80, 70), peak=8.0, sigma=14.0)
    noisy = hill.normals + np.random.default_rng(0).normal(0, 0.03, hill.normals.shape)
    one, other = (integrate(noisy, method=method) for method in ("masked", "bilateral"))
    assert error(other, hill.height) < 2.0 * error(one, hill.height) + 0.02


def test_a_mask_is_kept_to_and_what_is_outside_does_not_matter():
    height, normals = flap()
    r, c = np.mgrid[:SIDE, :SIDE]
    inside = np.hypot(r - SIDE / 2, c - SIDE / 2) < 40
    found = integrate(normals, mask=inside, method="bilateral")
    other = np.where(inside[..., None], normals, np.float32(0.5))
    assert np.array_equal(found, integrate(other, mask=inside, method="bilateral"))
    assert (found[~inside] == 0).all() and error(found, height, inside) < 0.15


def test_a_normal_without_trust_does_not_bend_its_neighbours():
    hill = bump((60, 60), peak=6.0, sigma=12.0)
    wrong, trust = hill.normals.copy(), np.ones((60, 60), np.float32)
    wrong[20:24, 20:24], trust[20:24, 20:24] = (0.9, 0.0, 0.435), 0.0
    kept = integrate(wrong, method="bilateral", weights=trust)
    elsewhere = trust > 0
    assert error(kept, hill.height, elsewhere) < 0.05
