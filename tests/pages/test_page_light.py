"""Uneven light: paper becomes as bright everywhere, and what only looks like it stays as it is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import rumu
from rumu.pages.page_light import even_light

PAPER = (236, 228, 214)


def page_with_strokes(side=600):
    """A page of paper, and where there is ink."""
    rng = np.random.default_rng(4)
    page, ink = np.full((side, side, 3), PAPER, np.uint8), np.zeros((side, side), np.uint8)
    for x in range(60, side - 60, 70):
        for y in range(60, side - 60, 60):
            to = (x + int(rng.integers(-24, 24)), y + int(rng.integers(-24, 24)))
            cv2.line(ink, (x, y), to, 1, 6)
    page[ink > 0] = (30, 28, 26)
    return page, ink > 0


def lit(page, *, darkest, degrees=30.0):
    """The page under light that falls off to one side; darkest: light there, linear, 1 at the bright side."""
    height, width = page.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    across = x * np.cos(np.radians(degrees)) + y * np.sin(np.radians(degrees))
    light = darkest + (1 - darkest) * (across - across.min()) / np.ptp(across)
    return np.rint(255 * ((page / 255) ** 2.2 * light[..., None]) ** (1 / 2.2)).astype(np.uint8)


@pytest.mark.parametrize("darkest", [0.35, 0.6])
def test_paper_becomes_as_bright_everywhere_and_ink_stays_ink(darkest):
    page, ink = page_with_strokes()
    seen = lit(page, darkest=darkest)
    even = even_light(seen)
    paper = cv2.erode((~ink).astype(np.uint8), np.ones((5, 5))) > 0
    assert even.shape == seen.shape and even.dtype == np.uint8
    before, after = (np.ptp(np.quantile(one[paper].mean(axis=1), [0.02, 0.98])) for one in (seen, even))
    assert after < 0.25 * before and after < 14
    colours = even[paper].mean(axis=0)
    assert np.abs(colours / colours.max() - np.array(PAPER) / max(PAPER)).max() < 0.02
    assert even[cv2.erode(ink.astype(np.uint8), np.ones((3, 3))) > 0].max() < 80


def test_even_light_changes_nothing():
    page, _ = page_with_strokes()
    assert even_light(page) is page
    slight = lit(page, darkest=0.93)
    assert even_light(slight) is slight


def test_silk_on_a_mount_and_a_rubbing_stay_as_they_are():
    page, _ = page_with_strokes()
    mounted = page.copy()
    mounted[150:450, 100:500] = (mounted[150:450, 100:500] * 0.6).astype(np.uint8)
    assert even_light(mounted) is mounted
    rubbing = lit(255 - page, darkest=0.4)
    assert even_light(rubbing) is rubbing


def test_a_picture_of_no_size_stays_as_it_is():
    small = np.zeros((40, 30, 3), np.uint8)
    assert even_light(small) is small


def test_a_read_page_is_lit_evenly():
    page, _ = page_with_strokes()
    seen = lit(page, darkest=0.4)
    shown = rumu.read_page(seen).picture
    corners = [shown[:20, :20].mean(), shown[-20:, -20:].mean(), shown[:20, -20:].mean()]
    assert np.ptp(corners) < 16 < np.ptp([seen[:20, :20].mean(), seen[-20:, -20:].mean()])
