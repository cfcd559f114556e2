"""Inflation against its closed forms, and the surface made of it."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.capture.image import read_image, to_linear
from rumu.errors import RefusedImage, SurfaceError
from rumu.surface.inflation import InflationSettings
from rumu.surface.ink import find_ink
from rumu.surface.relief import half_width, inflate, relief

EXACT = InflationSettings(tolerance=1e-6, iterations=400)


def disk(radius: float, side: int) -> np.ndarray:
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    return np.hypot(rows, columns) < radius


def cross(side: int = 200) -> np.ndarray:
    mask = np.zeros((side, side), bool)
    mask[90:114, 30:170] = True
    mask[40:160, 84:102] = True
    return mask


def picture(mask: np.ndarray, *, dark: float = 0.1) -> np.ndarray:
    return np.where(mask, dark, 0.9).astype(np.float32)


# --- inflation ------------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1, 2, 7, 20, 33])
def test_a_strip_inflates_to_a_half_circle(width):
    mask = np.zeros((60, 60 + 20 * width), bool)
    mask[10 : 10 + width, 5:-5] = True
    profile = inflate(mask, settings=EXACT)[:, mask.shape[1] // 2]
    offset = np.arange(60) - (10 + (width - 1) / 2)
    circle = np.sqrt(np.maximum((width / 2) ** 2 - offset**2, 0))
    np.testing.assert_allclose(profile, circle, atol=2e-3 * width)


def test_the_default_tolerance_is_within_half_a_percent():
    for mask in (cross(), disk(70, 160), np.pad(np.ones((120, 120), bool), 4)):
        exact = inflate(mask, settings=EXACT)
        assert np.abs(inflate(mask) - exact).max() < 0.005 * exact.max()


def test_a_disk_inflates_to_an_ellipsoid():
    height = inflate(disk(60, 140), settings=EXACT)
    rows, columns = np.mgrid[:140, :140] - 69.5
    ellipsoid = np.sqrt(np.maximum(60**2 - rows**2 - columns**2, 0) / 2)
    assert height.max() == pytest.approx(60 / np.sqrt(2), rel=0.005)
    assert np.abs(height - ellipsoid)[disk(55, 140)].max() < 0.02 * height.max()


def test_a_filled_square_of_400_pixels_converges():
    mask = np.pad(np.ones((400, 400), bool), 6)
    # Torsion of a square bar: the potential at the centre is 0.0736713 of the side squared.
    assert inflate(mask).max() == pytest.approx(400 * np.sqrt(2 * 0.0736713), rel=1e-3)


def test_speckle_and_hair_gaps_converge():
    mask = np.random.default_rng(2).random((200, 200)) < 0.4
    comb = np.ones((200, 200), bool)
    comb[:, ::9] = False
    for ink in (mask, comb):
        assert np.abs(inflate(ink) - inflate(ink, settings=EXACT)).max() < 0.05


def test_height_is_zero_off_the_ink_and_positive_on_it():
    mask = cross()
    height = inflate(mask)
    assert height.dtype == np.float32
    assert not height[~mask].any()
    assert (height[mask] > 0).all()


def test_a_symmetric_mask_inflates_symmetrically():
    height = inflate(disk(40, 100), settings=EXACT)
    for turned in (height[::-1], height[:, ::-1], height.T):
        np.testing.assert_allclose(height, turned, atol=1e-3)


def test_more_ink_is_never_lower():
    small = cross()
    large = small.copy()
    large[1:] |= small[:-1]
    large[:, 1:] |= small[:, :-1]
    assert (inflate(large, settings=EXACT) >= inflate(small, settings=EXACT) - 1e-3).all()


def test_ink_at_the_border_of_the_picture_is_cut_there():
    whole = np.ones((20, 300), bool)
    np.testing.assert_allclose(inflate(whole), inflate(np.pad(whole, 3))[3:-3, 3:-3], atol=1e-4)


def test_no_ink_has_no_height_and_no_mask_is_an_error():
    assert not inflate(np.zeros((10, 12), bool)).any()
    with pytest.raises(SurfaceError, match=r"bool mask of shape \(H, W\), got float64 \(3, 3, 3\)"):
        inflate(np.zeros((3, 3, 3)))


# --- the surface ----------------------------------------------------------------------------------


def test_a_relief_is_a_surface_in_pixels_that_says_its_source():
    surface = relief(picture(cross()))
    np.testing.assert_array_equal(surface.mask, cross())
    np.testing.assert_allclose(surface.height, inflate(cross()))
    assert (surface.unit, surface.spacing, surface.source) == ("px", 1.0, "inflation")
    np.testing.assert_array_equal(surface.confidence, cross().astype(np.float32))
    np.testing.assert_allclose(surface.albedo, to_linear(picture(cross())), atol=1e-6)
    assert surface.quality["ink_share"] == pytest.approx(cross().mean())
    assert surface.quality["contrast"] == pytest.approx(8 / 9, abs=0.01)
    assert surface.quality["half_width"] == pytest.approx(10, abs=2)


def test_normals_stand_on_the_slopes_and_up_on_paper():
    surface = relief(picture(cross()))
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=2), 1, atol=1e-5)
    assert (surface.normals[5, 5] == (0, 0, 1)).all()
    right, left = surface.normals[60, 99], surface.normals[60, 86]
    top, bottom = surface.normals[92, 50], surface.normals[111, 50]
    assert right[0] > 0.3 and left[0] < -0.3
    assert top[1] > 0.3 and bottom[1] < -0.3, "y points up, rows grow downward"


def test_density_is_a_height_of_its_own():
    faded = picture(cross())
    faded[:, :93][cross()[:, :93]] = 0.3
    surface = relief(faded, method="density")
    assert surface.source == "density"
    dark, pale = surface.height[100, 150], surface.height[100, 50]
    assert pale / dark == pytest.approx((1 - 0.3 / 0.9) / (1 - 0.1 / 0.9), rel=0.02)
    assert dark == pytest.approx((8 / 9) * surface.quality["half_width"], rel=0.02)
    np.testing.assert_array_equal(relief(faded).mask, surface.mask)


def test_homogeneous_strokes_reach_one_height():
    two = np.zeros((200, 200), bool)
    two[40:50, 20:180] = two[100:140, 20:180] = True
    thin, wide = (slice(40, 50), 100), (slice(100, 140), 100)
    by_width, even, between = (
        relief(picture(two), mode=m).height for m in ("inhomogeneous", "homogeneous", "hybrid")
    )
    assert by_width[wide].max() / by_width[thin].max() == pytest.approx(4, rel=0.05)
    assert even[wide].max() / even[thin].max() == pytest.approx(1, rel=0.1)
    np.testing.assert_allclose(between, (by_width + even) / 2, atol=1e-4)


def test_kappa_raises_ink_that_is_denser_than_the_ink_around_it():
    streaked = picture(cross(), dark=0.3)
    streaked[98:104, 30:170] = 0.05
    plain, detailed = relief(streaked), relief(streaked, kappa=5.0)
    assert detailed.height[101, 40] > plain.height[101, 40] + 0.3
    assert detailed.height[92, 40] < plain.height[92, 40]
    assert not detailed.height[~plain.mask].any()
    assert (detailed.height >= 0).all()


def test_an_ink_will_do_for_an_image():
    image = picture(cross(), dark=0.4)
    surface, again = relief(image), relief(find_ink(image))
    np.testing.assert_array_equal(surface.height, again.height)
    np.testing.assert_allclose(surface.albedo, again.albedo, atol=0.01)


def test_colour_is_kept_in_the_albedo():
    image = picture(cross())[:, :, None] * np.array([0.9, 0.75, 0.5], np.float32)
    surface = relief(image)
    assert surface.albedo.shape == (200, 200, 3)
    np.testing.assert_allclose(surface.albedo[0, 0], to_linear(image)[0, 0], atol=1e-5)


def test_half_width_of_a_strip():
    strip = np.zeros((80, 300), bool)
    strip[20:41, 10:290] = True
    assert half_width(strip) == pytest.approx(10.5, abs=0.6)
    assert half_width(np.zeros((9, 9), bool)) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "photometric"}, "method: expected one of inflation, density, got 'photometric'"),
        ({"mode": "flat"}, "mode: expected one of inhomogeneous, homogeneous, hybrid, got 'flat'"),
        ({"kappa": np.nan}, "kappa: expected a finite number, got nan"),
    ],
)
def test_wrong_settings_are_errors(arguments, message):
    with pytest.raises(SurfaceError, match=message):
        relief(picture(cross()), **arguments)


def test_a_refusal_names_the_file(tmp_path):
    from PIL import Image

    Image.new("L", (64, 64), 230).save(tmp_path / "empty.png")
    with pytest.raises(RefusedImage, match=r"empty\.png: expected writing") as refused:
        relief(tmp_path / "empty.png")
    assert refused.value.reason == "blank"


def test_a_real_copy_from_its_file(data):
    file = sorted((data / "e3c" / "copies").iterdir())[0]
    surface = relief(file)
    np.testing.assert_allclose(surface.height, relief(read_image(file)).height)
    assert 3 < surface.quality["half_width"] < 40
    assert surface.height.max() < 40


def test_a_large_picture_is_worked_at_a_smaller_size(tmp_path):
    page = np.full((3000, 4400), 230, np.uint8)
    page[800:2200, 1800:2100] = 30
    page[1400:1700, 1000:3200] = 30
    Image.fromarray(page).save(tmp_path / "large.png", compress_level=1)
    Image.fromarray(page[:2800, :4400]).save(tmp_path / "phone.png", compress_level=1)
    large, phone = relief(tmp_path / "large.png"), relief(tmp_path / "phone.png")
    assert phone.height.shape == (2800, 4400) and "reduced" not in phone.quality
    assert large.height.size == pytest.approx(6_300_000, rel=0.001)
    reduced = large.quality["reduced"]
    assert reduced == pytest.approx(4400 / large.height.shape[1])
    assert large.quality["half_width"] * reduced == pytest.approx(phone.quality["half_width"], rel=0.02)
