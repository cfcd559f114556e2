"""What is said is said in both languages."""

from __future__ import annotations

import typing

import cv2
import numpy as np
import pytest

import rumu
from rumu.report import wording
from rumu.values import Bilingual, Level, Source


def texts() -> list[Bilingual]:
    found = []
    for value in vars(wording).values():
        held = value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else ()
        for item in held:
            found += [t for t in (item if isinstance(item, tuple) else ()) if isinstance(t, Bilingual)]
            found += [item] if isinstance(item, Bilingual) else []
    return found


def test_nothing_is_left_untranslated():
    said = texts()
    assert len(said) > 30
    for text in said:
        assert any("一" <= sign <= "鿿" for sign in text.zh), text
        assert text.en.isascii(), text


def test_every_level_and_source_has_words():
    assert set(wording.LEVELS) == set(typing.get_args(Level))
    assert set(wording.SOURCES) == set(typing.get_args(Source))


@pytest.mark.parametrize(
    ("size", "unit", "shown"),
    [
        (3.24, "deg", "3.2°"),
        (12.3, "%", "12%"),
        (0.44, "mm", "0.4 mm"),
        (-15, "degrees", "15°"),
        (0.124, "of the ink", "12%"),
        (2, "", "2.0"),
    ],
)
def test_sizes_with_their_unit(size, unit, shown):
    assert wording.with_unit(size, unit) == shown


def test_an_unknown_name_is_shown_plainly():
    assert wording.quality_meaning("odd_figure").en == "odd figure"
    assert wording.kind_name("ink_blot").en == "Ink blot"


@pytest.mark.parametrize(
    ("percentile", "zh", "en"),
    [
        (3.0, "在學習者的臨作裡，屬最低的一成。", "Among the lowest tenth of learners' copies."),
        (72.0, "學習者的臨作，每十張裡比 7 張好。", "Better than 7 of 10 learners' copies."),
        (97.0, "比幾乎所有學習者的臨作都好。", "Better than nearly all learners' copies."),
    ],
)
def test_a_copy_stands_among_learners_copies(percentile: float, zh: str, en: str) -> None:
    assert wording.standing(percentile) == (zh, en)


def test_every_figure_of_a_surface_has_words(data):
    """Of a picture, of a page of many characters and of photographs."""
    shapes = np.full((900, 900), 255, np.uint8)
    for k in range(12):
        row, column = divmod(k, 4)
        cv2.putText(shapes, "K", (40 + 220 * column, 230 + 290 * row), cv2.FONT_HERSHEY_SIMPLEX, 6, 0, 22)
    surfaces = (
        rumu.relief(data / "e3c" / "copies" / "003503.png"),
        rumu.relief(shapes),
        rumu.reconstruct(data / "photometric" / "psbox-cat", solver="least_squares"),
    )
    said = {name for surface in surfaces for name in surface.quality}
    assert said - set(wording.QUALITY) == set()
    assert len(said) > 12
