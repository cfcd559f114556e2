"""The white between lines, and the ink in an elastic mesh."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.lines import StrokeLine
from rumu_lab.baselines.white_gaps import elastic_shares, mesh_of, white_gaps


def bars(*rows: int, left: int = 10, right: int = 90) -> tuple[np.ndarray, list[StrokeLine]]:
    """Bars six pixels thick in a picture of 100, and their centre lines."""
    ink = np.zeros((100, 100), bool)
    lines = []
    for row in rows:
        ink[row : row + 6, left:right] = True
        x = np.arange(left, right, dtype=float)
        lines.append(StrokeLine(np.column_stack([x, np.full(len(x), row + 2.5)]), np.full(len(x), 3.0)))
    return ink, lines


def test_gaps_are_the_white_between_neighbours_only():
    ink, lines = bars(10, 40, 80)
    found = white_gaps(ink, lines, least=6)
    assert set(found) == {(0, 1), (1, 2)}
    assert found[0, 1] == pytest.approx(0.24) and found[1, 2] == pytest.approx(0.34)


def test_gaps_are_found_across_columns_as_well():
    ink, lines = bars(10, 40)
    turned = [StrokeLine(line.points[:, ::-1], line.radius) for line in lines]
    assert white_gaps(ink.T, turned, least=6) == pytest.approx({(0, 1): 0.24})


def test_who_faces_another_over_too_little_is_no_neighbour():
    ink, lines = bars(10)
    low, more = bars(60, left=86, right=99)
    assert white_gaps(ink | low, lines + more, least=10) == {}
    assert set(white_gaps(ink | low, lines + more, least=3)) == {(0, 1)}


def test_no_white_no_gaps():
    ink, lines = bars(40)
    assert white_gaps(ink, lines, least=6) == {}


def test_the_mesh_leaves_a_third_on_either_side():
    mass = np.random.default_rng(1).random((60, 90)) * np.linspace(0.1, 2, 90)
    rows, columns = mesh_of(mass)
    shares = elastic_shares(mass, (rows, columns)).reshape(3, 3)
    assert shares.sum() == pytest.approx(1.0)
    assert shares.sum(axis=0) == pytest.approx([1 / 3] * 3, abs=1e-6)
    assert shares.sum(axis=1) == pytest.approx([1 / 3] * 3, abs=1e-6)


def test_the_mesh_stretches_with_the_character():
    mass = np.zeros((120, 120))
    mass[10:40, 10:30], mass[20:35, 50:58] = 1.0, 2.0
    wide = np.repeat(np.repeat(mass, 2, axis=1), 3, axis=0)
    assert elastic_shares(wide, mesh_of(wide)) == pytest.approx(elastic_shares(mass, mesh_of(mass)))


def test_ink_beyond_the_lines_lies_in_the_outer_cells():
    mass = np.ones((9, 9))
    shares = elastic_shares(mass, (np.array([-5.0, 20.0]), np.array([3.0, 6.0])))
    assert shares.reshape(3, 3).sum(axis=1) == pytest.approx([0, 1, 0])
