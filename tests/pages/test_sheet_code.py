import numpy as np
import pytest

from rumu.errors import RumuError
from rumu.pages.sheet_code import code_modules, decode_modules, looks_like_code
from rumu.pages.sheet_layout import SheetPage, lay_out

LONG = (
    "天地玄黃宇宙洪荒日月盈昃辰宿列張寒來暑往秋收冬藏閏餘成歲律呂調陽雲騰致雨露結為霜金生麗水玉出崑岡劍號巨闕"
)


@pytest.mark.parametrize("page", lay_out(SheetPage(LONG, "#abc123", times=1, cell=18, pupil="李𠮷")))
def test_a_code_says_the_whole_page(page):
    assert decode_modules(np.where(code_modules(page), 0.1, 0.9)) == page


def test_a_code_is_read_in_uneven_light_with_modules_that_are_covered():
    page = SheetPage("永天人水", "strokes", sheet="0123abcd", pupil="王小明")
    dark = code_modules(page)
    light = np.where(dark, 20.0, 200.0) * np.linspace(1.0, 0.3, len(dark))[:, None]
    light[20:24, 14:18] = 5.0
    assert looks_like_code(light) and decode_modules(light) == page


def test_damage_beyond_repair_never_gives_another_page():
    page, rng = SheetPage("永天人水", "strokes", sheet="0123abcd"), np.random.default_rng(1)
    dark = code_modules(page)
    for _ in range(40):
        flipped = dark ^ (rng.random(dark.shape) < rng.uniform(0.02, 0.3))
        assert decode_modules(np.where(flipped, 0.0, 1.0)) in (page, None)


def test_another_programs_code_is_none_of_ours():
    from reportlab.graphics.barcode import qrencoder

    code = qrencoder.QRCode(None, qrencoder.QRErrorCorrectLevel.M)
    code.addData("HTTPS://EXAMPLE.ORG/SHEET")
    code.make()
    side = range(code.getModuleCount())
    light = np.array([[0.0 if code.isDark(row, column) else 1.0 for column in side] for row in side])
    assert decode_modules(light) is None


def test_a_page_that_says_too_much_is_refused():
    text = "".join(chr(0x20000 + k) for k in range(54))
    with pytest.raises(RumuError, match="528 letters"):
        code_modules(SheetPage(20 * text, "strokes"))
