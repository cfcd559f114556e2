"""The oracle against closed forms that can be checked with a pencil."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import CaptureError, SurfaceError
from rumu_lab.simulation.lamps import (
    DistantLamp,
    Gloss,
    NearLamp,
    Sensor,
    cast_shadow,
    normals_of,
    photographs,
    render,
)
from rumu_lab.simulation.shapes import bump, plane, sphere

FLAT = np.zeros((41, 61))


@pytest.mark.parametrize("slant", [0.0, 20.0, 45.0, 70.0])
def test_flat_sheet_is_as_bright_as_the_cosine_of_the_slant(slant: float) -> None:
    image = render(FLAT, 0.8, lamp=DistantLamp(tilt=33.0, slant=slant))
    assert image.dtype == np.float32
    np.testing.assert_allclose(image, 0.8 * np.cos(np.radians(slant)), rtol=1e-6)


def test_inclined_plane_follows_lambert_to_the_attached_shadow() -> None:
    p, q = 0.5, -0.25
    tilted = plane((20, 30), p=p, q=q)
    for tilt in range(0, 360, 30):
        lamp = DistantLamp(tilt=tilt, slant=75.0)
        image = render(tilted.height, 1.0, lamp=lamp)
        expected = max(np.array([-p, -q, 1.0]) @ lamp.direction / np.sqrt(p * p + q * q + 1.0), 0.0)
        np.testing.assert_allclose(image, expected, atol=1e-6)


@pytest.mark.parametrize(
    ("tilt", "bright", "dark"),
    [
        (0, (32, 42), (32, 22)),
        (90, (22, 32), (42, 32)),
        (180, (32, 22), (32, 42)),
        (270, (42, 32), (22, 32)),
    ],
)
def test_the_flank_that_faces_the_lamp_is_the_bright_one(
    tilt: int, bright: tuple[int, int], dark: tuple[int, int]
) -> None:
    """Rows grow downward: a lamp at tilt 90 stands at the top, so the upper rows of a bump are bright."""
    hill = bump((65, 65), peak=8.0, sigma=10.0)
    image = render(hill.height, 1.0, lamp=DistantLamp(tilt=tilt, slant=45.0))
    assert image[bright] > image[0, 0] > image[dark]


def test_near_lamp_falls_off_with_the_square_of_distance_and_the_cosine() -> None:
    image = render(np.zeros((3, 201)), 1.0, lamp=NearLamp((0.0, 0.0, 50.0), strength=0.9))
    d = np.abs(np.arange(201) - 100.0)
    np.testing.assert_allclose(image[1], 0.9 * 50.0**3 / (d**2 + 50.0**2) ** 1.5, rtol=1e-6)
    facing = plane((1001, 3), p=0.0, q=0.0).height
    twice = render(facing, 1.0, lamp=NearLamp((0.0, 0.0, 100.0), strength=0.5))
    assert twice[500, 1] == pytest.approx(0.5), "strength is the brightness at the centre, at any distance"


def test_near_lamp_moved_to_the_right_and_top_lights_the_upper_right_corner_most() -> None:
    image = render(FLAT, 1.0, lamp=NearLamp((30.0, 20.0, 15.0), strength=0.05))
    assert np.unravel_index(int(image.argmax()), image.shape) == (0, 60)


def test_near_lamp_far_away_is_a_distant_lamp() -> None:
    hill = bump((33, 33), peak=6.0, sigma=5.0)
    distant = DistantLamp(tilt=120.0, slant=50.0)
    near = NearLamp(tuple(1e6 * distant.direction))
    a, b = (render(hill.height, 0.7, lamp=lamp) for lamp in (distant, near))
    np.testing.assert_allclose(a, b, atol=1e-4)


@pytest.mark.parametrize(("slant", "height"), [(45.0, 10.0), (60.0, 10.0), (30.0, 20.0), (70.0, 8.0)])
@pytest.mark.parametrize("tilt", [0, 90, 180, 270])
def test_a_wall_throws_a_shadow_as_long_as_height_times_tan_slant(
    slant: float, height: float, tilt: int
) -> None:
    z = np.zeros((121, 121))
    z[58:63, 58:63] = height
    shadow = cast_shadow(z, lamp=DistantLamp(tilt=tilt, slant=slant))
    behind = {
        0: shadow[60, :58],
        90: shadow[63:, 60],
        180: shadow[60, 63:],
        270: shadow[:58, 60],
    }[tilt]
    assert behind.sum() == pytest.approx(height * np.tan(np.radians(slant)), abs=1.01)
    before = {0: shadow[60, 63:], 90: shadow[:58, 60], 180: shadow[60, :58], 270: shadow[63:, 60]}[tilt]
    assert not before.any()


def test_shadow_of_a_low_near_lamp_ends_where_the_line_of_sight_does() -> None:
    z = np.zeros((3, 201))
    z[:, 100:103] = 10.0
    shadow = cast_shadow(z, lamp=NearLamp((60.0, 0.0, 30.0)))  # the lamp stands over column 160
    first = int(np.flatnonzero(shadow[1])[0])
    edge, lamp, top, lamp_height = 100.0, 160.0, 10.0, 30.0
    assert first == pytest.approx(edge - top * (lamp - edge) / (lamp_height - top), abs=1.01)


def test_shadow_in_millimetres_is_the_shadow_in_pixels() -> None:
    z = bump((64, 64), peak=20.0, sigma=5.0).height
    a = cast_shadow(z, lamp=DistantLamp(40.0, 65.0))
    b = cast_shadow(z * 0.1, lamp=DistantLamp(40.0, 65.0), spacing=0.1)
    assert a.any()
    np.testing.assert_array_equal(a, b)


def test_no_shadow_from_above_and_no_cast_shadow_on_a_convex_surface() -> None:
    z = bump((64, 64), peak=40.0, sigma=5.0).height
    assert not cast_shadow(z, lamp=DistantLamp(0.0, 0.0)).any()
    ball = sphere((101, 101), radius=40.0)
    lamp = DistantLamp(tilt=20.0, slant=50.0)
    lit_ball = (ball.height > 0) & (ball.normals @ lamp.direction > 0.05)
    assert not (cast_shadow(ball.height, lamp=lamp) & lit_ball).any()


def test_cast_shadow_is_dark_only_when_asked_for() -> None:
    z = np.zeros((41, 41))
    z[:, 20:22] = 8.0
    lamp = DistantLamp(0.0, 60.0)
    assert render(z, 1.0, lamp=lamp)[20, 12] == 0.0
    assert render(z, 1.0, lamp=lamp, cast_shadows=False)[20, 12] == pytest.approx(0.5)


def test_normals_in_millimetres_are_those_in_pixels() -> None:
    z = bump((30, 30), peak=6.0, sigma=6.0).height
    np.testing.assert_allclose(normals_of(z), normals_of(z * 0.25, spacing=0.25), atol=1e-12)


def test_ambient_is_absorbed_by_ink_and_a_veil_is_not() -> None:
    albedo = np.full(FLAT.shape, 0.8)
    albedo[:, :30] = 0.1
    lamp = DistantLamp(0.0, 60.0)
    room = render(FLAT, albedo, lamp=lamp, ambient=0.2)
    fog = render(FLAT, albedo, lamp=lamp, veil=0.2)
    assert room[0, 0] == pytest.approx(0.1 * 0.7)
    assert fog[0, 0] == pytest.approx(0.1 * 0.5 + 0.2)


def test_noise_has_the_declared_size_and_is_the_seed_s() -> None:
    lamp = DistantLamp(0.0, 60.0)
    a, b = (render(FLAT, 1.0, lamp=lamp, sensor=Sensor(noise=0.02, seed=s)) for s in (1, 2))
    assert np.std(a) == pytest.approx(0.02, rel=0.1)
    assert not np.array_equal(a, b)
    np.testing.assert_array_equal(a, render(FLAT, 1.0, lamp=lamp, sensor=Sensor(noise=0.02, seed=1)))


def test_encoding_is_undone_by_its_inverse() -> None:
    ramp = np.tile(np.linspace(0.0, 1.0, 61), (41, 1))
    stored = render(FLAT, ramp, lamp=DistantLamp(0.0, 0.0), sensor=Sensor(encoding="srgb"))
    linear = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear, ramp, atol=1e-5)
    stored = render(FLAT, ramp, lamp=DistantLamp(0.0, 0.0), sensor=Sensor(encoding=2.2))
    np.testing.assert_allclose(stored**2.2, ramp, atol=1e-5)


def test_bright_lamp_saturates_and_gloss_peaks_half_way_to_the_lamp() -> None:
    assert render(FLAT, 1.0, lamp=DistantLamp(0.0, 0.0, strength=3.0)).max() == 1.0
    ball = sphere((201, 201), radius=90.0)
    lamp = DistantLamp(tilt=0.0, slant=40.0)
    dull, shiny = (
        render(ball.height, 0.2, lamp=lamp, normals=ball.normals, gloss=g) for g in (None, Gloss(0.5, 200.0))
    )
    row, column = np.unravel_index(int((shiny - dull).argmax()), dull.shape)
    assert row == 100
    assert column - 100 == pytest.approx(90.0 * np.sin(np.radians(20.0)), abs=1.0)


def test_photographs_come_with_their_lights_and_strengths() -> None:
    hill = bump((32, 32), peak=4.0, sigma=6.0)
    images, lights = photographs(
        hill.height, 0.5, tilts=(0, 90, 180), slant=45.0, strengths=(1.0, 0.5, 1.0), sensor=Sensor(noise=0.01)
    )
    assert images.shape == (3, 32, 32)
    root = np.sqrt(0.5)
    np.testing.assert_allclose(lights, [[root, 0, root], [0, root, root], [-root, 0, root]], atol=1e-12)
    assert images[1, 0].mean() == pytest.approx(images[0, 0].mean() / 2, rel=0.05)
    noise = [
        image - image.mean()
        for image in photographs(FLAT, 0.5, tilts=(0, 1), slant=45.0, sensor=Sensor(noise=0.01))[0]
    ]
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.1, (
        "each photograph has its own noise"
    )


def test_colour_keeps_its_three_channels() -> None:
    albedo = np.broadcast_to([0.9, 0.6, 0.3], (*FLAT.shape, 3))
    image = render(FLAT, albedo, lamp=DistantLamp(0.0, 60.0))
    np.testing.assert_allclose(image[5, 5], [0.45, 0.3, 0.15], rtol=1e-6)


def test_nonsense_is_refused_by_name() -> None:
    lamp = DistantLamp(0.0, 45.0)
    with pytest.raises(SurfaceError, match="albedo of shape"):
        render(FLAT, np.ones((2, 2)), lamp=lamp)
    with pytest.raises(SurfaceError, match="finite"):
        render(np.full((4, 4), np.nan), 1.0, lamp=lamp)
    with pytest.raises(SurfaceError, match="at least 2 x 2"):
        render(np.zeros(5), 1.0, lamp=lamp)
    with pytest.raises(CaptureError, match="above the sheet"):
        render(FLAT, 1.0, lamp=NearLamp((0.0, 0.0, -1.0)))
    with pytest.raises(CaptureError, match="slants"):
        photographs(FLAT, 1.0, tilts=(0, 90), slant=(45.0,))
    with pytest.raises(CaptureError, match="clip"):
        Sensor(clip=False, encoding="srgb")
