import numpy as np
import pytest

from rumu.pages.cell_lattice import best_sizes
from rumu.pages.cell_scores import CellSettings, EdgeMaps, fit_of_pairs, map_edges, opposite_edges
from rumu.pages.line_evidence import PrintedLineSettings, find_line_evidence


def test_the_fit_of_a_cell_is_that_of_its_four_edges():
    rng = np.random.default_rng(2)
    across, down = rng.random((2, 60, 80)).astype(np.float32)
    edges = EdgeMaps(across, down, stride=2, pitch=20.0)
    sides, ends = opposite_edges(edges, 20.0, along="x"), opposite_edges(edges, 12.0, along="y")
    fit, least = fit_of_pairs(sides, ends), CellSettings().least
    for row, column in ((30, 40), (3, 5), (0, 79), (57, 12)):
        four = [
            values[row + y, column + x] if 0 <= row + y < 60 and 0 <= column + x < 80 else 0.0
            for values, y, x in ((down, 0, -5), (down, 0, 5), (across, -3, 0), (across, 3, 0))
        ]
        expected = least * min(four) + (1 - least) * np.mean(four)
        assert fit[row, column] == pytest.approx(expected, abs=1e-6)


def test_the_best_size_is_that_of_the_cells():
    page = np.full((700, 640, 3), 245, np.uint8)
    for k in range(9):
        page[40 + k * 60 : 42 + k * 60, 50:532] = page[40:522, 50 + k * 60 : 52 + k * 60] = (60, 150, 90)
    lines = PrintedLineSettings()
    edges = map_edges(find_line_evidence(page), 60.0, reduction=lines.reduction, enough=lines.enough)
    _, width, height = best_sizes(edges)[0]
    assert (width, height) == pytest.approx((60, 60), abs=1.5)
