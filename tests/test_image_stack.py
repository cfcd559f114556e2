"""Photographs in their own bits: the same light in memory, on disk and as floats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.capture.image import to_linear
from rumu.image_stack import ImageStack, Photograph, ScratchFile, pixels_of
from rumu.values import Capture

RNG = np.random.default_rng(5)
EIGHT = RNG.integers(0, 256, (4, 11, 13), np.uint8)
KINDS = {
    "8 bits": EIGHT,
    "16 bits": RNG.integers(0, 65536, (4, 11, 13), np.uint16),
    "floats": RNG.random((4, 11, 13), np.float32),
    "colour": RNG.integers(0, 256, (4, 11, 13, 3), np.uint8),
}
CURVES = {
    "uint8": to_linear(np.arange(256, dtype=np.float32) / np.float32(255)),
    "uint16": to_linear(np.arange(65536, dtype=np.float32) / np.float32(65535)),
}


@pytest.mark.parametrize("on_disk", [False, True])
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_linear_light_however_it_is_kept_and_asked_for(kind, curved, on_disk):
    samples = KINDS[kind]
    curve = CURVES.get(samples.dtype.name) if curved else None
    full = {"uint8": 255, "uint16": 65535}.get(samples.dtype.name, 1)
    wanted = samples.astype(np.float32) / np.float32(full) if curve is None else curve[samples]
    stack = ImageStack([Photograph(ScratchFile(one) if on_disk else one, curve) for one in samples])
    assert stack.shape == samples.shape and stack.is_colour == (samples.ndim == 4)
    flat = wanted.reshape(4, -1, *wanted.shape[3:])
    np.testing.assert_array_equal(stack.floats(), wanted)
    np.testing.assert_array_equal(stack.frame(2), wanted[2])
    np.testing.assert_array_equal(stack.range(17, 90), flat[:, 17:90])
    np.testing.assert_array_equal(stack.rows(3, 7), wanted[:, 3:7])
    np.testing.assert_array_equal(stack.at(np.array([0, 5, 142])), flat[:, [0, 5, 142]])
    assert stack.range(0, 5).dtype == np.float32


def test_the_dark_frame_is_taken_off_and_never_leaves_less_than_nothing():
    dark = Photograph(np.full((11, 13), 51, np.uint8))
    stack = ImageStack([Photograph(one) for one in EIGHT], dark=dark, peak=2.0)
    wanted = np.maximum(EIGHT.astype(np.float32) / 255 - np.float32(0.2), 0) / 2
    np.testing.assert_allclose(stack.floats(), wanted, atol=1e-6)
    np.testing.assert_allclose(stack.at(np.array([7]))[:, 0], wanted.reshape(4, -1)[:, 7], atol=1e-6)
    assert stack.floats().min() == 0


def test_the_samples_of_an_array_are_not_changed_by_the_dark_frame():
    images = np.full((3, 8, 8), 0.5, np.float32)
    stack = ImageStack([Photograph(one) for one in images], dark=Photograph(np.full((8, 8), 0.2, np.float32)))
    assert stack.floats().max() == pytest.approx(0.3)
    assert (images == 0.5).all()


def test_a_capture_shows_arrays_and_keeps_bits():
    stack = ImageStack([Photograph(one) for one in EIGHT])
    lights = np.array([[0.6, 0, 0.8], [0, 0.6, 0.8], [-0.6, 0, 0.8], [0, -0.6, 0.8]])
    capture = Capture(images=stack, lights=lights, mask=np.ones((11, 13), bool))
    changed = capture.changed(spacing=0.5)
    assert changed.photographs is capture.photographs is stack and changed.spacing == 0.5
    assert isinstance(capture.images, np.ndarray) and capture.images.dtype == np.float32
    assert capture.images is capture.images  # computed once
    np.testing.assert_array_equal(capture.gray, EIGHT.astype(np.float32) / np.float32(255))
    np.testing.assert_array_equal(replace(capture, spacing=2.0).images, capture.images)
    from_array = Capture(capture.images, lights, capture.mask)
    assert from_array.images is capture.images and from_array.photographs.shape == (4, 11, 13)


@pytest.mark.parametrize("on_disk", [False, True])
def test_a_reduced_photograph_is_the_mean_of_its_pixels(on_disk):
    rows, columns = np.mgrid[:160, :240]
    samples = np.clip(40 + columns * 0.7 + rows * 0.3 + RNG.normal(0, 9, (160, 240)), 0, 255).astype(np.uint8)
    kept = ScratchFile(samples) if on_disk else samples
    stack = ImageStack([Photograph(kept)], dark=Photograph(np.full((160, 240), 13, np.uint8)))
    for side in (8, 80):
        found = stack.reduced(0, (240 // side, 160 // side))
        means = stack.frame(0).reshape(160 // side, side, 240 // side, side).mean(axis=(1, 3))
        np.testing.assert_allclose(found, means, atol=0.5 / 255)  # half a level


@pytest.mark.parametrize("about", [1, 7, 40, 1000])
def test_some_pixels_of_a_mask_are_every_kth_of_it(about):
    mask = np.random.default_rng(0).random((9, 11)) < 0.6
    for one in (mask, np.ones_like(mask), np.zeros_like(mask)):
        inside = np.flatnonzero(one)
        step = max(1, len(inside) // about)
        assert np.array_equal(pixels_of(one, about=about), inside[::step])
