"""Lines: corners cut, dots given a direction, the same lines however the character is scaled."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.lines import StrokeLine, angles_between, as_line, corners, lines_of, polygon, turnings


def line(*places: tuple[float, float]) -> StrokeLine:
    """A polygon with a point at every unit of length."""
    parts = [
        np.linspace(a, b, max(2, round(np.hypot(b[0] - a[0], b[1] - a[1]))), endpoint=False)
        for a, b in zip(np.array(places[:-1], float), np.array(places[1:], float), strict=True)
    ]
    points = np.concatenate([*parts, [places[-1]]])
    return StrokeLine(points, np.full(len(points), 3.0))


def arc(degrees: float, radius: float) -> StrokeLine:
    t = np.radians(np.linspace(0, degrees, 90))
    return StrokeLine(radius * np.column_stack([np.sin(t), 1 - np.cos(t)]), np.full(90, 3.0))


def test_a_polygon_leaves_no_point_farther_than_its_deviation():
    curve = arc(120, 60)
    for deviation in (0.5, 2.0, 8.0):
        kept = polygon(curve.points, deviation=deviation)
        assert kept[0] == 0 and kept[-1] == 89
        corner = curve.points[kept]
        for a, b, k, m in zip(corner[:-1], corner[1:], kept[:-1], kept[1:], strict=True):
            chord = (b - a) / np.hypot(*(b - a))
            rel = curve.points[k : m + 1] - a
            assert np.abs(rel[:, 0] * chord[1] - rel[:, 1] * chord[0]).max() <= deviation
    assert len(polygon(curve.points, deviation=0.5)) > len(polygon(curve.points, deviation=8.0)) >= 3


@pytest.mark.parametrize(("bend", "cut"), [(20, 0), (40, 0), (50, 1), (90, 1), (150, 1)])
def test_a_line_is_cut_where_it_turns_enough(bend, cut):
    end = 60 + 50 * np.cos(np.radians(bend)), 50 * np.sin(np.radians(bend))
    found = corners(line((0, 0), (60, 0), end), deviation=2.0, arm=12.0, least=45.0)
    assert len(found) == cut
    assert all(abs(place - 60) <= 2 for place in found)


def test_a_round_corner_is_one_corner_and_a_long_curve_none():
    rounded = line((0, 0), (50, 0), (56, 2), (58, 8), (58, 60))
    assert len(corners(rounded, deviation=2.0, arm=12.0, least=45.0)) == 1
    assert corners(arc(90, 150), deviation=2.0, arm=12.0, least=45.0) == []


def test_no_corner_is_cut_within_an_arm_of_an_end():
    hooked = line((0, 0), (60, 0), (60, 8))
    assert corners(hooked, deviation=2.0, arm=12.0, least=45.0) == []


def test_turning_is_that_of_the_chords():
    bent = line((0, 0), (60, 0), (60, 60))
    assert turnings(bent, np.array([60]), arm=10.0)[0] == pytest.approx(90.0, abs=3)


def test_a_box_has_four_lines():
    ink = np.zeros((SIDE, SIDE), bool)
    ink[60:200, 60:200] = True
    ink[78:182, 78:182] = False
    found = lines_of(cell_from(ink))
    assert 4 <= len(found) <= 5
    assert sum(one.length for one in found) == pytest.approx(4 * 122, rel=0.06)


def test_a_round_dot_is_a_short_line():
    dot = as_line(np.array([[10.0, 20.0]]), np.array([4.0]))
    assert dot.length == pytest.approx(4.0)
    assert angles_between(dot.chord, np.array([1.0, 1.0])) == pytest.approx(0.0, abs=1e-9)
    rows, columns = np.mgrid[:SIDE, :SIDE]
    assert len(lines_of(cell_from((rows - 120) ** 2 + (columns - 130) ** 2 < 100))) >= 1


def test_parts_and_turning_keep_the_line():
    whole = line((0, 0), (60, 0), (60, 60))
    assert whole.part(0, 30).length + whole.part(30, 120).length == pytest.approx(whole.length)
    assert whole.reversed().at(np.array([0.25])) == pytest.approx(whole.at(np.array([0.75])))
    assert whole.middle == pytest.approx((60, 0), abs=0.6)
