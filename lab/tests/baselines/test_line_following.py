"""Candidates of strokes: only what a stroke may be is handed on."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import cell_from
from rumu_lab.baselines.line_following import FollowSettings, candidates_of, segments_of
from rumu_lab.baselines.lines import lines_of, skeleton_of
from rumu_lab.baselines.mbse import _model
from rumu_lab.baselines.relational_graph import frame_of


def cell(*, streaks: bool):
    """Two crossing strokes; `streaks` scratches the standing one into a ladder of loops."""
    ink = np.zeros((256, 256), dtype=bool)
    ink[40:216, 100:150] = True
    ink[110:140, 40:220] = True
    if streaks:
        for k in range(8):
            ink[50 + 20 * k : 62 + 20 * k, 112:120] = False
            ink[50 + 20 * k : 62 + 20 * k, 130:138] = False
    return cell_from(ink)


def test_ways_that_no_stroke_chose_are_dropped():
    copy = cell(streaks=True)
    segments = segments_of(skeleton_of(copy), frame_of(lines_of(copy)))
    graph = _model(cell(streaks=False))[2]
    found = candidates_of(graph, segments)
    chosen = {k for choice in found.choice for k in choice}
    assert chosen == set(range(len(found.ways))) and chosen
    assert len(found.traits.length) == len(found.ways)
    assert all(list(cost) == sorted(cost) for cost in found.cost)


def plus(*, gap: int = 0) -> np.ndarray:
    """Two crossing strokes, the level one broken by so many pixels."""
    ink = np.zeros((256, 256), dtype=bool)
    ink[40:216, 120:136] = True
    ink[110:126, 20:236] = True
    ink[:, 170 : 170 + gap] = False
    return ink


def followed(ink: np.ndarray) -> list[list[float]]:
    """Lengths of the candidates of each stroke of the unbroken cross, longest stroke first."""
    copy = cell_from(ink)
    segments = segments_of(skeleton_of(copy), frame_of(lines_of(copy)))
    found = candidates_of(_model(cell_from(plus()))[2], segments)
    return [[float(found.traits.length[k]) for k in choice] for choice in found.choice]


def test_a_line_is_followed_straight_through_a_fork():
    level, standing = followed(plus())
    assert level[0] == pytest.approx(1.0, abs=0.03)
    assert standing[0] == pytest.approx(160 / 200, abs=0.05)


@pytest.mark.parametrize(("gap", "jumped"), [(6, True), (40, False)])
def test_a_narrow_break_is_jumped_and_a_wide_one_is_not(gap, jumped):
    longest = max(followed(plus(gap=gap))[0])
    assert (longest > 0.9) == jumped


def test_a_way_never_runs_twice_through_a_piece():
    copy = cell(streaks=True)
    segments = segments_of(skeleton_of(copy), frame_of(lines_of(copy)))
    found = candidates_of(_model(cell(streaks=False))[2], segments)
    m = len(segments.pieces)
    assert all(len({d % m for d in way}) == len(way) for way in found.ways)


def test_few_ways_are_looked_at_where_there_are_thousands():
    copy = cell(streaks=True)
    segments = segments_of(skeleton_of(copy), frame_of(lines_of(copy)))
    graph = _model(cell(streaks=False))[2]
    best = [
        candidates_of(graph, segments, settings=FollowSettings(most=n)).cost[0][0] for n in (60, 400, 4000)
    ]
    assert best[0] >= best[1] and best[1] == best[2]
