"""When a character leans, and when only its horizontals climb; when it is too wide for its height."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.strokes.pose import CharacterPose, find_pose
from rumu.strokes.stance import find_stance
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


def shape_of(copy: FloatArray, *, strokes: int = 6) -> CharacterPose:
    master, owner, double = frame_of_strokes()
    own = owner < strokes
    master, copy, owner, double = master[own], copy[own], owner[own], double[own]
    pose, squeeze = find_stance(master, copy, owner=owner, double=double)
    assert squeeze is None
    return pose


@pytest.mark.parametrize("aspect", [-0.3, -0.15, 0.15, 0.3])
def test_a_character_of_another_shape_has_its_aspect_and_size(aspect: float) -> None:
    master, _, _ = frame_of_strokes()
    pose = shape_of(1.1 * master * np.exp([aspect / 2, -aspect / 2]) + [0.2, 0.1])
    assert (pose.aspect, pose.scale, pose.angle) == pytest.approx((aspect, 1.1, 0.0), abs=1e-6)
    assert pose.shift == pytest.approx([0.2, 0.1], abs=1e-6)


def test_no_single_stroke_nor_a_small_change_makes_another_shape() -> None:
    master, owner, _ = frame_of_strokes()
    long = np.where((owner == 1)[:, None], master * [1.8, 1.0], master)
    assert shape_of(long).aspect == pytest.approx(0.0)
    assert shape_of(master * [1.08, 1.0]).aspect == pytest.approx(0.0)
    assert shape_of(master * [1.5, 1.0], strokes=1).aspect == pytest.approx(
        0.0
    )  # 一 has no height to speak of


def test_parts_that_stand_too_close_together_make_no_narrow_character() -> None:
    master, owner, _ = frame_of_strokes()
    half = np.array([0.6, 0.0])
    both = np.concatenate([master * [0.3, 1.0] - half, master * [0.3, 1.0] + half])
    owners = np.concatenate([owner, owner + 6])
    closer = both - 0.12 * np.sign(both[:, :1]) * [1.0, 0.0]
    pose, _ = find_stance(both, closer, owner=owners, double=np.zeros_like(both))
    assert pose.aspect == pytest.approx(0.0)
    pose, _ = find_stance(both, both * [0.8, 1.0], owner=owners, double=np.zeros_like(both))
    assert pose.aspect == pytest.approx(np.log(0.8))
