"""Coloured ink where nothing is black; red marks and seals beside black ink stay what they are."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.errors import RefusedImage
from rumu.gallery.starter import find_work, starter_samples
from rumu.surface.colour import coloured_as_gray, is_seal
from rumu.surface.ink import find_ink
from rumu_lab.simulation.photographs import GRIDS, INKS, Grid, Shade, photograph


@pytest.fixture(scope="module")
def ink() -> np.ndarray:
    sample = next(s for s in starter_samples() if s.id == "regular-shui-good")
    return np.asarray(Image.open(sample.path).convert("L")) < 128


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


@pytest.mark.parametrize("name", INKS)
def test_ink_of_any_colour_is_ink(name, ink):
    assert iou(find_ink(photograph(ink, colour=INKS[name])).mask, find_ink(photograph(ink)).mask) > 0.97


@pytest.mark.parametrize("kind", GRIDS)
def test_red_writing_in_a_red_grid_is_found_and_the_grid_is_not(kind, ink):
    page = photograph(
        ink, colour=INKS["vermilion"], grid=Grid(kind, colour=(236, 130, 120)), shade=Shade(0.3, 30)
    )
    assert iou(find_ink(page).mask, find_ink(photograph(ink)).mask) > 0.93


def test_red_writing_in_a_black_grid(ink):
    page = photograph(ink, colour=INKS["red"], grid=Grid("mi", gray=60, width=0.004))
    assert iou(find_ink(page).mask, find_ink(photograph(ink)).mask) > 0.93


def test_black_writing_keeps_a_red_grid_and_a_seal_out(ink):
    page = photograph(ink, grid=Grid("mi", colour=(200, 40, 40), width=0.004))
    page[540:610, 540:610] = (190, 40, 36)
    assert iou(find_ink(page).mask, find_ink(photograph(ink)).mask) > 0.93


def test_the_page_that_went_wrong_has_the_mark_of_the_black_one(cases):
    master = rumu.relief(find_work("regular-shui").path)
    black, red = (rumu.assess(cases / "copies" / f"shui-{name}.jpg", master) for name in ("plain", "ink-red"))
    assert red.refused is None and red.score == pytest.approx(black.score, abs=5)


@pytest.mark.parametrize("half", [30, 60, 150])
def test_a_seal_alone_is_no_writing(half):
    page = photograph(np.zeros((64, 64), bool))
    cv2.rectangle(page, (320 - half, 320 - half), (320 + half, 320 + half), (190, 40, 36), max(4, half // 6))
    cv2.line(page, (320, 330 - half), (320, 310 + half), (190, 40, 36), max(4, half // 6))
    with pytest.raises(RefusedImage) as refused:
        find_ink(page)
    assert refused.value.reason == "blank"


def test_a_character_is_no_seal(ink):
    page = np.zeros((400, 400), bool)
    page[60:340, 60:340] = cv2.resize(ink.astype(np.uint8), (280, 280)) > 0
    assert not is_seal(page)
    tiny = np.zeros((400, 400), bool)
    tiny[300:360, 300:360] = True
    assert is_seal(tiny)


def test_paper_of_any_colour_is_gray_once_it_is_divided_out(ink):
    for paper in ((244, 240, 228), (214, 180, 130), (250, 220, 220)):
        gray = coloured_as_gray(photograph(ink, colour=INKS["red"], paper=paper, grain=0.5))
        assert np.percentile(gray, 90) > 0.9 * max(paper) and gray[find_ink(photograph(ink)).mask].mean() < 60


def test_an_empty_red_grid_is_a_blank_page():
    for kind in GRIDS:
        with pytest.raises(RefusedImage) as refused:
            find_ink(photograph(np.zeros((64, 64), bool), grid=Grid(kind, colour=(200, 40, 40))))
        assert refused.value.reason == "blank", kind
