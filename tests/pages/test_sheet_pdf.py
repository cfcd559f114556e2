import io

import numpy as np
import pypdfium2
import pytest
from pypdf import PdfReader

from rumu.errors import RumuError
from rumu.gallery.sheet_masters import choose_masters
from rumu.pages.sheet_layout import GRIDS, HELPS, SheetPage, lay_out
from rumu.pages.sheet_pdf import sheet_pdf


def test_the_words_of_a_sheet_are_text_in_an_embedded_font(page, masters):
    reader = PdfReader(io.BytesIO(sheet_pdf([page], masters.shapes)))
    text = reader.pages[0].extract_text()
    assert "永天人水" in text and "王小明" in text and "姓名" in text
    fonts = reader.pages[0]["/Resources"]["/Font"].values()
    embedded = [f for f in (font.get_object() for font in fonts) if "rumu" in str(f["/BaseFont"])]
    assert embedded and all("/FontFile2" in font["/FontDescriptor"] for font in embedded)
    assert all("+" in str(font["/BaseFont"]) for font in embedded)  # a subset


def test_one_sheets_font_is_not_anothers():
    for text, pupil in (("人", "王小明"), ("永天人水", "陳大文")):
        pages = lay_out(SheetPage(text, "strokes", pupil=pupil))
        reader = PdfReader(io.BytesIO(sheet_pdf(pages, choose_masters(text).shapes)))
        assert text in reader.pages[0].extract_text() and pupil in reader.pages[0].extract_text()


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("help_", HELPS)
def test_what_a_pupil_writes_over_is_nearly_white_in_red_light(grid, help_, masters):
    (page,) = lay_out(SheetPage("永天", "strokes", grid=grid, help=help_, times=5))
    picture = np.asarray(
        pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))[0].render(scale=2).to_pil().convert("RGB")
    )
    for cell in page.cells:
        left, top, side = (round(v * 144 / 25.4) for v in (cell.box.left, cell.box.top, cell.box.width))
        shown = picture[top + 2 : top + side - 2, left + 2 : left + side - 2]
        assert (shown[..., 0].min() > 225) == cell.is_for_writing
        if cell.model != "none" or grid != "none":
            assert shown[..., 2].min() < 225  # and yet it can be seen


def test_pages_have_the_size_of_their_paper(masters):
    for paper, size in (("A4", (595.3, 841.9)), ("Letter", (612.0, 792.0))):
        pages = lay_out(SheetPage("永天人水", "strokes", paper=paper))
        reader = PdfReader(io.BytesIO(sheet_pdf(pages, masters.shapes)))
        assert np.allclose([float(v) for v in reader.pages[0].mediabox[2:]], size, atol=0.1)


def test_a_character_without_a_master_is_refused():
    with pytest.raises(RumuError, match="none of 水"):
        sheet_pdf(lay_out(SheetPage("永水", "strokes")), choose_masters("永").shapes)


@pytest.mark.parametrize(
    ("script", "ordered"),
    [("regular", True), ("running", True), ("seal", False), ("clerical", False), ("cursive", False)],
)
def test_the_order_of_strokes_is_printed_only_of_scripts_that_have_it(script, ordered):
    """Above a seal character stands its name, not the order of another script's strokes."""
    (page,) = lay_out(SheetPage("水", script, help="none", times=2))
    data = sheet_pdf([page], choose_masters("水", (script,)).shapes)
    shown = np.asarray(pypdfium2.PdfDocument(data)[0].render(scale=4).to_pil().convert("RGB")).astype(int)
    ((_, strip),) = page.labels
    top, left, bottom, right = (
        round(v * 4 * 72 / 25.4)
        for v in (strip.top, strip.left, strip.top + strip.height - 0.4, strip.left + strip.width)
    )
    red = shown[top:bottom, left:right, 0] - shown[top:bottom, left:right, 1] > 120
    assert red.any() == ordered
