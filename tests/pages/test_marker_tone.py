"""Markers drawn by numpy alone and smeared in light, as any camera with any tone curve would show them."""

import cv2
import numpy as np
import pytest

from rumu.pages.marker_tone import fit_tone
from rumu.pages.sheet_markers import SIDE, find_markers, marker_modules

MODULE = 10  # pixels


def photographed(*, gamma: float, smear: float, noise: float = 0.0) -> np.ndarray:
    """(H, W) uint8: four markers on paper; smear: standard deviation in pixels."""
    light = np.full((4 * SIDE * MODULE, 4 * SIDE * MODULE), 0.8)
    for k, number in enumerate((0, 1, 2, 3)):
        top, left = (SIDE * MODULE // 2 + 2 * SIDE * MODULE * n for n in divmod(k, 2))
        dark = np.kron(marker_modules(number), np.ones((MODULE, MODULE))) > 0
        light[top : top + len(dark), left : left + len(dark)][dark] = 0.01
    light = cv2.GaussianBlur(light, (0, 0), smear)
    levels = 255 * light ** (1 / gamma) + np.random.default_rng(5).normal(0, noise, light.shape)
    return np.clip(np.round(levels), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("gamma", [1.0, 1.5, 2.2])
@pytest.mark.parametrize("smear", [1.5, 2.5])
def test_the_tone_curve_and_the_smear_are_found(gamma, smear):
    picture = photographed(gamma=gamma, smear=smear, noise=4.0)
    markers = find_markers(picture, among=range(4))
    assert len(markers) >= 2
    tone = fit_tone(picture, markers)
    assert tone.gamma == pytest.approx(gamma, abs=0.15)
    assert tone.smear * MODULE == pytest.approx(smear, abs=0.3)


def test_an_exponent_that_no_camera_has_is_not_believed():
    for gamma, believed in ((0.7, 1.0), (3.4, 2.6)):
        picture = photographed(gamma=gamma, smear=2.0)
        assert fit_tone(picture, find_markers(picture, among=range(4))).gamma == believed
