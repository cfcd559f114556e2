"""The page of a work: its plot, pins, keys, menus and licence are where a reader needs them."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Arrive, Visitor
from tests.e2e.test_walk import opened

PHONES = [{"width": 390, "height": 844}, {"width": 360, "height": 640}]
WINDOWS = [{"width": 1280, "height": 800}, *PHONES]


def on_phone(size: dict[str, int]) -> dict[str, object]:
    return {"viewport": size} | ({"has_touch": True, "is_mobile": True} if size["width"] < 600 else {})


def in_sight(page: Page, selector: str) -> bool:
    """Whether an element is within the window, whole."""
    return bool(
        page.locator(selector).first.evaluate(
            """(e) => {
                const box = e.getBoundingClientRect();
                const { top, left, right, bottom } = box;
                return top >= -1 && left >= -1 && right <= innerWidth + 1 && bottom <= innerHeight + 1;
            }"""
        )
    )


@pytest.mark.parametrize("size", WINDOWS, ids=lambda size: f"{size['width']}x{size['height']}")
def test_a_cut_and_its_plot_are_in_sight_together(arrive: Arrive, size: dict[str, int]) -> None:
    page = opened(arrive(**on_phone(size)), "/works/regular-shui")
    page.get_by_role("button", name="Cross-section").click()
    page.wait_for_timeout(900)  # while the page scrolls to the work
    box = page.locator(".viewer-stage").bounding_box()
    assert box is not None and 0 <= box["y"] + box["height"] / 2 <= size["height"]
    y = box["y"] + box["height"] * 0.6
    page.mouse.move(box["x"] + box["width"] * 0.3, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.7, y, steps=3)
    page.mouse.up()
    expect(page.locator(".profile path.edge")).to_be_attached()
    page.wait_for_timeout(900)
    assert in_sight(page, ".profile svg")
    assert in_sight(page, ".drawn.section")


def test_the_numbers_of_notes_can_be_hidden_and_stay_so(visitor: Visitor) -> None:
    page = opened(visitor, "/works/regular-shui")
    pins = page.locator("button.pin")
    expect(pins).to_have_count(4)
    page.keyboard.press("n")
    expect(pins).to_have_count(0)
    page.reload()
    button = page.get_by_role("button", name="Show the numbers of notes")
    expect(button).to_be_visible()
    expect(pins).to_have_count(0)
    page.locator(".note-head").nth(1).click()
    expect(pins).to_have_count(1)  # the one that is read
    page.locator(".note-head").nth(1).click()
    button.click()
    expect(pins).to_have_count(4)


def test_keys_work_without_a_click_and_not_while_typing(visitor: Visitor) -> None:
    page = opened(visitor, "/works/regular-shui")
    page.keyboard.press("3")
    expect(page.get_by_role("button", name="Mesh")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("1")
    page.keyboard.press("ArrowLeft")
    expect(page).to_have_url(re.compile("tilt=1[0-9]"))
    page.get_by_role("button", name="中文").click()  # the focus is outside of the viewer
    page.keyboard.press("2")
    surface = page.get_by_role("button", name="立體", exact=True)
    expect(surface).to_have_attribute("aria-pressed", "true")
    page.get_by_label("下載").first.click()
    field = page.locator(".print-form input").first
    field.focus()
    page.keyboard.type("31")
    expect(field).to_have_value("31")
    expect(surface).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("Escape")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_contain_text("N")
    page.keyboard.press("1")
    expect(surface).to_have_attribute("aria-pressed", "true")  # a dialog is open


@pytest.mark.parametrize("locale", ["zh-TW", "en-GB"])
@pytest.mark.parametrize("size", PHONES, ids=lambda size: f"{size['width']}x{size['height']}")
def test_no_menu_is_cut_on_a_phone(arrive: Arrive, size: dict[str, int], locale: str) -> None:
    page = opened(arrive(**on_phone(size), locale=locale), "/works/regular-shui")
    cut = page.locator(".top a, .top button").evaluate_all(
        "(all) => all.filter((e) => e.getBoundingClientRect().right > innerWidth).map((e) => e.textContent)"
    )
    assert cut == []
    page.locator(".menu > summary").click()
    page.wait_for_timeout(200)
    assert in_sight(page, ".menu-list")
    last = page.locator(".menu-list > :last-child")
    last.scroll_into_view_if_needed()
    expect(last).to_be_in_viewport(ratio=0.9)


def test_a_licence_is_told_in_the_reader_s_language(visitor: Visitor) -> None:
    page = opened(visitor, "/works/clerical-tian")
    english = page.get_by_role("link", name="CC BY-ND 3.0, Attribution-NoDerivatives, Taiwan")
    expect(english).to_have_attribute("href", re.compile("licenses/by-nd/3.0/tw/deed.en$"))
    page.get_by_role("button", name="中文").click()
    chinese = page.get_by_role("link", name=re.compile("姓名標示-禁止改作"))
    expect(chinese).to_have_attribute("href", re.compile("licenses/by-nd/3.0/tw/deed.zh-hant$"))
    expect(page.locator(".facts")).to_contain_text("原樣展示")


DRAWS = """(() => {
    window.draws = 0;
    const kind = WebGL2RenderingContext.prototype;
    for (const name of ["drawElements", "drawArrays"]) {
        const draw = kind[name];
        kind[name] = function (...values) { window.draws++; return draw.apply(this, values); };
    }
})()"""


def test_what_stands_still_is_drawn_once(visitor: Visitor) -> None:
    """Drawing on and on empties a battery; drawing twice makes everybody wait."""
    visitor.page.add_init_script(DRAWS)
    page = opened(visitor, "/works/regular-shui")
    page.wait_for_function("() => window.draws > 0")
    page.wait_for_timeout(1000)
    assert page.evaluate("window.draws") == 1
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("() => window.draws > 1")
    page.wait_for_timeout(500)
    assert page.evaluate("window.draws") == 2
