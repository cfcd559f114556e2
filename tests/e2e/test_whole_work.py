"""A page with its text: sent, read beside its picture, both ways linked, and down into a character."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect
from tests.e2e.conftest import Visitor
from tests.e2e.test_access import faults
from tests.gallery.pages import COLUMNS, ROWS, draw_page, packed, page_text

LogIn = Callable[..., Visitor]


def open_work(owner: Visitor, sent: dict[str, str]) -> Page:
    """The page of the whole work, which the first test sends."""
    if "path" not in sent:
        page = owner.go("/add")
        page.get_by_role("button", name="A page with its text").click()
        picture = {"name": "leaf.png", "mimeType": "image/png", "buffer": packed(draw_page())}
        page.locator("input[type=file]").set_input_files(picture)
        page.get_by_label("What is written on it").fill(page_text())
        page.get_by_label("Title (English)").fill("A practice scroll")
        page.get_by_label("Licence").fill("CC0-1.0")
        assert faults(page) == []
        page.get_by_role("button", name="Send").click()
        page.get_by_role("link", name="See the work").click(timeout=240_000)  # other jobs come first
        sent["path"] = page.evaluate("location.hash").removeprefix("#")
    page = owner.go(sent["path"])
    expect(page.locator(".work-text .columns button")).to_have_count(COLUMNS * ROWS)
    expect(page.locator(".viewer-canvas")).to_be_visible()
    return page


def test_text_and_picture_are_linked_both_ways(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    page = open_work(owner, sent)
    letters = page.locator(".work-text .columns button")
    letters.nth(2).hover()
    expect(page.locator(".box.lit")).to_have_attribute("d", re.compile("^M"))
    letters.nth(2).click()
    card = page.locator(".character-card")
    expect(card.locator("h3")).to_have_text("水")
    expect(page).to_have_url(re.compile(r"at=[\w-]+-0003"))
    # its neighbour below, in the picture: where it is, then without its card, which lies over others
    letters.nth(3).click()
    host = page.locator(".viewer-host")
    host.scroll_into_view_if_needed()
    box, corner = page.locator(".box.chosen").bounding_box(), host.bounding_box()
    assert box is not None and corner is not None
    page.mouse.click(corner["x"] + 12, corner["y"] + 12)
    expect(card).to_have_count(0)
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(letters.nth(3)).to_have_class(re.compile("lit"))
    page.mouse.down()
    page.mouse.up()
    expect(card.locator("h3")).to_have_text("書")
    expect(letters.nth(3)).to_have_attribute("aria-pressed", "true")
    assert faults(page) == []
    page.get_by_label("Frame every character").check()
    expect(page.locator(".box.all")).to_have_attribute("d", re.compile("(M[^M]*){35}"))
    page.reload()
    expect(page.locator(".character-card h3")).to_have_text("書")


def test_one_goes_down_into_a_character_and_to_other_hands(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    page = open_work(owner, sent)
    page.locator(".work-text .columns button").nth(2).click()
    page.get_by_role("link", name="Open it").click()
    expect(page.locator(".facts h1")).to_have_text("水, A practice scroll")
    expect(page.locator(".within")).to_contain_text("A practice scroll")
    assert faults(page) == []
    page.get_by_role("link", name="“水” by other hands").click()
    expect(page.locator(".gather h1")).to_have_text("“水” by all hands")
    picks = page.get_by_role("button", name=re.compile("^Choose "))
    assert picks.count() >= 6
    picks.nth(0).click()
    picks.nth(1).click()
    assert faults(page) == []
    page.get_by_role("link", name="Side by side").click()
    expect(page.locator(".viewer-canvas")).to_have_count(2)
    page = owner.go(sent["path"] + "?at=none")
    expect(page.locator(".character-card")).to_have_count(0)


def test_on_a_phone_nothing_is_wider_than_the_screen(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    page = open_work(owner, sent)
    page.set_viewport_size({"width": 390, "height": 844})
    for path in (sent["path"], "/characters/水"):
        page = owner.go(path)
        expect(page.locator(".work-text, .gather").first).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.get_by_role("button", name="中文").click()
        assert faults(page) == []
        page.get_by_role("button", name="English").click()
