"""Characters named by what they look like: certain names are right, and the rest have none."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rumu.characters.stroke_data import find_character
from rumu.errors import RumuError
from rumu.strokes.shape_names import ReferenceShapes, describe_look, name_shapes

POEM = "永和九年歲在癸丑暮春之初會于會稽山陰之蘭亭修禊事也群賢畢至少長咸集此地有崇山峻領茂林修竹又有清流"


def look_of(character, *, side=48, thicker=0, turn=0.0, seed=None):
    """Rows and columns of a character that is drawn stroke by stroke, its points moved a little at random."""
    rng = np.random.default_rng(seed)
    ink = np.zeros((2 * side, 2 * side), np.uint8)
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    for stroke in find_character(character).strokes:
        moved = stroke.polygon() - 0.5 + (rng.normal(0, 0.012, 2) if seed is not None else 0)
        points = moved @ np.array([[cos, sin], [-sin, cos]]) * side + side
        cv2.fillPoly(ink, [np.rint(points).astype(np.int32)], 255)
    if thicker:
        ink = cv2.dilate(ink, np.ones((1 + thicker, 1 + thicker), np.uint8))
    return np.nonzero(ink)


@pytest.mark.parametrize("changes", [{}, {"thicker": 2}, {"turn": 3.0}, {"seed": 1}, {"side": 28}])
def test_what_is_named_is_right(changes):
    names = name_shapes([look_of(one, **changes) for one in POEM])
    named = [(found.character, one) for found, one in zip(names, POEM, strict=True) if found.character]
    assert len(named) >= 0.6 * len(POEM)
    assert [pair for pair in named if pair[0] != pair[1]] == []
    assert all(found.certainty > 0.9 for found in names if found.character)


def test_characters_that_look_alike_stay_without_a_name_or_are_right():
    twins = "己已巳土士未末日曰"
    found = name_shapes([look_of(one, side=30, seed=k, thicker=1) for k, one in enumerate(twins * 4)])
    wrong = [
        (one.character, true)
        for one, true in zip(found, twins * 4, strict=True)
        if one.character not in (None, true)
    ]
    assert wrong == []
    assert any(one.character is None for one in found)


def test_what_is_no_character_is_not_named():
    rng = np.random.default_rng(5)
    looks = []
    for _ in range(40):
        blob = cv2.GaussianBlur(rng.random((60, 60)).astype(np.float32), (0, 0), rng.uniform(2, 6))
        looks.append(np.nonzero(blob > np.quantile(blob, 0.75)))
    assert sum(one.character is not None for one in name_shapes(looks)) <= 1


def test_specks_and_nothing_are_not_named():
    assert name_shapes([]) == []
    (speck,) = name_shapes([(np.array([3, 3, 4]), np.array([5, 6, 5]))])
    assert speck.character is None and speck.certainty == 0


def test_a_page_of_traditional_characters_has_no_simplified_ones():
    """马 alone is named; among traditional characters it is a misprint that has no name."""
    traditional = "馬鳥龍龜學書畫國圖會話語貝見車門風飛魚麥"
    assert name_shapes([look_of("马")])[0].character == "马"
    among = name_shapes([look_of(one) for one in traditional + "马"])
    assert among[-1].character != "马"
    assert sum(one.character == true for one, true in zip(among, traditional, strict=False)) >= 12


def test_only_characters_of_the_references_are_named():
    references = ReferenceShapes(
        tuple("永和九年"), np.array([describe_look(look_of(one, seed=3)) for one in "永和九年"])
    )
    names = name_shapes([look_of(one, seed=7) for one in POEM], references=references)
    assert {one.character for one in names} == {None, "永", "和", "九", "年"}
    assert [one.character for one in names[:4]] == list("永和九年")


def test_a_reference_names_what_no_copybook_has():
    """A sign that is in no list of strokes is known by its picture."""
    sign = np.zeros((80, 80), np.uint8)
    cv2.circle(sign, (40, 40), 34, 255, 5)
    cv2.line(sign, (10, 40), (70, 40), 255, 5)
    cv2.line(sign, (28, 20), (28, 60), 255, 5)
    references = ReferenceShapes(("☯",), describe_look(np.nonzero(sign))[None])
    again = np.nonzero(cv2.warpAffine(sign, np.array([[1.1, 0.02, 0], [0, 1.05, 2.0]]), (95, 95)) > 127)
    found = name_shapes([again, look_of("永")], references=references)
    assert [one.character for one in found] == ["☯", None]


def test_references_need_a_description_each():
    with pytest.raises(RumuError, match="a description for each of 1 or more reference characters, got 0"):
        ReferenceShapes((), np.zeros((0, 1024)))
