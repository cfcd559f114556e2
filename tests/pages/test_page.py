"""A page's own checks, text and JSON."""

from __future__ import annotations

import json

import numpy as np
import pytest

from rumu.errors import ImageError
from rumu.pages.page import Page, PageCharacter

SQUARE = np.array([[10.0, 20.0], [30.0, 20.0], [30.0, 44.0], [10.0, 44.0]])
PICTURE = np.zeros((60, 80, 3), np.uint8)


def test_the_box_is_left_top_right_bottom():
    assert PageCharacter(SQUARE, 0, 0, 0).box == (10.0, 20.0, 30.0, 44.0)


def test_text_has_a_line_for_each_column_and_a_sign_for_what_is_not_known():
    found = [
        PageCharacter(SQUARE, 0, 0, 0, character="永"),
        PageCharacter(SQUARE, 0, 0, 1),
        PageCharacter(SQUARE, 1, 0, 0, character="水"),
    ]
    assert Page(PICTURE, tuple(found)).text == "永〓\n水"


def test_json_has_the_same_names():
    page = Page(PICTURE, (PageCharacter(SQUARE, 0, 1, 2, character="永", certainty=0.5),))
    facts = json.loads(json.dumps(page.as_json()))
    assert (facts["width"], facts["height"]) == (80, 60)
    (found,) = facts["characters"]
    assert found["box"] == [10.0, 20.0, 30.0, 44.0]
    for name in ("register", "column", "row", "character", "certainty"):
        assert found[name] == getattr(page.characters[0], name)


@pytest.mark.parametrize(
    "make",
    [
        lambda: PageCharacter(SQUARE[:3], 0, 0, 0),
        lambda: PageCharacter(SQUARE * np.nan, 0, 0, 0),
        lambda: PageCharacter(SQUARE, 0, 0, 0, certainty=1.5),
        lambda: Page(PICTURE[..., 0], ()),
        lambda: Page(PICTURE, (), direction="diagonal"),
    ],
)
def test_what_is_no_page_is_refused(make):
    with pytest.raises(ImageError, match="expected"):
        make()
