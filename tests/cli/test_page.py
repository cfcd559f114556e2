"""page: a picture of writing into a folder, and pictures that hold none."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.characters.stroke_data import find_character

LINES = ("永和九年歲在", "暮春之初會于", "山陰之蘭亭修", "也群賢畢至少")


@pytest.fixture
def photo(tmp_path):
    """Four columns of six characters."""
    page = np.full((360, 320), 240, np.uint8)
    for c, line in enumerate(LINES):
        for k, character in enumerate(line):
            for stroke in find_character(character).strokes:
                points = (stroke.polygon() - 0.5) * 40 + (270 - 60 * c, 50 + 48 * k)
                cv2.fillPoly(page, [np.rint(points).astype(np.int32)], 20)
    Image.fromarray(page).save(tmp_path / "photo.png")
    return tmp_path / "photo.png"


def test_a_page_becomes_a_folder(rumu, photo, tmp_path):
    ended = rumu("page", photo, "-o", tmp_path / "out", "--json")
    facts = ended.facts
    assert (ended.code, ended.err, len(facts["characters"]), facts["direction"]) == (0, "", 24, "vertical")
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {"page.json", "page.xml", "page.hocr", "page.txt", "page.png", "report.html"}
    written = json.loads((tmp_path / "out" / "page.json").read_text(encoding="utf-8"))
    assert written["characters"] == facts["characters"]
    assert {"box", "polygon", "register", "column", "row", "character", "certainty"} <= set(
        facts["characters"][0]
    )


@pytest.mark.parametrize("encoding", ["utf-8", "gb18030", "big5", "utf-16"])
def test_a_text_in_any_encoding_names_the_characters(rumu, photo, tmp_path, encoding):
    (tmp_path / "text.txt").write_bytes("，".join(LINES).encode(encoding))
    ended = rumu("page", photo, "--text", tmp_path / "text.txt", "-o", tmp_path / "out")
    assert ended.code == 0 and "named: 24" in ended.out
    assert (tmp_path / "out" / "page.txt").read_text(encoding="utf-8") == "\n".join(LINES) + "\n"
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert report.count("<polygon") == 24 and "永和九年歲在" in report


def test_a_blank_picture_is_refused(rumu, tmp_path):
    Image.new("L", (300, 400), 235).save(tmp_path / "blank.png")
    rumu("page", tmp_path / "blank.png", "-o", tmp_path / "out").failed_with("without ink")
    assert not (tmp_path / "out").exists()


def test_a_folder_with_other_things_is_left_alone(rumu, photo, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "diary.txt").write_text("keep me")
    rumu("page", photo, "-o", tmp_path / "mine").failed_with("mine", "page.json")
    assert (tmp_path / "mine" / "diary.txt").read_text() == "keep me"


def test_a_text_that_is_not_there(rumu, photo, tmp_path):
    rumu("page", photo, "--text", tmp_path / "no.txt", "-o", tmp_path / "out").failed_with("no.txt")


def test_a_photograph_of_our_own_sheet_becomes_marks(rumu, tmp_path):
    import pypdfium2

    assert (
        rumu("sheet", "人", "-o", tmp_path / "s.pdf", "--cell", 60, "--times", 2, "--pupil", "王小明").code
        == 0
    )
    sheet = pypdfium2.PdfDocument(tmp_path / "s.pdf")[0].render(scale=110 / 72).to_pil().convert("RGB")
    master = Image.new("L", (120, 120), 255)
    pixels = np.asarray(master).copy()
    for stroke in find_character("人").strokes:
        cv2.fillPoly(pixels, [np.rint(stroke.polygon() * 120).astype(np.int32)], 20)
    sheet.paste(Image.fromarray(pixels).convert("RGB"), (200, 240))  # in the first cell
    sheet.rotate(180).save(tmp_path / "photo.jpg", quality=92)
    ended = rumu("page", tmp_path / "photo.jpg", "-o", tmp_path / "out", "--jobs", 1, "--json")
    (facts,) = ended.facts["photos"]
    assert (ended.code, facts["pupil"], facts["empty"]) == (0, "王小明", 1)
    assert [(cell["row"], cell["column"]) for cell in facts["cells"]] == [(0, 0)]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("marks.csv", "marks.json", "cells", "pupils", "teacher.pdf")
    }


def test_a_folder_without_sheets_gives_no_mark(rumu, photo, tmp_path):
    (tmp_path / "in").mkdir()
    photo.rename(tmp_path / "in" / "photo.png")
    ended = rumu("page", tmp_path / "in", "-o", tmp_path / "out", "--jobs", 1)
    ended.failed_with("no character was marked")
    assert "no sheet" in (tmp_path / "out" / "marks.csv").read_text(encoding="utf-8-sig")


def test_a_text_cannot_go_with_sheets(rumu, photo, tmp_path):
    ended = rumu("page", photo, photo, "--text", photo, "-o", tmp_path / "out")
    assert ended.code == 2


def test_a_page_without_a_text_is_named_by_masters(rumu, photo, tmp_path):
    """Only what the starter works in regular script show may have a name: nothing on this page."""
    ended = rumu("page", photo, "--reference", "regular", "-o", tmp_path / "out", "--json")
    names = [one["character"] for one in ended.facts["characters"]]
    assert ended.code == 0 and set(names) == {None}
    ended = rumu("page", photo, "-o", tmp_path / "out", "--json")
    right = [
        one["character"] == true
        for one, true in zip(ended.facts["characters"], "".join(LINES), strict=True)
        if one["character"]
    ]
    assert len(right) >= 12 and all(right)


def test_a_text_and_references_do_not_go_together(rumu, photo, tmp_path):
    (tmp_path / "text.txt").write_text("永", encoding="utf-8")
    ended = rumu(
        "page", photo, "--text", tmp_path / "text.txt", "--reference", "regular", "-o", tmp_path / "out"
    )
    assert ended.code == 2 and "--reference" in ended.err
