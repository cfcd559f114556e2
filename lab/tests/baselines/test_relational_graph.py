"""Types of strokes, relations of pairs, and the frame of the box."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.lines import StrokeLine
from rumu_lab.baselines.relational_graph import (
    RELATIONS,
    differences,
    frame_of,
    graph_of,
    relations,
    traits_of,
    wrap_degrees,
)


def straight(x0: float, y0: float, x1: float, y1: float) -> StrokeLine:
    points = np.linspace((x0, y0), (x1, y1), 20)
    return StrokeLine(points, np.full(20, 0.02))


def relation(a: StrokeLine, b: StrokeLine) -> str:
    codes = relations(traits_of([a, b]), width=0.05)
    assert codes[0, 1] == codes[1, 0] and codes[0, 0] == codes[1, 1] == 0
    return RELATIONS[codes[0, 1]]


@pytest.mark.parametrize(
    ("ends", "kind"),
    [
        ((0.0, 0.0, 0.5, 0.05), "H"),
        ((0.5, 0.05, 0.0, 0.0), "H"),
        ((0.0, 0.5, 0.02, 0.0), "V"),
        ((0.0, 0.0, -0.02, 0.5), "V"),
        ((0.3, 0.5, 0.0, 0.0), "S"),
        ((0.0, 0.5, 0.3, 0.0), "B"),
        ((0.0, 0.0, 0.4, 0.3), "T"),
        ((0.0, 0.0, 0.1, -0.1), "D"),
    ],
)
def test_types_are_those_of_the_direction_a_brush_takes(ends, kind):
    assert graph_of([straight(*ends)], width=0.05).kinds == (kind,)


def test_a_hook_ends_a_longer_line_and_turns_from_it():
    shaft, hook = straight(0.5, 0.5, 0.5, -0.4), straight(0.4, -0.3, 0.5, -0.4)
    assert graph_of([shaft, hook], width=0.05).kinds == ("V", "K")
    on = straight(0.5, -0.4, 0.5, -0.5)
    assert graph_of([shaft, on], width=0.05).kinds == ("V", "D")


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((0, 0, 1, 0), (0.5, -0.4, 0.5, 0.4), "cross"),
        ((0, 0, 1, 0), (0.5, 0, 0.5, 0.4), "T-joint"),
        ((0, 0, 1, 0), (0.5, 0.04, 0.5, 0.4), "T-joint"),
        ((0, 0, 1, 0), (1, 0, 1, 0.5), "end-joint"),
        ((0, 0, 1, 0), (0.1, 0.3, 0.9, 0.3), "parallel"),
        ((0, 0, 1, 0), (0.5, 0.2, 0.5, 0.6), "apart"),
        ((0, 0, 0.4, 0), (0.6, 0.1, 1, 0.1), "apart"),
        ((0, 0, 1, 0), (0.1, 0.9, 0.9, 0.9), "apart"),
    ],
)
def test_how_two_lines_stand_to_each_other(a, b, expected):
    assert relation(straight(*a), straight(*b)) == expected
    assert relation(straight(*b), straight(*a)) == expected


def test_arcs_run_from_middle_to_middle():
    traits = traits_of([straight(0, 0, 1, 0), straight(0, 0.5, 0, 1.5)])
    between, bend = differences(traits)
    assert between[0, 1] == pytest.approx((-0.5, 1.0))
    assert bend[0, 1] == pytest.approx(90.0) and bend[1, 0] == pytest.approx(-90.0)


def test_angles_wrap():
    assert wrap_degrees(np.array([190.0, -190.0, 180.0, -180.0, 0.0])) == pytest.approx(
        [-170, 170, 180, 180, 0]
    )


def test_the_box_forgets_place_and_size():
    lines = [straight(10, 10, 110, 12), straight(50, 0, 52, 60)]
    moved = [StrokeLine(3 * one.points + 40, 3 * one.radius) for one in lines]
    a, b = frame_of(lines), frame_of(moved)
    for one, other in zip(lines, moved, strict=True):
        assert a.to_box(one).points == pytest.approx(b.to_box(other).points)
    assert np.abs(a.to_box(lines[0]).points).max() == pytest.approx(0.5)


def test_a_speck_far_out_does_not_stretch_the_box():
    lines = [straight(10, 10, 110, 12), straight(50, 0, 52, 60), straight(10, 50, 100, 50)]
    assert frame_of([*lines, straight(240, 240, 241, 241)]).side == frame_of(lines).side
