"""Values that travel: an array still to be made is made once, checked like any other, and travels too."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, replace
from functools import partial

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.values import Polyline, Surface

SHAPE = (9, 12)


def flat_normals(calls: list[int]) -> np.ndarray:
    calls.append(1)
    return np.broadcast_to(np.array([0, 0, 1], np.float32), (*SHAPE, 3))


def surface(**changes) -> Surface:
    given = {
        "height": np.zeros(SHAPE, np.float32),
        "normals_from": partial(flat_normals, []),
        "albedo_from": partial(np.ones, SHAPE, np.float32),
        "mask": np.ones(SHAPE, bool),
        "confidence": np.ones(SHAPE, np.float32),
        "spacing": 1.0,
        "unit": "px",
        "source": "inflation",
    }
    return Surface(**(given | changes))


def test_a_recipe_is_followed_once_and_only_when_asked():
    calls: list[int] = []
    made = surface(normals_from=partial(flat_normals, calls))
    assert not calls
    assert made.normals is made.normals
    assert len(calls) == 1


@pytest.mark.parametrize("later", [False, True])
@pytest.mark.parametrize(
    ("name", "array", "words"),
    [
        ("normals", np.zeros((*SHAPE, 3), np.float32), "expected unit normals"),
        ("normals", np.zeros(SHAPE, np.float32), r"expected normals \(9, 12, 3\), got \(9, 12\)"),
        ("albedo", np.full(SHAPE, 2.0, np.float32), r"expected albedo in \[0, 1\]"),
        ("albedo", np.full(SHAPE, np.nan, np.float32), "expected albedo to be finite"),
        ("albedo", np.zeros((3, 3), np.float32), "expected albedo of"),
    ],
)
def test_what_is_made_later_is_checked_like_what_is_given(later, name, array, words):
    if later:
        made = surface(**{f"{name}_from": lambda: array})
        with pytest.raises(SurfaceError, match=words):
            getattr(made, name)
    else:
        with pytest.raises(SurfaceError, match=words):
            surface(**{f"{name}_from": array})


def test_a_surface_travels_before_and_after():
    made = surface()
    before = pickle.loads(pickle.dumps(made))
    np.testing.assert_array_equal(before.normals, made.normals)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(made)).albedo, np.ones(SHAPE))
    np.testing.assert_array_equal(replace(made, spacing=2.0).normals, made.normals)


def test_a_surface_is_frozen():
    for name in ("height", "normals"):
        with pytest.raises(FrozenInstanceError):
            setattr(surface(), name, np.ones(SHAPE, np.float32))


LINE = Polyline(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 6.0]]), np.array([1.0, 2.0, 3.0]))


def test_a_polyline_knows_its_length_and_its_parts():
    assert LINE.length == 7.0
    assert LINE.along.tolist() == [0.0, 5.0, 7.0]
    assert LINE.chord.tolist() == [3.0, 6.0]
    back = LINE.reversed()
    assert back.length == LINE.length
    assert back.radius.tolist() == [3.0, 2.0, 1.0] and back.points[0].tolist() == [3.0, 6.0]
    assert LINE.part(1, 2).points.tolist() == [[3.0, 4.0], [3.0, 6.0]]
    assert Polyline(np.zeros((1, 2)), np.ones(1)).length == 0.0


@pytest.mark.parametrize(
    ("points", "radius", "words"),
    [
        (np.zeros((0, 2)), np.zeros(0), r"expected \(n >= 1, 2\) points, got \(0, 2\)"),
        (np.zeros((3, 3)), np.zeros(3), r"expected \(n >= 1, 2\) points, got \(3, 3\)"),
        (np.zeros((3, 2)), np.zeros(2), r"expected half-widths of \(3,\), got \(2,\)"),
        (np.full((3, 2), np.nan), np.zeros(3), "expected points to be finite"),
    ],
)
def test_a_polyline_is_checked(points, radius, words):
    with pytest.raises(SurfaceError, match=words):
        Polyline(points, radius)
