import cv2
import numpy as np
import pytest

from rumu.pages.sheet_sharpening import sharpen


def strokes(gap: int) -> np.ndarray:
    """Two strokes 12 pixels wide with a gap between them, 0 on paper of 1."""
    light = np.ones((160, 160), np.float32)
    light[30:130, 60 - 12 : 60] = light[30:130, 60 + gap : 72 + gap] = 0
    return light


@pytest.mark.parametrize("smear", [1.5, 2.5])
def test_a_gap_that_blur_closes_is_open_again(smear):
    seen = cv2.GaussianBlur(strokes(gap=3), (0, 0), smear)
    assert seen[80, 61] < 0.7
    assert sharpen(seen, smear=smear)[80, 61] > seen[80, 61] + 0.12


@pytest.mark.parametrize("smear", [1.5, 2.5])
def test_a_thin_end_that_blur_shortens_is_long_again(smear):
    fine = np.full((1600, 1600), 255, np.uint8)
    cv2.fillPoly(fine, [np.array([[740, 300], [860, 300], [800, 1300]])], 0)
    true = cv2.resize(fine, (160, 160), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    seen = cv2.GaussianBlur(true, (0, 0), smear)
    lengths = [
        np.count_nonzero((light < 0.5).any(axis=1)) for light in (seen, sharpen(seen, smear=smear), true)
    ]
    assert lengths[0] + 3 < lengths[1] <= lengths[2]


def test_paper_keeps_its_level_and_noise_stays_below_ink():
    rng = np.random.default_rng(4)
    light = (0.97 + rng.normal(0, 0.03, (200, 160))).astype(np.float32)
    sharp = sharpen(light, smear=2.0)
    assert sharp.shape == light.shape
    assert sharp.mean() == pytest.approx(light.mean(), abs=0.002)
    assert sharp.min() > 0.75


def test_a_sharp_picture_is_left_as_it_is():
    light = strokes(gap=4)
    assert sharpen(light, smear=0.3) is light
