"""One vector a character: alike for one character by several hands, unlike for others."""

from __future__ import annotations

from functools import partial

import cv2
import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

import rumu
from rumu.gallery.starter import find_work
from rumu.registration.descriptor import (
    DescriptorSettings,
    beyond_others,
    describe,
    likeness,
    mirror,
    turn,
)
from rumu.registration.points import sample_points
from rumu_lab.simulation import faults


def vector_of(ink: np.ndarray, **options) -> np.ndarray:
    page = np.rint(245 - 225 * ink.astype(np.float32)).astype(np.uint8)
    return describe(sample_points(rumu.relief(page)), **options)


def ink_of(work: str) -> np.ndarray:
    return 1.0 - np.asarray(Image.open(find_work(work).path), np.float32) / 255.0


def test_a_vector_is_of_unit_length_and_nowhere_negative():
    vector = vector_of(ink_of("regular-shu"))
    assert vector.shape == (DescriptorSettings().length,)
    assert vector.dtype == np.float32
    assert np.linalg.norm(vector) == pytest.approx(1.0, abs=1e-5)
    assert vector.min() >= 0


@pytest.mark.parametrize("work", ["regular-shui", "seal-ren", "cursive-shu"])
def test_place_and_size_do_not_matter(work):
    ink = ink_of(work)
    M = np.array([[0.6, 0, 40.0], [0, 0.6, 130.0]])
    moved = cv2.warpAffine(ink, M, (512, 512), flags=cv2.INTER_AREA)
    assert vector_of(moved) @ vector_of(ink) > 0.985


def test_a_squeezed_part_costs_less_when_strokes_are_spread_evenly():
    ink = ink_of("regular-shu")
    squeezed = faults.apply(ink > 0.5, "squeeze", severity=5, seed=1).ink
    plain, even = (DescriptorSettings(evenness=e) for e in (0.0, 0.8))
    gained = [vector_of(squeezed, settings=s) @ vector_of(ink, settings=s) for s in (plain, even)]
    assert gained[1] > gained[0]


def test_another_character_is_less_like_than_another_hand():
    own, hand = vector_of(ink_of("regular-shui")), vector_of(ink_of("running-shui"))
    others = [vector_of(ink_of(f"regular-{name}")) for name in ("ren", "ri", "shu", "tian", "yue")]
    assert own @ hand > max(own @ other for other in others)


def test_a_mirrored_character_is_another():
    ink = ink_of("regular-ren")
    assert vector_of(ink) @ vector_of(ink[:, ::-1].copy()) < 0.93


def test_one_straight_stroke_can_be_described():
    ink = np.zeros((200, 200), np.float32)
    ink[96:104, 20:180] = 1
    assert np.isfinite(vector_of(ink)).all()
    assert vector_of(ink) @ vector_of(ink.T.copy()) < 0.7


def test_likeness_is_one_for_the_same_and_about_nothing_for_others():
    vectors = np.stack(
        [vector_of(ink_of(f"regular-{name}")) for name in ("ren", "ri", "shu", "shui", "tian")]
    )
    each = np.stack([likeness(vector, vectors) for vector in vectors])
    np.testing.assert_allclose(np.diag(each), 1.0, atol=1e-5)
    np.testing.assert_allclose(each, each.T, atol=1e-5)
    assert abs(float(np.median(each[~np.eye(5, dtype=bool)]))) < 0.2
    assert float(likeness(vectors[0], vectors[1])) == pytest.approx(each[0, 1], abs=1e-6)


@pytest.mark.parametrize(("change", "steps"), [(mirror, (1, -1)), (partial(turn, degrees=180), (-1, -1))])
def test_points_reversed_are_the_points_of_the_reversed_picture(change, steps):
    ink = ink_of("regular-shu")
    page = [np.rint(245 - 225 * i).astype(np.uint8) for i in (ink, ink[:: steps[0], :: steps[1]])]
    points = [sample_points(rumu.relief(p)) for p in page]
    assert float(likeness(describe(change(points[0])), describe(points[1]))) > 0.99
    again = change(change(points[0]))
    np.testing.assert_allclose(again.xyz, points[0].xyz)
    np.testing.assert_allclose(again.direction, points[0].direction)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_points_turned_are_the_points_of_the_turned_picture(degrees):
    page = np.rint(245 - 225 * ink_of("regular-shu")).astype(np.uint8)
    turned = np.ascontiguousarray(np.rot90(page, -degrees // 90))
    points = [sample_points(rumu.relief(p)) for p in (page, turned)]
    changed = turn(points[0], degrees=degrees)
    assert float(likeness(describe(changed), describe(points[1]))) > 0.99
    own, near = cKDTree(points[1].xyz[:, :2]).query(changed.xyz[:, :2])
    assert np.median(own) < 0.02
    assert np.median(np.sum(changed.direction * points[1].direction[near], axis=1)) > 0.9


def test_beyond_others_parts_a_hand_from_another_character_and_knows_common_shapes():
    own, hand = vector_of(ink_of("regular-shui")), vector_of(ink_of("running-shui"))
    others = [vector_of(ink_of(f"regular-{name}")) for name in ("ren", "ri", "shu", "tian", "yue")]
    assert beyond_others(own, hand) > 0 > max(beyond_others(own, other) for other in others)
    assert beyond_others(own, hand) == pytest.approx(beyond_others(hand, own), abs=1e-5)
    assert beyond_others(own, own) < float(likeness(own, own))  # some other characters are like it too
