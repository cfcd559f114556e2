from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image
from tests.card.conftest import PHONE, angles, lamps_around, on_the_grid_of, window_middle

from rumu.card.capture import read_card_capture
from rumu.errors import CaptureError
from rumu.pipeline import reconstruct


def test_lamps_scale_and_normals_of_a_sheet(taken, sheet):
    folder, lamps = taken
    made = read_card_capture(folder)
    capture = made.capture
    assert angles(lamps - window_middle(), capture.lights).max() < 3.0
    assert 9.0 < made.ball < 10.0 and len(made.lamps) == 4
    assert max(lamp.unsure for lamp in made.lamps) < 2.5
    surface = reconstruct(capture)
    assert surface.unit == "mm"
    shape = surface.height.shape
    true = np.dstack(
        [on_the_grid_of(sheet, shape, made.pixel_mm, sheet.normals[..., k])[0] for k in range(3)]
    )
    albedo, inside = on_the_grid_of(sheet, shape, made.pixel_mm, sheet.albedo)
    off = angles(true, surface.normals)[inside]
    assert off.mean() < 2.5 and np.quantile(off, 0.95) < 6.0
    assert abs(_scale_beside(surface.albedo.mean(axis=2), albedo, inside) - 1) < 0.01


def _scale_beside(found, true, inside):
    """How much larger a picture is than the true one: by the shifts of its left and its right part."""
    rows, columns = np.nonzero(inside)
    top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
    third = (right - left) // 3
    shifts = []
    for start in (left, right - third):
        part = np.s_[top:bottom, start : start + third]
        window = cv2.createHanningWindow((third, bottom - top), cv2.CV_32F)
        a, b = (np.ascontiguousarray(one[part], np.float32) for one in (true, found))
        shifts.append(cv2.phaseCorrelate(a - a.mean(), b / b.mean() - 1, window)[0][0])
    assert max(abs(shift) for shift in shifts) < 2.0  # where it should be, too
    return 1 + (shifts[1] - shifts[0]) / (right - third - left)


@pytest.mark.parametrize("lobe", [0.0, 3.0])
def test_white_alone_tells_near_lamps(shoot, tmp_path, lobe):
    lamps = lamps_around(5, distance=330.0)
    made = read_card_capture(shoot(tmp_path / "card", lamps, ball=None, lobe=lobe))
    assert made.ball is None
    off = angles(np.array(lamps) - window_middle(), made.capture.lights)
    assert off.max() < 3.0
    assert all(apart < 3 * lamp.unsure for apart, lamp in zip(off, made.lamps, strict=True))
    assert "the card's white" in made.capture.notes[0].en


def test_three_photographs_without_exif_and_with_contrast(shoot, tmp_path):
    phone = replace(PHONE, exif=False, curve=lambda x: x**1.1)
    lamps = lamps_around(3)
    made = read_card_capture(shoot(tmp_path / "card", lamps, phone=phone))
    assert angles(np.array(lamps) - window_middle(), made.capture.lights).max() < 3.5
    assert any("26 mm" in note.en for note in made.capture.notes)


def refused(folder, *words):
    with pytest.raises(CaptureError) as caught:
        read_card_capture(folder)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert caught.value.zh
    return caught.value


@pytest.fixture
def copied(taken, tmp_path):
    """The photographs of `taken`, to be spoilt."""
    folder = tmp_path / "copy"
    folder.mkdir()
    for path in taken[0].iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


def spoil(path, change):
    with Image.open(path) as image:
        exif, picture = image.getexif(), np.asarray(image)
    Image.fromarray(np.ascontiguousarray(change(picture))).save(path, quality=93, exif=exif)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda one: np.full_like(one, 90), ("2.jpg", "found none")),
        (lambda one: one[:, : one.shape[1] // 2], ("2.jpg", "the whole card")),
        (lambda one: cv2.GaussianBlur(one, (0, 0), 3), ("2.jpg", "blurred")),
        (lambda one: np.clip(one.astype(float) * 2.2, 0, 255).astype(np.uint8), ("2.jpg", "burnt out")),
        (lambda one: (one * 0.13).astype(np.uint8), ("2.jpg", "dark")),
        (lambda one: np.hstack([one, one]), ("2.jpg", "two")),
    ],
    ids=["none", "cut off", "blurred", "burnt out", "dark", "two cards"],
)
def test_a_bad_photograph_is_named(copied, change, words):
    spoil(copied / "2.jpg", change)
    refused(copied, *words)


def test_a_lamp_that_stood_still(shoot, tmp_path):
    lamps = [one + np.array([0, 0, 5 * k]) for k, one in enumerate([lamps_around(3)[0]] * 3)]
    refused(shoot(tmp_path / "card", lamps), "hardly moved")


def test_lamps_in_one_plane(shoot, tmp_path):
    lamps = [np.array([x, 0.0, 350.0]) for x in (-250.0, 20.0, 250.0)]
    refused(shoot(tmp_path / "card", lamps), "three sides")


def test_far_lamps_need_a_ball(shoot, tmp_path):
    lamps = lamps_around(3, distance=1100.0)
    refused(shoot(tmp_path / "bare", lamps, ball=None), "white tells", "shiny ball")
    made = read_card_capture(shoot(tmp_path / "ball", lamps))
    assert angles(np.array(lamps) - window_middle(), made.capture.lights).max() < 3.0


def test_too_few_and_no_folder(taken, tmp_path):
    with pytest.raises(CaptureError, match="at least 3"):
        read_card_capture(taken[0], leave_out=("0", "1"))
    with pytest.raises(CaptureError, match="there is none"):
        read_card_capture(tmp_path / "nothing")


def test_a_camera_turned_on_its_side_changes_nothing(copied, taken):
    upright = read_card_capture(taken[0]).capture
    spoil(copied / "1.jpg", np.rot90)
    turned = read_card_capture(copied).capture
    assert turned.mask.shape == upright.mask.shape
    assert angles(turned.lights, upright.lights).max() < 0.3
