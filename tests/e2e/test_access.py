"""Everybody can use it: no serious fault that axe-core finds, and a phone's screen is enough."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from tests.e2e.brush import write
from tests.e2e.conftest import Arrive, Visitor

from conftest import absent

AXE = Path(__file__).parents[2] / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
OPEN = (
    *("/", "/about", "/gallery", "/works/regular-shui", "/collections", "/tours", "/studio"),
    *("/studio/regular-shui", "/login"),
)
OWNERS = ("/add", "/practice", "/classes", "/judge", "/people")

LogIn = Callable[..., Visitor]


def faults(page: Page) -> list[str]:
    """The serious and critical ones, each with where it is, once what comes up on the page has come up."""
    if not AXE.is_file():
        absent("axe-core (npm ci in frontend/)")
    page.evaluate(AXE.read_text(encoding="utf-8"))
    page.evaluate("Promise.all(document.getAnimations().map((one) => one.finished.catch(() => null)))")
    found: dict[str, Any] = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
    return [
        f"{fault['id']}: {fault['help']} at {[node['target'] for node in fault['nodes']][:3]}"
        for fault in found["violations"]
        if fault["impact"] in ("serious", "critical")
    ]


def settled(page: Page) -> Page:
    expect(page.get_by_text("Loading …").or_(page.get_by_text("載入中……"))).to_have_count(0)
    return page


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_serious_fault_on_what_is_open(arrive: Arrive, scheme: str) -> None:
    visitor = arrive(color_scheme=scheme)
    assert {path: found for path in OPEN if (found := faults(settled(visitor.go(path))))} == {}


def test_no_serious_fault_behind_the_login(as_person: LogIn) -> None:
    visitor = as_person("owner", locale="zh-TW")
    assert {path: found for path in OWNERS if (found := faults(settled(visitor.go(path))))} == {}


def test_no_serious_fault_in_a_mark(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-ren")
    write(page, "regular-ren")
    page.get_by_role("button", name="Mark it").click()
    expect(page.locator(".verdict-score")).to_be_visible()
    assert faults(page) == []


@pytest.mark.parametrize("locale", ["zh-TW", "en-GB"])
def test_nothing_is_wider_than_a_phone(arrive: Arrive, locale: str) -> None:
    visitor = arrive(**PHONE, locale=locale)
    wide = {}
    for path in OPEN:
        page = settled(visitor.go(path))
        width = page.evaluate("document.documentElement.scrollWidth")
        if width > PHONE["viewport"]["width"]:  # type: ignore[index]
            wide[path] = width
    assert wide == {}


def test_the_cell_fills_a_phone_and_a_finger_writes_without_scrolling(arrive: Arrive) -> None:
    visitor = arrive(**PHONE)
    page = visitor.go("/studio/regular-ren")
    cell = page.locator(".cell")
    box = cell.bounding_box()
    assert box is not None and box["width"] > 340
    touch = page.context.new_cdp_session(page)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 3

    def point(kind: str, *points: dict[str, float]) -> None:
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})

    point("touchStart", {"x": x, "y": y})
    for step in range(1, 20):
        point("touchMove", {"x": x - step * 2, "y": y + step * 6})
    point("touchEnd")
    expect(page.get_by_role("button", name="Undo")).to_be_enabled()
    assert page.evaluate("scrollY") == 0
