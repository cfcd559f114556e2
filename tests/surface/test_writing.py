"""What is refused in place of writing, and the reason that is given."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.errors import RefusedImage
from rumu.gallery.starter import find_work, starter_samples
from rumu.surface.ink import find_ink
from rumu_lab.simulation.photographs import Grid, Shade, photograph, thin_pen


@pytest.fixture(scope="module")
def ink() -> np.ndarray:
    sample = next(s for s in starter_samples() if s.id == "regular-shui-good")
    return np.asarray(Image.open(sample.path).convert("L")) < 128


def refused(page: np.ndarray, work: str = "regular-shui") -> rumu.Assessment:
    mark = rumu.assess(page, rumu.relief(find_work(work).path))
    assert mark.score is None and mark.refused and mark.refused_zh
    return mark


@pytest.mark.parametrize("width", [0.006, 0.01, 0.013])
@pytest.mark.parametrize("work", ["regular-shui", "regular-tian"])
def test_lines_of_a_pen_are_too_thin(work, width):
    drawn = thin_pen(np.asarray(Image.open(find_work(work).path).convert("L")) < 128, width=width)
    mark = refused(photograph(drawn), work)
    assert mark.refused.startswith("too thin: ") and "pixels wide" in mark.refused
    assert "毛筆" in mark.refused_zh and "像素" in mark.refused_zh


def test_a_pen_in_a_printed_grid_is_too_thin(ink):
    mark = refused(photograph(thin_pen(ink, width=0.007), grid=Grid("tian", gray=120)))
    assert mark.refused.startswith("too thin: ")


def test_the_pen_that_went_wrong(cases):
    mark = refused(cases / "copies" / "shui-pen7.jpg")
    assert mark.refused.startswith("too thin: ") and "about 33 pixels wide" in mark.refused


def test_ruled_lines_are_still_ruled_lines():
    page = np.full((400, 400), 245, np.uint8)
    for row in range(60, 380, 60):
        cv2.line(page, (60, row), (320, row), 20, 2)
    with pytest.raises(RefusedImage, match="ruled lines only") as told:
        find_ink(page)
    assert told.value.reason == "blank"


@pytest.mark.parametrize("side", [12, 16, 24])
def test_a_picture_of_few_pixels_is_too_small(side, ink):
    mark = refused(cv2.resize(photograph(ink), (side, side), interpolation=cv2.INTER_AREA))
    assert mark.refused.startswith("too small: ") and f"{side} x {side}" in mark.refused
    assert f"{side} × {side}" in mark.refused_zh


@pytest.mark.parametrize("edge", [0.02, 0.15])
@pytest.mark.parametrize("toward", [0, 45, 180, 300])
def test_a_shadow_that_hides_a_part_is_uneven_light_and_never_nothing(toward, edge, ink):
    master = rumu.relief(find_work("regular-shui").path)
    plain = rumu.assess(photograph(ink), master, remarks=False).score
    for depth in (0.8, 0.95):
        mark = rumu.assess(photograph(ink, shade=Shade(depth, toward, edge)), master, remarks=False)
        if mark.refused is None:
            assert mark.score == pytest.approx(plain, abs=5)
        else:
            assert mark.refused.startswith("uneven light: ") and "光線" in mark.refused_zh
