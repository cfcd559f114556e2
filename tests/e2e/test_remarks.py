"""Remarks beside the writing: their strokes in master and copy, their numbers, and the order of strokes."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Locator, Page, expect
from tests.e2e.conftest import PATIENCE, Arrive, Visitor

from rumu.gallery.starter import starter_samples

LogIn = Callable[..., Visitor]
WORK = "regular-shui"


def be_marked(visitor: Visitor) -> Page:
    """Send the worst sample of a work: it has five remarks."""
    sample = next(s for s in starter_samples() if s.work == WORK and s.degree == "bad")
    page = visitor.go(f"/studio/{WORK}")
    page.get_by_role("tab", name="Send a photo").click()
    page.locator("input[type=file]").last.set_input_files(sample.path)
    expect(page.get_by_alt_text("Your photo")).to_be_visible()
    page.get_by_role("button", name="Mark it").click()
    expect(page.locator(".remark").first).to_be_visible(timeout=3 * PATIENCE)
    return page


def on_both(page: Page) -> int:
    """A remark that is drawn in the master, too."""
    numbers = page.locator(".remark-sheets figure").first.locator(".remark-badge")
    expect(numbers.first).to_be_visible()
    return int(numbers.first.inner_text()) - 1


def standing_out(page: Page) -> Locator:
    return page.locator(".remark-sheets .outline.on")


def test_a_remark_shows_its_strokes_in_master_and_copy(visitor: Visitor) -> None:
    page = be_marked(visitor)
    k = on_both(page)
    expect(standing_out(page)).to_have_count(0)
    page.locator(".remark").nth(k).hover()
    expect(standing_out(page)).to_have_count(2)
    page.mouse.move(5, 5)
    expect(standing_out(page)).to_have_count(0)
    page.get_by_role("tab", name="Remarks").focus()
    for _ in range(k + 1):
        page.keyboard.press("Tab")
    expect(page.locator(".remark").nth(k)).to_be_focused()
    expect(standing_out(page)).to_have_count(2)
    page.locator(".remark-sheets figure").first.locator(".remark-badge").first.hover()
    expect(page.locator(".remark").nth(k)).to_have_class(re.compile("on"))


@pytest.mark.parametrize("width", [360, 768])
def test_on_touch_a_tap_keeps_a_remark_and_numbers_stand_clear(arrive: Arrive, width: int) -> None:
    page = be_marked(arrive(viewport={"width": width, "height": 780}, has_touch=True, is_mobile=True))
    k = on_both(page)
    page.locator(".remark").nth(k).tap()
    expect(standing_out(page)).to_have_count(2)
    expect(page.locator(".remark-sheets").first).to_be_in_viewport()
    page.locator(".remark").nth(k).tap()
    expect(standing_out(page)).to_have_count(0)
    page.locator(".remark-sheets figure").last.locator(".remark-badge").nth(k).tap()
    expect(page.locator(".remark").nth(k)).to_have_attribute("aria-pressed", "true")
    for sheet in page.locator(".remark-sheets .sheet").all():
        frame = sheet.bounding_box()
        boxes = [badge.bounding_box() for badge in sheet.locator(".remark-badge").all()]
        assert frame and boxes
        middles = []
        for box in boxes:
            assert box
            assert frame["x"] - 1 <= box["x"] and box["x"] + box["width"] <= frame["x"] + frame["width"] + 1
            assert frame["y"] - 1 <= box["y"] and box["y"] + box["height"] <= frame["y"] + frame["height"] + 1
            middles.append((box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"]))
        for (x, y, size), (u, v, _) in itertools.combinations(middles, 2):
            assert (x - u) ** 2 + (y - v) ** 2 >= size**2
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_the_order_of_strokes_stands_beside_the_sheet(arrive: Arrive) -> None:
    wide = arrive().go("/studio/regular-ren").locator(".desk-master")
    expect(wide.locator(".stroke-order")).to_contain_text("2 strokes")
    wide.get_by_role("button", name="Play").focus()
    for _ in range(2):
        wide.page.keyboard.press("ArrowLeft")
    expect(wide.locator("path.to-come")).to_have_count(2)
    wide.page.keyboard.press("ArrowRight")
    expect(wide.locator(".stroke-name")).to_have_text("Stroke 1: left-falling stroke")
    phone = arrive(viewport={"width": 390, "height": 780}, has_touch=True, is_mobile=True)
    narrow = phone.go("/studio/regular-ren").locator(".desk-master")
    expect(narrow.locator(".stroke-order")).to_have_count(0)
    narrow.get_by_text("Master and stroke order").tap()
    narrow.get_by_role("button", name="One stroke back").tap()
    expect(narrow.locator("path.to-come")).to_have_count(1)
    narrow.get_by_role("img", name="Stroke order: 人").tap()  # plays, all of it
    expect(narrow.get_by_role("button", name="Play")).to_be_visible()
    expect(narrow.locator("path.to-come")).to_have_count(0)
    narrow.get_by_label("Number the strokes").check()
    expect(narrow.locator(".stroke-number text")).to_have_text(["1", "2"])
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 390


def test_of_cursive_script_the_studio_claims_no_order(visitor: Visitor) -> None:
    page = visitor.go("/studio/cursive-shui")
    expect(page.locator(".desk-master img")).to_be_visible()
    expect(page.locator(".stroke-order")).to_have_count(0)


def test_after_the_second_attempt_the_page_says_what_changed(as_person: LogIn) -> None:
    pupil = as_person("other pupil")
    samples = {s.degree: s for s in starter_samples() if s.work == WORK}
    page = pupil.go(f"/studio/{WORK}")
    page.get_by_role("tab", name="Send a photo").click()
    for degree in ("bad", "good"):
        page.locator("input[type=file]").last.set_input_files(samples[degree].path)
        expect(page.get_by_alt_text("Your photo")).to_be_visible()
        with page.expect_response(re.compile("/api/marks"), timeout=3 * PATIENCE) as coming:
            page.get_by_role("button", name="Mark it").click()
        changed = coming.value.json()["progress"]
        if degree == "bad":
            assert changed is None
            expect(page.locator(".verdict-score")).to_be_visible()
            expect(page.locator(".progress")).to_have_count(0)
    assert changed["mark"]["change"] == "better"
    expect(page.locator(".progress-mark")).to_have_text(changed["mark"]["en"])
    expect(page.locator(".progress-faults .gone").first).to_be_visible()
    expect(page.locator(".progress-faults li")).to_have_count(len(changed["faults"]))
    page = pupil.go(f"/practice?work={WORK}")
    expect(page.locator(".progress-mark")).to_have_text(changed["mark"]["en"])
    page.get_by_role("button", name="中文").click()
    expect(page.locator(".progress-mark")).to_have_text(changed["mark"]["zh"])
