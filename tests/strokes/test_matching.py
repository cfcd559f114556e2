import numpy as np
import pytest

from rumu.strokes.centre_lines import LinePoints
from rumu.strokes.matching import COVER, LineMatch, find_covered, slope, weigh_cover

SPACING, NEAR = 0.05, 0.2


def line_at(x: float) -> LinePoints:
    """Ten points of one upright line."""
    xy = np.column_stack([np.full(10, x), np.arange(10) * SPACING])
    double = np.tile([-1.0, 0.0], (10, 1))
    return LinePoints(xy, double, np.full(10, 0.05), np.zeros(10, np.intp), np.ones(10, bool), SPACING)


def covers(aside: float, explained: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """What is covered and explained of a line that lies beside the master's, as weighed and as decided."""
    master, copy = line_at(0.0), line_at(aside)
    found = LineMatch(master.xy, np.eye(10, dtype=np.float32) * np.float32(explained))
    has, told = weigh_cover(found, copy, master, near=NEAR)
    covered, owner = find_covered(found, copy, master, near=NEAR)
    return (float(has.mean()), float(told.mean())), (float(covered.mean()), float((owner >= 0).mean()))


@pytest.mark.parametrize(("aside", "explained"), [(0.0, 1.0), (0.1, 0.9), (1.0, 0.9), (0.0, 0.02)])
def test_far_from_the_limits_points_are_weighed_as_they_are_decided(aside, explained):
    weighed, decided = covers(aside, explained)
    assert weighed == pytest.approx(decided)


def test_weights_never_jump_where_the_decision_does():
    aside = [covers(a, 1.0) for a in np.linspace(0.1, 0.6, 101)]
    explained = [covers(0.0, e) for e in np.linspace(0.0, 1.0, 101)]
    for rows in (aside, explained):
        weighed, decided = (np.array([row[k] for row in rows]) for k in (0, 1))
        assert np.abs(np.diff(decided, axis=0)).max() > 0.8
        assert np.abs(np.diff(weighed, axis=0)).max() < 0.06
    # at the limit itself a point counts half
    assert covers(0.0, COVER.min_explained)[0][1] == pytest.approx(0.5)


def test_slope_is_straight_between_its_ends():
    assert slope(np.array([0.0, 0.5, 1.0, 1.5, 2.0]), 1.0, 0.5).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
