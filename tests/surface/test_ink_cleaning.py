"""What is dark and no stroke of the character: remains of seals, stains, strokes of a neighbour."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.surface.ink import find_ink
from rumu.surface.ink_cleaning import remove_by_colour
from rumu.values import BoolArray

PAPER = np.array([190, 180, 150], np.uint8)
BLACK, BROWN = (40, 38, 36), (105, 72, 58)


def page(*parts: tuple[int, int, int, int, tuple[int, int, int]]) -> np.ndarray:
    """200 x 200 paper with rectangles (top, bottom, left, right, colour) and a little grain."""
    view = np.tile(PAPER, (200, 200, 1))
    for top, bottom, left, right, colour in parts:
        view[top:bottom, left:right] = colour
    grain = np.random.default_rng(3).integers(-4, 5, (200, 200, 1))
    return np.asarray(np.clip(view.astype(int) + grain, 0, 255), np.uint8)


CROSS = ((60, 80, 40, 140, BLACK), (30, 150, 80, 100, BLACK))


def test_remains_of_a_seal_are_left_out_and_a_black_dot_in_their_place_is_not() -> None:
    place = (40, 55, 150, 165)
    with_seal, with_dot = (find_ink(page(*CROSS, (*place, colour))) for colour in (BROWN, BLACK))
    assert not with_seal.mask[40:55, 150:165].any()
    assert with_seal.left_out["seal"] > 150
    assert with_dot.mask[40:55, 150:165].mean() > 0.9
    assert with_seal.mask[62:78, 45:135].mean() > 0.9


def test_what_reaches_in_over_one_side_is_a_neighbours() -> None:
    beside = ((40, 70, 180, 200, BLACK), (90, 140, 175, 190, BLACK), (100, 104, 188, 200, BLACK))
    ink = find_ink(page(*CROSS, *beside))
    assert not ink.mask[:, 160:].any()
    assert ink.left_out["neighbour"] > 500


def masked(*parts: tuple[int, int, int, int, float]) -> tuple[BoolArray, np.ndarray]:
    density = np.zeros((200, 200), np.float32)
    for top, bottom, left, right, dark in parts:
        density[top:bottom, left:right] = dark
    return density > 0, density


@pytest.mark.parametrize(("noise", "kept"), [(5.0, False), (20.0, True)])
def test_a_pale_part_is_a_stain_on_grainy_paper_and_a_dry_dot_on_clean(noise: float, kept: bool) -> None:
    mask, density = masked((60, 100, 40, 140, 0.8), (140, 150, 90, 100, 0.4))
    own, removed = remove_by_colour(mask, density, redness=None, noise=noise, framed=False)
    assert own[140:150, 90:100].all() == kept
    assert removed["stain"] == (0 if kept else 100)
    assert own[60:100, 40:140].all()


def test_a_pale_part_beside_a_dark_one_is_its_dry_end() -> None:
    mask, density = masked((60, 100, 40, 140, 0.8), (103, 112, 90, 100, 0.4))
    own, _ = remove_by_colour(mask, density, redness=None, noise=5.0, framed=False)
    assert np.array_equal(own, mask)


def test_only_in_a_frame_may_a_neighbour_end_short_of_the_side() -> None:
    mask, density = masked((60, 100, 40, 120, 0.8), (50, 110, 175, 190, 0.8))
    for framed in (False, True):
        own, _ = remove_by_colour(mask, density, redness=None, noise=20.0, framed=framed)
        assert own[:, 160:].any() != framed


def test_a_character_cropped_to_its_ink_keeps_the_parts_at_its_sides() -> None:
    mask, density = masked((20, 180, 0, 30, 0.8), (40, 170, 70, 130, 0.8), (10, 190, 170, 200, 0.8))
    own, _ = remove_by_colour(mask, density, redness=None, noise=20.0, framed=False)
    assert np.array_equal(own, mask)
    own, removed = remove_by_colour(
        mask & (np.arange(200) >= 60), density, redness=None, noise=20.0, framed=False
    )
    assert removed["neighbour"] == 180 * 30  # nothing at the other side: a part is cut off by this one
