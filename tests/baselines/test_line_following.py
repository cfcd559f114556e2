"""Candidates of strokes: only what a stroke may be is handed on."""

from __future__ import annotations

import numpy as np

from rumu.baselines.cell import cell_from
from rumu.baselines.line_following import candidates_of, segments_of
from rumu.baselines.lines import lines_of, skeleton_of
from rumu.baselines.mbse import _model
from rumu.baselines.relational_graph import frame_of


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
