"""New light: the mixture of three photographs is what the simulated lamp gives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rumu.errors import SurfaceError
from rumu.surface.relight import relight, relight_three
from rumu.values import Surface
from rumu_lab.simulation.lamps import photographs
from rumu_lab.simulation.shapes import bump

SHAPE = bump((40, 50), peak=4.0, sigma=10.0)
ALBEDO = 0.3 + 0.5 * (np.indices((40, 50)).sum(axis=0) % 2)


def photos(tilts, slant):
    return photographs(
        SHAPE.height, ALBEDO, tilts=tilts, slant=slant, normals=SHAPE.normals, cast_shadows=False
    )[0]


def surface(albedo):
    return Surface(
        height=SHAPE.height.astype(np.float32),
        normals_from=SHAPE.normals.astype(np.float32),
        albedo_from=albedo.astype(np.float32),
        mask=np.ones(SHAPE.height.shape, dtype=bool),
        confidence=np.ones(SHAPE.height.shape, dtype=np.float32),
        spacing=1.0,
        unit="px",
        source="photometric",
    )


def test_the_three_photographs_and_the_fourth_come_back():
    a, b, c = photos((0, 90, 180), 40.0)
    for tilt, wanted in ((0, a), (90, b), (180, c), (270, a + c - b), (360, a)):
        assert np.allclose(relight_three(a, b, c, slant=40.0, tilt=tilt), wanted, atol=1e-6)


@settings(max_examples=25, deadline=None)
@given(tilt=st.floats(-360, 720), old=st.floats(15, 50), new=st.floats(0, 50))
def test_any_tilt_and_slant_is_what_a_lamp_there_gives(tilt, old, new):
    a, b, c = photos((0, 90, 180), old)
    mixed = relight_three(a, b, c, slant=old, tilt=tilt, new_slant=new)
    assert np.allclose(mixed, photos((tilt,), new)[0], atol=2e-5)
    assert np.allclose(relight(surface(ALBEDO), tilt=tilt, slant=new), photos((tilt,), new)[0], atol=1e-5)


def test_attached_shadow_is_black_and_never_below():
    a, b, c = photos((0, 90, 180), 40.0)
    grazing = relight_three(a, b, c, slant=40.0, tilt=45.0, new_slant=89.0)
    assert grazing.min() == 0.0 and grazing.dtype == np.float32
    assert relight(surface(ALBEDO), tilt=45.0, slant=89.0).min() == 0.0


def test_colour_is_kept():
    colour = np.stack([ALBEDO, 0.5 * ALBEDO, 0.1 * ALBEDO], axis=-1)
    lit = relight(surface(colour), tilt=30.0, slant=45.0)
    assert lit.shape == (40, 50, 3)
    assert np.allclose(lit[..., 0], 2 * lit[..., 1], atol=1e-6)


def test_bad_angles_and_shapes_are_refused():
    one = np.ones((3, 3))
    with pytest.raises(SurfaceError, match="slant between 0 and 90 degrees, got 120"):
        relight(surface(ALBEDO), tilt=0.0, slant=120.0)
    with pytest.raises(SurfaceError, match="finite tilt"):
        relight(surface(ALBEDO), tilt=float("nan"), slant=20.0)
    with pytest.raises(SurfaceError, match="one shape"):
        relight_three(one, one, np.ones((3, 4)), slant=45.0, tilt=0.0)
    with pytest.raises(SurfaceError, match="strictly between"):
        relight_three(one, one, one, slant=90.0, tilt=0.0)
