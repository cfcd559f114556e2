"""Pictures: right side up, light from where it was asked for, the file that was promised."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

from rumu.report.pictures import (
    HEIGHT_STOPS,
    PAPER,
    RESIDUAL_STOPS,
    PictureSettings,
    albedo_picture,
    colour_scale,
    css_gradient,
    data_uri,
    height_picture,
    normals_picture,
    png_bytes,
    shaded_picture,
    share_picture,
    shrink_to_fit,
    srgb,
)


def opened(uri: str) -> Image.Image:
    return Image.open(io.BytesIO(base64.b64decode(uri.split(",", 1)[1])))


def test_srgb_at_known_values():
    linear = np.array([[0.0, 0.0031308, 0.21404114, 1.0, 2.0, -1.0]])
    assert srgb(linear).tolist() == [[0, 10, 128, 255, 255, 0]]  # 0.5 in sRGB is 0.214 in light
    assert srgb(linear, bits=16)[0, 2] == pytest.approx(32768, abs=2)


def test_a_picture_is_shrunk_and_never_enlarged():
    assert shrink_to_fit(np.zeros((100, 400), np.float32), side=200).shape == (50, 200)
    assert shrink_to_fit(np.zeros((3, 4), np.float32), side=200).shape == (3, 4)
    assert shrink_to_fit(np.ones((1, 4000, 3), np.float32), side=100).shape == (1, 100, 3)


@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_png_holds_exactly_what_was_given(shape, dtype):
    import cv2

    picture = np.random.default_rng(3).integers(0, np.iinfo(dtype).max, shape).astype(dtype)
    read = cv2.imdecode(np.frombuffer(png_bytes(picture), np.uint8), cv2.IMREAD_UNCHANGED)
    assert read.dtype == dtype
    np.testing.assert_array_equal(read if read.ndim == 2 else read[:, :, ::-1], picture)


def test_a_large_png_of_a_photograph_becomes_a_jpeg():
    noise = np.random.default_rng(3).integers(0, 255, (64, 64, 3)).astype(np.uint8)
    assert data_uri(noise).startswith("data:image/png;base64,")
    uri = data_uri(noise, settings=PictureSettings(jpeg_over=500))
    assert uri.startswith("data:image/jpeg;base64,") and opened(uri).size == (64, 64)


def test_ink_is_dark_and_paper_white(master_surface):
    picture = albedo_picture(master_surface)
    assert picture[master_surface.mask].max() < 100 and picture[0, 0] == 255


def test_light_comes_from_the_side_that_tilt_names(master_surface):
    """The standing stroke of 十 is a ridge: its right flank is bright under tilt 0, its left under 180."""
    row = 20
    columns = np.flatnonzero(master_surface.mask[row])
    for tilt, brighter, darker in ((0, columns[-2], columns[1]), (180, columns[1], columns[-2])):
        picture = shaded_picture(master_surface, tilt=tilt).astype(int).sum(axis=2)
        assert picture[row, brighter] > picture[row, darker] + 100


def test_light_from_the_top_brightens_the_upper_flank(master_surface):
    column = 20
    rows = np.flatnonzero(master_surface.mask[:, column])
    picture = shaded_picture(master_surface, tilt=90).astype(int).sum(axis=2)
    assert picture[rows[1], column] > picture[rows[-2], column] + 100


def test_normals_show_x_in_red_and_y_in_green(master_surface):
    picture = normals_picture(master_surface).astype(int)
    columns = np.flatnonzero(master_surface.mask[20])
    assert picture[20, columns[-2], 0] > 150
    assert picture[20, columns[1], 0] < 100
    assert picture[0, 0].tolist() == [128, 128, 255]


def test_height_has_a_range_in_its_unit(master_surface):
    picture, (low, high) = height_picture(master_surface)
    assert low == 0 and high == pytest.approx(master_surface.height.max(), rel=0.05)
    assert picture[0, 0].tolist() == list(HEIGHT_STOPS[0])
    assert picture[48, 20].astype(int).sum() > picture[0, 0].astype(int).sum()


def test_height_outside_of_what_was_measured_is_paper(master_surface):
    from dataclasses import replace

    picture, _ = height_picture(replace(master_surface, source="photometric"))
    assert picture[0, 0].tolist() == list(PAPER)


def test_a_flat_surface_has_a_picture_too(master_surface):
    from dataclasses import replace

    flat = replace(master_surface, height=np.zeros_like(master_surface.height))
    assert np.ptp(height_picture(flat)[0], axis=(0, 1)).max() == 0


def test_shares_are_gray():
    assert share_picture(np.array([[0.0, 0.5, 1.0, 7.0]])).tolist() == [[0, 128, 255, 255]]


def test_the_residual_scale_darkens_steadily():
    """Read in grey, a louder colour must not look quieter."""
    colours = colour_scale(np.linspace(0, 1, 20), stops=RESIDUAL_STOPS).astype(float)
    lightness = colours @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness[7:]) < 0).all() and lightness[-1] < 0.5 * lightness[0]
    assert colour_scale(np.array([-1.0, 9.0]), stops=RESIDUAL_STOPS).tolist() == [
        list(RESIDUAL_STOPS[0]),
        list(RESIDUAL_STOPS[-1]),
    ]


def test_a_gradient_for_the_page():
    assert css_gradient(((1, 2, 3), PAPER)) == "linear-gradient(90deg, rgb(1 2 3), rgb(250 247 240))"
