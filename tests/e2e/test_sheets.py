"""Practice sheets: printed from the studio; their photographs come back as marks, cell by cell."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from playwright.sync_api import Page, expect
from tests.e2e.conftest import PATIENCE, Arrive, Visitor
from tests.e2e.test_access import PHONE, faults, settled
from tests.written_sheets import encoded, photograph, written_sheet

from rumu.pages.sheet_layout import SheetPage
from rumu.pages.sheet_reading import locate_sheet

LogIn = Callable[..., Visitor]


def downloaded(page: Page, name: str) -> list[SheetPage]:
    """What the codes say on the pages of a PDF that is downloaded."""
    with page.expect_download() as coming:
        page.get_by_role("link", name=name).click()
    document = pypdfium2.PdfDocument(Path(coming.value.path()))
    return [locate_sheet(np.asarray(one.render(scale=2).to_pil().convert("RGB"))).page for one in document]


def test_a_visitor_prints_a_sheet(visitor: Visitor) -> None:
    page = visitor.go("/studio")
    page.get_by_role("link", name="Print a practice sheet").click()
    expect(page.locator(".print-preview")).to_contain_text("Type characters")
    page.get_by_label("Characters to write").fill("永天人水")
    preview = page.locator(".sheet-page")
    expect(preview).to_be_visible()
    page.get_by_role("radio", name="Less and less").check()
    page.get_by_role("radio", name="Double").check()
    page.get_by_role("radio", name="Letter").check()
    page.get_by_label("Pupil's name").fill("王小明")
    expect(page).to_have_url(re.compile("grid=hui.*model=shrinking|model=shrinking.*grid=hui"))
    expect(preview).to_have_attribute("src", re.compile("pupil="))
    expect(page.get_by_role("status")).to_contain_text("pages: 1")
    assert preview.evaluate("(e) => e.decode().then(() => e.naturalWidth)") > 700
    (printed,) = downloaded(page, "Download the PDF")
    assert (printed.text, printed.pupil, printed.grid, printed.help) == (
        "永天人水",
        "王小明",
        "hui",
        "shrinking",
    )
    assert printed.paper == "Letter"


def test_what_cannot_be_printed_is_told_in_both_languages(visitor: Visitor) -> None:
    page = visitor.go("/sheets/print?text=永&master=seal")
    told = page.get_by_role("alert")
    expect(told).to_contain_text("no master of 永")
    page.get_by_role("button", name="中文").click()
    expect(told).to_contain_text("沒有「永」的範字")
    visitor.forgive()


def test_works_are_chosen_as_masters_after_a_login(as_person: LogIn) -> None:
    page = as_person("pupil").go("/sheets/print")
    page.get_by_role("button", name="Add a work").click()
    page.get_by_role("searchbox").fill("seal 水")
    page.get_by_role("button", name=re.compile("水.*seal")).click()
    expect(page.locator(".chosen-work img")).to_be_visible()
    expect(page.locator(".sheet-page")).to_be_visible()
    (printed,) = downloaded(page, "Download the PDF")
    assert printed.text == "水" and printed.master.startswith("#")
    page.get_by_role("button", name=re.compile("Leave out")).click()
    expect(page.locator(".chosen-work")).to_have_count(0)


@pytest.mark.parametrize(("locale", "scheme"), [("zh-TW", "dark"), ("en-GB", "light")])
def test_the_page_to_print_suits_a_phone_and_has_no_serious_fault(
    arrive: Arrive, locale: str, scheme: str
) -> None:
    page = settled(arrive(**PHONE, locale=locale, color_scheme=scheme).go("/sheets/print?text=永天人水"))
    expect(page.locator(".sheet-page")).to_be_visible()
    assert faults(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


# --- photographs -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def photo() -> bytes:
    """A sheet of 人 and 水 with one copy of each, photographed from aside and upside down."""
    return encoded(photograph(written_sheet(sources=("regular",), pupil="Xiao Hua"), turn=180))


def send(page: Page, data: bytes) -> None:
    page.locator("input[type=file]").last.set_input_files(
        {"name": "sheet.jpg", "mimeType": "image/jpeg", "buffer": data}
    )


def test_a_photographed_sheet_shows_its_cells_and_each_opens_as_a_mark(
    as_person: LogIn, photo: bytes
) -> None:
    visitor = as_person("pupil")
    page = visitor.go("/studio")
    page.get_by_role("link", name="Send a photograph of a sheet").click()
    send(page, photo)
    page.wait_for_url(re.compile("#/sheets/[0-9a-f]{32}"))
    cells = page.locator(".sheet-cell")
    expect(cells).to_have_count(2)
    expect(cells.first).to_contain_text("人")
    expect(page.locator(".read-sheet")).to_contain_text("empty cells: 4")
    expect(page.locator(".visitor")).to_contain_text("printed for Xiao Hua")
    assert cells.first.locator("img").evaluate("(e) => e.decode().then(() => e.naturalWidth)") > 100
    expect(cells.first.locator(".sheet-told")).not_to_be_empty()
    page.get_by_role("button", name="中文").click()
    expect(page.locator(".visitor")).to_contain_text("存在「Xiao Ming」的練習裡")
    assert faults(page) == []
    cells.first.click()
    page.wait_for_url(re.compile("#/attempts/"))
    expect(page.locator(".verdict-score")).to_be_visible()
    expect(page.locator("h1")).to_contain_text("人")
    page.go_back()
    page.get_by_role("link", name="練習紙的照片").click()
    expect(page.locator(".sent-sheets li")).to_have_count(1)
    expect(page.locator(".sent-sheets li")).to_contain_text("人水")


def test_why_a_photograph_is_refused_is_told(as_person: LogIn) -> None:
    visitor = as_person("pupil", **PHONE)
    page = visitor.go("/sheets")
    flat = written_sheet()
    send(page, encoded(flat[: round(0.55 * len(flat))]))
    told = page.locator(".sheet-refused")
    expect(told).to_contain_text("cut off or covered")
    page.get_by_role("button", name="中文").click()
    expect(told).to_contain_text("沒有拍全")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    visitor.forgive()


def test_a_visitor_is_asked_to_log_in(visitor: Visitor) -> None:
    page = visitor.go("/sheets")
    expect(page.locator(".need")).to_contain_text("this needs a login")


def test_a_teacher_sends_the_sheets_of_a_class(as_person: LogIn, photo: bytes) -> None:
    page = as_person("teacher").go("/classes")
    page.get_by_label("Name of the class").fill("四年一班")
    page.get_by_role("button", name="Make it").click()
    page.wait_for_url(re.compile("#/classes/"))
    page.get_by_role("link", name="Photographs of the class's sheets").click()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.jpg", photo)
        archive.writestr("desk.jpg", encoded(np.full((800, 600, 3), 120, np.uint8)))
    page.locator("input[type=file]").set_input_files(
        {"name": "class.zip", "mimeType": "application/zip", "buffer": packed.getvalue()}
    )
    # behind the job that a new gallery makes its thumbnails in
    page.wait_for_url(re.compile("#/sheets/[0-9a-f]{32}"), timeout=8 * PATIENCE)
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.first).to_contain_text("Xiao Hua")
    expect(rows.last).to_contain_text("none of its black squares")
    page.locator("summary").click()
    expect(page.locator(".sheet-cell")).to_have_count(2)
    expect(page.locator(".read-sheet")).to_contain_text("no pupil called Xiao Hua")
    assert (
        page.locator(".sheet-cell img").first.evaluate("(e) => e.decode().then(() => e.naturalWidth)") > 100
    )
    assert faults(page) == []
    for name, start in (("All files", b"PK"), ("Table (CSV)", b"\xef\xbb\xbf"), ("teacher's PDF", b"%PDF")):
        with page.expect_download() as coming:
            page.get_by_role("link", name=name).click()
        assert Path(coming.value.path()).read_bytes().startswith(start)
