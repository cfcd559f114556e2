"""Flat-field frames: vignetting and fall-off go with them; what is none is refused with its reason."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from rumu.capture.flat_frames import SmoothGain, divide_by_flat_frames
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack
from rumu.surface.solve import solve
from rumu.values import Capture
from rumu_lab.simulation.lamps import DistantLamp, NearLamp, normals_of, render

SHAPE = (120, 150)
LAMPS = [DistantLamp(tilt=60 * i, slant=35 + 4 * (i % 3), strength=0.9) for i in range(6)]
NAMES = tuple(f"{i}.png" for i in range(6))


def relief() -> np.ndarray:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 1.5 * np.sin(x / 9.0) * np.cos(y / 11.0)


def vignetting() -> np.ndarray:
    """A lens that gives the corners less than half of the light, off centre."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 1.0 / (1.0 + ((x - 85) ** 2 + (y - 50) ** 2) / 90.0**2)


def save(path, light: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    Image.fromarray(np.round(np.clip(light, 0, 1) * 65535).astype(np.uint16)).save(path)


def capture_of(images: np.ndarray, lamps=LAMPS) -> Capture:
    return Capture(
        images=images.astype(np.float32),
        lights=np.array([lamp.direction for lamp in lamps]),
        mask=np.ones(SHAPE, bool),
        names=NAMES,
    )


def error_of(capture: Capture, truth: np.ndarray) -> float:
    """Median angle, in degrees, between the normals of least squares and the truth."""
    strengths = np.ones(len(capture.lights)) if capture.strengths is None else capture.strengths
    lights = capture.lights * strengths[:, None]
    normals = solve(capture.photographs, lights, solver="least_squares").normals
    return float(np.median(np.degrees(np.arccos(np.clip((normals * truth).sum(axis=2), -1, 1)))))


def rendered(height: np.ndarray, lamps=LAMPS, *, noise: float = 0.0) -> np.ndarray:
    found = np.stack([render(height, 0.8, lamp=lamp, cast_shadows=False) for lamp in lamps])
    return found + noise * np.random.default_rng(2).standard_normal(found.shape)


def test_vignetting_goes_with_one_frame(tmp_path):
    dim = vignetting()
    plain, seen = rendered(relief()), rendered(relief()) * dim
    save(tmp_path / "flat.png", 0.9 * dim + 0.01 * np.random.default_rng(1).standard_normal(SHAPE))
    divided = divide_by_flat_frames(capture_of(seen), tmp_path / "flat.png")
    ratio = divided.images / np.maximum(plain, 0.02)
    lit = plain > 0.1
    assert np.std(ratio[lit]) / np.mean(ratio[lit]) < 0.01
    assert divided.images.max() <= 1 and "divided by the mean of 1" in divided.notes[0].en
    spread = np.std((seen / np.maximum(plain, 0.02))[lit])
    assert spread > 0.1  # there was something to divide by


def test_the_fall_off_of_near_lamps_goes_with_a_frame_for_each(tmp_path):
    """Frames of single lamps take the fall-off with them, and tell strengths that nobody told."""
    strengths = [0.9, 0.5, 0.8, 0.6, 0.9, 0.7]
    lamps = [
        NearLamp((260 * np.cos(t), 260 * np.sin(t), 260.0), strength=s)
        for t, s in zip(np.arange(6) * np.pi / 3, strengths, strict=True)
    ]
    for name, frame in zip(NAMES, rendered(np.zeros(SHAPE), lamps), strict=True):
        save(tmp_path / "flat" / name, 0.8 * frame)
    height, truth = relief(), normals_of(relief())
    capture = capture_of(rendered(height, lamps), lamps)
    divided = divide_by_flat_frames(capture, tmp_path / "flat")
    assert divided.strengths == pytest.approx(np.array(strengths) / np.mean(strengths), rel=0.02)
    assert error_of(divided, truth) < 0.6 * error_of(capture.changed(strengths=divided.strengths), truth)
    assert "flat-field frame of its lamp (6" in divided.notes[0].en


def test_several_frames_of_other_names_are_averaged(tmp_path):
    dim, rng = vignetting(), np.random.default_rng(5)
    for i in range(3):
        save(tmp_path / "flats" / f"flat{i}.png", (0.5 + 0.1 * i) * dim + 0.02 * rng.standard_normal(SHAPE))
    divided = divide_by_flat_frames(capture_of(rendered(relief()) * dim), tmp_path / "flats")
    ratio = (divided.images / np.maximum(rendered(relief()), 0.02))[rendered(relief()) > 0.1]
    assert np.std(ratio) / np.mean(ratio) < 0.01 and divided.strengths is None


def test_what_was_overexposed_stays_so_and_nothing_else_becomes_it(tmp_path):
    dim = vignetting()
    images = np.clip(rendered(relief()) * dim, 0, 0.9)
    images[:, 10:14, 10:14] = 1.0
    save(tmp_path / "flat.png", 0.9 * dim)
    divided = divide_by_flat_frames(capture_of(images), tmp_path / "flat.png").photographs
    white = divided.floats() >= 0.998
    assert white[:, 10:14, 10:14].all() and white.sum() == 6 * 16


def test_a_gain_is_the_same_however_it_is_asked_for(tmp_path):
    save(tmp_path / "flat.png", 0.9 * vignetting())
    stack = divide_by_flat_frames(capture_of(rendered(relief())), tmp_path / "flat.png").photographs
    whole = stack.floats()
    assert isinstance(stack, ImageStack)
    assert np.allclose(stack.range(1000, 4000), whole.reshape(6, -1)[:, 1000:4000], atol=1e-6)
    assert np.allclose(stack.at(np.array([5, 17999])), whole.reshape(6, -1)[:, [5, 17999]], atol=1e-6)
    assert np.allclose(stack.rows(7, 9), whole[:, 7:9], atol=1e-6)
    assert np.allclose(stack.chosen([4, 1]).frame(1), whole[1], atol=1e-6)
    assert np.allclose(
        stack.reduced(2, (50, 40)), whole[2].reshape(40, 3, 50, 3).mean(axis=(1, 3)), atol=0.01
    )


def test_factors_lie_between_the_cells():
    gain = SmoothGain(np.array([[0.2, 0.4], [0.6, 0.8]], np.float32), (4, 4))
    found = gain.at(np.arange(16)).reshape(4, 4)
    assert found[0, 0] == pytest.approx(0.05, abs=1e-6) and found[3, 3] == pytest.approx(0.95, abs=1e-6)
    assert np.allclose(np.diff(found, axis=1), 0.1, atol=1e-6)


@pytest.mark.parametrize(
    ("light", "words"),
    [
        (0.02, "too dark for a flat field: 2.0% of white"),
        (1.0, "overexposed: 100.0%"),
        ("half", "overexposed: 50"),
        ("small", "of 150 x 120 pixels"),
        ("writing", "expected a blank, even sheet"),
        ("corner", "too uneven"),
    ],
)
def test_what_is_no_flat_field_is_refused(tmp_path, light, words):
    frame = np.full(SHAPE, light if isinstance(light, float) else 0.6)
    if light == "half":
        frame[:60] = 1.0
    if light == "small":
        frame = frame[:50]
    if light == "writing":
        frame[20:100:24] = frame[21:100:24] = frame[22:100:24] = 0.1
        frame[20:100, 30:60] = 0.15
    if light == "corner":
        frame = 0.9 * vignetting() ** 6
    save(tmp_path / "flat.png", frame)
    with pytest.raises(CaptureError, match=words) as refused:
        divide_by_flat_frames(capture_of(rendered(relief())), tmp_path / "flat.png")
    assert refused.value.zh and "flat.png" in str(refused.value)


def test_frames_that_are_not_there(tmp_path):
    capture = capture_of(rendered(relief()))
    with pytest.raises(CaptureError, match="there is none"):
        divide_by_flat_frames(capture, tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(CaptureError, match="found none"):
        divide_by_flat_frames(capture, tmp_path / "empty")
    for name in NAMES[:-1]:
        save(tmp_path / "few" / name, np.full(SHAPE, 0.5))
    with pytest.raises(CaptureError, match=r"named like 5\.png"):
        divide_by_flat_frames(capture, tmp_path / "few")
