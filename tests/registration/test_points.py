"""Ink points: which pixels they stand on, their frame, their heights and their directions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from rumu.errors import RegistrationError, SurfaceError
from rumu.registration.points import CANVAS, RADIUS, Sampling, canvas_of, normalise_height, sample_points

CANVAS_PIXEL = 1.0 / RADIUS


def bar(size: tuple[int, int], rows: slice, columns: slice) -> np.ndarray:
    mask = np.zeros(size, bool)
    mask[rows, columns] = True
    return mask


def slanted(
    angle: float, *, size: int = 256, half_width: float = 9.0, half_length: float = 90.0
) -> np.ndarray:
    """One straight stroke through the centre, `angle` degrees counter-clockwise from +x."""
    rows, columns = np.mgrid[:size, :size]
    x, y = columns - (size - 1) / 2, (size - 1) / 2 - rows
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return (np.abs(c * x + s * y) < 90) & (np.abs(c * y - s * x) < half_width)


# Eq. (17)


def test_heights_run_from_nought_to_one_over_the_ink():
    height = np.linspace(-3, 9, 10_000).reshape(100, 100)
    mask = np.zeros((100, 100), bool)
    mask[20:80] = True
    h = normalise_height(height, mask=mask)
    assert h[mask].min() == pytest.approx(0.0, abs=0.01)
    assert h[mask].max() == pytest.approx(1.0, abs=0.01)
    assert (h[~mask] == 0).all()
    inner = h[mask][100:-100]
    np.testing.assert_allclose(np.diff(inner), np.diff(inner)[0], rtol=1e-2)  # still linear


@pytest.mark.parametrize("outlier", [1e4, -1e4])
def test_one_outlier_does_not_set_the_scale(outlier):
    rng = np.random.default_rng(0)
    height, mask = rng.random((60, 60)), np.ones((60, 60), bool)
    clean = normalise_height(height, mask=mask)
    height[30, 30] = outlier
    spoilt = normalise_height(height, mask=mask)
    rest = np.ones_like(mask)
    rest[30, 30] = False
    np.testing.assert_allclose(spoilt[rest], clean[rest], atol=0.01)


def test_common_bounds_keep_a_higher_surface_higher():
    mask = np.ones((20, 20), bool)
    low = normalise_height(np.full((20, 20), 2.0), mask=mask, bounds=(0.0, 8.0))
    high = normalise_height(np.full((20, 20), 6.0), mask=mask, bounds=(0.0, 8.0))
    assert (low[0, 0], high[0, 0]) == (0.25, 0.75)


def test_a_flat_map_has_no_heights():
    with pytest.raises(SurfaceError, match=r"expected a height map with relief, got a flat one \(range 0\)"):
        normalise_height(np.full((9, 9), 4.0), mask=np.ones((9, 9), bool))


def test_noise_is_no_relief():
    height = np.random.default_rng(1).normal(0, 0.2, (100, 100))
    mask = np.ones((100, 100), bool)
    normalise_height(height, mask=mask)  # nothing was said about noise
    with pytest.raises(SurfaceError, match="flat one"):
        normalise_height(height, mask=mask, noise=0.2)
    normalise_height(height + np.linspace(0, 5, 100), mask=mask, noise=0.2)


def test_no_ink_has_no_heights():
    with pytest.raises(SurfaceError, match="got an empty mask"):
        normalise_height(np.ones((5, 5)), mask=np.zeros((5, 5), bool))


# where the points are


def test_points_stand_on_ink_and_cover_it(surface, glyph):
    mask = glyph("regular-shui") > 0.5
    points = sample_points(surface(mask))
    rows, columns = np.nonzero(mask)
    ink = np.column_stack([columns - columns.mean(), rows.mean() - rows]) * points.pixel
    to_ink, _ = cKDTree(ink).query(points.xyz[:, :2])
    assert to_ink.max() < CANVAS_PIXEL  # none on the sheet
    to_points, _ = cKDTree(points.xyz[:, :2]).query(ink)
    assert to_points.max() < 6 * CANVAS_PIXEL  # no ink left out
    assert len(points.xyz) > 600


def test_the_blank_sheet_does_not_enter(surface):
    """A measured surface is full of measured pixels; only those with ink are points."""
    mask = slanted(0.0) | slanted(90.0)
    page = np.full(mask.shape, 0.9, np.float32)
    page[mask] = 0.03
    height = 0.2 * np.random.default_rng(2).random(mask.shape) + mask
    whole = surface(np.ones_like(mask), height=height, source="photometric")
    object.__setattr__(whole, "albedo", page)
    points = sample_points(whole)
    small = surface(mask)
    ink = sample_points(small)
    assert points.radius == pytest.approx(ink.radius, rel=0.02)
    assert cKDTree(ink.xyz[:, :2]).query(points.xyz[:, :2])[0].max() < 5 * CANVAS_PIXEL


def test_the_frame_of_known_ink(surface):
    """A block 80 x 40 px in a sheet 400 wide and 200 high, 100 px right of its middle and 60 up."""
    mask = bar((200, 400), slice(20, 60), slice(260, 340))
    points = sample_points(surface(mask))
    radius = np.hypot(np.arange(80).std(), np.arange(40).std())
    assert points.radius == pytest.approx(radius / 400)
    assert points.pixel == pytest.approx(1 / radius)
    np.testing.assert_allclose(points.centre, (100 / 400, 60 / 400), atol=1e-12)
    assert points.cell == (1.0, 0.5)
    assert np.abs(points.xyz[:, 0]).max() == pytest.approx(40 / radius, abs=2 * CANVAS_PIXEL)
    assert np.abs(points.xyz[:, 1]).max() == pytest.approx(20 / radius, abs=2 * CANVAS_PIXEL)


def test_a_centred_character_has_its_centre_at_the_origin(surface):
    for side in (200, 201):
        mask = np.zeros((side, side), bool)
        mask[50 : side - 50, 80 : side - 80] = True
        np.testing.assert_allclose(sample_points(surface(mask)).centre, 0.0, atol=1e-12)


def test_y_is_up(surface):
    """A short stroke above a long one."""
    mask = bar((256, 256), slice(60, 80), slice(100, 156)) | bar((256, 256), slice(170, 190), slice(40, 216))
    points = sample_points(surface(mask))
    above = points.xyz[:, 1] > 0
    assert np.ptp(points.xyz[above, 0]) < 0.5 * np.ptp(points.xyz[~above, 0])
    assert points.centre[1] < 0  # most of the ink is in the lower half


def test_x_is_right(surface):
    mask = bar((256, 256), slice(30, 226), slice(60, 80)) | bar((256, 256), slice(120, 140), slice(180, 220))
    points = sample_points(surface(mask))
    right = points.xyz[:, 0] > 0.5
    assert np.ptp(points.xyz[right, 1]) < 0.5
    assert points.centre[0] < 0


def test_the_points_have_unit_rms_radius_about_the_origin(surface, glyph):
    for work in ("regular-shu", "seal-ri", "cursive-yue"):
        xy = sample_points(surface(glyph(work) > 0.5)).xyz[:, :2]
        np.testing.assert_allclose(xy.mean(axis=0), 0.0, atol=0.03)
        assert np.sqrt((xy**2).sum(axis=1).mean()) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("shift", [(37, -21), (-60, 44)])
def test_the_place_on_the_sheet_is_recorded_and_taken_out(surface, glyph, moved, shift):
    ink = glyph("regular-shui")
    here = sample_points(surface(moved(ink)))
    there = sample_points(surface(moved(ink, shift=shift)))
    assert len(there.xyz) == len(here.xyz)
    np.testing.assert_allclose(there.xyz, here.xyz, atol=0.02)
    np.testing.assert_allclose(there.centre - here.centre, np.array(shift) / 512, atol=1e-6)
    assert there.radius == pytest.approx(here.radius, rel=1e-9)


@pytest.mark.parametrize("scale", [0.5, 0.7])
def test_the_size_is_recorded_and_taken_out(surface, glyph, moved, scale):
    ink = glyph("regular-shui")
    whole, small = sample_points(surface(moved(ink))), sample_points(surface(moved(ink, scale=scale)))
    assert small.radius / whole.radius == pytest.approx(scale, rel=0.01)
    apart, nearest = cKDTree(whole.xyz[:, :2]).query(small.xyz[:, :2])
    assert np.sqrt((apart**2).mean()) < 2 * CANVAS_PIXEL
    # as high, in rms radii: a stroke half as wide in a character half the size is the same stroke
    assert small.xyz[:, 2].mean() == pytest.approx(whole.xyz[:, 2].mean(), rel=0.03)
    assert np.median(np.abs(small.xyz[:, 2] - whole.xyz[nearest, 2])) < 0.1


def test_a_stroke_twice_as_wide_is_twice_as_high(surface):
    """The inflated height keeps the unit of the page; half circles are as high as half a stroke is wide."""
    thin = sample_points(surface(slanted(0.0, half_width=5.0) | slanted(90.0, half_width=5.0)))
    wide = sample_points(surface(slanted(0.0, half_width=10.0) | slanted(90.0, half_width=10.0)))
    top = [np.percentile(p.xyz[np.abs(p.xyz[:, :2]).max(axis=1) > 0.5, 2], 95) for p in (thin, wide)]
    assert top[1] / top[0] == pytest.approx(2.0, rel=0.15)


def test_the_weight_of_the_height_is_zeta(surface, glyph):
    mask = glyph("regular-ren") > 0.5
    one, three = (sample_points(surface(mask), settings=Sampling(height_weight=z)) for z in (1.0, 3.0))
    np.testing.assert_allclose(three.xyz[:, 2], 3.0 * one.xyz[:, 2])
    np.testing.assert_array_equal(three.xyz[:, :2], one.xyz[:, :2])


# directions


@pytest.mark.parametrize(
    ("angle", "double"),
    [(0, (1, 0)), (45, (0, 1)), (90, (-1, 0)), (135, (0, -1)), (30, (0.5, 3**0.5 / 2)), (20, None)],
)
def test_the_direction_of_a_stroke(surface, angle, double):
    """0 is horizontal, 45 rises to the right: doubled, so that both ends of a stroke are one direction."""
    double = double or (np.cos(np.deg2rad(2 * angle)), np.sin(np.deg2rad(2 * angle)))
    points = sample_points(surface(slanted(angle)))
    along = points.xyz[:, :2] @ (np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle)))
    shaft = np.abs(along) < 0.7 * np.abs(along).max()
    np.testing.assert_allclose(np.median(points.direction[shaft], axis=0), double, atol=0.06)
    assert (points.direction[shaft] @ double > 0.9).mean() > 0.9


def test_directions_have_length_one_or_nought(surface, glyph):
    length = np.linalg.norm(sample_points(surface(glyph("running-shu") > 0.5)).direction, axis=1)
    assert ((np.abs(length - 1) < 1e-3) | (length < 1e-3)).mean() > 0.99
    assert length.max() < 1.0 + 1e-5


# sampling


def test_every_pixel_of_ink_on_the_canvas_is_a_point(surface, glyph):
    """So no choice of points moves a mark."""
    ink = glyph("regular-shu") > 0.5
    points, full = sample_points(surface(ink)), canvas_of(ink).solid
    at = np.rint((CANVAS - 1) / 2 + points.xyz[:, :2] * (RADIUS, -RADIUS)).astype(int)
    assert len(at) == np.count_nonzero(full)
    assert full[at[:, 1], at[:, 0]].all()


@pytest.mark.parametrize("count", [200, 900, 2000])
def test_about_as_many_points_as_asked(surface, glyph, count):
    """Squares that ink covers in part have a point too, so there are more than asked, most so of few."""
    points = sample_points(surface(glyph("regular-shui") > 0.5), settings=Sampling(count=count))
    assert 0.9 * count < len(points.xyz) < 1.5 * count


def test_points_do_not_clump(surface, glyph):
    points = sample_points(surface(glyph("regular-shui") > 0.5))
    apart = cKDTree(points.xyz[:, :2]).query(points.xyz[:, :2], k=2)[0][:, 1]
    assert apart.max() < 4 * np.median(apart)
    assert CANVAS == 172  # the distances above are in its pixels


# refused


def test_too_little_ink_is_refused(surface):
    for mask, n in ((bar((50, 50), slice(3, 6), slice(3, 8)), 15), (np.zeros((50, 50), bool), 0)):
        with pytest.raises(RegistrationError, match=f"at least 20 pixels of ink, got {n}$"):
            sample_points(surface(mask))


def test_a_speck_is_refused(surface):
    with pytest.raises(RegistrationError, match=r"rms radius of 2 pixels or more, got 1\.80"):
        sample_points(surface(bar((50, 50), slice(3, 7), slice(3, 8))))


@pytest.mark.parametrize("side", [400, 1600])
def test_a_hairline_still_has_points(surface, side):
    """Thinner than a pixel of the canvas, and yet ink."""
    points = sample_points(surface(bar((side, side), slice(200, 201), slice(20, side - 20))))
    assert len(points.xyz) >= 100
    assert np.ptp(points.xyz[:, 0]) > 3.3
    np.testing.assert_allclose(points.xyz[:, 1], 0.0, atol=2 * CANVAS_PIXEL)
