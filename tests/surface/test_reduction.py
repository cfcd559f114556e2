"""A reduced surface has the same form, and says how large its pixels are."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.surface.reduction import reduce_surface
from rumu.values import Surface
from rumu_lab.simulation.shapes import bump


def surface(unit="mm"):
    shape = bump((120, 200), peak=9.0, sigma=25.0)
    mask = np.ones((120, 200), bool)
    mask[:, :40] = False
    return Surface(
        height=shape.height.astype(np.float32),
        normals_from=shape.normals.astype(np.float32),
        albedo_from=np.full((120, 200, 3), (0.7, 0.5, 0.2), np.float32),
        mask=mask,
        confidence=mask.astype(np.float32),
        spacing=0.1 if unit == "mm" else 1.0,
        unit=unit,
        source="photometric",
    )


@pytest.mark.parametrize("unit", ["mm", "px"])
def test_the_form_stays(unit):
    before = surface(unit)
    after = reduce_surface(before, pixels=60 * 100)
    assert after.height.shape == (60, 100) and after.unit == unit
    assert after.spacing == pytest.approx(2 * before.spacing)
    blocks = before.height.reshape(60, 2, 100, 2).mean(axis=(1, 3))
    assert np.abs(after.height - blocks).max() < 1e-4
    assert np.allclose(np.linalg.norm(after.normals, axis=2), 1, atol=1e-5)
    assert (after.normals * before.normals[::2, ::2]).sum(axis=2).min() > 0.99
    assert np.array_equal(after.mask, before.mask[::2, ::2])
    assert np.allclose(after.albedo, before.albedo[0, 0])


def test_a_small_one_is_left_alone():
    before = surface()
    assert reduce_surface(before) is before
