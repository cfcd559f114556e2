"""What stands on a page beside its characters and is none, and columns larger or smaller than the others."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rumu.characters.stroke_data import find_character
from rumu.pages.free_page import FreePage, find_free_page
from rumu.pages.page import Direction

POEM = ("永和九年歲在癸丑", "暮春之初會于會稽", "山陰之蘭亭修禊事", "也群賢畢至少長咸", "集此地有崇山峻領")
SIDE, PACE, PITCH = 40, 44, 62


def draw(gray: np.ndarray, character: str, x: float, y: float, side: float = SIDE) -> None:
    """One character in the middle of (x, y)."""
    found = find_character(character)
    assert found is not None
    for stroke in found.strokes:
        points = (stroke.polygon() - 0.5) * side + (x, y)
        cv2.fillPoly(gray, [np.rint(points * 16).astype(np.int32)], 25, cv2.LINE_AA, 4)


def place(direction: Direction, line: int, row: float) -> tuple[float, float]:
    """The middle of a character; columns from the right, or rows from the top."""
    along = 70 + PACE * (row + 0.5)
    across = 60 + PITCH * (line + 0.5)
    return (560 - across, along) if direction == "vertical" else (along, across)


def written(direction: Direction, lines: tuple[str, ...] = POEM) -> np.ndarray:
    """A page of these lines, a blank in a line standing for an empty place."""
    gray = np.full((620, 600), 240, np.uint8)
    for line, text in enumerate(lines):
        for row, character in enumerate(text):
            if character != " ":
                draw(gray, character, *place(direction, line, row))
    return gray


def counts(page: FreePage) -> list[int]:
    return [len(column.shapes) for column in page.columns]


def read(gray: np.ndarray) -> FreePage:
    return find_free_page(np.dstack([gray] * 3))


@pytest.mark.parametrize("direction", ["vertical", "horizontal"])
def test_points_in_places_of_their_own_are_no_characters(direction: Direction) -> None:
    """，。 stand at the upper right of their place in a column, at the lower left of it in a row."""
    lines = tuple(f"{text[:4]} {text[4:7]} {text[7:]}" for text in POEM)
    gray = written(direction, lines)
    aside, along = 11, -11
    for line, text in enumerate(lines):
        for row in (k for k, one in enumerate(text) if one == " "):
            x, y = place(direction, line, row)
            x, y = (x + aside, y + along) if direction == "vertical" else (x + along, y + aside)
            cv2.circle(gray, (round(x), round(y)), 4, 25, 2 if row == 4 else -1, cv2.LINE_AA)
    page = read(gray)
    assert page.direction == direction
    assert counts(page) == [8] * 5


def test_a_question_mark_and_a_bracket_in_a_row_are_no_characters() -> None:
    gray = written("horizontal", tuple(f"{text[:3]} {text[3:6]} {text[6:]}" for text in POEM))
    for line in range(5):
        x, y = map(round, place("horizontal", line, 3))
        cv2.line(gray, (x + 8, y - 16), (x + 8, y + 8), 25, 2)  # 「
        cv2.line(gray, (x + 8, y - 16), (x + 17, y - 16), 25, 2)
        x, y = map(round, place("horizontal", line, 7))
        cv2.line(gray, (x - 12, y - 16), (x - 12, y + 6), 25, 4)  # ！
        cv2.circle(gray, (x - 12, y + 14), 3, 25, -1)
    assert counts(read(gray)) == [8] * 5


def test_pieces_of_a_frame_above_columns_are_no_characters() -> None:
    gray = written("vertical")
    for line in (0, 2, 3):
        x, y = map(round, place("vertical", line, 0))
        cv2.line(gray, (x - 16, y - 42), (x + 12, y - 42), 25, 3)
    assert counts(read(gray)) == [8] * 5


def test_a_first_character_of_one_stroke_is_kept() -> None:
    gray = written("vertical", ("一" + POEM[0][1:], *POEM[1:3], "一" + POEM[3][1:], POEM[4]))
    assert counts(read(gray)) == [8] * 5


@pytest.mark.parametrize("direction", ["vertical", "horizontal"])
def test_characters_of_a_title_are_whole(direction: Direction) -> None:
    gray = written(direction, ("", *POEM[:4]))
    for row, character in enumerate("蘭亭序"):
        x, y = place(direction, 0, 1.8 * row + 1)
        shift = 22
        x, y = (x + shift, y) if direction == "vertical" else (x, y - shift)
        draw(gray, character, x, y, 70)
    assert counts(read(gray)) == [3, 8, 8, 8, 8]


def test_a_signature_beside_the_last_column_is_read() -> None:
    gray = written("vertical", POEM[:4])
    x, y = place("vertical", 4, 4)
    for row, character in enumerate("王右軍書之"):
        draw(gray, character, x + 18, y + 23 * row, 20)
    assert counts(read(gray)) == [8, 8, 8, 8, 5]
