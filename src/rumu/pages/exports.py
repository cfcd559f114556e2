"""A page in formats that other programs read: PAGE-XML and hOCR."""

from __future__ import annotations

from datetime import UTC, datetime
from itertools import groupby
from xml.etree import ElementTree as ET

import numpy as np

from rumu.pages.page import Page, PageCharacter
from rumu.values import FloatArray

PAGE_NAMESPACE = "http://schema.primaresearch.org/PAGE/gts/pagecontent/2019-07-15"
PAGE_SCHEMA = f"{PAGE_NAMESPACE} {PAGE_NAMESPACE}/pagecontent.xsd"
_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"
_XHTML = "http://www.w3.org/1999/xhtml"
_DOUBLE_ROW = {None: "", 0: "small right", 1: "small left"}


def page_xml(page: Page, *, picture_name: str, creator: str = "rumu", made: datetime | None = None) -> str:
    """The page as PAGE-XML (2019-07-15): a region for each register, a line for each column, glyphs in words.

    picture_name: the file of `page.picture`. creator: the program and its version. made: the time to write
    into it; now by default.
    """
    ET.register_namespace("", PAGE_NAMESPACE)
    ET.register_namespace("xsi", _INSTANCE)
    time = (made or datetime.now(UTC)).strftime("%Y-%m-%dT%H:%M:%SZ")
    root = ET.Element(_name("PcGts"), {f"{{{_INSTANCE}}}schemaLocation": PAGE_SCHEMA})
    metadata = _child(root, "Metadata")
    _child(metadata, "Creator").text = creator
    _child(metadata, "Created").text = time
    _child(metadata, "LastChange").text = time
    height, width = page.picture.shape[:2]
    size = {"imageWidth": str(width), "imageHeight": str(height)}
    sheet = _child(root, "Page", imageFilename=picture_name, **size)
    registers = [(key, list(group)) for key, group in groupby(page.characters, lambda one: one.register)]
    if registers:
        order = _child(_child(sheet, "ReadingOrder"), "OrderedGroup", id="reading-order")
        for number, (register, _) in enumerate(registers):
            _child(order, "RegionRefIndexed", index=str(number), regionRef=f"r{register}")
    for register, characters in registers:
        _region(sheet, page, register, characters)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _region(sheet: ET.Element, page: Page, register: int, characters: list[PageCharacter]) -> None:
    vertical = page.direction == "vertical"
    region = _child(
        sheet,
        "TextRegion",
        id=f"r{register}",
        type="paragraph",
        readingDirection="top-to-bottom" if vertical else "left-to-right",
        textLineOrder="right-to-left" if vertical else "top-to-bottom",
    )
    _coordinates(region, _box_around(characters), page)
    for column, members in groupby(characters, lambda one: one.column):
        line = list(members)
        element = _child(region, "TextLine", id=f"r{register}c{column}")
        _coordinates(element, _box_around(line), page)
        for number, (small, word) in enumerate(groupby(line, lambda one: one.small)):
            _word(element, page, f"r{register}c{column}w{number}", small, list(word))
        _text(element, line)


def _word(
    line: ET.Element, page: Page, name: str, small: int | None, characters: list[PageCharacter]
) -> None:
    word = _child(line, "Word", id=name, **({"custom": _DOUBLE_ROW[small]} if small is not None else {}))
    _coordinates(word, _box_around(characters), page)
    for one in characters:
        glyph = _child(word, "Glyph", id=f"{name}g{one.row}")
        _coordinates(glyph, one.polygon, page)
        _text(glyph, [one])
    _text(word, characters)


def _text(element: ET.Element, characters: list[PageCharacter]) -> None:
    """What is written, where all of it is known; and how sure it is."""
    if any(one.character is None for one in characters):
        return
    sure = float(np.mean([one.certainty for one in characters]))
    equivalent = _child(element, "TextEquiv", conf=f"{sure:.3f}")
    _child(equivalent, "Unicode").text = "".join(str(one.character) for one in characters)


def _box_around(characters: list[PageCharacter]) -> FloatArray:
    """(4, 2): the box around all of these characters, clockwise from the upper left."""
    points = np.concatenate([one.polygon for one in characters])
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def _coordinates(element: ET.Element, polygon: FloatArray, page: Page) -> None:
    height, width = page.picture.shape[:2]
    points = np.clip(np.rint(polygon), 0, [width, height]).astype(int)
    _child(element, "Coords", points=" ".join(f"{x},{y}" for x, y in points.tolist()))


def _child(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, _name(tag), attributes)


def _name(tag: str) -> str:
    return f"{{{PAGE_NAMESPACE}}}{tag}"


def hocr(page: Page, *, picture_name: str, creator: str = "rumu") -> str:
    """The page as hOCR: an area for each register, a line for each column, a word for each character.

    picture_name: the file of `page.picture`. creator: the program and its version. A character that is not
    known is 〓.
    """
    ET.register_namespace("", _XHTML)
    root = _tag(None, "html", lang="zh-Hant")
    head = _tag(root, "head")
    _tag(head, "title").text = picture_name
    _tag(head, "meta", charset="utf-8")
    _tag(head, "meta", name="ocr-system", content=creator)
    _tag(head, "meta", name="ocr-capabilities", content="ocr_page ocr_carea ocr_line ocrx_word")
    _tag(head, "meta", name="ocr-langs", content="zh")
    height, width = page.picture.shape[:2]
    title = f'image "{picture_name}"; bbox 0 0 {width} {height}; ppageno 0'
    sheet = _tag(_tag(root, "body"), "div", id="page_1", title=title, **{"class": "ocr_page"})
    for register, characters in groupby(page.characters, lambda one: one.register):
        members = list(characters)
        area = _tag(sheet, "div", id=f"r{register}", title=_bbox(members), **{"class": "ocr_carea"})
        if page.direction == "vertical":
            area.set("style", "writing-mode: vertical-rl")
        for column, line in groupby(members, lambda one: one.column):
            _hocr_line(area, f"r{register}c{column}", list(line))
    ET.indent(root)
    return "<!DOCTYPE html>\n" + ET.tostring(root, encoding="unicode") + "\n"


def _hocr_line(area: ET.Element, name: str, characters: list[PageCharacter]) -> None:
    line = _tag(area, "p", id=name, title=_bbox(characters), **{"class": "ocr_line"})
    for one in characters:
        title = f"{_bbox([one])}; x_wconf {round(100 * one.certainty)}"
        word = _tag(line, "span", id=f"{name}g{one.row}", title=title, **{"class": "ocrx_word"})
        word.text = one.character or "〓"


def _bbox(characters: list[PageCharacter]) -> str:
    (left, top), _, (right, bottom), _ = np.rint(_box_around(characters)).astype(int).tolist()
    return f"bbox {max(left, 0)} {max(top, 0)} {right} {bottom}"


def _tag(parent: ET.Element | None, tag: str, **attributes: str) -> ET.Element:
    name = f"{{{_XHTML}}}{tag}"
    return ET.Element(name, attributes) if parent is None else ET.SubElement(parent, name, attributes)
