"""Photographs of a copy: what is laid on the page lies where it is said to."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu_lab.simulation.photographs import (
    GRIDS,
    INKS,
    Grid,
    Shade,
    grid_cover,
    light_under,
    photograph,
    thin_pen,
)


def square() -> np.ndarray:
    ink = np.zeros((100, 100), bool)
    ink[30:70, 30:70] = True
    return ink


def test_the_same_seed_gives_the_same_photograph_and_ink_lies_in_the_middle():
    page = photograph(square(), side=200, fill=0.5, seed=4)
    assert page.shape == (200, 200, 3) and page.dtype == np.uint8
    np.testing.assert_array_equal(page, photograph(square(), side=200, fill=0.5, seed=4))
    assert not np.array_equal(page, photograph(square(), side=200, fill=0.5, seed=5))
    dark = page.max(axis=2) < 120
    assert dark[100, 100] and not dark[75, 100] and dark[84, 100] and 1400 < dark.sum() < 1800


@pytest.mark.parametrize("name", INKS)
def test_ink_has_its_colour(name):
    page = photograph(square(), side=200, colour=INKS[name], grain=0.0)
    np.testing.assert_allclose(page[90:110, 90:110].reshape(-1, 3).mean(axis=0), INKS[name], atol=6)


@pytest.mark.parametrize(("kind", "middle", "diagonal"), [("mi", 1, 1), ("tian", 1, 0), ("fang", 0, 0)])
def test_lines_of_a_grid_lie_where_they_belong(kind, middle, diagonal):
    cover = grid_cover(Grid(kind, cell=0.9, width=0.01, border_width=0.01), side=400)
    assert cover[20, 100] > 0.9 and cover[380, 100] > 0.9 and cover[100, 20] > 0.9 and cover[100, 379] > 0.9
    assert (cover[200, 100] > 0.9) == middle and (cover[100, 100] > 0.9) == diagonal
    assert cover[60, 100] == 0 and cover.max() <= 1


def test_nine_squares_inner_square_dashes_cells_lean_and_keystone():
    assert set(GRIDS) == {"mi", "tian", "jiu", "hui", "fang"}
    assert grid_cover(Grid("jiu", cell=0.9), side=400)[100, 139:142].max() > 0.5
    assert grid_cover(Grid("hui", cell=0.9), side=400)[150, 109:112].max() > 0.5
    whole, dashed = (grid_cover(Grid("tian", cell=0.9, dashed=d), side=400).sum() for d in (False, True))
    assert dashed < 0.95 * whole
    assert grid_cover(Grid("fang", cells=3, cell=0.6), side=400)[10, 80] > 0.5  # the upper neighbour's side
    leaning, level = (grid_cover(Grid("fang", cell=0.8, lean=lean), side=400) for lean in (5, 0))
    assert (level[:, 100] > 0.5).argmax() < (leaning[:, 100] > 0.5).argmax() - 4
    oblique = grid_cover(Grid("fang", cell=0.9, keystone=0.2), side=400)
    assert (oblique[60] > 0.5).argmax() > (oblique[340] > 0.5).argmax() + 10
    with pytest.raises(SurfaceError, match="expected a grid among"):
        grid_cover(Grid("round"), side=100)


@pytest.mark.parametrize(
    ("toward", "darkest"), [(0, (50, 99)), (90, (0, 50)), (180, (50, 0)), (270, (99, 50))]
)
def test_a_shade_is_deepest_on_its_side(toward, darkest):
    light = light_under(Shade(0.5, toward), side=100)
    assert light[darkest] == pytest.approx(0.5, abs=0.01) and light.max() == pytest.approx(1.0, abs=0.01)
    sharp = light_under(Shade(0.5, toward, 0.02), side=100)
    assert np.isin(np.round(sharp, 3), (0.5, 1.0)).mean() > 0.97


def test_a_thin_pen_draws_the_middle_of_the_strokes():
    ink = np.zeros((200, 200), bool)
    ink[95:106, 20:180] = True
    line = thin_pen(ink, width=0.02)
    assert line[100, 100] == 1 and 3 <= (line[:, 100] > 0.5).sum() <= 5 and line.shape == ink.shape
