"""A pupil's photograph: the first crop, ink that it cuts off, turning, and what is kept of it."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image, ImageDraw
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Visitor

from rumu.gallery.starter import starter_samples

LogIn = Callable[..., Visitor]
MARKS = re.compile("api/marks")


def cell() -> Image.Image:
    """A copy of 水 in its cell, 512 pixels wide."""
    sample = next(sample for sample in starter_samples() if sample.work == "regular-shui")
    return Image.open(sample.path).convert("L").resize((512, 512)).convert("RGB")


def jpeg(picture: Image.Image, *, orientation: int = 1) -> bytes:
    stream = io.BytesIO()
    exif = Image.Exif()
    exif[274] = orientation
    picture.save(stream, "JPEG", quality=92, exif=exif)
    return stream.getvalue()


TURNED_AGAIN_AT_ONCE = """() => new Promise((done) => {
  const buttons = [...document.querySelectorAll("button")];
  const button = (name) => buttons.find((one) => one.textContent.includes(name));
  const picture = () => document.querySelector(".crop img").src;
  const drawn = new MutationObserver(() => {
    drawn.disconnect();
    const first = picture(), seen = [];
    button("Turn right").click();
    const look = () => {
      if (picture() !== first) return done(seen);
      seen.push(button("Mark it").disabled ? "" : "may be marked");
      requestAnimationFrame(look);
    };
    look();
  });
  drawn.observe(document.querySelector(".crop"), { subtree: true, attributeFilter: ["src"] });
  button("Turn left").click();
})"""
"""Turns a photograph back as soon as it stands turned, and tells for each frame if it may be marked."""


def choose(page: Page, data: bytes) -> None:
    page.get_by_role("tab", name=re.compile("Send a photo|上傳照片")).click()
    page.locator("input[type=file]").last.set_input_files(
        {"name": "sheet.jpg", "mimeType": "image/jpeg", "buffer": data}
    )
    expect(page.locator(".crop img")).to_be_visible()


def square(page: Page) -> dict[str, float]:
    box = page.locator(".crop-square")
    return {name: float(box.get_attribute(name) or 0) for name in ("x", "y", "width")}


def marked(page: Page, name: str = "Mark it") -> dict[str, object]:
    with page.expect_response(MARKS) as coming:
        page.get_by_role("button", name=name).click()
    answer: dict[str, object] = coming.value.json()
    return answer


def test_the_first_crop_is_the_cell_and_its_mark_that_of_the_cell(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shui")
    scales = []
    sheet = Image.new("RGB", (900, 1200), cell().getpixel((4, 4)))
    sheet.paste(cell(), (200, 400))
    ImageDraw.Draw(sheet).rectangle((200, 400, 712, 912), outline=(196, 60, 50), width=5)
    for picture, reason in ((cell(), "whole picture"), (sheet, "printed on the sheet")):
        choose(page, jpeg(picture))
        expect(page.get_by_role("status").filter(has_text=reason)).to_be_visible()
        pose = marked(page)["mark"]["pose"]  # type: ignore[index]
        scales.append(pose["scale"])
    assert scales[1] == pytest.approx(scales[0], rel=0.03)
    found = square(page)
    assert found["x"] == pytest.approx(200, abs=8) and found["y"] == pytest.approx(400, abs=8)
    assert found["width"] == pytest.approx(512, abs=12)


def test_a_cell_photographed_from_the_side_is_taken_by_its_four_corners(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shui")
    sheet = Image.new("RGB", (900, 1200), cell().getpixel((4, 4)))
    sheet.paste(cell(), (200, 400))
    ImageDraw.Draw(sheet).rectangle((200, 400, 712, 912), outline=(196, 60, 50), width=5)
    flat = np.array([[0, 0], [900, 0], [900, 1200], [0, 1200]], np.float32)
    seen = np.array([[120, 60], [820, 20], [900, 1150], [10, 1190]], np.float32)
    view = cv2.getPerspectiveTransform(flat, seen)
    picture = cv2.warpPerspective(np.asarray(sheet), view, (900, 1200), borderMode=cv2.BORDER_REPLICATE)
    choose(page, jpeg(Image.fromarray(picture)))
    corners = page.get_by_role("slider", name=re.compile("corner"))
    expect(corners).to_have_count(4)
    true = cv2.perspectiveTransform(
        np.array([[[200, 400], [712, 400], [712, 912], [200, 912]]], np.float32), view
    )[0]
    knobs = [corners.nth(k).locator("circle").last for k in range(4)]
    found = [[float(knob.get_attribute(name) or 0) for name in ("cx", "cy")] for knob in knobs]
    assert found == pytest.approx(true, abs=8)
    assert marked(page)["mark"]["refused"] is None  # type: ignore[index]
    preview = page.locator(".flat-cell img")
    before = preview.get_attribute("src")
    box = knobs[2].bounding_box()
    assert box is not None
    at = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] - 40, at[1] - 30, steps=4)
    page.mouse.up()
    page.keyboard.press("Shift+ArrowLeft")  # the corner that was dragged has the focus
    moved = [float(knobs[2].get_attribute(name) or 0) for name in ("cx", "cy")]
    assert moved[0] < found[2][0] - 40 and moved[1] < found[2][1] - 20
    expect(preview).not_to_have_attribute("src", str(before))
    page.get_by_label("Drag each corner by itself").uncheck()
    expect(corners).to_have_count(0)


def test_ink_that_the_crop_cuts_off_is_red_and_said(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shui")
    choose(page, jpeg(cell()))
    said = page.locator(".crop-cuts")
    expect(said).to_have_count(0)
    page.locator(".crop svg").focus()
    for _ in range(20):
        page.keyboard.press("-")
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    expect(said).to_contain_text("beyond the frame")
    assert page.locator(".crop-cut").evaluate("(e) => e.getBBox().width") > 3
    page.get_by_role("button", name="中文").click()
    expect(said).to_contain_text("會被切掉")
    page.locator(".crop svg").focus()
    for _ in range(20):
        page.keyboard.press("+")
    expect(said).to_have_count(0)


def test_nothing_is_marked_while_a_photograph_is_turned_once_more(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shui")
    choose(page, jpeg(cell()))
    expect(page.get_by_role("button", name="Mark it")).to_be_enabled()
    seen = page.evaluate(TURNED_AGAIN_AT_ONCE)
    assert len(seen) > 2 and not any(seen)  # the cell of the first turn is not to be marked


def test_exif_is_honoured_and_a_photograph_can_be_turned(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shui")
    choose(page, jpeg(cell().rotate(90, expand=True), orientation=6))  # a phone that was held upright
    assert marked(page)["mark"]["refused"] is None  # type: ignore[index]
    page.get_by_role("button", name="Turn left").click()
    page.get_by_role("button", name="Turn right").click()
    assert marked(page)["mark"]["refused"] is None  # type: ignore[index]
    page.get_by_role("button", name="Turn right").click()
    page.get_by_role("button", name="Turn right").click()
    page.wait_for_timeout(300)
    assert marked(page)["mark"]["refused"]  # type: ignore[index]


def test_a_photograph_on_its_side_is_turned_by_one_click(as_person: LogIn) -> None:
    page = as_person("pupil").go("/studio/regular-shui")
    choose(page, jpeg(cell().rotate(90, expand=True)))
    refused = marked(page)["mark"]["refused"]  # type: ignore[index]
    assert refused["turned_by"] == 90
    expect(page.locator(".verdict.refused")).to_be_visible()
    answer = marked(page, "Turn it and mark again")
    assert answer["mark"]["refused"] is None  # type: ignore[index]
    expect(page.locator(".verdict-score")).to_be_visible()
    expect(page.locator(".kept")).to_contain_text("Kept in your practice")


def test_a_copy_that_cannot_be_marked_is_kept_only_if_its_writer_wants(as_person: LogIn) -> None:
    page = as_person("other pupil").go("/studio/regular-shui")
    sheet = Image.new("RGB", (600, 600), "white")
    ImageDraw.Draw(sheet).line((80, 300, 520, 300), fill="black", width=30)
    choose(page, jpeg(sheet))
    before = page.evaluate("async () => (await (await fetch('api/attempts')).json()).total")
    assert marked(page)["id"] is None
    result = page.locator(".desk-mark")
    expect(result).to_contain_text("cannot be marked yet")
    expect(result).not_to_contain_text("Kept")
    assert page.evaluate("async () => (await (await fetch('api/attempts')).json()).total") == before
    assert marked(page, "Keep it without a mark")["id"]
    expect(result).to_contain_text("Kept in your practice, without a mark")
    expect(result).not_to_contain_text("cannot be marked")


@pytest.mark.parametrize("name", ["copy-心1.jpeg", "copy-心2.jpeg"])
def test_a_cell_in_a_phone_s_photograph_is_found(visitor: Visitor, data: Path, name: str) -> None:
    page = visitor.go("/studio/regular-shui")
    choose(page, (data / "pages" / "phone" / name).read_bytes())
    expect(page.get_by_role("status").filter(has_text="printed on the sheet")).to_be_visible()
    expect(page.locator(".crop-cuts")).to_have_count(0)
