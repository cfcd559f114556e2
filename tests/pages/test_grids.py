"""Printed grids, drawn by the tests and on real pages of practice."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.errors import ImageError
from rumu.pages.even_cells import has_sides_both_ways
from rumu.pages.grids import find_grid
from rumu.pages.line_evidence import PrintedLineSettings, find_line_evidence

PAPER, RED, GREEN, GRAY, BLACK = (
    (238, 236, 230),
    (222, 120, 112),
    (110, 160, 120),
    (176, 176, 176),
    (40, 40, 40),
)
RNG = np.random.default_rng(5)


def draw_grid(
    rows: int,
    columns: int,
    *,
    cell: int = 64,
    colour: tuple[int, int, int] = RED,
    kind: str = "rice",
    gap: int = 0,
    beside: int = 0,
    side: int = 2,
    written: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A page with cells, (rows * columns, 4, 2) their corners, and the ink that was written.

    gap, beside: pixels between rows and between columns. side: width of the lines around a cell.
    """
    step, margin = cell + gap, 60
    height, width = 2 * margin + rows * step, 2 * margin + columns * (cell + beside)
    page = np.full((height, width, 3), PAPER, np.uint8)
    ink = np.zeros((height, width), np.uint8)
    quads = []
    for r in range(rows):
        for c in range(columns):
            x, y = margin + c * (cell + beside), margin + r * step
            quads.append([[x, y], [x + cell, y], [x + cell, y + cell], [x, y + cell]])
            _draw_guides(page, x, y, cell=cell, colour=colour, kind=kind)
            cv2.rectangle(page, (x, y), (x + cell, y + cell), colour, side)
            if written is None or written[r, c]:
                _write(ink, x, y, cell)
    page[ink > 0] = BLACK
    return page, np.array(quads, float), ink > 0


def _draw_guides(
    page: np.ndarray, x: int, y: int, *, cell: int, colour: tuple[int, int, int], kind: str
) -> None:
    lines = {
        "rice": [(0, 0.5, 1, 0.5), (0.5, 0, 0.5, 1), (0, 0, 1, 1), (0, 1, 1, 0)],
        "field": [(0, 0.5, 1, 0.5), (0.5, 0, 0.5, 1)],
        "nine": [(0, 1 / 3, 1, 1 / 3), (0, 2 / 3, 1, 2 / 3), (1 / 3, 0, 1 / 3, 1), (2 / 3, 0, 2 / 3, 1)],
        "double": [],
        "plain": [],
    }[kind]
    for x0, y0, x1, y1 in lines:
        for k in np.arange(0, 1, 0.1):  # dashed
            a, b = (x + cell * (x0 + (x1 - x0) * k), y + cell * (y0 + (y1 - y0) * k)), k + 0.05
            end = x + cell * (x0 + (x1 - x0) * b), y + cell * (y0 + (y1 - y0) * b)
            cv2.line(page, [round(v) for v in a], [round(v) for v in end], colour, 1, cv2.LINE_AA)
    if kind == "double":
        inset = round(0.22 * cell)
        cv2.rectangle(page, (x + inset, y + inset), (x + cell - inset, y + cell - inset), colour, 1)


def _write(ink: np.ndarray, x: int, y: int, cell: int) -> None:
    for _ in range(4):
        a, b = (RNG.uniform(0.15, 0.85, 2) * cell + (x, y) for _ in range(2))
        if np.linalg.norm(b - a) < 0.25 * cell:
            b = a + np.array([0.3 * cell * (-1 if a[0] > x + cell / 2 else 1), 0.05 * cell])
        cv2.line(
            ink, np.round(a).astype(int).tolist(), np.round(b).astype(int).tolist(), 1, max(3, cell // 16)
        )


def photograph(page: np.ndarray, corners: np.ndarray, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A page whose four corners are moved, noise and uneven light, and where points of it are then."""
    height, width = page.shape[:2]
    square = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    matrix = cv2.getPerspectiveTransform(square, (square + shift).astype(np.float32))
    seen = cv2.warpPerspective(page, matrix, (width, height), borderValue=PAPER).astype(np.float32)
    light = np.linspace(0.75, 1.0, width)[None, :, None] * np.linspace(1.0, 0.85, height)[:, None, None]
    seen = np.clip(seen * light + RNG.normal(0, 4, seen.shape), 0, 255).astype(np.uint8)
    return seen, cv2.perspectiveTransform(corners.reshape(1, -1, 2), matrix).reshape(corners.shape)


def farthest(cells: np.ndarray, truth: np.ndarray) -> float:
    """Largest distance of a corner from the true one, each cell beside the nearest true cell."""
    centres = truth.mean(axis=1)
    nearest = [int(np.argmin(np.linalg.norm(centres - one.mean(axis=0), axis=1))) for one in cells]
    assert len(set(nearest)) == len(nearest)
    return float(np.linalg.norm(cells - truth[nearest], axis=2).max())


@pytest.mark.parametrize(
    ("kind", "colour"), [("rice", RED), ("field", GREEN), ("nine", GRAY), ("plain", BLACK), ("double", RED)]
)
def test_cells_of_every_kind_of_grid_are_found(kind, colour):
    written = RNG.random((5, 4)) < 0.7
    page, quads, _ = draw_grid(5, 4, colour=colour, kind=kind, written=written)
    seen, quads = photograph(page, quads, np.array([[6, 4], [-5, 9], [3, -6], [8, 5]]))
    grid = find_grid(seen)
    assert grid is not None and len(grid.cells) == 20
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 6
    assert [cell.empty for cell in grid.cells] == (~written).ravel().tolist()
    assert [(cell.column, cell.row) for cell in grid.cells] == [(r, c) for r in range(5) for c in range(4)]


def test_rows_that_stand_apart_are_read_row_by_row():
    page, quads, _ = draw_grid(4, 6, gap=12, kind="field")
    grid = find_grid(photograph(page, quads, np.zeros((4, 2)))[0])
    assert grid is not None and grid.direction == "horizontal"
    assert [(cell.column, cell.row) for cell in grid.cells] == [(r, c) for r in range(4) for c in range(6)]


@pytest.mark.parametrize("kind", ["rice", "field", "nine"])
def test_guides_of_few_large_cells_are_not_taken_for_sides(kind):
    page, quads, _ = draw_grid(4, 3, cell=300, kind=kind, side=5)
    seen, quads = photograph(page, quads, np.zeros((4, 2)))
    grid = find_grid(seen)
    assert grid is not None and len(grid.cells) == 12
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 8


def test_cells_that_stand_apart_on_all_sides_are_found_once_each():
    page, quads, _ = draw_grid(6, 5, cell=144, kind="double", gap=16, beside=16, colour=GRAY)
    seen, quads = photograph(page, quads, np.zeros((4, 2)))
    grid = find_grid(seen)
    assert grid is not None and len(grid.cells) == 30
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 4


@pytest.mark.parametrize(("kind", "colour"), [("plain", BLACK), ("rice", GRAY), ("rice", RED)])
def test_cells_a_quarter_apart_do_not_take_in_the_gap(kind, colour):
    written = RNG.random((6, 5)) < 0.7
    page, quads, _ = draw_grid(6, 5, cell=120, kind=kind, gap=30, beside=30, colour=colour, written=written)
    seen, quads = photograph(page, quads, np.zeros((4, 2)))
    grid = find_grid(seen)
    assert grid is not None and len(grid.cells) == 30
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 3
    assert [cell.empty for cell in grid.cells] == (~written).ravel().tolist()


@pytest.mark.parametrize(("cell", "gap"), [(34, 5), (34, 14), (90, 36)])
def test_frames_that_touch_no_other_are_the_cells_however_small_and_far_apart(cell, gap):
    written = RNG.random((8, 6)) < 0.8
    page, quads, _ = draw_grid(
        8, 6, cell=cell, kind="field", gap=gap, beside=gap, side=1 + cell // 60, written=written
    )
    grid = find_grid(page)
    assert grid is not None and len(grid.cells) == 48
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 3
    assert [(cell.column, cell.row) for cell in grid.cells] == [(r, c) for r in range(8) for c in range(6)]


def test_dark_cells_that_stand_apart_are_no_characters():
    page, _, _ = draw_grid(8, 6, cell=84, kind="plain", gap=20, beside=20, colour=BLACK)
    grid = find_grid(page)
    assert grid is not None and len(grid.cells) == 48


@pytest.mark.parametrize("kind", ["plain", "field", "rice"])
def test_cells_of_a_leaf_that_lies_nearer_to_the_camera_are_found_too(kind):
    near, near_quads, _ = draw_grid(2, 6, cell=78, kind=kind)
    far, far_quads, _ = draw_grid(6, 8, cell=64, kind=kind)
    width = max(near.shape[1], far.shape[1])
    leaves = [
        cv2.copyMakeBorder(leaf, 0, 0, 0, width - leaf.shape[1], cv2.BORDER_CONSTANT, value=PAPER)
        for leaf in (near, far)
    ]
    quads = np.concatenate([near_quads, far_quads + np.array([0, len(near)])])
    grid = find_grid(photograph(np.concatenate(leaves), quads, np.zeros((4, 2)))[0])
    assert grid is not None
    assert [cell.register for cell in grid.cells] == [0] * 12 + [1] * 48
    assert farthest(np.array([cell.polygon for cell in grid.cells]), quads) < 6


@pytest.mark.parametrize("colour", [RED, BLACK])
def test_the_grid_is_taken_away_and_strokes_that_cross_it_stay(colour):
    page, _, ink = draw_grid(4, 4, colour=colour, cell=100)
    grid = find_grid(page)
    assert grid is not None
    both = np.count_nonzero(grid.ink & ink)
    assert both > 0.85 * np.count_nonzero(ink)
    assert both > 0.8 * np.count_nonzero(grid.ink)


def test_red_circles_and_a_pen_change_nothing():
    written = np.ones((5, 4), bool)
    written[2] = [True, False, False, True]
    page, _, _ = draw_grid(5, 4, written=written)
    for centre in ((92, 220), (156, 220), (220, 92)):
        cv2.circle(page, centre, 28, (220, 30, 40), 3)
    cv2.line(page, (0, 28), (page.shape[1], 16), (30, 30, 34), 34)
    grid = find_grid(page)
    assert grid is not None and len(grid.cells) == 20
    assert [cell.empty for cell in grid.cells] == (~written).ravel().tolist()


def no_grids() -> list[np.ndarray]:
    """Pictures without a grid: noise, a slope, discs, stripes, text, a bookshelf, a face of a clock."""
    rng = np.random.default_rng(11)
    size = (640, 520)
    noise = rng.integers(0, 255, (*size, 3)).astype(np.uint8)
    slope = np.tile(np.linspace(40, 250, size[1]).astype(np.uint8)[None, :, None], (size[0], 1, 3))
    found = [noise, cv2.GaussianBlur(noise, (0, 0), 9), slope, np.full((*size, 3), PAPER, np.uint8)]
    for k in range(8):
        page = np.full((*size, 3), PAPER, np.uint8)
        for _ in range(12 + 6 * k):
            colour = rng.integers(0, 255, 3).tolist()
            a, b = rng.integers(0, size[1], 2), rng.integers(0, size[0], 2)
            if k % 2:
                cv2.circle(page, (int(a[0]), int(b[0])), int(rng.integers(5, 120)), colour, -1)
            else:
                cv2.rectangle(
                    page, (int(a[0]), int(b[0])), (int(a[1]), int(b[1])), colour, int(rng.integers(1, 5))
                )
        found.append(page)
    for k in range(8):
        page = np.full((*size, 3), PAPER, np.uint8)
        for y in range(40, 600, 34 + 4 * k):
            for x in range(40, 480, 30 + 4 * k):
                ink = np.zeros(size, np.uint8)
                _write(ink, x, y, 26 + 3 * k)
                page[ink > 0] = BLACK
        found.append(page)
    return found


@pytest.mark.parametrize("rows", [False, True])
def test_level_rows_of_print_in_ruled_columns_are_no_sides_of_cells(rows):
    page = np.full((760, 900, 3), PAPER, np.uint8)
    for x in range(50, 851, 50):
        cv2.line(page, (x, 50), (x, 650), GRAY, 2)
        for y in range(50, 651, 50):
            top = y + (12 if rows else 0)
            cv2.line(page, (x + 10, top), (x + 36, top), BLACK, 3)
            cv2.line(page, (x + 23, top), (x + 23, y + 38), BLACK, 4)
            if rows:
                cv2.line(page, (50, y), (850, y), GRAY, 2)
    cell = np.array([[0, 0], [50, 0], [50, 50], [0, 50]])
    cells = np.array([cell + np.array([x, y]) for x in range(50, 850, 50) for y in range(50, 650, 50)], float)
    evidence = find_line_evidence(page, settings=PrintedLineSettings())
    assert has_sides_both_ways(evidence, cells, clear=True) == rows


def test_pictures_without_a_grid_give_none():
    assert [number for number, picture in enumerate(no_grids()) if find_grid(picture) is not None] == []


@pytest.mark.parametrize(
    "picture", [np.zeros((40, 40), np.uint8), np.zeros((40, 40, 3)), np.zeros((0, 0, 3), np.uint8)]
)
def test_what_is_no_picture_is_refused(picture):
    with pytest.raises(ImageError):
        find_grid(picture)


def test_a_tiny_picture_gives_none():
    assert find_grid(np.full((12, 9, 3), 200, np.uint8)) is None


LAYOUTS = json.loads((Path(__file__).parent / "practice_layouts.json").read_text())


@pytest.mark.usefixtures("data", "benchmarks")
@pytest.mark.parametrize("seed", [1, 2])
def test_patches_of_paper_around_the_characters_of_a_scroll_are_no_cells(seed):
    from scroll import draw_scroll

    scroll, _ = draw_scroll("yu", seed=seed, first=160, count=84)
    assert find_grid(np.asarray(scroll)) is None


@pytest.mark.usefixtures("benchmarks")
@pytest.mark.parametrize("page", ["4.13", "4.4-1", "3.15"])
def test_cells_of_a_page_of_practice(data, page):
    from practice_pages import measure

    there, hits, told, false, _ = measure(data / "pages" / "practice" / f"{page}.jpg", LAYOUTS[page])
    assert hits >= 0.98 * there and told >= 0.98 * hits and false <= 0.02 * there
    assert Image.open(data / "pages" / "practice" / f"{page}.jpg").size[0] > 1000
