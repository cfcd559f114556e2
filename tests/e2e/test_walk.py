"""The whole way: browse, turn the light, write, be marked, keep it, and be refused what is not yours."""

from __future__ import annotations

import io
import re
from collections.abc import Callable

import numpy as np
from PIL import Image
from playwright.sync_api import Page, expect
from tests.e2e.brush import write
from tests.e2e.conftest import Arrive, Visitor

from rumu.gallery.starter import starter_samples

LogIn = Callable[..., Visitor]


def seen(page: Page, selector: str) -> np.ndarray:
    """What stands there on the screen, (H, W, 3) as numbers."""
    picture = page.locator(selector).first.screenshot()
    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=np.float32)


def opened(visitor: Visitor, path: str) -> Page:
    page = visitor.go(path)
    expect(page.locator(".work-stage canvas").first).to_be_visible()
    expect(page.get_by_text("Loading …")).to_have_count(0)
    return page


def test_a_visitor_browses_by_script_and_searches(visitor: Visitor) -> None:
    page = visitor.go("/gallery")
    expect(page.get_by_text("39 works")).to_be_visible()
    page.get_by_role("button", name="Seal").click()
    expect(page).to_have_url(re.compile("script=seal"))
    cards = page.locator("a[href^='#/works/']")
    expect(cards).to_have_count(6)
    understood = page.locator(".understood")
    page.get_by_role("searchbox").fill("shui")
    expect(understood).to_have_text("shuias its reading (1)")
    page.get_by_role("searchbox").fill("水")
    expect(cards).to_have_count(1)
    expect(understood).to_have_text("水as the character (1)")
    cards.first.click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("水")
    expect(page.get_by_text("It was not measured")).to_be_visible()


def test_the_order_of_strokes_is_shown_step_by_step_and_played(visitor: Visitor) -> None:
    strokes = visitor.go("/works/regular-ren").locator(".stroke-order")
    expect(strokes).to_contain_text("2 strokes")
    strokes.get_by_role("button", name="One stroke back").click()
    expect(strokes).to_contain_text("Stroke 1: left-falling stroke")
    expect(strokes.locator("path.to-come")).to_have_count(1)
    strokes.get_by_label("Number the strokes").check()
    expect(strokes.locator("text")).to_have_text(["1", "2"])
    strokes.get_by_role("button", name="Play").click()
    expect(strokes.locator("polyline.brush")).to_be_visible()
    expect(strokes.get_by_role("button", name="Play")).to_be_visible()
    expect(strokes.locator("path.to-come")).to_have_count(0)


def test_of_seal_script_no_order_is_claimed(visitor: Visitor) -> None:
    page = visitor.go("/works/seal-shui")
    expect(page.get_by_role("heading", level=1)).to_contain_text("水")
    expect(page.locator(".stroke-order")).to_have_count(0)


def test_dragging_the_light_changes_what_is_seen(visitor: Visitor) -> None:
    page = opened(visitor, "/works/regular-shui?tilt=135&slant=60")
    page.wait_for_timeout(500)
    before = seen(page, ".work-stage canvas")
    box = page.locator(".work-stage canvas").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] * 0.35, box["y"] + box["height"] * 0.35)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.7, box["y"] + box["height"] * 0.75, steps=6)
    page.mouse.up()
    page.wait_for_timeout(500)
    after = seen(page, ".work-stage canvas")
    assert np.mean(np.abs(after - before) > 8) > 0.02
    assert "tilt=135" not in page.url, "the light stands in the address"


def test_the_view_in_a_link_is_the_view_that_opens(arrive: Arrive) -> None:
    first = opened(arrive(), "/works/regular-shu?mode=heights&tilt=30&slant=50")
    second = opened(arrive(), "/works/regular-shu?mode=heights&tilt=30&slant=50")
    other = opened(arrive(), "/works/regular-shu?mode=surface&tilt=200&slant=50")
    for page in (first, second, other):
        page.wait_for_timeout(800)
    one, same, changed = (seen(page, ".work-stage canvas") for page in (first, second, other))
    assert np.mean(np.abs(one - same)) < 1
    assert np.mean(np.abs(one - changed)) > 5


def test_two_works_stand_side_by_side(visitor: Visitor) -> None:
    page = opened(visitor, "/works/regular-shui")
    page.get_by_role("button", name="Two side by side").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("searchbox").or_(dialog.get_by_role("textbox")).first.fill("running")
    named = re.compile(r"water\), running")
    dialog.get_by_role("button", name=named).or_(dialog.get_by_role("link", name=named)).first.click()
    expect(page).to_have_url(re.compile("with=running-shui"))
    expect(page.locator(".work-stage canvas:visible")).to_have_count(2)


def test_section_and_ruler_are_of_the_work_that_was_touched_last(visitor: Visitor) -> None:
    page = opened(visitor, "/works/regular-shui?with=running-shui")
    stages = page.locator(".viewer-stage")
    expect(page.locator(".work-stage canvas:visible")).to_have_count(2)
    drawn, plot = stages.locator(".drawn.section"), page.locator(".viewer-profile")
    page.get_by_role("button", name="Cross-section").click()
    expect(stages.nth(0)).to_have_class(re.compile("acting"))

    def cut(which: int) -> None:
        box = stages.nth(which).bounding_box()
        assert box
        page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + box["height"] * 0.5)
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] * 0.7, box["y"] + box["height"] * 0.5, steps=3)
        page.mouse.up()

    for which, script in ((1, "running"), (0, "regular")):
        cut(which)
        expect(stages.nth(which)).to_have_class(re.compile("acting"))
        expect(stages.nth(which)).to_contain_text("Section and ruler: this one")
        expect(stages.nth(1 - which)).not_to_have_class(re.compile("acting"))
        expect(plot).to_contain_text(script)
    expect(drawn).to_have_count(2)
    curves = {which: "" for which in (0, 1)}
    for which in curves:
        stages.nth(which).locator(".viewer-host").focus()  # by keyboard as well
        expect(stages.nth(which)).to_have_class(re.compile("acting"))
        curves[which] = plot.locator("path.edge").get_attribute("d") or ""
    assert curves[0] != curves[1]
    page.get_by_role("button", name="Clear the section").click()
    expect(drawn).to_have_count(1)
    expect(stages.nth(0).locator(".drawn.section")).to_have_count(1)
    expect(plot).to_have_count(0)


def test_the_language_is_switched_and_remembered(visitor: Visitor) -> None:
    page = visitor.go("/works/regular-shui")
    page.get_by_role("button", name="中文").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("楷書「水」")
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_have_text("楷書「水」")
    assert page.evaluate("document.documentElement.lang") == "zh-Hant"


def test_a_visitor_writes_and_is_marked(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-ren")
    write(page, "regular-ren")
    with page.expect_response(re.compile("/api/marks")) as coming:
        page.get_by_role("button", name="Mark it").click()
    answer = coming.value.json()
    mark = answer["mark"]
    assert answer["id"] is None, "nothing of a visitor's is kept"
    assert mark["refused"] is None and 0 <= mark["interval"][0] <= mark["score"] <= mark["interval"][1] <= 100
    expect(page.locator(".verdict-score")).to_contain_text(str(int(mark["score"] + 0.5)))
    for part in ("Brushwork", "Structure", "Ink"):
        expect(page.locator(".verdict").or_(page.locator("main")).get_by_text(part).first).to_be_visible()


def test_what_is_left_out_is_told(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-tian")
    write(page, "regular-tian", leave_out=1)
    with page.expect_response(re.compile("/api/marks")) as coming:
        page.get_by_role("button", name="Mark it").click()
    mark = coming.value.json()["mark"]
    assert mark["refused"] is None
    assert "missing" in {remark["kind"] for remark in mark["remarks"]}
    remark = next(remark for remark in mark["remarks"] if remark["kind"] == "missing")
    expect(page.get_by_text(remark["en"]).first).to_be_visible()


def test_a_scribble_is_refused_kindly(visitor: Visitor) -> None:
    page = visitor.go("/studio/regular-shu")
    write(page, "regular-ren")
    page.get_by_role("button", name="Mark it").click()
    expect(
        page.get_by_text(re.compile("not marked|cannot be marked|another character", re.I)).first
    ).to_be_visible()


def test_an_attempt_is_kept_and_is_its_pupils_own(as_person: LogIn) -> None:
    pupil = as_person("pupil")
    page = pupil.go("/studio/regular-ren")
    write(page, "regular-ren")
    with page.expect_response(re.compile("/api/marks")) as coming:
        page.get_by_role("button", name="Mark it").click()
    attempt = coming.value.json()["id"]
    assert attempt
    page = pupil.go("/practice")
    expect(page.locator(f"a[href*='{attempt}']").first).to_be_attached()
    page = pupil.go(f"/attempts/{attempt}")
    expect(page.get_by_text("Structure").first).to_be_visible()

    other = as_person("other pupil")
    status = other.page.evaluate("async (id) => (await fetch(`/api/attempts/${id}`)).status", attempt)
    assert status == 404
    page = other.go(f"/attempts/{attempt}")
    expect(page.get_by_role("alert")).to_be_visible()
    other.forgive()

    teacher = as_person("teacher")
    status = teacher.page.evaluate("async (id) => (await fetch(`/api/attempts/${id}`)).status", attempt)
    assert status == 404, "a pupil of nobody's class is nobody's pupil"
    teacher.forgive()


def test_a_photo_is_cropped_to_its_cell_and_marked(visitor: Visitor) -> None:
    """The sheet is twice the cell; the crop that the page proposes is moved by keys onto the writing."""
    sample = next(sample for sample in starter_samples() if sample.work == "regular-shui")
    sheet = Image.new("L", (1024, 1536), 235)
    sheet.paste(Image.open(sample.path).convert("L"), (256, 512))
    photo = io.BytesIO()
    sheet.convert("RGB").save(photo, "JPEG", quality=90)
    page = visitor.go("/studio/regular-shui")
    page.get_by_role("tab", name="Send a photo").click()
    page.locator("input[type=file]").last.set_input_files(
        {"name": "sheet.jpg", "mimeType": "image/jpeg", "buffer": photo.getvalue()}
    )
    expect(page.get_by_alt_text("Your photo")).to_be_visible()
    with page.expect_response(re.compile("/api/marks")) as coming:
        page.get_by_role("button", name="Mark it").click()
    mark = coming.value.json()["mark"]
    assert mark["refused"] is None and mark["similarity"] > 0.7
    expect(page.locator(".verdict-score")).to_contain_text(str(int(mark["score"] + 0.5)))


def test_one_finger_turns_the_light_and_two_come_nearer(arrive: Arrive) -> None:
    visitor = arrive(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page = opened(visitor, "/works/regular-shui?tilt=135&slant=60")
    box = page.locator(".work-stage canvas").first.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = page.context.new_cdp_session(page)

    def fingers(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": px, "y": py, "id": k} for k, (px, py) in enumerate(places)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    fingers("touchStart", (x - 60, y - 60))
    for step in range(1, 9):
        fingers("touchMove", (x - 60 + 15 * step, y - 60 + 12 * step))
    fingers("touchEnd")
    expect(page).not_to_have_url(re.compile("tilt=135"))
    assert "cam=" not in page.url and page.evaluate("scrollY") == 0

    fingers("touchStart", (x - 30, y), (x + 30, y))
    for step in range(1, 9):
        fingers("touchMove", (x - 30 - 8 * step, y), (x + 30 + 8 * step, y))
    fingers("touchEnd")
    expect(page).to_have_url(re.compile("cam="))
