"""Which way up characters stand, and how sure that is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rumu.characters.stroke_data import find_character
from rumu.pages.glyph_likeness import describe_ink, turned_description
from rumu.pages.upright import quarter_turns, turn_votes

TEXT = "永和九年歲在癸丑暮春之初會于會稽"


def ink_of(character: str, *, lean: float = 0.0) -> np.ndarray:
    """(96, 96) bool: a character as copybooks print it, perhaps leaning."""
    found = find_character(character)
    assert found is not None
    canvas = np.zeros((96, 96), np.uint8)
    for stroke in found.strokes:
        cv2.fillPoly(canvas, [np.rint(stroke.polygon() * 70 + 13).astype(np.int32)], 1)
    matrix = cv2.getRotationMatrix2D((48, 48), lean, 1)
    return cv2.warpAffine(canvas, matrix, canvas.shape[::-1]) > 0


def looks(*, turns: int, lean: float = 0.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """The ink of the text's characters on a page turned by quarters clockwise."""
    found = []
    for character in TEXT:
        y, x = np.nonzero(np.rot90(ink_of(character, lean=lean), -turns))
        found.append((y, x))
    return found


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("lean", [0.0, 7.0])
def test_characters_say_how_a_page_is_turned(turns, lean):
    assert quarter_turns(looks(turns=turns, lean=lean)) == turns


def test_a_description_turns_as_its_ink_does():
    (y, x) = np.nonzero(ink_of("年"))
    described = describe_ink([(y, x)])
    for turns in range(4):
        again = describe_ink([np.nonzero(np.rot90(ink_of("年"), turns))])
        assert float(again[0] @ turned_description(described, turns)[0]) > 0.98
    assert float(again[0] @ described[0]) < 0.9


def test_most_single_characters_are_told_rightly():
    votes = turn_votes(describe_ink(looks(turns=0)))
    assert (votes.argmax(axis=1) == 0).mean() > 0.85


def test_what_speaks_for_no_way_up_stays_as_it_is():
    cross = np.zeros((60, 60), bool)
    cross[28:33, 8:53] = cross[8:53, 28:33] = True
    assert quarter_turns([np.nonzero(cross)] * 20) == 0


def test_few_characters_turn_no_page():
    assert quarter_turns(looks(turns=2)[:4]) == 0
    assert quarter_turns([]) == 0
