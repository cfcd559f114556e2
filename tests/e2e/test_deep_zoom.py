"""A large work: one zooms in until its pixels are seen, and a lamp shines on it there."""

from __future__ import annotations

import io
import re
from collections.abc import Callable

import numpy as np
from PIL import Image
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Visitor
from tests.gallery.pages import draw_page, packed, page_text

LogIn = Callable[..., Visitor]
SCALE = 3
LINES = 80  # pixels of the side of a square of lines
SHARP = '.viewer-canvas[data-missing="0"]'
PHONE = {
    "viewport": {"width": 390, "height": 844},
    "device_scale_factor": 2,
    "has_touch": True,
    "is_mobile": True,
}


def large_page() -> Image.Image:
    """The drawn page enlarged, with lines of two pixels at its middle, which no reduced picture shows."""
    small = draw_page()
    size = (small.width * SCALE, small.height * SCALE)
    page = np.asarray(small.resize(size, Image.Resampling.BICUBIC)).copy()
    top, left = page.shape[0] // 2, page.shape[1] // 2
    for column in range(left, left + LINES, 4):
        page[top : top + LINES, column : column + 2] = (40, 30, 30)
    return Image.fromarray(page)


def open_large(visitor: Visitor, sent: dict[str, str], query: str = "") -> Page:
    """The page of the large work, which the first test sends, as sharp as the screen."""
    if "path" not in sent:
        page = visitor.go("/add")
        page.get_by_role("button", name="A page with its text").click()
        picture = {"name": "large.png", "mimeType": "image/png", "buffer": packed(large_page())}
        page.locator("input[type=file]").set_input_files(picture)
        page.get_by_label("What is written on it").fill(page_text())
        page.get_by_label("Title (English)").fill("A large scroll")
        page.get_by_label("Licence").fill("CC0-1.0")
        page.get_by_role("button", name="Send").click()
        page.get_by_role("link", name="See the work").click(timeout=240_000)
        sent["path"] = page.evaluate("location.hash").removeprefix("#").split("?")[0]
        sent["work"] = sent["path"].removeprefix("/works/")
    visitor.page.goto("about:blank")  # so that what is seen next was drawn for this address
    page = visitor.go(sent["path"] + query)
    expect(page.locator(SHARP)).to_be_visible(timeout=240_000)  # the tiles are made when they are first seen
    return page


def factor(page: Page) -> int:
    """Pixels of the work for one of the tiles that are shown."""
    return int(page.locator(".viewer-canvas").get_attribute("data-factor") or 0)


def canvas(page: Page) -> np.ndarray:
    """What the viewer shows, (H, W, 3)."""
    page.wait_for_timeout(300)
    picture = Image.open(io.BytesIO(page.locator(".viewer-canvas").screenshot()))
    return np.asarray(picture.convert("RGB")).astype(float)


def steps(view: np.ndarray) -> int:
    """How often dark and light alternate where the lines are: to the right of the middle, and below it."""
    middle = view[view.shape[0] // 2 + 12, view.shape[1] // 2 + 4 : view.shape[1] // 2 + 64].mean(axis=1)
    dark = middle < (middle.min() + middle.max()) / 2
    return int(np.count_nonzero(dark[1:] != dark[:-1])) if np.ptp(middle) > 60 else 0


def test_one_zooms_in_to_the_pixels_of_the_work_and_relights_them(
    as_person: LogIn, sent: dict[str, str]
) -> None:
    page = open_large(as_person("owner"), sent)
    assert factor(page) >= 2
    far = canvas(page)
    host = page.locator(".viewer-host")
    box = host.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for _ in range(7):
        page.mouse.wheel(0, -120)
    expect(page.locator(f'{SHARP}[data-factor="1"]')).to_be_visible()
    near = canvas(page)
    assert steps(near) > 12 and steps(far) < 4  # the lines stand apart, and were one shade from afar
    page.keyboard.press("l")
    for _ in range(9):
        page.keyboard.press("ArrowDown")  # the lamp goes down
    low = canvas(page)
    assert np.abs(low - near).mean() > 3
    page.keyboard.press("ArrowLeft")
    for _ in range(17):
        page.keyboard.press("ArrowLeft")
    turned = canvas(page)
    lit = np.abs(turned - low).mean(axis=2)
    assert lit.max() > 20  # strokes are lit from another side
    expect(page.locator(SHARP)).to_be_visible()


def test_the_address_keeps_the_place_and_the_keys_move_it(as_person: LogIn, sent: dict[str, str]) -> None:
    page = open_large(as_person("owner"), sent, "?cam=0.1,0.05,0.08,0.1,0.05,0")
    assert factor(page) == 1
    page.keyboard.press("m")
    page.keyboard.press("ArrowRight")
    expect(page).to_have_url(re.compile(r"cam=0\.10\d+,0\.05,"))
    page.keyboard.press("0")
    expect(page).not_to_have_url(re.compile("cam="))
    expect(page.locator(f'{SHARP}:not([data-factor="1"])')).to_be_visible()  # once it has been drawn anew
    assert factor(page) >= 2


def test_the_boxes_of_characters_stay_on_them_in_the_depth(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    page = open_large(owner, sent)
    places = page.evaluate("async (id) => (await fetch(`/api/works/${id}/characters`)).json()", sent["work"])
    one = next(place for place in places if place["character"])
    xs, ys = zip(*one["place"]["polygon"], strict=True)
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    facts = page.evaluate("async (id) => (await fetch(`/api/works/${id}`)).json()", sent["work"])
    longest = max(facts["width"], facts["height"])
    at = f"{(x - 0.5) * facts['width'] / longest:.5f},{(0.5 - y) * facts['height'] / longest:.5f}"
    page = open_large(owner, sent, f"?cam={at},0.3,{at},0&at={one['id']}")
    box, stage = page.locator(".box.chosen").bounding_box(), page.locator(".viewer-host").bounding_box()
    assert box is not None and stage is not None
    assert abs(box["x"] + box["width"] / 2 - stage["x"] - stage["width"] / 2) < 4
    dark = canvas(page).mean(axis=2) < 90
    left, top = round(box["x"] - stage["x"]), round(box["y"] - stage["y"])
    inside = dark[top : top + round(box["height"]), left : left + round(box["width"])]
    assert inside.mean() > 0.05  # the character is in its box


def test_the_surface_is_as_fine_as_the_work_from_nearby(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    page = open_large(owner, sent, "?mode=contours")
    far = int(page.locator(".viewer-canvas").get_attribute("data-heights") or 0)
    page.evaluate("location.hash += '&cam=0.1,0.05,0.3,0.1,0.05,0'")
    expect(page.locator(f'{SHARP}:not([data-heights="{far}"])')).to_be_visible()
    near = int(page.locator(".viewer-canvas").get_attribute("data-heights") or 0)
    assert near >= 2 * far
    assert canvas(page).std() > 5  # contours are drawn


def test_on_a_phone_two_fingers_zoom(as_person: LogIn, sent: dict[str, str]) -> None:
    page = open_large(as_person("owner", **PHONE), sent)
    before = factor(page)
    box = page.locator(".viewer-host").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = page.context.new_cdp_session(page)
    for step, kind in enumerate(["touchStart", *["touchMove"] * 6]):
        points = [{"x": x - 15 - 20 * step, "y": y}, {"x": x + 15 + 20 * step, "y": y}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    expect(page.locator(f'{SHARP}:not([data-factor="{before}"])')).to_be_visible()
    assert factor(page) < before
    assert int(page.locator(".viewer-canvas").get_attribute("data-tile-bytes") or 0) < 48e6
