"""Known surfaces: the heights by pencil, the normals against differences of the heights."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu_lab.simulation.lamps import normals_of
from rumu_lab.simulation.shapes import KnownSurface, bump, plane, ridges, sphere


@pytest.mark.parametrize(
    "shape",
    [
        bump((120, 140), peak=15.0, sigma=20.0),
        plane((30, 40), p=0.7, q=-0.9),
        ridges((120, 140), width=60.0, pitch=70.0, angle=25.0),
        sphere((140, 120), radius=50.0),
    ],
    ids=["bump", "plane", "ridges", "sphere"],
)
def test_exact_normals_agree_with_differences_where_the_surface_is_gentle(shape: KnownSurface) -> None:
    numeric = normals_of(shape.height)
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=-1), 1.0, atol=1e-12)
    gentle = shape.normals[..., 2] > 0.6
    # The foot of a ridge has a corner, where a difference means nothing.
    gentle &= np.abs(numeric[..., 2] - shape.normals[..., 2]) < 0.2
    inner = gentle[1:-1, 1:-1]
    assert inner.mean() > 0.3
    error = np.degrees(np.arccos(np.clip((numeric * shape.normals).sum(-1), -1, 1)))[1:-1, 1:-1][inner]
    assert np.median(error) < 0.3


def test_a_ridge_is_a_half_circle_as_high_as_it_is_wide_by_two() -> None:
    z = ridges((41, 201), width=20.0, pitch=50.0, angle=90.0).height[20]
    x = np.arange(201) - 100.0
    np.testing.assert_allclose(z[91:110], np.sqrt(100.0 - x[91:110] ** 2), atol=1e-9)
    assert z[115] == 0.0
    assert z[150] == pytest.approx(10.0), "the next crest is one pitch away"


def test_a_ball_is_as_high_as_its_radius_and_flat_outside() -> None:
    z, normals = sphere((101, 101), radius=4.0, spacing=0.1)
    assert z[50, 50] == pytest.approx(4.0)
    assert z[50, 74] == pytest.approx(np.sqrt(16.0 - 2.4**2))
    np.testing.assert_allclose(normals[50, 74], [0.6, 0.0, 0.8], atol=1e-12)
    np.testing.assert_array_equal(normals[0, 0], [0.0, 0.0, 1.0])


def test_a_plane_with_positive_q_is_higher_in_the_upper_rows() -> None:
    z = plane((11, 11), p=0.0, q=0.5).height
    assert z[0, 5] - z[10, 5] == pytest.approx(5.0)


def test_ridges_wider_than_their_pitch_are_refused() -> None:
    with pytest.raises(SurfaceError, match="pitch"):
        ridges((10, 10), width=5.0, pitch=2.0)
