"""An owner mends what is known of a work on its page; nobody else is offered to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from playwright.sync_api import Locator, Page, expect
from tests.e2e.conftest import Visitor
from tests.e2e.test_access import PHONE, faults, settled

LogIn = Callable[..., Visitor]
EDIT = "Edit this work"
WORK = "regular-ri"


def work_page(visitor: Visitor) -> Page:
    page = settled(visitor.go(f"/works/{WORK}"))
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    return page


def form_of(page: Page) -> Locator:
    page.get_by_role("button", name=EDIT).click()
    return page.get_by_role("dialog")


def field(form: Locator, label: str) -> Locator:
    fields = [form.get_by_role(role, name=label, exact=True) for role in ("textbox", "combobox")]  # type: ignore[arg-type]
    return fields[0].or_(fields[1])


def read_work(page: Page) -> dict[str, Any]:
    """The facts as the service has them."""
    facts: dict[str, Any] = page.evaluate("async (id) => (await fetch(`/api/works/${id}`)).json()", WORK)
    return facts


def saved(form: Locator) -> None:
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0)


def entitle(page: Page, title: str) -> None:
    form = form_of(page)
    form.get_by_label("Title (English)").fill(title)
    saved(form)
    expect(page.get_by_role("heading", level=1)).to_have_text(title)


def test_an_owner_changes_the_title_and_changes_it_back(as_person: LogIn) -> None:
    page = work_page(as_person("owner"))
    before = read_work(page)
    entitle(page, "The sun, as the owner calls it")
    versioned = ("files", "thumb", "thumb_normals")  # addresses change with every change
    now = read_work(page)
    renamed = before | {"title": before["title"] | {"en": "The sun, as the owner calls it"}}
    assert now == renamed | {name: now[name] for name in versioned}
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_have_text("The sun, as the owner calls it")
    entitle(page, before["title"]["en"])
    assert read_work(page)["title"] == before["title"]


def test_every_fact_can_be_changed_and_is_seen_at_once(as_person: LogIn) -> None:
    page = work_page(as_person("owner"))
    before = read_work(page)
    new = {
        "Hand (Chinese)": "某人",
        "Hand (English)": "Somebody",
        "Period in words (English)": "in some year",
        "Material (English)": "ink on silk",
        "Source": "a shelf in Oxford",
        "Licence": "CC-BY-4.0",
        "Credit": "whoever found it",
    }
    form = form_of(page)
    old = {label: field(form, label).input_value() for label in new}
    for label, value in new.items():
        field(form, label).fill(value)
    form.get_by_label("Script").select_option("clerical")
    saved(form)
    beside = page.locator(".facts")
    shown = {**new, "Script": "Clerical", "Licence": "CC BY 4.0, Attribution"}
    for value in list(shown.values())[1:]:
        expect(beside).to_contain_text(value)

    form = form_of(page)
    for label, value in old.items():
        field(form, label).fill(value)
    form.get_by_label("Script").select_option(before["script"])
    saved(form)
    names = ("title", "hand", "period", "material", "script", "source", "licence", "attribution", "spacing")
    assert {name: read_work(page)[name] for name in names} == {name: before[name] for name in names}


def test_the_size_of_a_pixel_is_given_and_taken_back(as_person: LogIn) -> None:
    page = work_page(as_person("owner"))
    size = page.locator(".facts dd").filter(has_text="×")
    pixels = size.inner_text()
    for told_size, seen in (("0.25", "mm"), ("", "px")):
        form = form_of(page)
        form.get_by_label("Size of one pixel (mm)").fill(told_size)
        saved(form)
        expect(size).to_contain_text(seen)
        expect(page.locator(".scalebar")).to_contain_text(seen)
    assert size.inner_text() == pixels


ADD_A_LARGE_PICTURE = """async () => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 2000, height: 1400 });
    const drawn = canvas.getContext("2d");
    drawn.fillStyle = "white", drawn.fillRect(0, 0, 2000, 1400);
    drawn.fillStyle = "black", drawn.fillRect(900, 200, 160, 1000), drawn.fillRect(400, 600, 1200, 140);
    const form = new FormData();
    form.append("title_en", "A large ten");
    form.append("picture", await new Promise((resolve) => canvas.toBlob(resolve, "image/png")), "ten.png");
    const { csrf } = await (await fetch("/api/session")).json();
    const headers = { "X-CSRF-Token": csrf };
    return (await fetch("/api/works", { method: "POST", headers, body: form })).json();
}"""


def test_a_large_work_is_told_its_own_size(as_person: LogIn) -> None:
    owner = as_person("owner")
    added = owner.page.evaluate(ADD_A_LARGE_PICTURE)
    page = owner.go(f"/works/{added['id']}")
    size = page.locator(".facts dd").filter(has_text="×")
    expect(size.locator(".size")).to_have_text(["2000 × 1400 px", "3-D view from afar at 1024 × 717"])
    page.on("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Delete this work").click()
    expect(page.get_by_text("39 works")).to_be_visible()


def test_what_cannot_be_is_refused_kindly_and_changes_nothing(as_person: LogIn) -> None:
    owner = as_person("owner")
    page = work_page(owner)
    before = read_work(page)
    form = form_of(page)
    for label in ("Title (Chinese)", "Title (English)"):
        form.get_by_label(label).fill(" ")
    form.get_by_role("button", name="Save").click()
    expect(form.get_by_role("alert")).to_contain_text("needs a title")
    expect(form.get_by_role("button", name="Save")).to_be_in_viewport(ratio=1)
    form.get_by_label("Title (English)").fill("Sun")
    page.context.clear_cookies()  # as if logged out meanwhile
    form.get_by_role("button", name="Save").click()
    expect(form.get_by_role("alert")).not_to_contain_text("needs a title")
    expect(form.get_by_role("alert")).to_be_visible()
    assert read_work(page) == before
    owner.forgive()


def test_the_form_is_for_phones_and_for_everybody(as_person: LogIn) -> None:
    page = work_page(as_person("owner", locale="zh-TW", **PHONE))
    page.get_by_role("button", name="修改作品資料").click()
    form = page.get_by_role("dialog", name="修改作品資料")
    expect(form.get_by_label("標題（中文）")).to_have_value("楷書「日」")
    assert faults(page) == []
    assert form.evaluate("(box) => box.scrollWidth <= box.clientWidth"), "nothing is beyond its edge"
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["viewport"]["width"]  # type: ignore[index]
    form.get_by_role("button", name="關閉").click()
    expect(page.get_by_role("button", name="修改作品資料")).to_be_focused()


def test_why_an_import_failed_is_told_in_the_reader_s_language(as_person: LogIn) -> None:
    page = as_person("teacher").go("/add")
    page.get_by_role("button", name="Import an archive").click()
    broken = {"name": "a.zip", "mimeType": "application/zip", "buffer": b"PK\x03\x04 and no more"}
    page.locator("input[type=file]").set_input_files(broken)  # type: ignore[arg-type]
    page.get_by_role("button", name="Send").click()
    alert = page.locator(".job").get_by_role("alert")
    expect(alert).to_contain_text("Expected a whole zip file; the end of this one is missing")
    expect(alert).not_to_contain_text("zip 檔")
    page.get_by_role("button", name="中文").click()
    expect(alert).to_contain_text("這不是完整的 zip 檔：缺了結尾")


def test_a_pupil_is_not_offered_to(as_person: LogIn) -> None:
    page = work_page(as_person("pupil"))
    expect(page.get_by_role("link", name="Write it yourself")).to_be_visible()
    expect(page.get_by_role("button", name=EDIT)).to_have_count(0)


def test_what_is_not_there_is_told_in_a_heading(visitor: Visitor) -> None:
    for path, heading in (("/nowhere", "no such page"), ("/works/nothing", "no such work")):
        page = visitor.go(path)
        expect(page.get_by_role("heading", level=1)).to_contain_text(heading)
        expect(page.get_by_role("main").get_by_role("link", name="Back to the gallery")).to_be_visible()
    visitor.forgive()
