"""Heights of what a camera at a finite distance sees: a ball, a plane, and their known distances."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.surface.integrate import integrate

SIZE, FOCAL = (120, 160), 200.0


def rays():
    """(H, W, 3) directions of the pixels of a camera that looks along -z, with z = -1."""
    h, w = SIZE
    u, v = (np.arange(w) - (w - 1) / 2) / FOCAL, ((h - 1) / 2 - np.arange(h)) / FOCAL
    return np.dstack([np.broadcast_to(u, SIZE), np.broadcast_to(v[:, None], SIZE), -np.ones(SIZE)])


def ball(x=0.15, y=-0.1, away=3.0, radius=0.5):
    """Distances along the axis, normals, and where a ball is seen well."""
    middle = np.array([x, y, -away])
    along = rays()
    a, b = (along**2).sum(axis=2), along @ middle
    inside = b * b - a * (middle @ middle - radius**2)
    at = (b - np.sqrt(np.maximum(inside, 0.0))) / a
    normals = (at[..., None] * along - middle) / radius
    facing = -(normals * along).sum(axis=2) / np.sqrt(a)
    return at, normals, (inside > 0) & (facing > 0.35)


def plane(tilt=(0.3, -0.2)):
    """Distances and normals of a plane that leans; everywhere."""
    normal = np.array([-tilt[0], -tilt[1], 1.0])
    normal /= np.linalg.norm(normal)
    at = -normal[2] * 3.0 / (rays() @ normal)
    return at, np.broadcast_to(normal, (*SIZE, 3)), np.ones(SIZE, bool)


def expected(distance, where):
    """Height in pixels by the definition: a pixel where the mean of log distance is, f pixels away."""
    usual = np.exp(np.log(distance[where]).mean())
    height = FOCAL * (1.0 - distance / usual)
    return height - height[where].mean()


@pytest.mark.parametrize("method", ["masked", "bilateral"])
def test_a_ball_has_its_shape(method):
    distance, normals, seen = ball()
    found = integrate(normals.astype(np.float32), mask=seen, method=method, focal_length=FOCAL)
    wanted = expected(distance, seen)
    plain = integrate(normals.astype(np.float32), mask=seen, method=method)
    relief = np.ptp(wanted[seen])
    assert np.abs(found - wanted)[seen].mean() < 0.01 * relief
    assert np.abs(found - wanted)[seen].mean() < 0.2 * np.abs(plain - wanted)[seen].mean()


@pytest.mark.parametrize("method", ["dct", "frankot_chellappa", "masked"])
def test_a_leaning_plane_gets_its_distances(method):
    distance, normals, everywhere = plane()
    found = integrate(normals.astype(np.float32), method=method, focal_length=FOCAL)
    wanted = expected(distance, everywhere)
    assert np.abs(found - wanted).mean() < 0.03 * np.ptp(wanted)


def test_a_camera_far_away_is_the_limit():
    _, normals, seen = ball(away=30.0, radius=4.0)
    far = integrate(normals.astype(np.float32), mask=seen, focal_length=1e7)
    np.testing.assert_allclose(far, integrate(normals.astype(np.float32), mask=seen), atol=0.02)


@pytest.mark.parametrize("focal", [0.0, -5.0, 20.0, np.inf, np.nan])
def test_a_focal_length_that_cannot_be_is_refused(focal):
    _, normals, seen = ball()
    with pytest.raises(SurfaceError, match="focal length"):
        integrate(normals.astype(np.float32), mask=seen, focal_length=focal)
