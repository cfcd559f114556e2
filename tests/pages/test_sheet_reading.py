from dataclasses import replace

import cv2
import numpy as np
import pytest

from rumu.errors import RefusedImage
from rumu.gallery.sheet_masters import choose_masters
from rumu.pages.sheet_layout import SheetPage, lay_out
from rumu.pages.sheet_markers import find_markers
from rumu.pages.sheet_reading import is_sheet, locate_sheet, read_cells
from rumu_lab.simulation.camera import Conditions, take_photograph

WRITTEN = {(0, 0), (0, 3), (1, 1), (2, 2), (2, 5), (3, 4)}


@pytest.fixture(scope="module")
def written(page, masters, sheets):
    return sheets.write_in(sheets.print_page(page, masters), page, masters, cells=WRITTEN)


def intersection_over_union(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


def half_way(gamma: float) -> float:
    """The level half-way in light from the ink that `write_in` leaves to the paper."""
    return 255 * (1 + 0.12**gamma) / 2


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
        assert intersection_over_union(found.picture < half_way(gamma=1.0), ink > 0.5) > 0.93


@pytest.mark.parametrize("gamma", [1.0, 1.6, 2.2])
def test_strokes_keep_their_width_whatever_the_tone_curve_of_the_camera(gamma, written, masters, sheets):
    sheet = locate_sheet(sheets.photograph(written, size=(3000, 2400), blur=1.8, gamma=gamma)[0])
    for found in read_cells(sheet, masters.shapes):
        side = len(found.picture)
        ink = cv2.resize(
            sheets.copy_of(masters, found.cell.character), (side, side), interpolation=cv2.INTER_AREA
        )
        assert np.mean(found.picture < half_way(gamma)) == pytest.approx(np.mean(ink > 0.5), rel=0.035)


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


@pytest.mark.parametrize("along", [False, True])
def test_a_sheet_that_is_rolled_two_centimetres_high_is_read(along, written, page, masters):
    photograph = take_photograph(
        written, Conditions(tilt=20, towards=30, bend=0.1, bend_along=along, megapixels=3)
    )
    sheet = locate_sheet(photograph.picture)
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    true = photograph.points(corners * (np.array(written.shape[1::-1]) / page.size) - 0.5)
    assert np.hypot(*(sheet.places.pixels(corners) - true).T).max() < 1.0
    assert {(c.cell.row, c.cell.column) for c in read_cells(sheet, masters.shapes)} == WRITTEN


def test_all_markers_of_a_blurred_sheet_from_far_away_are_found(written, page):
    conditions = Conditions(tilt=20, towards=30, turn=10, fill=0.7, megapixels=3, blur=2, noise=4, jpeg=75)
    picture = take_photograph(written, conditions).picture
    assert len(find_markers(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))) == 12
    assert locate_sheet(picture).page == page


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


def test_two_hidden_corners_and_a_strong_shade_do_no_harm(written, page, masters, sheets):
    hidden = written.copy()
    hidden[:200, :160] = (190, 150, 130)
    hidden[-200:, -160:] = (150, 120, 100)
    picture, pixels = sheets.photograph(hidden, size=(2400, 2000))
    height, width = picture.shape[:2]
    across = np.linspace(0, 1, width)[None, :, None] + np.linspace(0, 0.5, height)[:, None, None]
    shade = 1 - 0.55 / (1 + np.exp((across - 0.7) / 0.05))  # the shadow of a hand: its edge crosses the page
    sheet = locate_sheet(np.clip(picture * shade, 0, 255).astype(np.uint8))
    assert sheet.page == page
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    assert np.hypot(*(sheet.places.pixels(corners) - pixels(corners)).T).max() < 1.5
    assert {(c.cell.row, c.cell.column) for c in read_cells(sheet, masters.shapes)} == WRITTEN


def drawn_pictures() -> dict[str, np.ndarray]:
    """Pictures that are no sheets: other documents, codes, boards, scenes."""
    rng = np.random.default_rng(7)
    lines = np.full((1200, 900, 3), 245, np.uint8)
    for row in range(60, 1150, 40):
        for left in range(60, 840, 22):
            cv2.putText(lines, chr(65 + int(rng.integers(26))), (left, row), 0, 0.7, (20, 20, 20), 2)
    board = np.kron(np.indices((12, 9)).sum(axis=0) % 2, np.ones((90, 90))).astype(np.uint8) * 255
    other = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    markers = np.full((1200, 900), 255, np.uint8)
    for number in range(12):
        y, x = 60 + number // 3 * 280, 60 + number % 3 * 280
        markers[y : y + 160, x : x + 160] = cv2.aruco.generateImageMarker(other, number, 160)
    code = cv2.QRCodeEncoder.create().encode("https://example.org/a-page-of-another-program")
    code = cv2.resize(np.pad(code, 4, constant_values=255), (700, 700), interpolation=cv2.INTER_NEAREST)
    scene = cv2.GaussianBlur(rng.integers(0, 256, (900, 1200, 3), dtype=np.uint8), (0, 0), 25)
    scene = cv2.normalize(scene, None, 0, 255, cv2.NORM_MINMAX)
    grid = np.full((1200, 900, 3), 240, np.uint8)
    for at in range(50, 1200, 100):
        cv2.line(grid, (50, at), (850, at), (200, 60, 60), 4)
        cv2.line(grid, (at, 50), (at, 1150), (200, 60, 60), 4)
    gray = {"board": board, "markers of another kind": markers, "code": code}
    coloured = {name: np.repeat(one[..., None], 3, axis=2) for name, one in gray.items()}
    return coloured | {"text": lines, "scene": scene, "grid": grid}


@pytest.mark.parametrize("turn", [0, 1])
@pytest.mark.parametrize("name", drawn_pictures())
def test_no_cell_is_read_in_what_is_no_sheet(name, turn):
    assert refusal(np.ascontiguousarray(np.rot90(drawn_pictures()[name], turn))) == "no sheet"


@pytest.mark.parametrize("turn", [0, 180, 265])
@pytest.mark.parametrize("blur", [3.5, 6.0, 9.0])
def test_a_sheet_is_told_to_be_blurred_however_blurred_it_is(blur, turn, written, sheets):
    picture, _ = sheets.photograph(written, turn=turn)
    blurred = cv2.GaussianBlur(picture, (0, 0), blur)
    cv2.circle(blurred, (700, 40), 25, (60, 60, 60), -1)  # something on the table
    assert is_sheet(blurred)
    assert refusal(blurred) == "blurred"


def test_dark_spots_that_stand_elsewhere_are_no_blurred_sheet():
    rng = np.random.default_rng(8)
    for _ in range(5):
        page = np.full((1800, 1300, 3), 235, np.uint8)
        for x, y in rng.uniform(80, 1220, (60, 2)).astype(int).tolist():
            cv2.rectangle(page, (x, y), (x + 48, y + 48), (20, 20, 20), -1)
        blurred = cv2.GaussianBlur(page, (0, 0), 9)
        assert not is_sheet(blurred)
        assert refusal(blurred) == "no sheet"


@pytest.mark.usefixtures("data", "benchmarks")
def test_sharp_characters_in_columns_are_no_blurred_sheet():
    from scroll import draw_scroll

    scroll = np.asarray(draw_scroll("shenlong")[0])
    assert not is_sheet(scroll)
    assert refusal(scroll) == "no sheet"


def test_a_dark_picture_is_told(written, sheets):
    picture, _ = sheets.photograph(written)
    rng = np.random.default_rng(1)
    dark = np.clip(0.12 * picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
    assert refusal(dark) in ("dark", "no sheet")


def test_a_page_with_another_code_is_never_read_as_this_one(page, masters, sheets):
    other = replace(page, number=1, count=1, sheet="ffffffff", pupil="")
    assert locate_sheet(sheets.photograph(sheets.print_page(other, masters))[0]).page == other
