"""The home page: one work under a lamp that follows the pointer, small for a phone, and ways onward."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Arrive, Visitor

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
LARGEST = 500_000  # bytes of a first visit


def seen(page: Page) -> np.ndarray:
    """The lit picture on the screen, (H, W) as numbers."""
    picture = page.locator(".lit-work canvas").screenshot()
    return np.asarray(Image.open(io.BytesIO(picture)).convert("L"), dtype=np.float32)


def test_the_lamp_follows_the_pointer(arrive: Arrive) -> None:
    page = arrive(reduced_motion="reduce").go("/")
    expect(page.locator(".lit-work canvas.lit")).to_be_visible()
    page.wait_for_timeout(600)  # until it has faded in
    box = page.locator(".lit-work canvas").bounding_box()
    assert box is not None
    pictures = []
    for x in (0.02, 0.98):
        page.mouse.move(box["x"] + x * box["width"], box["y"] + box["height"] / 2)
        page.wait_for_timeout(300)
        pictures.append(seen(page))
    assert float(np.abs(pictures[0] - pictures[1]).mean()) > 5  # grooves are dark on the other side
    page.locator(".lit-work a").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("simulated stele")


def test_it_leads_into_gallery_and_studio_and_says_what_a_mark_is(visitor: Visitor) -> None:
    page = visitor.go("/")
    expect(page.get_by_text("39 works in the gallery")).to_be_visible()
    page.get_by_role("link", name="Write a character").click()
    expect(page).to_have_url(f"{visitor.url}/#/studio")
    page.locator(".brand").click()
    page.get_by_role("link", name="To the gallery").click()
    expect(page.get_by_role("searchbox")).to_be_visible()
    page.get_by_role("contentinfo").get_by_role("link", name="What a mark means").click()
    expect(page.get_by_role("heading", name="What a mark means")).to_be_in_viewport()
    expect(page.get_by_text("no verdict on a person")).to_be_visible()


def test_links_of_older_versions_still_find_the_gallery(visitor: Visitor) -> None:
    page = visitor.go("/?script=seal")
    expect(page).to_have_url(f"{visitor.url}/#/gallery?script=seal")
    expect(page.locator("a[href^='#/works/']")).to_have_count(6)


@pytest.mark.parametrize("locale", ["zh-TW", "en-GB"])
def test_a_phone_loads_little_at_first(arrive: Arrive, locale: str) -> None:
    visitor = arrive(**PHONE, locale=locale)
    loaded: list[int] = []
    visitor.page.on("response", lambda answer: loaded.append(answer.request.sizes()["responseBodySize"]))
    page = visitor.go("/")
    expect(page.locator(".lit-work canvas.lit")).to_be_visible()
    assert 20_000 < sum(loaded) < LARGEST
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_shared_link_opens_the_work_and_a_frame_shows_it(visitor: Visitor) -> None:
    page = visitor.page
    page.goto(f"{visitor.url}/share/works/regular-shui")
    expect(page).to_have_url(f"{visitor.url}/#/works/regular-shui")
    page.get_by_text("Share", exact=True).click()
    code = page.get_by_label("In a frame of another page").input_value()
    assert f'src="{visitor.url}/embed/works/regular-shui"' in code
    page.goto(f"{visitor.url}/embed/works/regular-shui")
    expect(page.locator(".work-stage canvas").first).to_be_visible()
