"""Photographs that moved: shifts found as they were made, by a way that shares nothing with OpenCV's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack, Photograph, ScratchFile
from rumu.surface.alignment import FrameAlignmentSettings, align_photographs
from rumu.surface.photometric import photometric
from rumu.values import Capture
from rumu_lab.simulation.lamps import normals_of, photographs
from rumu_lab.simulation.shapes import bump, ridges

SIZE = (220, 260)
HEIGHT = bump(SIZE, peak=6, sigma=40).height
NAMES = tuple(f"p{i}.png" for i in range(6))


def still(*, noise: float = 0.003, slant: float = 45) -> Capture:
    """A low bump on inked paper under six lamps."""
    strokes = sum(ridges(SIZE, width=7, pitch=60, angle=angle).height for angle in (0, 80, 45))
    albedo = 0.06 + 0.8 * np.exp(-np.asarray(strokes))
    images, lights = photographs(HEIGHT, albedo, tilts=range(0, 360, 60), slant=slant)
    images = ndimage.gaussian_filter(
        images, (0, 0.9, 0.9)
    )  # of a lens; between sharp pixels nothing is known
    images += noise * np.random.default_rng(7).standard_normal(images.shape)
    return Capture(
        images=images.clip(0, 1).astype(np.float32), lights=lights, mask=np.ones(SIZE, bool), names=NAMES
    )


def moved_by(image: np.ndarray, x: float, y: float, turn: float = 0.0) -> np.ndarray:
    """The sheet turned about the middle by degrees, then moved right by x, down by y; by splines of scipy."""
    angle, middle = np.radians(turn), (np.array(SIZE) - 1) / 2
    back = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    offset = middle - back @ (middle + np.array([y, x]))
    return ndimage.affine_transform(image, back, offset=offset, order=3, mode="nearest").clip(0, 1)


def shaken(moves: dict[int, tuple[float, ...]], **options) -> Capture:
    capture = still(**options)
    images = capture.images.copy()
    for number, move in moves.items():
        images[number] = moved_by(images[number], *move)
    return replace(capture, images=images)


def inner(array: np.ndarray) -> np.ndarray:
    return array[..., 15:-15, 15:-15]


MOVES = {1: (2.3, -1.6), 3: (-5.4, 0.7), 4: (0.4, 0.35)}


def test_photographs_that_moved_are_laid_back_to_a_tenth_of_a_pixel():
    done = align_photographs(shaken(MOVES))
    wanted = [np.hypot(*MOVES.get(i, (0, 0))) for i in range(6)]
    assert done.moved == pytest.approx(wanted, abs=0.15)
    truth, now, before = still().images, done.capture.images, shaken(MOVES).images
    for number in MOVES:
        off, was = (np.sqrt(np.mean((inner(one - truth)[number]) ** 2)) for one in (now, before))
        assert off < 0.3 * was
    assert np.array_equal(now[0], before[0])  # what stood still is left as it was


def test_a_turn_is_taken_back():
    done = align_photographs(shaken({2: (1.0, 2.0, 0.6)}))
    corner = np.hypot(*SIZE) / 2 * np.radians(0.6)
    assert (
        done.moved[2] == pytest.approx(corner + np.hypot(1, 2), abs=0.9)
        and done.moved[[0, 1, 3, 4, 5]].max() < 0.2
    )
    truth = still().images
    off = np.sqrt(np.mean(inner(done.capture.images - truth)[2] ** 2))
    assert off < 0.3 * np.sqrt(np.mean(inner(shaken({2: (1.0, 2.0, 0.6)}).images - truth)[2] ** 2))


def test_a_capture_that_was_refused_becomes_the_surface():
    capture = shaken(MOVES)
    with pytest.raises(CaptureError, match="moved against"):
        photometric(capture)
    done = align_photographs(capture)
    surface = photometric(done.capture)
    known = inner(surface.mask)
    angle = np.degrees(np.arccos(np.clip(inner((surface.normals * normals_of(HEIGHT)).sum(axis=2)), -1, 1)))
    good = photometric(still())
    best = np.degrees(np.arccos(np.clip(inner((good.normals * normals_of(HEIGHT)).sum(axis=2)), -1, 1)))
    assert angle[known].mean() < best.mean() + 0.5


def test_what_not_all_photographs_show_is_outside_the_mask():
    mask = align_photographs(shaken(MOVES)).capture.mask
    assert not mask[:, -4:].any() and mask[20:-20, 20:-20].all() and mask.mean() > 0.9


def test_more_than_three_pixels_are_named():
    done = align_photographs(shaken(MOVES))
    (note,) = done.capture.notes
    assert "p3.png (5.4)" in note.en and "p1.png" not in note.en and "p3.png" in note.zh
    assert not align_photographs(still()).capture.notes


def test_a_capture_that_stood_still_is_left_as_it_was():
    done = align_photographs(still())
    assert not done.moved.any() and done.capture.mask.all()
    assert np.array_equal(done.capture.images, still().images)


def test_photographs_keep_their_bits_and_stay_on_disk():
    images = np.round(shaken(MOVES).images * 255).astype(np.uint8)
    curve = np.linspace(0, 1, 256, dtype=np.float32)
    stack = ImageStack([Photograph(ScratchFile(one), curve) for one in images])
    done = align_photographs(replace(still(), images=stack))
    kinds = []
    done.capture.photographs.mapped(
        lambda number, one: kinds.append((type(one.samples), one.samples.dtype)) or one
    )
    assert kinds == [(ScratchFile, np.dtype(np.uint8))] * 6
    assert done.moved[3] == pytest.approx(np.hypot(*MOVES[3]), abs=0.15)


def test_large_photographs_are_measured_small():
    done = align_photographs(shaken(MOVES), settings=FrameAlignmentSettings(side=130))
    assert done.moved[3] == pytest.approx(np.hypot(*MOVES[3]), abs=0.3)


@pytest.mark.parametrize(
    "name", ["psbox-cat", "uw-psm/cat", "uw-psm/gray", "uw-psm/horse", "bunny/bunny_lambert"]
)
def test_real_and_rendered_captures_that_stood_still_are_left_as_they_were(data, name):
    """Their edges move with the lamp, which is no move of the camera."""
    assert not align_photographs(read_capture(data / "photometric" / name)).moved.any()


def test_a_photograph_of_something_else_is_named_and_left():
    capture = still()
    images = capture.images.copy()
    images[2] = ndimage.gaussian_filter(np.random.default_rng(4).random(SIZE), 2).astype(np.float32)
    done = align_photographs(replace(capture, images=images))
    assert done.moved[2] == 0 and "p2.png: cannot be laid" in done.capture.notes[-1].en


def test_a_sheet_that_is_alike_in_many_places_is_laid_by_its_brightness():
    """Characters in a grid, over relief whose edges are where the light makes them."""
    y, x = np.mgrid[:180, :240]
    height = 3 * np.sin(x / 17) * np.cos(y / 13) + 1.5 * np.sin(x / 5 + y / 9)
    albedo = ndimage.gaussian_filter(np.where((x // 30 + y // 24) % 3 == 0, 0.25, 0.7), 1)
    tilts, slants = tuple(30.0 * np.arange(12)), (55.0, 35.0) * 6
    images, lights = photographs(height, albedo, tilts=tilts, slant=slants)
    noise = 0.003 * np.random.default_rng(3).standard_normal(images.shape)
    images = (images + noise).clip(0, 1).astype(np.float32)
    images[5] = np.roll(images[5], (5, 3), (0, 1))
    done = align_photographs(Capture(images=images, lights=lights, mask=np.ones((180, 240), bool)))
    assert done.moved == pytest.approx([5.83 if i == 5 else 0 for i in range(12)], abs=0.15)


@pytest.mark.parametrize(("far", "doubted"), [(2.0, False), (11.0, True)])
def test_a_sheet_that_repeats_itself_is_told_of_where_it_may_be_off_by_a_period(far, doubted):
    threads = sum(ridges(SIZE, width=5, pitch=20, angle=angle).height for angle in (0, 90))
    albedo = 0.06 + 0.8 * np.exp(-np.asarray(threads))
    images, lights = photographs(HEIGHT, albedo, tilts=range(0, 360, 60), slant=45)
    images = ndimage.gaussian_filter(images, (0, 0.9, 0.9))
    for number in (1, 4):
        images[number] = moved_by(images[number], far, 0.0)
    cloth = Capture(
        images=images.clip(0, 1).astype(np.float32), lights=lights, mask=np.ones(SIZE, bool), names=NAMES
    )
    notes = " ".join(note.en for note in align_photographs(cloth).capture.notes)
    assert ("the sheet repeats itself every 20 pixels" in notes) == doubted
