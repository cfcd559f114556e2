import cv2
import numpy as np
import pytest

from rumu.errors import ImageError
from rumu.pages.cell_flatten import find_cell_around, flatten_cell, refine_corners

SIDE = 400


def drawn_cell() -> np.ndarray:
    """A cell with its frame, a cross and a character of two strokes."""
    cell = np.full((SIDE, SIDE, 3), 240, np.uint8)
    cv2.rectangle(cell, (1, 1), (SIDE - 2, SIDE - 2), (200, 80, 70), 3)
    cv2.line(cell, (80, 130), (320, 120), (20, 20, 20), 26)
    cv2.line(cell, (210, 60), (190, 350), (20, 20, 20), 30)
    return cell


@pytest.fixture(scope="module")
def photographed():
    """(picture, corners): the cell seen from aside, on a desk; corners clockwise from the upper left."""
    corners = np.array([[330.0, 240], [690, 270], [760, 650], [280, 600]])
    square = np.array([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE]], np.float32) - 0.5
    matrix = cv2.getPerspectiveTransform(square, (corners - 0.5).astype(np.float32))
    desk = np.full((900, 1000, 3), 232, np.uint8)
    picture = cv2.warpPerspective(
        drawn_cell(), matrix, (1000, 900), dst=desk, borderMode=cv2.BORDER_TRANSPARENT
    )
    return cv2.GaussianBlur(picture, (0, 0), 0.8), corners


def test_perspective_is_taken_out(photographed):
    picture, corners = photographed
    flat = flatten_cell(picture, corners)
    small = cv2.resize(flat, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    ink, true = small[..., 0] < 130, drawn_cell()[..., 0] < 130
    assert np.count_nonzero(ink & true) / np.count_nonzero(ink | true) > 0.94
    assert flat.shape[0] == flat.shape[1] == pytest.approx(410, abs=40)
    assert flatten_cell(picture, corners, most=100).shape == (100, 100, 3)


def test_an_upright_square_is_cut_as_it_is():
    rng = np.random.default_rng(2)
    picture = rng.integers(0, 256, (120, 150, 3), dtype=np.uint8)
    corners = np.array([[20, 30], [100, 30], [100, 110], [20, 110]])
    assert np.array_equal(flatten_cell(picture, corners), picture[30:110, 20:100])


def test_a_turn_is_taken_out():
    picture = np.zeros((200, 200, 3), np.uint8)
    picture[:100] = 250  # the upper half is bright
    turned = np.array([[150, 50], [150, 150], [50, 150], [50, 50]])  # upright after a quarter to the left
    flat = flatten_cell(picture, turned)
    assert flat[:, :40].mean() > 230 and flat[:, -40:].mean() < 20


def test_printed_sides_near_a_square_are_found(photographed):
    picture, corners = photographed
    middle, half = corners.mean(axis=0), 215
    square = middle + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    found = refine_corners(picture, square)
    assert found is not None and np.hypot(*(found - corners).T).max() < 5
    assert refine_corners(np.full_like(picture, 240), square) is None


@pytest.mark.parametrize("half", [110, 150, 200])
def test_the_printed_cell_around_writing_is_found(photographed, half):
    picture, corners = photographed
    square = corners.mean(axis=0) + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    found = find_cell_around(picture, square)
    assert found is not None and np.hypot(*(found - corners).T).max() < 5
    assert find_cell_around(np.full_like(picture, 240), square) is None


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0], [100, 0], [100, 100]],
        [[0, 0], [0, 100], [100, 100], [100, 0]],  # the other way round
        [[0, 0], [100, 100], [100, 0], [0, 100]],  # crossed
        [[0, 0], [20, 0], [20, 20], [0, 20]],
        [[0, 0], [np.nan, 0], [100, 100], [0, 100]],
    ],
)
def test_corners_that_are_none_of_a_cell_are_told(corners):
    with pytest.raises(ImageError, match="four corners") as told:
        flatten_cell(np.zeros((200, 200, 3), np.uint8), np.array(corners))
    assert told.value.zh
