"""When a character leans, and when only its horizontals climb."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.strokes.pose import find_pose
from rumu.values import FloatArray, IntArray


def frame_of_strokes() -> tuple[FloatArray, IntArray, FloatArray]:
    """Points of three horizontals and three verticals, their strokes, and their doubled directions."""
    along = np.linspace(-1.0, 1.0, 20)
    lines = [np.column_stack([along, np.full(20, y)]) for y in (-0.8, 0.0, 0.8)]
    lines += [np.column_stack([np.full(20, x), along]) for x in (-0.8, 0.0, 0.8)]
    double = np.repeat([[1.0, 0.0]] * 3 + [[-1.0, 0.0]] * 3, 20, axis=0)
    return np.concatenate(lines), np.repeat(np.arange(6), 20), double


def turned(points: FloatArray, degrees: float) -> FloatArray:
    """Clockwise on the page, y down, about the middle."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("degrees", [-12.0, 6.0, 15.0])
def test_a_character_that_leans_turns_all_its_strokes(degrees: float) -> None:
    master, owner, double = frame_of_strokes()
    pose = find_pose(master, turned(master, degrees), owner=owner, double=double)
    assert pose.angle == pytest.approx(degrees, abs=0.5)


@pytest.mark.parametrize("degrees", [-12.0, 8.0])
@pytest.mark.parametrize("level", [True, False])
def test_strokes_of_one_direction_alone_make_no_lean(degrees: float, level: bool) -> None:
    """Where the horizontals climb and the verticals stand plumb a teacher does not speak of the axis."""
    master, owner, double = frame_of_strokes()
    copy = master.copy()
    for k in range(3) if level else range(3, 6):
        own = owner == k
        middle = master[own].mean(axis=0)
        copy[own] = middle + turned(master[own] - middle, degrees)
    assert abs(find_pose(master, copy, owner=owner, double=double).angle) < 3.0
