"""The sheet to print, in either language, with the Chinese on it whatever the reader's fonts are."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pypdf
import pypdfium2
import pytest

from rumu import pdf_text
from rumu.characters.stroke_data import find_character
from rumu.database.tables import Attempt, Work, now
from rumu.pages.punctuation import PUNCTUATION
from rumu.pages.sheet_font import SheetFont
from rumu.studio.practice import Curve
from rumu.studio.practice_pdf import PracticeSheet, practice_pdf, printed_attempts, progress_sentences


@pytest.fixture
def sheet(packed, cross):
    def make(count=3, language="zh", remarks=2, name="林小明"):
        work = Work(
            id="w", title_zh="楷書「十」", title_en="Ten, regular script", hand_zh="某", hand_en="somebody"
        )
        remark = {"zh": "整字向右傾斜 12°。先看範本的中軸。" * 3, "en": "The whole leans 12° clockwise. " * 3}
        attempts = tuple(
            Attempt(
                id=str(k),
                created=now(),
                kind="pen",
                score=None if k == 1 else 40.0 + 5 * k,
                level=None if k == 1 else "medium",
                mark={
                    "score": None if k == 1 else 40.0 + 5 * k,
                    "interval": None if k == 1 else [30.0, 70.0],
                    "remarks": [remark] * remarks,
                    "refused": None,
                },
            )
            for k in range(count)
        )
        picture = packed(cross())
        return PracticeSheet(
            name, Curve(work, attempts), picture, {a.id: picture for a in attempts}, language
        )

    return make


def text_of(pdf: bytes, pages: int = 1) -> str:
    found = pypdf.PdfReader(io.BytesIO(pdf)).pages
    assert len(found) == pages
    assert all([round(float(x)) for x in page.mediabox[2:]] == [595, 842] for page in found)
    return "".join(page.extract_text() for page in found)


def test_english_is_set_and_can_be_read(sheet):
    text = text_of(practice_pdf(sheet(language="en", name="Lin")))
    for words in ("Practice", "Ten, regular script", "Lin", "80% interval", "leans 12°", "not marked"):
        assert words in text


def test_an_unknown_hand_leaves_no_gap_between_dots(sheet):
    known, unknown = sheet(language="en", name="Lin"), sheet(language="en", name="Lin")
    unknown.curve.work.hand_en = ""
    texts = [" ".join(text_of(practice_pdf(one)).split()) for one in (known, unknown)]
    assert "Lin · somebody · 3 copies" in texts[0]
    assert "Lin · 3 copies" in texts[1]


def test_what_changed_since_the_attempt_before_is_printed(sheet):
    whole = sheet(language="en", name="Lin", count=4)
    assert progress_sentences(whole)[0].startswith("About as before")
    assert "Against the one before" in text_of(practice_pdf(whole))
    for count in (1, 2, 3):  # a single one; the last, then the one before it, was refused
        assert progress_sentences(sheet(count=count)) == []
    assert "Against the one before" not in text_of(practice_pdf(sheet(language="en", count=3)))


def test_many_attempts_and_remarks_go_on_to_another_page(sheet):
    whole = sheet(count=40, remarks=9)
    assert [a.id for a in printed_attempts(whole.curve)] == ["0", "37", "38", "39"]
    assert text_of(practice_pdf(whole), pages=2).count("先看範本的中軸") == 3 * 9
    text_of(practice_pdf(sheet(count=1, remarks=0)))


def fonts_of(pdf: bytes) -> set[str]:
    fonts = pypdf.PdfReader(io.BytesIO(pdf)).pages[0]["/Resources"]["/Font"].values()
    return {font.get_object()["/BaseFont"] for font in fonts}


def test_chinese_can_be_read_and_searched_without_a_font_of_the_reader(sheet):
    drawn = practice_pdf(sheet())
    text = "".join(text_of(drawn).split())
    for words in ("臨帖練習·楷書「十」", "林小明", "整字向右傾斜12°。先看", "進步曲線（豎線"):
        assert words in text
    assert {font.partition("+")[2][:5] or font for font in fonts_of(drawn)} == {"rumu-", "/Helvetica"}


def dark(pdf: bytes, box: tuple[int, int, int, int]) -> int:
    """Dark pixels in a box of the page, (left, top, right, bottom) in points, as PDFium shows it."""
    left, top, right, bottom = (2 * side for side in box)
    page = np.asarray(pypdfium2.PdfDocument(pdf)[0].render(scale=2).to_pil().convert("L"))
    return int((page[top:bottom, left:right] < 128).sum())


def test_rare_characters_are_brought_by_the_reader_where_the_machine_has_no_font(sheet, monkeypatch):
    monkeypatch.setattr(pdf_text, "find_chinese_font", lambda: None)
    drawn = practice_pdf(sheet(name="林𠀀"))
    assert any("MSung" in font for font in fonts_of(drawn))
    assert dark(drawn, (48, 52, 300, 82)) > 500  # the title


@pytest.mark.parametrize("mark", sorted(set(PUNCTUATION) - {"\u3000"}))
def test_punctuation_is_drawn_within_its_square(mark):
    outlines = np.vstack(PUNCTUATION[mark])
    assert (outlines >= 0).all() and (outlines <= 1).all()
    x, y = np.hstack([np.vstack([line, line[:1]]).T for line in PUNCTUATION[mark][:1]])
    assert np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) > 0  # clockwise: ink, not a hole


@pytest.mark.parametrize("letter", ["田", "十"])
def test_ink_stays_ink_where_strokes_cross(letter):
    from reportlab.pdfgen.canvas import Canvas

    stream = io.BytesIO()
    canvas = Canvas(stream, pagesize=(100, 100))
    assert SheetFont(letter).draw(canvas, 0, 12, letter, 100) == 100
    canvas.save()
    shown = np.asarray(pypdfium2.PdfDocument(stream.getvalue())[0].render(scale=8).to_pil().convert("L"))
    strokes = [stroke.polygon() * 800 for stroke in find_character(letter).strokes]
    expected = np.zeros((800, 800), np.uint8)
    for outline in strokes:
        cv2.fillPoly(expected, [np.rint(outline).astype(np.int32)], 1)
    assert ((shown < 128) & (expected > 0)).sum() > 0.95 * expected.sum()
    assert (shown < 128).sum() < 1.1 * expected.sum()


def test_lines_are_as_long_as_they_may_be():
    text = "整字向右傾斜 12°，先看範本的中軸，落筆時把重心扶正。 The whole character leans 12° clockwise."
    folded = pdf_text.wrap_text(text, 10, width=120)
    assert len(folded) > 3 and "".join(folded).replace(" ", "") == text.replace(" ", "")
    for line in folded:
        assert pdf_text.text_width(line, 10) <= 132 and line[0] not in "，。"


def test_runs_tell_latin_from_the_rest():
    assert list(pdf_text.split_runs("A 十°B")) == [(False, "A "), (True, "十"), (False, "°B")]
    assert np.isclose(pdf_text.text_width("十十", 10), 20, atol=1)
