from dataclasses import replace

import cv2
import numpy as np
import pytest

from rumu.errors import RefusedImage
from rumu.gallery.sheet_masters import choose_masters
from rumu.pages.sheet_layout import SheetPage, lay_out
from rumu.pages.sheet_reading import is_sheet, locate_sheet, read_cells

WRITTEN = {(0, 0), (0, 3), (1, 1), (2, 2), (2, 5), (3, 4)}


@pytest.fixture(scope="module")
def written(page, masters, sheets):
    return sheets.write_in(sheets.print_page(page, masters), page, masters, cells=WRITTEN)


def intersection_over_union(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


@pytest.mark.parametrize("turn", [0, 97, 180])
def test_cells_are_found_however_the_sheet_is_turned(turn, written, page, masters, sheets):
    picture, pixels = sheets.photograph(written, turn=turn)
    sheet = locate_sheet(picture)
    assert sheet.page == page
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    assert np.hypot(*(sheet.places.pixels(corners) - pixels(corners)).T).max() < 0.7
    cells = read_cells(sheet, masters.shapes)
    assert {(c.cell.row, c.cell.column) for c in cells} == WRITTEN
    assert all(np.allclose(c.polygon, pixels(c.cell.box.corners), atol=0.7) for c in cells)


def test_what_was_written_comes_back_without_the_print(written, masters, sheets):
    sheet = locate_sheet(sheets.photograph(written, size=(3000, 2400))[0])
    for found in read_cells(sheet, masters.shapes):
        side = len(found.picture)
        ink = cv2.resize(
            sheets.copy_of(masters, found.cell.character), (side, side), interpolation=cv2.INTER_AREA
        )
        assert intersection_over_union(found.picture < 110, ink > 0.5) > 0.93


@pytest.mark.parametrize(
    ("grid", "help_", "gray"),
    [
        ("mi", "faint", True),
        ("mi", "dots", False),
        ("nine", "outlined", True),
        ("tian", "beside", False),
        ("hui", "dots", True),
        ("none", "faint", False),
    ],
)
def test_no_grid_and_no_model_is_taken_for_writing(grid, help_, gray, masters, sheets):
    (page,) = lay_out(
        SheetPage("永天人水", "strokes", grid=grid, help="shrinking" if help_ == "dots" else help_, cell=32)
    )
    flat = sheets.print_page(page, masters, gray=gray)
    sheet = locate_sheet(sheets.photograph(flat)[0])
    assert sheet.page == page and (sheet.gray > 0.8) == gray
    assert read_cells(sheet, masters.shapes) == ()
    cell = next(cell for cell in page.cells if cell.is_for_writing)
    flat = sheets.write_in(flat, page, masters, cells={(cell.row, cell.column)})
    (found,) = read_cells(locate_sheet(sheets.photograph(flat)[0]), masters.shapes)
    side = len(found.picture)
    ink = cv2.resize(sheets.copy_of(masters, cell.character), (side, side), interpolation=cv2.INTER_AREA)
    assert intersection_over_union(found.picture < 110, ink > 0.5) > 0.85


def test_a_bent_sheet_is_read_by_the_frames_of_its_cells(written, page, masters, sheets):
    picture, pixels = sheets.photograph(written)
    height, width = picture.shape[:2]
    columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    bow = 14 * np.sin(np.pi * columns / width).astype(np.float32)  # pixels, as a page bends upward
    sheet = locate_sheet(cv2.remap(picture, columns, rows + bow, cv2.INTER_LINEAR))
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    x, y = pixels(corners).T
    for _ in range(4):
        bent = y - 14 * np.sin(np.pi * x / width)
    assert np.hypot(*(sheet.places.pixels(corners) - np.column_stack([x, bent])).T).max() < 1.0
    assert {(c.cell.row, c.cell.column) for c in read_cells(sheet, masters.shapes)} == WRITTEN


def test_another_master_of_the_same_text_has_another_sheet(masters):
    (one,), (other,) = (lay_out(SheetPage("天人水", name)) for name in ("strokes", "regular"))
    assert one.sheet != other.sheet
    assert set(choose_masters("天人水", ("regular",)).by_character) == set("天人水")


# --- refusals --------------------------------------------------------------------------------------


def refusal(picture: np.ndarray) -> str:
    with pytest.raises(RefusedImage) as caught:
        locate_sheet(picture)
    assert caught.value.zh
    return caught.value.reason


def test_pictures_without_a_sheet_are_told(sheets):
    rng = np.random.default_rng(3)
    blank = np.full((900, 700, 3), 240, np.uint8)
    for picture in (blank, rng.integers(0, 256, blank.shape, dtype=np.uint8)):
        assert not is_sheet(picture)
        assert refusal(picture) == "no sheet"


def test_a_sheet_of_another_program_is_told(written, page, sheets):
    covered, box = written.copy(), page.code_box
    left, top, right, bottom = (
        round(v * 200 / 25.4) for v in (box.left, box.top, box.left + box.width, box.top + box.height)
    )
    covered[top:bottom, left:right] = 255
    assert refusal(sheets.photograph(covered)[0]) == "unreadable"


def test_two_sheets_in_one_picture_are_told(written, sheets):
    picture, _ = sheets.photograph(written)
    assert refusal(np.hstack([picture, picture])) == "two sheets"


def test_a_sheet_that_is_cut_off_is_told(written, sheets):
    picture, _ = sheets.photograph(written)
    assert refusal(picture[: round(0.55 * len(picture))]) == "cut off"
    assert refusal(picture[:, 420:]) == "cut off"


def test_a_hidden_marker_does_no_harm(written, page, masters, sheets):
    hidden = written.copy()
    hidden[:200, :160] = (190, 150, 130)  # a thumb on the first corner
    sheet = locate_sheet(sheets.photograph(hidden)[0])
    assert sheet.page == page and len(read_cells(sheet, masters.shapes)) == len(WRITTEN)


def test_a_blurred_or_dark_picture_is_told(written, sheets):
    picture, _ = sheets.photograph(written)
    assert refusal(cv2.GaussianBlur(picture, (0, 0), 3.5)) in ("blurred", "no sheet")
    rng = np.random.default_rng(1)
    dark = np.clip(0.12 * picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
    assert refusal(dark) in ("dark", "no sheet")


def test_a_page_with_another_code_is_never_read_as_this_one(page, masters, sheets):
    other = replace(page, number=1, count=1, sheet="ffffffff", pupil="")
    assert locate_sheet(sheets.photograph(sheets.print_page(other, masters))[0]).page == other
