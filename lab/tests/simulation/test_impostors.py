"""Impostors are what they say, alike for one seed, and as large as the glyph they pass for."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.errors import SurfaceError
from rumu.gallery.starter import find_work
from rumu_lab.simulation.impostors import IMPOSTORS, impostor, picture_of


@pytest.fixture(scope="module")
def mask() -> np.ndarray:
    return np.asarray(Image.open(find_work("regular-shu").path)) < 128


def ink(picture: np.ndarray) -> np.ndarray:
    return picture < 128


@pytest.mark.parametrize("kind", IMPOSTORS)
def test_one_seed_makes_one_picture(kind, mask):
    first, again = (impostor(mask, kind, seed=4) for _ in range(2))
    assert first.dtype == np.uint8 and first.shape[:2] == mask.shape
    np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize("kind", ["one_stroke", "outline", "blobs", "scribble", "coloured_noise"])
def test_another_seed_makes_another(kind, mask):
    assert any((impostor(mask, kind, seed=0) != impostor(mask, kind, seed=s)).any() for s in (1, 2, 3))


def test_blank_and_black_hold_no_ink_and_nothing_else(mask):
    assert impostor(mask, "blank").min() > 200
    assert impostor(mask, "black").max() < 20


def test_reversed_ones_are_the_glyph_reversed(mask):
    assert (ink(impostor(mask, "mirrored"))[:, ::-1] == mask).mean() > 0.99
    assert (ink(impostor(mask, "upside_down"))[::-1, ::-1] == mask).mean() > 0.99


def test_one_stroke_is_a_part_of_the_glyph(mask):
    stroke = ink(impostor(mask, "one_stroke", seed=2))
    assert 0.02 < stroke.sum() / mask.sum() < 0.6
    assert (stroke & mask).sum() / stroke.sum() > 0.95


def test_an_outline_leaves_the_middle_of_strokes_empty(mask):
    from scipy.ndimage import distance_transform_edt

    line = ink(impostor(mask, "outline", seed=1))
    deep = distance_transform_edt(mask) > 5
    assert deep.any() and not (line & deep).any()
    edge = np.abs(distance_transform_edt(mask) - distance_transform_edt(~mask)) < 1.01
    assert (line & edge).sum() / edge.sum() > 0.8


@pytest.mark.parametrize("kind", ["blobs", "scribble"])
def test_made_up_ink_is_about_as_much_as_the_glyph_has(kind, mask):
    assert 0.3 < ink(impostor(mask, kind, seed=3)).sum() / mask.sum() < 1.6


def test_a_picture_of_ink_is_dark_on_light():
    page = picture_of(np.array([[0.0, 0.5, 1.0]]))
    assert page.dtype == np.uint8
    assert page[0, 0] > page[0, 1] > page[0, 2]


def test_what_is_unknown_or_empty_is_refused(mask):
    with pytest.raises(SurfaceError, match="expected an impostor among blank"):
        impostor(mask, "ghost")
    with pytest.raises(SurfaceError, match="ink"):
        impostor(np.zeros((20, 20), bool), "outline")
