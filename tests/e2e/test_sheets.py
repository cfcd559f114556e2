"""Practice sheets: printed from the studio; their photographs come back as marks, cell by cell."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Arrive, Visitor
from tests.e2e.test_access import PHONE, faults, settled

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
