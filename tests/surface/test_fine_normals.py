"""Normals of a large picture, block by block, against those of the whole picture at once."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rumu.gallery.starter import find_work
from rumu.surface.fine_normals import FineSettings, fine_normals, prepare_ink
from rumu.surface.inflation import inflate
from rumu.surface.relief import normals_of, relief

SCALE = 4
SMALL = FineSettings(block=256)


def written(*, light: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """(960, 640) a column of two characters in sRGB, and its ink; or a rubbing, light on dark."""
    ink = np.zeros((960, 640), bool)
    for row, name in enumerate(("shui", "tian")):
        gray = cv2.imread(str(find_work(f"regular-{name}").path), cv2.IMREAD_GRAYSCALE)
        part = ink[40 + 460 * row : 440 + 460 * row, 120:520]
        part |= cv2.resize(gray, (400, 400), interpolation=cv2.INTER_AREA) < 128
    grain = np.random.default_rng(3).normal(0, 4, ink.shape)
    levels = np.where(ink, 215, 40) if light else np.where(ink, 40, 215)
    return np.clip(levels + grain, 0, 255).astype(np.uint8), ink


def reduced(picture: np.ndarray, **options: str):
    small = cv2.resize(picture, None, fx=1 / SCALE, fy=1 / SCALE, interpolation=cv2.INTER_AREA)
    return relief(small, **options)


def angles(levels: np.ndarray, normals: np.ndarray) -> np.ndarray:
    n = levels.astype(float) / 127.5 - 1
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    return np.degrees(np.arccos(np.clip((n * normals).sum(axis=2), -1, 1)))


@pytest.mark.parametrize("light", [False, True])
def test_the_relief_follows_the_outline_of_the_large_picture(light):
    picture, ink = written(light=light)
    fine = np.concatenate(list(fine_normals(prepare_ink(picture, reduced(picture)), settings=SMALL)))
    wrong = angles(fine, normals_of(inflate(ink)))
    enlarged = cv2.resize(reduced(picture).normals, ink.shape[::-1], interpolation=cv2.INTER_LINEAR)
    blurred = angles(np.round(enlarged * 127.5 + 127.5), normals_of(inflate(ink)))
    near = cv2.dilate(ink.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    assert fine.shape == (960, 640, 3) and fine.dtype == np.uint8
    assert wrong[near].mean() < 0.5 * blurred[near].mean() and np.median(wrong[ink]) < 3


def test_blocks_meet_without_a_seam():
    picture, _ = written()
    ink = prepare_ink(picture, reduced(picture))
    whole = np.concatenate(list(fine_normals(ink, settings=FineSettings(block=1024))))
    blocks = np.concatenate(list(fine_normals(ink, settings=SMALL)))
    difference = np.abs(whole.astype(int) - blocks).max(axis=2)
    assert (difference > 6).mean() < 0.002


def test_paper_is_flat_and_what_was_cleaned_away_stays_away():
    picture, ink = written()
    surface = reduced(picture)
    cut = replace(
        surface, mask=surface.mask & (np.arange(240)[:, None] < 118)
    )  # the lower character is left out
    fine = np.concatenate(list(fine_normals(prepare_ink(picture, cut), settings=SMALL)))
    assert (fine[600:] == (128, 128, 255)).all()
    assert (fine[ink & (np.arange(960)[:, None] < 440)] != (128, 128, 255)).any(axis=1).mean() > 0.8


def test_thick_strokes_are_made_at_a_part_of_the_size():
    picture, _ = written()
    ink = prepare_ink(picture, reduced(picture), settings=FineSettings(widest=80))
    assert ink.dark.shape in {(480, 320), (240, 160)} and ink.margin <= 80
    fine = np.concatenate(list(fine_normals(ink, settings=SMALL)))
    assert fine.shape[:2] == ink.dark.shape


def test_the_height_of_a_density_follows_the_density():
    picture, ink = written()
    fine = np.concatenate(
        list(fine_normals(prepare_ink(picture, reduced(picture, method="density")), settings=SMALL))
    )
    inside = cv2.erode(ink.astype(np.uint8), np.ones((15, 15), np.uint8)) > 0
    assert (
        angles(fine, normals_of(np.zeros(ink.shape, np.float32)))[inside].mean() > 1
    )  # grain, and no round stroke
