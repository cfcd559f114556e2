"""Pages of many characters: nothing of the writing is taken for a speck, a line or a neighbour."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from rumu.capture.image import read_image
from rumu.errors import RefusedImage
from rumu.gallery.starter import find_work
from rumu.surface.ink import find_ink
from rumu.surface.pages import character_size, remove_solid
from rumu.surface.relief import relief

CELL = 64


def sheet(rows: int, columns: int, *, margin: int = 0) -> np.ndarray:
    """(H, W) bool: the starter's regular characters in cells of CELL pixels, each with a dot of 4 x 4."""
    glyphs = []
    for name in ("shui", "ren", "tian", "shu", "yue"):
        image = read_image(find_work(f"regular-{name}").path)
        gray = image if image.ndim == 2 else image.mean(axis=2)
        glyphs.append(cv2.resize(gray, (48, 48), interpolation=cv2.INTER_AREA) < 0.5)
    page = np.zeros((rows * CELL, columns * CELL), bool)
    for row, column in np.ndindex(rows, columns):
        cell = page[row * CELL : (row + 1) * CELL, column * CELL : (column + 1) * CELL]
        cell[8:56, 8:56] = glyphs[(row * columns + column) % len(glyphs)]
        cell[58:62, 30:34] = True
    return np.pad(page, margin)


def photo(ink: np.ndarray) -> np.ndarray:
    grain = np.random.default_rng(1).normal(0, 0.01, ink.shape)
    return np.clip(np.where(ink, 0.12, 0.88) + grain, 0, 1).astype(np.float32)


@pytest.mark.parametrize(("rows", "columns"), [(7, 4), (12, 9), (30, 20)])
def test_a_page_keeps_every_dot_and_every_column(rows, columns):
    page = sheet(rows, columns, margin=20)
    ink = find_ink(photo(page))
    assert np.count_nonzero(ink.mask ^ page) < 0.002 * np.count_nonzero(page)
    assert 30 < ink.figures["character"] < 70
    assert ink.left_out["neighbour"] == ink.left_out["caption"] == 0


def test_a_column_that_stands_alone_at_the_side_of_a_page_is_no_neighbour():
    page = np.hstack([sheet(12, 1), np.zeros((12 * CELL, 3 * CELL), bool), sheet(12, 10)])
    assert find_ink(photo(page)).mask[:, :CELL].sum() > 0.99 * page[:, :CELL].sum()


def test_what_lies_beyond_a_ruled_line_of_a_page_stays():
    page = sheet(12, 9, margin=20)
    ruled = page.copy()
    for column in range(10):
        ruled[:, 20 + column * CELL : 22 + column * CELL] = True
    ink = find_ink(photo(ruled))
    assert ink.left_out["grid"] > 5000
    assert np.count_nonzero(ink.mask & page) > 0.99 * np.count_nonzero(page)
    assert np.count_nonzero(ink.mask & ~page) < 0.02 * np.count_nonzero(page)


def test_dots_and_thin_strokes_of_a_page_have_the_relief_of_their_own_width():
    page = sheet(12, 9, margin=20)
    page[300:420, 22:24] = True  # a thin stroke in the gap between the rows of cells
    dot = np.zeros_like(page)
    dot[20 + 58 : 20 + 62, 20 + 30 : 20 + 34] = True
    height = relief(photo(page)).height
    assert 1.2 < height[dot].max() < 2.2, "half the width of the dot, 2 px, is its radius"
    assert 0.7 < height[320:400, 22:24].mean() < 1.1


def test_one_character_is_no_page_and_dotted_paper_is_no_writing():
    assert character_size(sheet(1, 1)) is None
    assert character_size(np.zeros((64, 64), bool)) is None
    assert "character" not in find_ink(photo(sheet(2, 2))).figures
    squares = np.zeros((1600, 1200), bool)
    squares[::20, ::20] = True
    squares = cv2.dilate(squares.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    assert character_size(squares) is None


def test_noise_on_a_large_sheet_is_no_page():
    grain = cv2.GaussianBlur(np.random.default_rng(0).normal(0, 1, (1600, 1200)), (0, 0), 2)
    with pytest.raises(RefusedImage) as refused:
        find_ink(((grain - grain.min()) / np.ptp(grain)).astype(np.float32))
    assert refused.value.reason == "noise"


# --- real pages -----------------------------------------------------------------------------------


def test_printed_pages_keep_the_ink_of_all_their_characters(data):
    folder = data / "pages"
    for entry in json.loads((folder / "text.json").read_text(encoding="utf-8")):
        ink = find_ink(read_image(next(folder.rglob(Path(entry["file"]).name))))
        columns = [column for register in entry["registers"] for column in register]
        count = sum(len(column["text"]) for column in columns)
        each = ink.mask.sum() / count / ink.figures["character"] ** 2
        assert 0.1 < each < 0.6, (entry["file"], each)  # of a square of this side, a character covers a part
        lost = sum(ink.left_out[kind] for kind in ("speck", "neighbour", "caption", "stain"))
        assert lost < 0.01 * ink.mask.sum(), (entry["file"], dict(ink.left_out))


def test_pages_of_practice_are_taken(data):
    for file in sorted((data / "pages" / "practice").iterdir())[::3]:
        ink = find_ink(read_image(file))
        assert 60 < ink.figures["character"] < 220, file.name
        assert 0.01 < ink.mask.mean() < 0.12, file.name
        assert ink.left_out["caption"] == ink.left_out["neighbour"] == 0, file.name


def test_crops_of_one_character_are_no_pages(data):
    folder = data / "masters" / "running-lantingxu"
    for file in [*(folder / "yu").glob("0[0-2]*"), *(folder / "dingwu").glob("0[0-2]*")]:
        assert "character" not in find_ink(read_image(file)).figures, file.name


@pytest.mark.parametrize("character", [9, 40, 81])
def test_what_is_as_thick_as_a_character_is_what_an_opening_by_a_disk_leaves(character):
    rng = np.random.default_rng(5)
    mask = cv2.GaussianBlur(rng.normal(size=(300, 400)).astype(np.float32), (0, 0), 12) > 0
    mask[100:260, 40:240] = True
    side = 2 * round(character / 2) + 1
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    opened = cv2.morphologyEx(np.pad(mask.astype(np.uint8), side, mode="edge"), cv2.MORPH_OPEN, disk)
    solid = cv2.dilate(opened, np.ones((5, 5), np.uint8))[side:-side, side:-side] > 0
    kept = remove_solid(mask, character=character)
    assert np.mean(kept != (mask & ~solid)) < 0.01 and (mask & ~kept).any()


def test_thin_ink_is_left_as_it_is():
    mask = np.zeros((200, 200), bool)
    mask[10:190:20, 10:190] = True
    assert np.array_equal(remove_solid(mask, character=40), mask)
