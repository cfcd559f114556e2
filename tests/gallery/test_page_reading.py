"""Pages without a text: named by the known characters, or by masters that are given."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.characters.stroke_data import find_character
from rumu.errors import GalleryError
from rumu.gallery.catalog import open_gallery, works
from rumu.gallery.page_reading import describe_references

LINES = ("永和九年歲在", "暮春之初會于", "山陰之蘭亭修", "也群賢畢至少")


def drawn(character, side=56):
    """(side, side) gray: a character as copybooks print it, black on white."""
    picture = np.full((side, side), 255, np.uint8)
    for stroke in find_character(character).strokes:
        cv2.fillPoly(picture, [np.rint(stroke.polygon() * side).astype(np.int32)], 0)
    return picture


@pytest.fixture
def photo(tmp_path):
    """Four columns of six characters."""
    page = np.full((480, 420), 240, np.uint8)
    for c, line in enumerate(LINES):
        for k, character in enumerate(line):
            place = page[30 + 68 * k :, 330 - 80 * c :][:56, :56]
            np.minimum(place, drawn(character), out=place)
    Image.fromarray(page).save(tmp_path / "photo.png")
    return tmp_path / "photo.png"


@pytest.fixture
def masters(tmp_path):
    """A folder with the characters of the first column and one that is not on the page."""
    folder = tmp_path / "masters"
    folder.mkdir()
    for character in LINES[0] + "龍":
        Image.fromarray(np.pad(drawn(character, 120), 20, constant_values=255)).save(
            folder / f"{character}.png"
        )
    return folder


def test_a_page_without_a_text_is_named_where_that_is_certain(photo):
    page = rumu.read_page(photo)
    wanted = "".join(LINES)
    pairs = [(one.character, true) for one, true in zip(page.characters, wanted, strict=True)]
    assert [pair for pair in pairs if pair[0] not in (None, pair[1])] == []
    assert sum(name is not None for name, _ in pairs) >= 16
    assert "〓" in page.text or page.text == "\n".join(LINES)


def test_with_references_only_their_characters_are_named(photo, masters):
    page = rumu.read_page(photo, reference=masters)
    assert page.text.split("\n")[0] == LINES[0]
    assert {one.character for one in page.characters} == {None, *LINES[0]}
    same = rumu.read_page(photo, reference=[masters / "永.png", masters / "年.png"])
    assert [one.character for one in same.characters if one.character] == ["永", "年"]


def test_starter_works_and_works_of_the_gallery_are_references(monkeypatch, tmp_path):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path))
    by_script = describe_references(["regular"])
    assert {"人", "水"} <= set(by_script.characters) and len(by_script.vectors) == len(by_script.characters)
    gallery = open_gallery()
    work = next(one for one in works(gallery).items if one.character == "水")
    assert describe_references([work.id]).characters == ("水",)
    assert len(describe_references([work.collection_id]).characters) > 5


def test_references_that_name_nothing_are_refused(tmp_path, photo):
    Image.fromarray(np.pad(drawn("永", 120), 20, constant_values=255)).save(tmp_path / "scan_0001.png")
    with pytest.raises(GalleryError, match="expected masters whose characters are known in"):
        describe_references([tmp_path / "scan_0001.png"])
    with pytest.raises(GalleryError, match="expected a text or references, got both"):
        rumu.read_page(photo, text="永", reference="regular")
