"""Normals to height: exact on harmonics, blind to curl, and right about which way is up."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.surface.integrate import INTEGRATORS, integrate
from rumu.surface.stereo import normals_from_gradients
from rumu_lab.simulation.shapes import bump, plane, sphere

METHODS = [name for name in INTEGRATORS if name != "auto"]


def disc(size, share=0.43):
    r, c = np.ogrid[:size, :size]
    return (r - (size - 1) / 2) ** 2 + (c - (size - 1) / 2) ** 2 < (share * size) ** 2


def off(height, wanted, mask=None):
    """Root mean square of the difference over the range of the relief, both centred."""
    mask = np.ones(wanted.shape, dtype=bool) if mask is None else mask
    difference = (height - wanted)[mask]
    return (difference - difference.mean()).std() / np.ptp(wanted[mask])


def wave(h, w, k, m):
    """A cosine of free edges, its exact slopes and its slopes between neighbours."""
    r, c = np.mgrid[:h, :w] + 0.5
    wc, wr = np.pi * k / w, np.pi * m / h
    z = 2.0 * np.cos(wc * c) * np.cos(wr * r)
    by_column = -2.0 * wc * np.sin(wc * c) * np.cos(wr * r)
    by_row = -2.0 * wr * np.cos(wc * c) * np.sin(wr * r)
    return z, by_column, by_row


def test_frankot_chellappa_is_exact_on_an_integrable_harmonic():
    z, by_column, by_row = wave(48, 64, 3, 2)
    height = integrate(normals_from_gradients(by_column, -by_row), method="frankot_chellappa")
    assert np.abs(height - z).max() < 1e-4


def test_dct_and_masked_are_exact_where_slopes_are_means_of_differences():
    # For z = x^2, xy, y^2 the mean of two slopes is the difference between two neighbours.
    r, c = np.mgrid[:40, :50].astype(float)
    z = 0.01 * c**2 - 0.02 * c * r + 0.005 * r**2 + 0.1 * r
    n = normals_from_gradients(0.02 * c - 0.02 * r, -(-0.02 * c + 0.01 * r + 0.1))
    for method in ("dct", "masked"):
        assert np.abs(integrate(n, method=method) - (z - z.mean())).max() < 0.002


@pytest.mark.parametrize("method", [name for name in METHODS if name != "bilateral"])
def test_a_pure_curl_gives_nothing(method):
    """But for the one that takes what contradicts itself for steps."""
    # The slopes of a stream function turned by a right angle: divergence 0, and 0 across the edges.
    h, w = 48, 64
    r, c = np.mgrid[:h, :w] + 0.5
    wc, wr = np.pi * 3 / w, np.pi * 2 / h
    by_column = 0.3 * wr * np.sin(wc * c) * np.cos(wr * r)
    by_row = -0.3 * wc * np.cos(wc * c) * np.sin(wr * r)
    height = integrate(normals_from_gradients(by_column, -by_row), method=method)
    assert np.abs(height).max() < 2e-3


@pytest.mark.parametrize("method", [*METHODS, "auto"])
def test_a_bump_comes_back(method):
    shape = bump((96, 128), peak=10.0, sigma=12.0)
    height = integrate(shape.normals, method=method)
    assert off(height, shape.height) < 1e-3
    assert height.dtype == np.float32 and abs(height.mean()) < 1e-4


def test_rows_grow_downward():
    tilted = integrate(plane((30, 40), p=0.0, q=0.5).normals)
    assert tilted[0].mean() > tilted[-1].mean()
    assert tilted[0, 0] - tilted[-1, 0] == pytest.approx(0.5 * 29, rel=1e-3)
    right = integrate(plane((30, 40), p=0.5, q=0.0).normals)
    assert right[0, -1] - right[0, 0] == pytest.approx(0.5 * 39, rel=1e-3)


def test_the_mask_keeps_the_background_out():
    ball, inside = sphere((128, 128), radius=58.0), disc(128)
    messy = np.where(inside[..., None], ball.normals, np.nan)
    masked = integrate(messy, mask=inside)
    assert off(masked, ball.height, inside) < 1e-3
    assert (masked[~inside] == 0).all()
    for method in ("dct", "frankot_chellappa"):
        assert off(integrate(messy, mask=inside, method=method), ball.height, inside) > 3 * off(
            masked, ball.height, inside
        )


def test_parts_that_do_not_touch_have_mean_zero_each():
    shape = plane((40, 60), p=0.3, q=0.0)
    mask = np.zeros((40, 60), dtype=bool)
    mask[5:20, 5:20] = mask[25:35, 40:55] = True
    height = integrate(shape.normals, mask=mask)
    assert abs(height[5:20, 5:20].mean()) < 1e-4 and abs(height[25:35, 40:55].mean()) < 1e-4
    assert height[10, 19] - height[10, 5] == pytest.approx(0.3 * 14, rel=1e-3)


def test_weights_shut_a_liar_out():
    shape = bump((64, 64), peak=6.0, sigma=9.0)
    lying = shape.normals.copy()
    lying[20:24, 20:44] = normals_from_gradients(np.full((4, 24), 5.0), np.full((4, 24), -5.0))
    trust = np.ones((64, 64))
    trust[20:24, 20:44] = 0.0
    naive, wary = integrate(lying), integrate(lying, weights=trust)
    assert off(wary, shape.height) < 0.1 * off(naive, shape.height)


@pytest.mark.parametrize("method", METHODS)
def test_any_normals_give_a_finite_height(method):
    rng = np.random.default_rng(2)
    n = rng.normal(size=(33, 47, 3))
    n[..., 2] += 0.1  # a little less than half of them point away
    n[3, 4] = 0.0
    n[5, 6] = (1.0, 0.0, 0.0)
    height = integrate(n, method=method)
    assert np.isfinite(height).all() and np.abs(height).max() < 10 * 80


def test_odd_sizes_agree_between_the_methods():
    shape = bump((57, 91), peak=5.0, sigma=8.0)
    heights = [integrate(shape.normals, method=method) for method in METHODS]
    for one in heights[1:]:
        assert np.abs(one - heights[0]).max() < 0.02


def test_bad_input_is_refused():
    n = np.tile([0.0, 0.0, 1.0], (8, 9, 1))
    with pytest.raises(SurfaceError, match=r"normals of shape \(H >= 2"):
        integrate(np.zeros((8, 9)))
    with pytest.raises(SurfaceError, match="got 'magic'"):
        integrate(n, method="magic")
    with pytest.raises(SurfaceError, match="bool mask"):
        integrate(n, mask=np.ones((9, 8), dtype=bool))
    with pytest.raises(SurfaceError, match="empty"):
        integrate(n, mask=np.zeros((8, 9), dtype=bool))
    n[2, 3, 0] = np.nan
    with pytest.raises(SurfaceError, match="1 pixels that hold NaN"):
        integrate(n)


@pytest.mark.parametrize("masked", [False, True])
def test_bands_do_not_show(masked, monkeypatch):
    shape = bump((57, 91), peak=5.0, sigma=8.0)
    mask = disc(91)[17:74] if masked else None
    whole = integrate(shape.normals, mask=mask)
    monkeypatch.setattr("rumu.surface.integrate._BAND", 91 * 7)
    monkeypatch.setattr("rumu.surface.neighbours._ROWS_IN_CACHE", 91 * 5)
    assert np.abs(integrate(shape.normals, mask=mask) - whole).max() < 1e-4


def test_a_corner_of_a_large_sheet_is_integrated_where_it_lies():
    shape = bump((40, 53), peak=5.0, sigma=8.0)
    mask, normals = np.zeros((150, 160), bool), np.full((150, 160, 3), np.nan)
    mask[31:71, 90:143], normals[31:71, 90:143] = True, shape.normals
    height = integrate(normals, mask=mask)
    assert off(height, np.pad(shape.height, ((31, 79), (90, 17))), mask) < 1e-3
    assert (height[~mask] == 0).all()
