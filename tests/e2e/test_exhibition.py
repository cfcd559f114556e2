"""A collection as an exhibition: its cover, tour and order, and a screen that visitors use by themselves."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Visitor
from tests.e2e.test_access import faults

LogIn = Callable[..., Visitor]
STARTER = "/collections/starter"


@pytest.fixture
def owner(as_person: LogIn) -> Visitor:
    return as_person("owner")


def first_works(page: Page) -> list[str]:
    expect(page.locator(".card-title").nth(2)).to_be_visible()
    return page.locator(".card-title").all_inner_texts()[:3]


def test_an_owner_chooses_cover_and_tour_and_puts_works_in_order(owner: Visitor, visitor: Visitor) -> None:
    page = owner.go(STARTER)
    titles = first_works(page)
    page.get_by_role("button", name="Edit “").click()
    form = page.get_by_role("dialog", name="Edit the collection")
    form.get_by_role("button", name="Choose a work").click()
    picker = page.get_by_role("dialog", name="Work at its head")
    picker.get_by_role("searchbox").fill("水 regular")
    picker.get_by_role("button", name="水 shui (water), regular script").click()
    form.get_by_label("Its tour").select_option(index=1)
    tour = form.get_by_label("Its tour").locator("option").nth(1).inner_text()
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0)
    expect(page.locator(".lit-work strong")).to_contain_text("shui (water), regular script")
    expect(page.locator(".home-words")).to_contain_text(tour)

    page.get_by_role("button", name="Put the works in order").click()
    page.get_by_role("button", name=f"Front: “{titles[2]}”").click()
    page.get_by_role("button", name=f"“{titles[0]}” one place later").click()
    assert faults(page) == []
    page.get_by_role("button", name="Save").click()
    expect(page.locator(".card-title").first).to_have_text(titles[2])
    page = visitor.go(STARTER)
    assert first_works(page) == [titles[2], titles[1], titles[0]]
    assert faults(page) == []
    expect(page.get_by_role("button", name="Put the works in order")).to_have_count(0)
    page.get_by_role("link", name="Begin", exact=True).click()
    expect(page.get_by_role("heading", level=1)).to_have_text(tour)


def test_a_screen_in_an_exhibition_has_no_way_out_and_comes_back(visitor: Visitor) -> None:
    page = visitor.go(f"{STARTER}?kiosk=10")
    expect(page.locator(".lit-work")).to_be_visible()
    expect(page.get_by_role("navigation")).to_have_count(0)
    expect(page.get_by_role("contentinfo")).to_have_count(0)
    page.locator(".card a").first.click()
    expect(page.locator("article.work h1").first).to_be_visible()
    assert "/works/" in page.url
    page.reload()
    expect(page.get_by_role("navigation", name="Menu")).to_have_count(0)
    page.get_by_role("link", name="Back to the exhibition").click()
    expect(page.locator(".lit-work")).to_be_visible()
    page.locator(".card a").first.click()
    expect(page.locator("article.work")).to_be_visible()
    page.wait_for_url(f"**/#{STARTER}")  # nobody touches it
    page.goto(f"{visitor.url}/#{STARTER}?kiosk=off")
    expect(page.get_by_role("navigation", name="Menu")).to_be_visible()
