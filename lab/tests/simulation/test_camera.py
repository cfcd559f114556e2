"""The camera's picture and its map agree; conditions do what they say."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rumu.errors import ImageError
from rumu_lab.simulation.camera import Conditions, draw_conditions, take_photograph

SHEET = (1400, 1000)
DOTS = np.array([[x, y] for y in (60, 480, 700, 1340) for x in (60, 300, 500, 940)], float)


def dotted() -> np.ndarray:
    flat = np.full((*SHEET, 3), 235, np.uint8)
    for x, y in DOTS:
        cv2.circle(flat, (int(x), int(y)), 12, (20, 20, 20), -1, cv2.LINE_AA)
    return flat


def middle_of_dot(picture: np.ndarray, at: np.ndarray, reach: int = 14) -> np.ndarray:
    """The dark around a point, weighted by how dark it is."""
    column, row = np.round(at).astype(int)
    part = picture[row - reach : row + reach + 1, column - reach : column + reach + 1].mean(axis=2)
    dark = np.clip(part.max() - part - 60.0, 0, None)
    rows, columns = np.mgrid[row - reach : row + reach + 1, column - reach : column + reach + 1]
    return np.array([(dark * columns).sum(), (dark * rows).sum()]) / dark.sum()


@pytest.mark.parametrize(
    "conditions",
    [
        Conditions(megapixels=3),
        Conditions(megapixels=3, turn=20, fill=0.6),
        Conditions(megapixels=3, tilt=35, towards=60, distance=1.6, fill=0.6),
        Conditions(megapixels=3, bend=0.03, tilt=20, towards=200, fill=0.7),
        Conditions(megapixels=3, bend=0.03, bend_along=True, tilt=20, towards=10, fill=0.7, landscape=True),
        Conditions(megapixels=3, bend=0.03, light=0.3, blur=1.5, noise=2, jpeg=85, tilt=25, fill=0.7),
    ],
)
def test_every_dot_lies_where_the_map_says(conditions):
    photograph = take_photograph(dotted(), conditions, seed=3)
    for at in photograph.points(DOTS):
        assert np.hypot(*(middle_of_dot(photograph.picture, at) - at)) < 0.6


def test_the_size_is_in_megapixels_and_upright_unless_said():
    picture = take_photograph(dotted(), Conditions(megapixels=2)).picture
    assert picture.shape[0] * picture.shape[1] == pytest.approx(2e6, rel=0.01)
    assert picture.shape[0] > picture.shape[1]
    wide = take_photograph(dotted(), Conditions(megapixels=2, landscape=True)).picture
    assert wide.shape[:2] == picture.shape[1::-1]


def test_the_desk_lies_around_the_sheet():
    picture = take_photograph(dotted(), Conditions(megapixels=1, desk=(20, 60, 120))).picture
    corner = picture[:20, :20].reshape(-1, 3).mean(axis=0)
    assert np.abs(corner - [20, 60, 120]).max() < 8
    assert picture[picture.shape[0] * 2 // 5, picture.shape[1] * 2 // 5].min() > 200


@pytest.mark.parametrize("seed", range(8))
def test_the_whole_sheet_is_seen(seed):
    conditions = draw_conditions(np.random.default_rng(seed))
    edges = np.array([[0, 0], [999, 0], [0, 1399], [999, 1399]], float)
    photograph = take_photograph(dotted(), replace(conditions, megapixels=0.5), seed=seed)
    at = photograph.points(edges)
    assert (at > 0).all() and (at < photograph.picture.shape[1::-1]).all()


def test_a_tilted_sheet_narrows_toward_the_far_side():
    edges = np.array([[0, 0], [999, 0], [0, 1399], [999, 1399]], float)
    at = take_photograph(dotted(), Conditions(megapixels=1, tilt=30, towards=90, fill=0.5)).points(edges)
    upper, lower = np.hypot(*(at[1] - at[0])), np.hypot(*(at[3] - at[2]))
    assert max(upper, lower) > 1.2 * min(upper, lower)


def test_light_shadow_and_colour_are_seen():
    flat = np.full((*SHEET, 3), 235, np.uint8)
    plain = take_photograph(flat, Conditions(megapixels=1)).picture.astype(float)
    lit = take_photograph(flat, Conditions(megapixels=1, light=0.5, light_from=0)).picture.astype(float)
    h, w = plain.shape[:2]
    left, right = np.s_[h // 2, w // 5], np.s_[h // 2, 4 * w // 5]
    assert plain[left].mean() == pytest.approx(plain[right].mean(), abs=1)
    assert lit[left].mean() < lit[right].mean() - 20
    shadowed = take_photograph(flat, Conditions(megapixels=1, shadow=0.4), seed=1).picture.astype(float)
    inside = np.s_[h // 8 : -h // 8, w // 6 : -w // 6]
    assert np.ptp(shadowed[inside].mean(axis=2)) > 20
    warm = take_photograph(flat, Conditions(megapixels=1, colour=(1, 0.9, 0.7))).picture
    assert warm[h // 2, w // 2, 0] > warm[h // 2, w // 2, 2] + 20


def test_a_pixel_gathers_light_and_stores_it_by_the_tone_curve():
    lines = np.zeros((400, 400, 3), np.uint8)
    lines[:, ::2] = 255  # half of the light, however it is stored
    for gamma, half in ((None, 188), (1.0, 128), (2.2, 186)):
        photograph = take_photograph(lines, Conditions(megapixels=0.05, fill=0.9, gamma=gamma))
        height, width = photograph.picture.shape[:2]
        assert np.median(photograph.picture[height // 2 - 5 :, width // 2]) == pytest.approx(half, abs=3)


def test_the_same_seed_gives_the_same_photograph():
    conditions = draw_conditions(np.random.default_rng(4))
    first, second = (take_photograph(dotted(), conditions, seed=9).picture for _ in range(2))
    assert (first == second).all()


def test_conditions_stay_within_what_was_asked():
    drawn = [draw_conditions(np.random.default_rng(seed), most_tilt=20) for seed in range(50)]
    assert 15 < max(c.tilt for c in drawn) <= 20
    assert any(c.bend > 0 for c in drawn) and any(c.bend == 0 for c in drawn)


def test_what_is_no_colour_picture_is_refused():
    with pytest.raises(ImageError, match=r"expected a \(H, W, 3\) uint8 picture"):
        take_photograph(np.zeros((20, 20)), Conditions())
