"""Printed grids are taken off the page, whatever their gray; strokes are not, however straight."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.capture.image import read_image
from rumu.gallery.starter import find_work, starter_samples
from rumu.pipeline import PreparedMaster
from rumu.surface.grid import remove_grid
from rumu.surface.ink import InkMaskSettings, find_ink
from rumu.surface.paper import PAPER_GRAY
from rumu_lab.simulation.photographs import GRIDS, Grid, photograph

SAMPLE = "regular-shui-good"


@pytest.fixture(scope="module")
def ink() -> np.ndarray:
    sample = next(s for s in starter_samples() if s.id == SAMPLE)
    return np.asarray(Image.open(sample.path).convert("L")) < 128


@pytest.fixture(scope="module")
def master() -> PreparedMaster:
    return PreparedMaster(rumu.relief(find_work("regular-shui").path))


@pytest.fixture(scope="module")
def plain(ink, master) -> rumu.Assessment:
    return rumu.assess(photograph(ink), master)


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


@pytest.mark.parametrize("gray", [40, 90, 165])
@pytest.mark.parametrize("kind", GRIDS)
def test_a_grid_of_any_gray_leaves_the_ink_and_the_mark(kind, gray, ink, master, plain):
    for width in (0.003, 0.007):
        page = photograph(ink, grid=Grid(kind, gray=gray, width=width, border_width=1.6 * width), seed=gray)
        found = find_ink(page)
        assert found.left_out["grid"] + found.left_out["frame"] > 500  # a border may be cut off as a frame
        assert iou(found.mask, find_ink(photograph(ink)).mask) > 0.93
        mark = rumu.assess(page, master)
        assert mark.refused is None and mark.score == pytest.approx(plain.score, abs=5)


@pytest.mark.parametrize(
    "grid",
    [
        Grid("mi", gray=75, lean=2.5),
        Grid("tian", gray=75, lean=-1.0, dashed=True, width=0.005),
        Grid("mi", gray=120, keystone=0.06),
        Grid("jiu", gray=60, cells=3, cell=0.8),
        Grid("hui", gray=100, cells=3, cell=0.7, lean=1.0),
        Grid("mi", colour=(112, 62, 142), width=0.005),
    ],
    ids=["leaning", "dashed", "oblique", "several cells", "smaller cells", "purple"],
)
def test_a_grid_that_leans_or_is_dashed_or_one_of_many_or_purple(grid, ink, master, plain):
    mark = rumu.assess(photograph(ink, grid=grid, seed=3), master)
    assert mark.refused is None and mark.score == pytest.approx(plain.score, abs=5)
    assert "missing" not in " ".join(remark.en for remark in mark.remarks)


@pytest.mark.parametrize("name", ["black", "gray100", "gray130"])
def test_pages_that_went_wrong_under_a_grid(name, cases, master):
    expected = rumu.assess(cases / "copies" / "shui-plain.jpg", master)
    mark = rumu.assess(cases / "copies" / f"shui-grid-{name}.jpg", master)
    assert mark.refused is None and mark.score == pytest.approx(expected.score, abs=5)


def drawn(*lines: tuple[tuple[int, int], tuple[int, int]], width: int) -> np.ndarray:
    """A page divided by its paper, (400, 400), with straight strokes of one width."""
    page = np.full((400, 400), PAPER_GRAY, np.uint8)
    for a, b in lines:
        cv2.line(page, a, b, 25, width, cv2.LINE_AA)
    return page


SQUARE = (((80, 80), (320, 80)), ((320, 80), (320, 320)), ((320, 320), (80, 320)), ((80, 320), (80, 80)))


@pytest.mark.parametrize(
    "page",
    [
        drawn(((70, 200), (330, 200)), width=22),
        drawn(((70, 200), (330, 200)), ((200, 60), (200, 340)), width=4),
        drawn(*SQUARE, ((80, 200), (320, 200)), ((200, 80), (200, 320)), width=12),
        drawn(((60, 60), (340, 340)), ((340, 60), (60, 340)), width=4),
    ],
    ids=["一", "thin 十", "田", "thin 乂"],
)
def test_straight_strokes_alone_are_no_grid(page):
    clean, pixels = remove_grid(page)
    assert pixels == 0
    np.testing.assert_array_equal(clean, page)


def test_thin_strokes_beside_thick_ones_are_no_grid():
    page = drawn(((60, 120), (340, 120)), ((200, 50), (200, 350)), width=4)
    cv2.line(page, (80, 300), (320, 290), 25, 24)
    np.testing.assert_array_equal(remove_grid(page)[0], page)


@pytest.mark.parametrize("gray", [40, 110])
def test_a_stroke_that_lies_on_a_line_stays(gray):
    stroke = np.zeros((512, 512), np.uint8)
    cv2.line(stroke, (90, 256), (420, 250), 1, 26)
    cv2.line(stroke, (256, 80), (252, 430), 1, 24)
    page = photograph(stroke, fill=1.0, side=512, grid=Grid("mi", gray=gray))
    assert iou(find_ink(page).mask, stroke > 0) > 0.93


def test_learners_pages_and_masters_hold_no_grid(data):
    pages = [
        *sorted((data / "e3c" / "templates").glob("*.png")),
        *sorted((data / "e3c" / "copies").glob("*.png")),
    ]
    for path in pages[::9]:
        x = np.rint(PAPER_GRAY * np.atleast_3d(read_image(path)).mean(axis=2)).astype(np.uint8)
        assert remove_grid(x)[1] == 0, path.name


def test_an_empty_grid_is_a_blank_page():
    for kind in GRIDS:
        with pytest.raises(rumu.RumuError) as refused:
            find_ink(photograph(np.zeros((64, 64), bool), grid=Grid(kind, gray=70)))
        assert refused.value.reason == "blank"


def test_no_grid_is_looked_for_where_there_can_be_none(ink):
    page = photograph(ink, grid=Grid("mi", gray=90))
    assert find_ink(page).left_out["grid"] > 0
    without = find_ink(page, settings=InkMaskSettings(grid=False))
    assert without.left_out["grid"] < find_ink(page).left_out["grid"]
    clean = photograph(ink)
    assert (find_ink(clean).mask == find_ink(clean, settings=InkMaskSettings(grid=False)).mask).all()


def test_strokes_of_a_character_of_forty_pixels_are_no_grid():
    page = np.full((44, 44), PAPER_GRAY, np.uint8)
    for at in (10, 20, 30):
        page[at : at + 2] = page[:, at : at + 2] = 40
    assert remove_grid(page)[1] == 0
