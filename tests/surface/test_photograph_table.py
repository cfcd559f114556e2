"""The table of photographs: the one that was spoilt stands out, whatever spoilt it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rumu.surface.photograph_table import fault_notes, photograph_table, table_text
from rumu.surface.photometric import photometric
from rumu.values import Bilingual, Capture
from rumu_lab.simulation.lamps import Sensor, photographs
from rumu_lab.simulation.shapes import bump

SPOILT = 4
STRENGTHS = np.array([1, 1, 0.8, 1, 1, 1.2, 1, 1.0]) / 1.0


def spoil(image, how):
    if how == "moved":
        return cv2.warpAffine(image, np.array([[1.0, 0, 4], [0, 1, -3]]), image.shape[::-1], borderMode=2)
    if how == "blurred":
        return cv2.GaussianBlur(image, (0, 0), 3.0)
    return np.clip(image * 4, 0, 1) if how == "overexposed" else image


def table(how=None, mask=None):
    """The table of eight photographs of a mound of blotted paper; the surface is made of good ones."""
    rng = np.random.default_rng(8)
    ink = cv2.GaussianBlur(rng.random((150, 170)).astype(np.float32), (0, 0), 1.2)
    albedo = np.clip(0.5 + 3 * (ink - ink.mean()), 0.15, 0.8)
    images, lights = photographs(
        bump((150, 170), peak=8.0, sigma=30.0).height,
        albedo,
        tilts=tuple(np.arange(8) * 45.0),
        slant=(30.0, 45.0) * 4,
        strengths=STRENGTHS / 1.2,
        sensor=Sensor(noise=0.002),
    )
    mask = np.ones((150, 170), bool) if mask is None else mask
    names = tuple(f"{i}.png" for i in range(8))
    surface = photometric(Capture(images=images, lights=lights, mask=mask, names=names, lamps_as_given=True))
    changed = images.copy()
    changed[SPOILT] = spoil(images[SPOILT], how)
    return photograph_table(Capture(images=changed, lights=lights, mask=mask, names=names), surface)


def test_good_photographs_have_no_fault_and_show_their_lamps():
    rows = table()
    assert not fault_notes(rows)
    found = np.array([row.strength for row in rows])
    assert np.abs(found - STRENGTHS / STRENGTHS.mean()).max() < 0.02
    assert max(row.residual for row in rows) < 0.02
    assert max(row.moved for row in rows) < 0.3
    assert all(0.8 < row.sharpness < 1.3 for row in rows)
    assert len(table_text(rows).splitlines()) == 9


@pytest.mark.parametrize(
    ("how", "words"), [("moved", "pixels beside"), ("blurred", "blurred"), ("overexposed", "overexposed")]
)
def test_the_spoilt_one_is_named(how, words):
    rows = table(how)
    assert [row.name for row in rows if row.faults] == [f"{SPOILT}.png"]
    (note,) = fault_notes(rows)
    assert words in note.en and f"--leave-out {SPOILT}.png" in note.en and f"{SPOILT}.png" in note.zh
    if how == "moved":
        assert rows[SPOILT].moved == pytest.approx(5.0, abs=0.3)


@pytest.mark.parametrize("how", [None, "moved", "blurred"])
def test_what_lies_outside_the_mask_is_no_fault(how):
    """Of a disc beside the middle, on paper that goes on around it."""
    y, x = np.ogrid[:150, :170]
    rows = table(how, mask=np.hypot(y - 60, x - 100) < 45)
    assert [row.name for row in rows if row.faults] == ([] if how is None else [f"{SPOILT}.png"])
    good = [row for row in rows if not row.faults]
    assert all(0.8 < row.sharpness < 1.3 and row.moved < 0.3 for row in good)
    if how == "moved":
        assert rows[SPOILT].moved == pytest.approx(5.0, abs=0.4)


def test_exchanged_lamps_are_told_as_such():
    """Two of eight, which the surface of the other six contradicts; a third is spoilt otherwise."""
    rng = np.random.default_rng(3)
    albedo = np.clip(0.6 + 0.1 * cv2.GaussianBlur(rng.standard_normal((90, 100)), (0, 0), 1.5), 0.2, 0.9)
    images, lights = photographs(
        bump((90, 100), peak=9.0, sigma=20.0).height,
        albedo,
        tilts=tuple(np.arange(8) * 45.0),
        slant=(30.0, 45.0) * 4,
        sensor=Sensor(noise=0.002),
    )
    mask, names = np.ones((90, 100), bool), tuple(f"{i}.png" for i in range(8))
    surface = photometric(Capture(images=images, lights=lights, mask=mask, names=names, lamps_as_given=True))
    images[5] = images[5][::-1, ::-1]  # of another sheet
    wrong = lights[[0, 1, 6, 3, 4, 5, 2, 7]]
    rows = photograph_table(Capture(images=images, lights=wrong, mask=mask, names=names), surface)
    notes = [note.en for note in fault_notes(rows)]
    assert [row.name for row in rows if row.faults] == ["2.png", "5.png", "6.png"]
    assert "2.png: its lamp seems to be exchanged with that of 6.png" in notes[0]
    assert "6.png: its lamp seems to be exchanged with that of 2.png" in notes[2]
    assert "contradicts the surface" in notes[1]


def test_many_bad_ones_are_told_in_one_sentence():
    rows = [
        replace(row, residual=0.1 + 0.01 * i, faults=(Bilingual("x", "x"),)) for i, row in enumerate(table())
    ]
    (note,) = fault_notes(rows)
    assert note.en.startswith("8 photographs fit badly, 7.png, 6.png, 5.png worst")
