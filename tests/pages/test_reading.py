"""Whole pages: drawn ones, where each character's place is known, and scanned and photographed ones."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
import pytest

import rumu
from rumu.characters.stroke_data import find_character
from rumu.errors import ImageError, RefusedImage, RumuError
from rumu.pages.page_ink import find_page_ink

POEM = (
    "永和九年歲在癸丑", "暮春之初會于會稽", "山陰之蘭亭修禊事", "也群賢畢至少長咸",
    "集此地有崇山峻領", "茂林修竹又有清流",
)  # fmt: skip
TEXT = "".join(POEM)


@dataclass
class DrawnPage:
    """A page on which characters are drawn; centres: (character, x, y) in the order of drawing."""

    gray: np.ndarray
    centres: list[tuple[str, float, float]] = field(default_factory=list)

    def draw(self, character: str, x: float, y: float, side: float) -> None:
        """One character in the middle of (x, y)."""
        found = find_character(character)
        assert found is not None, character
        for stroke in found.strokes:
            points = (stroke.polygon() - 0.5) * side + (x, y)
            cv2.fillPoly(self.gray, [np.rint(points * 16).astype(np.int32)], 25, cv2.LINE_AA, 4)
        self.centres.append((character, x, y))

    @property
    def picture(self) -> np.ndarray:
        return np.dstack([self.gray] * 3)


Draw = Callable[..., DrawnPage]


@pytest.fixture
def columns_page() -> Draw:
    """Registers of columns, from the right, with a frame and a line between the registers."""

    def draw(
        *registers: Sequence[str], side: int = 40, pitch: int = 56, pace: int = 44, frame: bool = True
    ) -> DrawnPage:
        longest = max(len(column) for register in registers for column in register)
        columns = max(len(register) for register in registers)
        high, wide = longest * pace + 50, columns * pitch + 40
        page = DrawnPage(np.full((high * len(registers) + 100, wide + 100), 240, np.uint8))
        for r, register in enumerate(registers):
            top = 50 + r * high
            if frame:
                cv2.rectangle(page.gray, (50, top), (50 + wide, top + high), 40, 3)
            for c, column in enumerate(register):
                x = 50 + wide - 20 - pitch * (c + 0.5)
                for k, character in enumerate(column):
                    page.draw(character, x, top + 25 + pace * (k + 0.5), side)
        return page

    return draw


@pytest.fixture
def rows_page() -> Draw:
    """A modern page: rows from the left, from top to bottom."""

    def draw(rows: Sequence[str], *, side: int = 40, pitch: int = 64, pace: int = 44) -> DrawnPage:
        size = (pitch * len(rows) + 80, pace * max(map(len, rows)) + 80)
        page = DrawnPage(np.full(size, 240, np.uint8))
        for r, row in enumerate(rows):
            for k, character in enumerate(row):
                page.draw(character, 40 + pace * (k + 0.5), 40 + pitch * (r + 0.5), side)
        return page

    return draw


def assert_in_place(page, drawn, *, within=8.0):
    """Each found character stands where it was drawn, in the same order."""
    assert len(page.characters) == len(drawn.centres)
    for found, (_, x, y) in zip(page.characters, drawn.centres, strict=True):
        left, top, right, bottom = found.box
        assert abs((left + right) / 2 - x) < within + 6 and abs((top + bottom) / 2 - y) < within + 6


def places(page):
    return [(one.register, one.column, one.row) for one in page.characters]


def test_columns_run_from_right_to_left(columns_page):
    drawn = columns_page(POEM)
    page = rumu.read_page(drawn.picture)
    assert page.direction == "vertical"
    assert places(page) == [(0, c, k) for c in range(6) for k in range(8)]
    assert_in_place(page, drawn)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_page_that_lies_on_its_side_or_head_is_turned_upright(columns_page, rows_page, turns):
    for drawn in (columns_page(POEM), rows_page(POEM)):
        page = rumu.read_page(np.rot90(drawn.picture, turns), text=TEXT)
        assert page.picture.shape == drawn.picture.shape
        assert_in_place(page, drawn)
        assert "".join(one.character for one in page.characters) == TEXT


@pytest.mark.parametrize("degrees", [-3.0, 2.0, 11.0])
def test_a_page_that_leans_is_set_straight_by_its_text(columns_page, degrees):
    drawn = columns_page(POEM, frame=False)
    height, width = drawn.gray.shape
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 1)
    leaning = cv2.warpAffine(drawn.picture, matrix, (width, height), borderValue=(240, 240, 240))
    page = rumu.read_page(leaning)
    assert places(page) == [(0, c, k) for c in range(6) for k in range(8)]
    middles = np.array([one.polygon.mean(axis=0) for one in page.characters]).reshape(6, 8, 2)
    assert np.abs(np.diff(middles[:, [0, -1], 0], axis=1)).max() < 6  # each column stands upright


@pytest.mark.parametrize("colour", [(200, 60, 50), (70, 90, 180), (60, 60, 60), (180, 175, 170)])
@pytest.mark.parametrize("thick", [1, 3])
def test_columns_between_ruled_lines_are_columns(columns_page, colour, thick):
    """朱絲欄, 烏絲欄 and their like are no grid of cells."""
    drawn = columns_page(POEM, frame=False, side=38, pitch=60)
    picture, (height, width) = drawn.picture, drawn.gray.shape
    for c in range(7):
        x = width - 70 - 60 * c
        cv2.line(picture, (x, 52), (x, height - 52), colour, thick)
    cv2.rectangle(picture, (width - 430, 52), (width - 70, height - 52), colour, 3)
    page = rumu.read_page(picture, text=TEXT)
    assert page.cells == () and page.direction == "vertical"
    assert page.text == "\n".join(POEM)
    assert_in_place(page, drawn)


@pytest.mark.parametrize("colour", [(120, 150, 210), (60, 60, 60)])
def test_rows_on_ruled_lines_are_rows(rows_page, colour):
    drawn = rows_page(POEM)
    picture, width = drawn.picture, drawn.gray.shape[1]
    for r in range(7):
        cv2.line(picture, (20, 40 + 64 * r), (width - 20, 40 + 64 * r), colour, 2)
    page = rumu.read_page(picture, text=TEXT)
    assert page.cells == () and page.direction == "horizontal"
    assert page.text == "\n".join(POEM)
    assert_in_place(page, drawn)


def test_registers_run_from_top_to_bottom(columns_page):
    drawn = columns_page(POEM[:4], POEM[2:])
    page = rumu.read_page(drawn.picture)
    assert places(page) == [(r, c, k) for r in range(2) for c in range(4) for k in range(8)]
    assert_in_place(page, drawn)


def test_a_short_column_is_a_column(columns_page):
    page = rumu.read_page(columns_page([POEM[0], "暮春", *POEM[2:]]).picture)
    counts = [len(list(group)) for _, group in itertools.groupby(page.characters, lambda one: one.column)]
    assert counts == [8, 2, 8, 8, 8, 8]


def test_rows_of_a_modern_page_run_from_the_left(rows_page):
    drawn = rows_page(POEM)
    page = rumu.read_page(drawn.picture, text=TEXT)
    assert page.direction == "horizontal"
    assert places(page) == [(0, c, k) for c in range(6) for k in range(8)]
    assert_in_place(page, drawn)
    assert page.text == "\n".join(POEM)


@pytest.mark.parametrize(
    "text",
    [TEXT, "\n".join(POEM), "，".join(POEM) + "。\n", "　".join(TEXT)],
    ids=["one line", "lines", "signs", "spaces"],
)
def test_a_text_names_the_characters_however_it_is_broken(columns_page, text):
    page = rumu.read_page(columns_page(POEM).picture, text=text)
    assert page.text == "\n".join(POEM)
    assert min(one.certainty for one in page.characters) > 0.3


def test_names_survive_what_the_text_leaves_out(columns_page):
    page = rumu.read_page(columns_page(POEM).picture, text=TEXT[:10] + TEXT[19:30] + TEXT[31:])
    names = [one.character for one in page.characters]
    assert names == [*TEXT[:10], *[None] * 9, *TEXT[19:30], None, *TEXT[31:]]


def test_names_survive_what_the_page_leaves_out(columns_page):
    page = rumu.read_page(columns_page(POEM).picture, text="天地玄黃" + TEXT[:20] + "宇宙洪荒" + TEXT[20:])
    assert "".join(str(one.character) for one in page.characters) == TEXT


def test_a_white_on_black_rubbing(columns_page):
    drawn = columns_page(POEM, frame=False)
    page = rumu.read_page(255 - drawn.picture, text=TEXT)
    assert page.text == "\n".join(POEM)


def test_a_rubbing_of_large_characters_that_stand_close_on_grained_stone(columns_page):
    drawn = columns_page(POEM, frame=False, side=62, pitch=72, pace=66)
    grain = cv2.GaussianBlur(np.random.default_rng(2).normal(0, 40, drawn.gray.shape), (0, 0), 1.2)
    rubbing = np.clip(255 - drawn.picture + grain[..., None], 0, 255).astype(np.uint8)
    assert rumu.read_page(rubbing, text=TEXT).text == "\n".join(POEM)


def test_thin_strokes_of_a_blurred_page_are_ink(columns_page):
    drawn = columns_page(POEM, side=26, pitch=40, pace=29)
    faint = 240 - 0.75 * (240.0 - cv2.GaussianBlur(drawn.picture, (0, 0), 1.3))
    ink = find_page_ink(faint.astype(np.uint8)).ink
    strokes = drawn.gray < 90
    assert ink[strokes].mean() > 0.97
    assert not ink[cv2.erode((drawn.gray > 230).astype(np.uint8), np.ones((9, 9))) > 0].any()


def test_a_heading_outside_of_a_frame_that_leans_and_bends_is_left_out(columns_page):
    drawn = columns_page(POEM)
    height, width = drawn.gray.shape
    page = DrawnPage(np.full((height, width + 80), 240, np.uint8))
    page.gray[:, :width] = np.where(np.arange(width) > width - 60, 240, drawn.gray)  # its right line goes
    y = np.arange(50, height - 50)
    x = width - 50 + 30 * ((y - 50) / height) ** 0.7
    cv2.polylines(page.gray, [np.column_stack([x, y]).astype(np.int32)], False, 40, 3)
    for k, character in enumerate("群賢畢至"):
        page.draw(character, width + 30, 90 + 30 * k, 24)
    assert places(rumu.read_page(page.picture)) == [(0, c, k) for c in range(6) for k in range(8)]


def test_silk_on_a_lighter_mount_is_no_ink(columns_page):
    drawn = columns_page(POEM, frame=False)
    silk = (drawn.picture * np.array([0.62, 0.52, 0.38])).astype(np.uint8)
    mount = np.full((silk.shape[0] + 300, silk.shape[1] + 300, 3), 235, np.uint8)
    mount[150:-150, 150:-150] = silk
    page = rumu.read_page(mount, text=TEXT)
    assert page.text == "\n".join(POEM)


def test_a_seal_is_left_out(columns_page):
    drawn = columns_page(POEM)
    picture = drawn.picture
    height, width = drawn.gray.shape
    seal = np.zeros_like(drawn.gray)
    cv2.rectangle(seal, (width // 2 - 45, height - 160), (width // 2 + 45, height - 70), 255, 8)
    cv2.putText(seal, "HH", (width // 2 - 32, height - 95), 0, 1.6, 255, 7)
    picture[(seal > 0) & (drawn.gray > 128)] = (190, 40, 30)
    page = rumu.read_page(picture, text=TEXT)
    assert page.text == "\n".join(POEM)


def test_a_shaded_page(columns_page):
    drawn = columns_page(POEM)
    light = np.linspace(0.35, 1.0, drawn.gray.shape[1])[None, :, None]
    page = rumu.read_page((drawn.picture * light).astype(np.uint8), text=TEXT)
    assert page.text == "\n".join(POEM)


def test_a_double_row_is_told_and_read_on_the_right_first(columns_page):
    columns = [list(column) for column in POEM * 2]
    for c in range(12):
        columns[c][3] = "　"
    blank = [[one if one != "　" else "一" for one in column] for column in columns]
    drawn = columns_page(["".join(column) for column in blank])
    height = 50 + 25 + 44 * 3.5
    for c in range(12):
        x = drawn.centres[8 * c][1]
        cv2.rectangle(drawn.gray, (int(x - 24), int(height - 21)), (int(x + 24), int(height + 21)), 240, -1)
        for dx, dy, character in ((11, -11, "天"), (11, 11, "地"), (-11, -11, "人"), (-11, 11, "和")):
            drawn.draw(character, x + dx, height + dy, 19)
    page = rumu.read_page(drawn.picture)
    column = [one for one in page.characters if one.column == 1]
    assert [one.small for one in column] == [None, None, None, 0, 0, 1, 1, None, None, None, None]
    right, left = column[3].box, column[5].box
    assert right[0] > left[2] - 3 and column[3].box[3] <= column[4].box[1] + 3


def test_a_character_that_was_taken_for_a_double_row_is_one_where_the_text_says_so(columns_page):
    columns = tuple(column[:3] + "林" + column[4:] for column in POEM)
    drawn = columns_page(columns)
    low = DrawnPage(np.full((44, 44), 240, np.uint8))
    low.draw("林", 22, 22, 42)
    low.gray[:, 21:24] = 240
    for character, x, y in drawn.centres:
        if character == "林":  # low, its halves apart
            (left, top), drawn_low = (int(x) - 22, int(y) - 22), np.full((44, 44), 240, np.uint8)
            drawn_low[12:32] = cv2.resize(low.gray, (44, 20), interpolation=cv2.INTER_AREA)
            drawn.gray[top : top + 44, left : left + 44] = drawn_low
    assert {0, 1} <= {one.small for one in rumu.read_page(drawn.picture).characters}
    page = rumu.read_page(drawn.picture, text="".join(columns))
    assert page.text == "\n".join(columns)
    assert all(one.small is None for one in page.characters)


def test_low_characters_far_apart_are_no_double_rows(columns_page):
    """Clerical characters are broad and low, and their halves stand apart."""
    columns = ("竹林八川北小以心", "川竹此林心兆八北", "北以竹心川小林兆", "心八林川竹北此以")
    picture = columns_page(columns, side=66, pace=96, pitch=92, frame=False).picture
    page = rumu.read_page(cv2.resize(picture, None, fx=1, fy=0.62, interpolation=cv2.INTER_AREA))
    assert places(page) == [(0, c, k) for c in range(4) for k in range(8)]
    assert [one.small for one in page.characters] == [None] * 32


def test_boxes_are_in_pixels_of_the_picture_whatever_its_size(columns_page):
    drawn = columns_page(POEM)
    large = np.ascontiguousarray(np.repeat(np.repeat(drawn.picture, 6, axis=0), 6, axis=1))
    page = rumu.read_page(large)
    assert page.picture.shape == large.shape
    for one, (_, x, y) in zip(page.characters, drawn.centres, strict=True):
        left, top, right, bottom = one.box
        assert abs((left + right) / 12 - x) < 14 and abs((top + bottom) / 12 - y) < 14


def test_a_blank_page_is_refused_in_both_languages():
    with pytest.raises(RefusedImage) as refused:
        rumu.read_page(np.full((300, 200), 230, np.uint8))
    assert refused.value.reason == "blank" and refused.value.zh


def lines_everywhere():
    rng = np.random.default_rng(0)
    picture = np.full((800, 600), 255, np.uint8)
    for x0, y0, x1, y1 in rng.integers(0, (600, 800, 600, 800), (100, 4)).tolist():
        cv2.line(picture, (x0, y0), (x1, y1), 0, 2)
    return picture


def landscape():
    picture = np.full((800, 600, 3), (200, 220, 250), np.uint8)
    cv2.fillPoly(
        picture, [np.array([[0, 800], [150, 400], [300, 650], [450, 350], [600, 800]])], (60, 90, 50)
    )
    noise = np.random.default_rng(0).normal(0, 6, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    "picture",
    [
        np.random.default_rng(0).integers(0, 256, (800, 600), dtype=np.uint8),
        lines_everywhere(),
        np.uint8(np.indices((800, 600)).sum(axis=0) // 20 % 2 * 255),
        np.uint8(np.linspace(0, 255, 800)[:, None] * np.ones(600)),
        landscape(),
    ],
    ids=["noise", "lines", "stripes", "gradient", "landscape"],
)
def test_what_is_no_page_holds_no_characters(picture):
    assert rumu.read_page(picture).characters == ()


def test_a_text_without_characters_is_refused(columns_page):
    with pytest.raises(RumuError, match="got none"):
        rumu.read_page(columns_page(POEM).picture, text="，。 \n")


def test_a_file_that_is_no_picture(tmp_path):
    (tmp_path / "page.png").write_text("not a picture")
    with pytest.raises(ImageError):
        rumu.read_page(tmp_path / "page.png")


def true_columns(data, name):
    for entry in json.loads((data / "pages" / "text.json").read_text(encoding="utf-8")):
        if name in entry["file"]:
            return [[re.sub(r"\W", "", c["text"]) for c in register] for register in entry["registers"]]
    raise AssertionError(name)


@pytest.mark.parametrize("name", ["hongwu-southern-38.jpg", "qisha-377.png", "zhaocheng-jin-11.png"])
def test_printed_pages_fall_into_their_columns(data, name):
    true = true_columns(data, name)
    page = rumu.read_page(data / "pages" / "printed" / name)
    found = {}
    for one in page.characters:
        found.setdefault((one.register, one.column), []).append(one)
    assert [sum(key[0] == r for key in found) for r in range(len(true))] == [len(r) for r in true]
    off = [len(found[r, c]) - len(text) for r, register in enumerate(true) for c, text in enumerate(register)]
    assert np.mean(np.array(off) == 0) > 0.9 and np.abs(off).max() <= 1


def test_names_of_a_printed_page(data):
    true = true_columns(data, "qianlong-80.jpg")
    text = "".join("".join(register) for register in true)
    page = rumu.read_page(data / "pages" / "printed" / "qianlong-80.jpg", text=text)
    assert page.text == "\n".join("\n".join(register) for register in true)


def test_the_cells_of_a_grid_on_two_leaves_are_named(data):
    text = (
        "红笺小字，说尽平生意。鸿雁在云鱼在水，惆怅"
        "此情难寄。斜阳独倚西楼，遥山恰对帘钩。人面不知何处，绿波依旧东流。"
    )
    page = rumu.read_page(data / "pages" / "practice" / "3.15.jpg", text=text)
    assert len(page.cells) > len(page.characters)
    named = [one.character for one in page.characters if one.character is not None]
    assert len(named) >= len(page.characters) - 1  # a shadow lies in an empty cell
    assert "".join(named) == re.sub("[，。]", "", text)
