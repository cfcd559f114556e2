"""The cell: its frame, its measures, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rumu
from rumu.errors import RegistrationError
from rumu.gallery.starter import find_work
from rumu_lab.baselines.cell import SIDE, Cell, Raw, cell_from, cell_of


def bar(height: int, width: int, *, rows: slice, columns: slice) -> np.ndarray:
    ink = np.zeros((height, width), bool)
    ink[rows, columns] = True
    return ink


def test_the_frame_of_the_cell_is_kept() -> None:
    cell = cell_from(bar(512, 512, rows=slice(64, 128), columns=slice(256, 448)))
    rows, columns = np.nonzero(cell.ink)
    assert (rows.min(), rows.max() + 1) == (32, 64)
    assert (columns.min(), columns.max() + 1) == (128, 224)


def test_an_oblong_picture_is_padded_on_both_sides_and_not_stretched() -> None:
    cell = cell_from(bar(512, 256, rows=slice(0, 512), columns=slice(0, 256)))
    rows, columns = np.nonzero(cell.ink)
    assert (rows.min(), rows.max() + 1) == (0, 256)
    assert (columns.min(), columns.max() + 1) == (64, 192)


@pytest.mark.parametrize("width", [5, 11, 21])
def test_the_stroke_width_is_that_of_the_bar(width: int) -> None:
    cell = cell_from(bar(SIDE, SIDE, rows=slice(100, 100 + width), columns=slice(20, 230)))
    assert cell.width == pytest.approx(width, abs=0.5)


def test_the_skeleton_of_a_bar_is_its_middle_line() -> None:
    cell = cell_from(bar(SIDE, SIDE, rows=slice(100, 111), columns=slice(20, 230)))
    rows, columns = np.nonzero(cell.skeleton)
    assert abs(np.median(rows) - 105) <= 1
    assert len(columns) == np.ptp(columns) + 1 > 190


def test_a_hairline_of_a_large_picture_survives() -> None:
    cell = cell_from(bar(2048, 2048, rows=slice(1000, 1002), columns=slice(200, 1800)))
    assert np.count_nonzero(cell.ink.any(axis=0)) >= 200


def test_a_surface_s_density_is_how_dark_its_ink_is() -> None:
    surface = rumu.relief(find_work("regular-shui").path)
    cell = cell_of(surface)
    assert cell.density[cell.ink].mean() > 0.9
    assert cell.density[~cell.ink].mean() < 0.01
    tone = np.where(surface.mask, 0.5, 1.0).astype(np.float32)
    pale = cell_of(replace(surface, albedo_from=tone**2.2))
    inner = pale.depth > 2
    assert pale.density[inner].mean() == pytest.approx(0.5, abs=0.02)


def test_a_rubbing_s_density_is_that_of_its_light_strokes() -> None:
    surface = rumu.relief(find_work("regular-shui").path)
    cell = cell_of(replace(surface, albedo_from=np.where(surface.mask, 0.9, 0.05).astype(np.float32)))
    assert cell.density[cell.depth > 2].mean() > 0.8
    assert cell.density[~cell.ink].mean() < 0.01


@pytest.mark.parametrize(
    "ink", [np.zeros((64, 64), bool), np.ones((64, 64), np.uint8), np.ones((4, 4, 3), bool)]
)
def test_what_is_no_mask_with_ink_is_refused(ink: np.ndarray) -> None:
    with pytest.raises(RegistrationError, match="expected"):
        cell_from(ink)


def test_a_speck_is_too_little() -> None:
    with pytest.raises(RegistrationError, match="at least 20 pixels"):
        cell_from(bar(SIDE, SIDE, rows=slice(3, 5), columns=slice(3, 5)))


def test_a_cell_has_one_size() -> None:
    with pytest.raises(RegistrationError, match=r"expected ink of \(256, 256\) bool"):
        Cell(np.ones((64, 64), bool), np.ones((64, 64), np.float32))


@pytest.mark.parametrize("value", [-0.1, 1.1, float("nan")])
def test_a_raw_grade_lies_between_0_and_1(value: float) -> None:
    with pytest.raises(RegistrationError, match="raw grade"):
        Raw(value)


def test_features_are_finite() -> None:
    with pytest.raises(RegistrationError, match="finite features"):
        Raw(0.5, {"slant": float("inf")})
