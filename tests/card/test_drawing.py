import io
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from pypdf import PdfReader

from rumu.card.drawing import card_pdf
from rumu.card.finding import find_card
from rumu.card.layout import CardLayout
from rumu.pages.sheet_layout import PAPERS


@pytest.mark.parametrize("paper", PAPERS)
def test_a_printed_card_is_found_where_it_was_drawn(paper):
    scale = 150 / 25.4
    page = pypdfium2.PdfDocument(card_pdf(paper))[0]
    picture = np.asarray(page.render(scale=150 / 72).to_pil().convert("RGB"))
    view = find_card(picture, Path("card.png"))
    assert view.layout.paper == paper and view.off < 0.1
    assert abs(view.scale() / scale - 1) < 2e-3
    ends = np.array(CardLayout(paper).scale)
    seen = view.pixels(ends)
    assert abs(np.hypot(*(seen[1] - seen[0])) / scale - 100) < 0.2  # millimetres, as its words say
    (x, y) = seen.mean(axis=0).round().astype(int)
    assert picture[y - 2 : y + 3, x].min() < 90  # the line is there


def test_its_words_are_text_in_an_embedded_font():
    reader = PdfReader(io.BytesIO(card_pdf("A4")))
    text = reader.pages[0].extract_text()
    assert "拍攝卡" in text and "100 mm" in text and "capture card" in text
    fonts = [font.get_object() for font in reader.pages[0]["/Resources"]["/Font"].values()]
    assert any("rumu" in str(font["/BaseFont"]) and "/FontFile2" in font["/FontDescriptor"] for font in fonts)
