"""Practice sheets through the service: what may be asked, and that the PDF is what was asked for."""

from __future__ import annotations

import io

import numpy as np
import pypdfium2
import pytest
from PIL import Image

from rumu.gallery.sheet_masters import open_masters
from rumu.pages.sheet_reading import locate_sheet
from rumu.web.settings import RateLimitSettings


@pytest.fixture(autouse=True)
def home(tmp_path_factory, monkeypatch):
    """Masters of chosen works are kept in the home of whoever runs the service."""
    monkeypatch.setenv("RUMU_HOME", str(tmp_path_factory.mktemp("home")))


def pages_of(pdf: bytes) -> list:
    """What the codes on the pages of a PDF say."""
    document = pypdfium2.PdfDocument(pdf)
    return [locate_sheet(np.asarray(page.render(scale=2).to_pil().convert("RGB"))).page for page in document]


def test_a_visitor_prints_a_sheet_of_copybook_strokes(world):
    browser = world.browser()
    asked = "text=永天 人水&grid=nine&model=shrinking&paper=Letter&cell=30&times=4&pupil=王小明"
    plan = browser("GET", f"/api/practice-sheet?{asked}").json()
    assert plan["text"] == "永天人水" and plan["pages"] == 1 and plan["cells"] == 16 and plan["times"] == 4
    answer = browser("GET", f"/api/practice-sheet.pdf?{asked}")
    assert answer.headers["content-type"] == "application/pdf"
    (page,) = pages_of(answer.content)
    assert (page.text, page.master, page.paper, page.grid, page.help) == (
        *("永天人水", "strokes", "Letter", "nine", "shrinking"),
    )
    assert page.pupil == "王小明" and page.cell == 30 and page.times == 4 and page.sheet == plan["sheet"]
    preview = browser("GET", f"/api/practice-sheet.png?{asked}")
    with Image.open(io.BytesIO(preview.content)) as picture:
        width, height = picture.size
    assert width / height == pytest.approx(215.9 / 279.4, abs=0.005) and width > 700


def test_chosen_works_are_the_masters_and_the_sheet_knows_which(world):
    pupil = world.browser("吳")
    asked = "works=seal-shui&works=regular-tian&text=永"
    (page,) = pages_of(pupil("GET", f"/api/practice-sheet.pdf?{asked}").content)
    assert page.text == "永水天" and page.master.startswith("#")
    masters = open_masters(page.master, page.text).by_character
    assert {c: m.work for c, m in masters.items()} == {"永": "", "水": "seal-shui", "天": "regular-tian"}
    assert masters["水"].script == "seal"


def test_a_place_in_the_cell_is_known_in_the_work(world):
    """The middle of the ink in a printed cell is that in the picture of the work."""
    from rumu.gallery.sheet_masters import choose_masters
    from rumu.gallery.starter import find_work

    master = choose_masters("水", ("seal",)).by_character["水"]
    sx, sy, tx, ty = master.in_work
    with Image.open(find_work("seal-shui").path) as picture:
        work = 1 - np.asarray(picture.convert("L"), float) / 255
    for ink, expected in ((master.ink, None), (work, True)):
        rows, columns = np.nonzero(ink > 0.5)
        box = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1], float) / len(ink)
        if expected is None:
            moved = box * [sx, sy, sx, sy] + [tx, ty, tx, ty]
        else:
            assert moved == pytest.approx(box, abs=0.004)


def test_each_pupil_of_a_class_gets_a_sheet(world):
    teacher = world.browser("林")
    url = f"/api/practice-sheet.pdf?text=水&class={world.ids['林班']}"
    assert [page.pupil for page in pages_of(teacher("GET", url).content)] == ["吳"]


@pytest.mark.parametrize(
    ("asked", "status", "code"),
    [
        ("text=", 422, "no_text"),
        ("text=水A", 422, "no_master"),
        ("text=永&master=seal", 422, "no_master"),
        (f"text={'水' * 201}", 422, "too_long"),
        (f"text={'水' * 401}", 422, "invalid"),
        ("text=水&cell=11", 422, "invalid"),
        ("text=水&grid=foo", 422, "invalid"),
        ("text=水&master=/etc/passwd", 422, "invalid"),
        ("text=水&cell=160&times=40", 422, "unusable"),
        ("text=水&pupil=" + "王" * 25, 422, "invalid"),
        ("works=none", 404, "not_found"),
        ("text=水&pupil=" + "&pupil=".join(f"p{k}" for k in range(61)), 422, "invalid"),
    ],
)
def test_what_cannot_be_printed_is_told_in_both_languages(world, code_of, asked, status, code):
    answer = world.browser("林")("GET", f"/api/practice-sheet.pdf?{asked}")
    assert (answer.status_code, code_of(answer)) == (status, code), answer.text


def test_too_many_pages_and_pages_that_are_not_there_are_told(world, code_of):
    teacher = world.browser("林")
    names = "&".join(f"pupil=p{k}" for k in range(60))
    answer = teacher("GET", f"/api/practice-sheet.pdf?text=水火木&cell=150&times=1&{names}")
    assert (answer.status_code, code_of(answer)) == (422, "too_long")
    answer = teacher("GET", "/api/practice-sheet.png?text=水&number=2")
    assert (answer.status_code, code_of(answer)) == (404, "not_found")


def test_an_address_may_ask_so_often_and_no_more(new_world, code_of):
    world = new_world(rate_limits=RateLimitSettings(sheets="2/hour"))
    browser = world.browser()
    answers = [browser("GET", "/api/practice-sheet?text=水") for _ in range(3)]
    assert [answer.status_code for answer in answers] == [200, 200, 429] and code_of(
        answers[2]
    ) == "too_often"
