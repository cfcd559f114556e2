"""Bent pages set straight: drawn curves, and pages that the laboratory's simulated camera photographs."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import rumu
from rumu.characters.stroke_data import find_character
from rumu.pages.bend import PageCurves, find_straightening
from rumu_lab.simulation.camera import Conditions, take_photograph

POEM = "永和九年歲在癸丑暮春之初會于會稽山陰之蘭亭修禊事也群賢畢至少長咸集此地有崇山峻領茂林修竹又有清流"
SIDE = 60


def waves(count, *, height, along=40):
    """Curves that ran down a page 1000 pixels wide and high, and bend alike."""
    y = np.linspace(0, 1000, along)
    return tuple(
        np.column_stack([x + height * np.sin(y / 320) * (0.5 + x / 1000), y])
        for x in np.linspace(100, 900, count)
    )


def test_bent_curves_become_straight_and_the_picture_with_them():
    bent = waves(8, height=30)
    straight = find_straightening(PageCurves(bent, (), 50.0))
    assert straight is not None
    assert max(np.ptp(one[:, 0]) for one in bent) > 30
    assert max(np.ptp(straight.points(one)[:, 0]) for one in bent) < 4
    page = np.full((1001, 1001, 3), 255, np.uint8)
    for one in bent:
        cv2.polylines(page, [np.rint(one).astype(np.int32)], False, (0, 0, 0), 3)
    shown = straight.picture(page)
    for one in bent:
        x, y = straight.points(one).T
        assert shown[np.rint(y[5:-5]).astype(int), np.rint(x[5:-5]).astype(int)].max() < 128


def test_level_curves_bend_the_other_way():
    bent = tuple(one[:, ::-1] for one in waves(5, height=24))
    straight = find_straightening(PageCurves((), bent, 50.0))
    assert straight is not None
    assert max(np.ptp(straight.points(one)[:, 1]) for one in bent) < 4


def test_columns_that_crowd_to_one_side_stand_at_equal_distances_again():
    number = np.arange(12)
    places = 80 * number - 2.2 * number**2
    columns = tuple(np.column_stack([np.full(20, x), np.linspace(0, 800, 20)]) for x in places)
    straight = find_straightening(PageCurves(columns, (), 40.0))
    assert straight is not None
    gaps = np.diff([float(straight.points(one)[:, 0].mean()) for one in columns])
    assert np.ptp(gaps) < 1 < np.ptp(np.diff(places))


def test_what_is_straight_or_wanders_freely_stays_as_it_is():
    assert find_straightening(PageCurves(waves(8, height=0), (), 50.0)) is None
    rng = np.random.default_rng(2)
    y = np.linspace(0, 1000, 40)
    wandering = tuple(
        np.column_stack([x + rng.uniform(-20, 20) * np.sin(y / rng.uniform(90, 400) + rng.uniform(0, 6)), y])
        for x in np.linspace(100, 900, 9)
    )
    assert find_straightening(PageCurves(wandering, (), 50.0, (9, 0))) is None
    assert find_straightening(PageCurves((), (), 50.0)) is None


def test_a_few_columns_that_each_lean_and_bend_otherwise_stay_as_they_are():
    rng = np.random.default_rng(11)
    y = np.linspace(0, 1000, 40)
    for _ in range(20):
        columns = tuple(
            np.column_stack([x + np.polyval(rng.normal(0, (5, 5, 0)), y / 500 - 1), y])
            for x in np.linspace(100, 900, 5)
        )
        assert find_straightening(PageCurves(columns, (), 50.0, (5, 0))) is None


def drawn_page(*, ruled, columns=8, rows=11, pitch=84, pace=66):
    """A page of columns, and the middles of its characters in reading order."""
    width, height = columns * pitch + 160, rows * pace + 180
    gray, middles = np.full((height, width), 238, np.uint8), []
    for c in range(columns):
        for r in range(rows):
            x, y = width - 80 - pitch * (c + 0.5), 90 + pace * (r + 0.5)
            for stroke in find_character(POEM[(c * rows + r) % len(POEM)]).strokes:
                points = (stroke.polygon() - 0.5) * SIDE + (x, y)
                cv2.fillPoly(gray, [np.rint(points * 16).astype(np.int32)], 25, cv2.LINE_AA, 4)
            middles.append((x, y))
    if ruled:
        cv2.rectangle(gray, (80, 80), (width - 80, height - 80), 30, 4)
        for c in range(1, columns):
            cv2.line(gray, (80 + c * pitch, 80), (80 + c * pitch, height - 80), 60, 2)
    return np.dstack([gray] * 3), np.array(middles)


def off_by(page, middles):
    """How far each true middle is from a box of the page, in sides of a character, but for an affine map."""
    boxes = np.array([one.box for one in page.characters])
    found = (boxes[:, :2] + boxes[:, 2:]) / 2
    low, high = found.min(axis=0), found.max(axis=0)
    moved = (found - low) / (high - low) * np.ptp(middles, axis=0) + middles.min(axis=0)
    for _ in range(6):
        apart = np.linalg.norm(middles[:, None] - moved[None], axis=2)
        nearest = apart.argmin(axis=1)
        near = apart.min(axis=1) < 0.6 * SIDE
        wide = np.column_stack([found, np.ones(len(found))])
        moved = wide @ np.linalg.lstsq(wide[nearest[near]], middles[near], rcond=None)[0]
    return np.linalg.norm(middles - moved[nearest], axis=1) / SIDE


@pytest.mark.parametrize(
    ("ruled", "conditions"),
    [
        (True, Conditions(bend=0.1, tilt=25, towards=30, megapixels=4)),
        (False, Conditions(bend=0.1, tilt=20, towards=30, megapixels=5)),
        (True, Conditions(bend=0.07, bend_along=True, tilt=15, towards=30, megapixels=5)),
    ],
    ids=["ruled", "no lines", "rolled the other way"],
)
def test_boxes_on_a_bent_page_are_where_its_characters_were_printed(monkeypatch, ruled, conditions):
    flat, middles = drawn_page(ruled=ruled)
    seen = take_photograph(flat, conditions, seed=3).picture
    straight = off_by(rumu.read_page(seen, text=POEM), middles)
    monkeypatch.setattr("rumu.pages.reading.find_straightening", lambda _: None)
    bent = off_by(rumu.read_page(seen, text=POEM), middles)
    assert np.quantile(straight, 0.9) < 0.13
    assert np.median(straight) < 0.85 * np.median(bent)
