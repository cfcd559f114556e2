"""PAGE-XML and hOCR of a page."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from rumu.pages.exports import PAGE_NAMESPACE, hocr, page_xml
from rumu.pages.page import Page, PageCharacter

PICTURE = np.full((90, 120, 3), 255, np.uint8)
PAGE = {"p": PAGE_NAMESPACE}
HTML = {"h": "http://www.w3.org/1999/xhtml"}


def box(x, y, **facts):
    corners = np.array([[x, y], [x + 20, y], [x + 20, y + 20.4], [x - 130.0, y + 20]])
    return PageCharacter(corners, **facts)


@pytest.fixture
def page():
    return Page(
        PICTURE,
        (
            box(90, 5, register=0, column=0, row=0, character="永", certainty=0.9),
            box(90, 30, register=0, column=0, row=1, character="<", certainty=0.5, small=0),
            box(60, 5, register=0, column=1, row=0),
            box(60, 60, register=1, column=0, row=0, character="水"),
        ),
    )


# Children in the order that the schema of 2019-07-15 asks for.
ORDER = {
    "PcGts": ["Metadata", "Page"],
    "Metadata": ["Creator", "Created", "LastChange"],
    "Page": ["ReadingOrder", "TextRegion"],
    "TextRegion": ["Coords", "TextLine"],
    "TextLine": ["Coords", "Word", "TextEquiv"],
    "Word": ["Coords", "Glyph", "TextEquiv"],
    "Glyph": ["Coords", "TextEquiv"],
    "TextEquiv": ["Unicode"],
}


def test_page_xml_has_the_order_and_the_values_of_its_schema(page):
    root = ET.fromstring(page_xml(page, picture_name="p.png", made=datetime(2026, 1, 2, tzinfo=UTC)))
    for element in root.iter():
        tag = element.tag.removeprefix(f"{{{PAGE_NAMESPACE}}}")
        children = [child.tag.removeprefix(f"{{{PAGE_NAMESPACE}}}") for child in element]
        if tag in ORDER:
            places = [ORDER[tag].index(child) for child in children]
            assert places == sorted(places), tag
    for coordinates in root.iterfind(".//p:Coords", PAGE):
        assert re.fullmatch(r"([0-9]+,[0-9]+ )+([0-9]+,[0-9]+)", coordinates.get("points"))
        assert all(
            int(x) <= 120 and int(y) <= 90 for x, y in re.findall(r"(\d+),(\d+)", coordinates.get("points"))
        )
    names = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(names) == len(set(names))
    assert root.find("p:Metadata/p:Created", PAGE).text == "2026-01-02T00:00:00Z"


def test_page_xml_keeps_registers_columns_and_names(page):
    root = ET.fromstring(page_xml(page, picture_name="p.png"))
    regions = root.findall(".//p:TextRegion", PAGE)
    assert [len(region.findall("p:TextLine", PAGE)) for region in regions] == [2, 1]
    glyphs = root.findall(".//p:Glyph", PAGE)
    assert [glyph.findtext("p:TextEquiv/p:Unicode", None, PAGE) for glyph in glyphs] == [
        "永",
        "<",
        None,
        "水",
    ]
    assert regions[0].find("p:TextLine/p:TextEquiv/p:Unicode", PAGE).text == "永<"
    assert regions[0].get("readingDirection") == "top-to-bottom"
    order = root.findall(".//p:RegionRefIndexed", PAGE)
    assert [one.get("regionRef") for one in order] == [region.get("id") for region in regions]


def test_hocr_names_its_parts_as_hocr_does(page):
    text = hocr(page, picture_name="p.png").removeprefix("<!DOCTYPE html>\n")
    root = ET.fromstring(text)
    title = root.find(".//h:div[@class='ocr_page']", HTML).get("title")
    assert title == 'image "p.png"; bbox 0 0 120 90; ppageno 0'
    assert root.find("h:head/h:meta[@name='ocr-langs']", HTML).get("content") == "zh"
    words = root.findall(".//h:span[@class='ocrx_word']", HTML)
    assert [word.text for word in words] == ["永", "<", "〓", "水"]
    assert words[1].get("title").endswith("x_wconf 50")
    assert len(root.findall(".//h:p[@class='ocr_line']", HTML)) == 3


def test_a_page_without_characters_has_both_forms():
    empty = Page(PICTURE, ())
    assert "Page imageFilename" in page_xml(empty, picture_name="p.png")
    assert "ocr_page" in hocr(empty, picture_name="p.png")
