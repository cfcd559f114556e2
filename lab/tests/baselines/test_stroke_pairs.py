"""Lines cut alike and paired one to one."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.lines import StrokeLine
from rumu_lab.baselines.stroke_pairs import curves_of, cut_alike, middles_apart, orient, pair_lines


def straight(x0: float, y0: float, x1: float, y1: float, radius: float = 4.0) -> StrokeLine:
    n = max(2, round(np.hypot(x1 - x0, y1 - y0)))
    return StrokeLine(np.linspace((x0, y0), (x1, y1), n), np.linspace(radius, 2 * radius, n))


def lengths(lines) -> list[int]:
    return sorted(round(line.length) for line in lines)


def test_a_stroke_in_two_pieces_is_cut_on_the_other_side_too():
    whole, halves = [straight(0, 0, 100, 0)], [straight(0, 3, 60, 3), straight(62, 3, 100, 3)]
    one, two = cut_alike(whole, halves, width=8.0)
    assert lengths(two) == [38, 60]
    assert lengths(one) == pytest.approx([39, 61], abs=2)
    two, one = cut_alike(halves, whole, width=8.0)
    assert lengths(one) == pytest.approx([39, 61], abs=2)


def test_a_stroke_that_another_meets_is_not_cut():
    bar, stem = straight(0, 0, 100, 0), straight(50, 0, 50, 80)
    one, _ = cut_alike([bar, stem], [bar, stem], width=8.0)
    assert lengths(one) == [80, 100]


def test_no_short_piece_is_cut_off():
    one, _ = cut_alike([straight(0, 0, 100, 0)], [straight(6, 0, 94, 0)], width=8.0)
    assert lengths(one) == [100]


def test_the_copy_is_turned_to_run_beside():
    reference, copy = curves_of([straight(0, 0, 90, 0)]), curves_of([straight(90, 5, 0, 5)])
    points, radius = orient(copy, reference)
    assert points[0, 0, :, 0] == pytest.approx(reference.points[0, :, 0])
    assert radius[0, 0, 0] > radius[0, 0, -1]


def test_pairs_are_one_to_one_and_near_ones_only():
    model = [straight(0, y, 90, y) for y in (0, 30, 60)]
    copy = [straight(0, y + 4, 90, y + 4) for y in (60, 0)] + [straight(0, 0, 0, 90)]
    reference, own = (
        curves_of([StrokeLine(x.points / 100, x.radius / 100) for x in some]) for some in (model, copy)
    )
    worth = np.exp(-middles_apart(reference, own) / 0.1)
    assert pair_lines(worth, reference, own) == [(0, 1), (2, 0)]
