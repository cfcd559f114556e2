"""Photographs of a flat page: from the side, turned, on a desk; and pictures that are no pages."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rumu.errors import ImageError
from rumu.pages.flatten import flatten_photo
from rumu.pages.grids import find_grid

DESK, PAPER, RED, BLACK = (96, 78, 62), (238, 236, 230), (222, 120, 112), (40, 40, 40)
NOISE = np.random.default_rng(3)


def camera(size: tuple[int, int], *, tilt: float, turn: float, spin: float) -> tuple[np.ndarray, int]:
    """(3, 3) photograph from page, of a camera that looks at its middle, and the photograph's side."""
    height, width = size
    longer = max(size)
    a, b, c = np.radians([tilt, turn, spin])
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    turned, side = about_x @ about_y @ about_z, int(1.5 * longer)
    lens = np.array([[1.12 * longer, 0, side / 2], [0, 1.12 * longer, side / 2], [0, 0, 1]])
    place = np.stack([turned[:, 0], turned[:, 1], [0, 0, 1.5 * longer]], axis=1)
    return lens @ place @ np.array([[1, 0, -width / 2], [0, 1, -height / 2], [0, 0, 1.0]]), side


def page_with_grid() -> tuple[np.ndarray, np.ndarray]:
    page = np.full((720, 540, 3), PAPER, np.uint8)
    cells = [(45 + 90 * c, 45 + 90 * r) for r in range(7) for c in range(5)]
    for x, y in cells:
        cv2.rectangle(page, (x, y), (x + 90, y + 90), RED, 2)
        cv2.line(page, (x + 20, y + 30), (x + 70, y + 26), BLACK, 5)
        cv2.line(page, (x + 45, y + 14), (x + 42, y + 76), BLACK, 5)
    corners = np.array([[0, 0], [90, 0], [90, 90], [0, 90]])
    return page, np.array([np.array([x, y]) + corners for x, y in cells], float)


def photograph(page: np.ndarray, matrix: np.ndarray, side: int) -> np.ndarray:
    seen = cv2.warpPerspective(page, matrix, (side, side), borderValue=DESK).astype(np.float32)
    light = np.linspace(0.7, 1.0, side)[None, :, None]
    return np.clip(seen * light + NOISE.normal(0, 4, seen.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(("tilt", "turn", "spin"), [(25, 0, 0), (30, 10, 3), (36, 0, 0), (28, 28, 5)])
def test_the_cells_of_a_page_seen_from_the_side_lie_where_they_are(tilt, turn, spin):
    page, quads = page_with_grid()
    matrix, side = camera(page.shape[:2], tilt=tilt, turn=turn, spin=spin)
    flat = flatten_photo(photograph(page, matrix, side))
    assert flat.found_by == "lines"
    grid = find_grid(flat.picture)
    assert grid is not None and len(grid.cells) == 35
    found = np.array([flat.photo_from_flat(cell.polygon) for cell in grid.cells])
    true = cv2.perspectiveTransform(quads.reshape(1, -1, 2), matrix).reshape(quads.shape)
    assert np.linalg.norm(found - true, axis=2).max() < 3


def test_a_sheet_on_a_desk_is_found_by_its_edge():
    page = np.full((800, 600, 3), PAPER, np.uint8)
    for x, y in NOISE.integers(100, 480, (14, 2)):
        cv2.ellipse(page, (int(x), int(y)), (24, 14), 40, 0, 250, BLACK, 6)
    matrix, side = camera(page.shape[:2], tilt=40, turn=8, spin=0)
    flat = flatten_photo(photograph(page, matrix, side))
    assert flat.found_by in ("paper", "lines")
    size = flat.picture.shape
    corners = cv2.perspectiveTransform(np.array([[[0.0, 0], [600, 0], [600, 800], [0, 800]]]), matrix)[0]
    back = flat.photo_from_flat(np.array([[0, 0], [size[1], 0], [size[1], size[0]], [0, size[0]]], float))
    assert np.linalg.norm(back - corners, axis=1).max() < 0.15 * side


@pytest.mark.parametrize(("tilt", "turn"), [(0, 0), (36, 6)])
def test_the_lines_of_a_tiled_desk_are_not_those_of_the_sheet_on_it(tilt, turn):
    page, quads = page_with_grid()
    matrix, side = camera(page.shape[:2], tilt=tilt, turn=turn, spin=4 * bool(tilt))
    tiles = np.full((side, side, 3), (118, 116, 112), np.uint8)
    tiles[::130] = tiles[:, ::130] = (60, 60, 60)
    tiles = cv2.erode(tiles, np.ones((3, 3), np.uint8))
    on_sheet = cv2.warpPerspective(np.full(page.shape[:2], 255, np.uint8), matrix, (side, side)) > 127
    seen = np.where(on_sheet[..., None], photograph(page, matrix, side), tiles)
    flat = flatten_photo(seen)
    grid = find_grid(flat.picture)
    assert grid is not None and len(grid.cells) == 35
    found = np.array([flat.photo_from_flat(cell.polygon) for cell in grid.cells])
    true = cv2.perspectiveTransform(quads.reshape(1, -1, 2), matrix).reshape(quads.shape)
    assert np.linalg.norm(found - true, axis=2).max() < 4


@pytest.mark.parametrize("spin", [0, 38, 90, 215])
def test_lines_are_followed_however_the_camera_is_turned(spin):
    page, quads = page_with_grid()
    matrix, side = camera(page.shape[:2], tilt=20, turn=10, spin=spin)
    flat = flatten_photo(photograph(page, matrix, side))
    assert flat.found_by == "lines"
    true = cv2.perspectiveTransform(quads.reshape(1, -1, 2), matrix)[0]
    grid = find_grid(flat.picture)
    assert grid is not None and len(grid.cells) == 35
    found = np.concatenate([flat.photo_from_flat(cell.polygon) for cell in grid.cells])
    assert np.linalg.norm(found[:, None] - true[None], axis=2).min(axis=1).max() < 3


@pytest.mark.parametrize(("tilt", "turn", "spin"), [(0, 0, 9), (25, 0, 0), (0, 25, 3), (18, 18, -6)])
def test_a_page_without_lines_or_edges_is_set_straight_by_its_text(tilt, turn, spin):
    page = np.full((840, 700, 3), PAPER, np.uint8)
    centres = np.array([(80 + 60 * c, 60 + 40 * r) for c in range(10) for r in range(19)], float)
    for x, y in centres.astype(int):  # ink that shows no straight line
        for dx, dy in NOISE.integers(-12, 13, (6, 2)):
            cv2.ellipse(page, (int(x + dx), int(y + dy)), (7, 3), int(NOISE.integers(180)), 0, 360, BLACK, -1)
    matrix, side = camera(page.shape[:2], tilt=tilt, turn=turn, spin=spin)
    seen = cv2.warpPerspective(page, matrix, (side, side), borderValue=PAPER)
    flat = flatten_photo(seen)
    assert flat.found_by == "text"
    height, width = flat.picture.shape[:2]
    x, y = np.meshgrid(np.linspace(0.3, 0.7, 9) * width, np.linspace(0.3, 0.7, 9) * height)
    grid = flat.photo_from_flat(np.column_stack([x.ravel(), y.ravel()]))
    on_page = cv2.perspectiveTransform(grid[None], np.linalg.inv(matrix))[0].reshape(9, 9, 2)
    down, right = on_page[-1, :] - on_page[0, :], on_page[:, -1] - on_page[:, 0]
    assert np.degrees(np.abs(np.arctan2(down[:, 0], down[:, 1]))).max() < 1.5
    assert np.degrees(np.abs(np.arctan2(right[:, 1], right[:, 0]))).max() < 1.5


def test_the_ground_around_a_sheet_is_cut_off():
    page, _ = page_with_grid()
    matrix, side = camera(page.shape[:2], tilt=20, turn=0, spin=4)
    flat = flatten_photo(photograph(page, matrix, side))
    height, width = flat.picture.shape[:2]
    x, y = np.meshgrid(np.linspace(0, width, 40), np.linspace(0, height, 40))
    shown = flat.photo_from_flat(np.column_stack([x.ravel(), y.ravel()]))
    on_page = cv2.perspectiveTransform(shown[None], np.linalg.inv(matrix))[0] / page.shape[1::-1]
    assert ((on_page > 0) & (on_page < 1)).all(axis=1).mean() > 0.85
    assert on_page.min() > -0.05 and on_page.max() < 1.05


def test_a_sheet_that_lies_half_in_a_shadow_is_kept_whole():
    photo = np.full((800, 900, 3), DESK, np.uint8)
    photo[100:700, 150:750] = PAPER
    shade = 1 - 0.5 / (1 + np.exp((np.arange(900) - 420) / 60))
    flat = flatten_photo((photo * shade[None, :, None]).astype(np.uint8))
    assert flat.picture.shape[:2] == pytest.approx((612, 612), abs=12)


def test_a_page_that_lies_flat_stays_as_it_is():
    page, _ = page_with_grid()
    flat = flatten_photo(page)
    assert flat.found_by == "picture" and flat.picture is page
    assert np.array_equal(flat.photo_from_flat(np.array([[3.0, 4.0]])), [[3.0, 4.0]])


def test_noise_and_a_plain_picture_stay_as_they_are():
    for picture in (
        NOISE.integers(0, 255, (300, 260, 3)).astype(np.uint8),
        np.full((90, 80, 3), 200, np.uint8),
    ):
        assert flatten_photo(picture).found_by == "picture"


@pytest.mark.parametrize("picture", [np.zeros((40, 40), np.uint8), np.zeros((40, 40, 3))])
def test_what_is_no_picture_is_refused(picture):
    with pytest.raises(ImageError):
        flatten_photo(picture)
