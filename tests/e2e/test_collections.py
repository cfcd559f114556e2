"""An owner gives a collection its titles and description, and deletes it; nobody else is offered to."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Callable

from playwright.sync_api import Route, expect
from tests.e2e.conftest import Visitor
from tests.e2e.test_access import faults

from rumu.gallery.starter import find_work

LogIn = Callable[..., Visitor]


def packed() -> bytes:
    """A zip of one picture, as a collection of its own."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("collection.json", json.dumps({"id": "small", "title": "Small"}))
        archive.writestr("labels.csv", "file,character,script\na.png,水,regular\n")
        archive.write(find_work("regular-shui").path, "a.png")
    return stream.getvalue()


def test_a_collection_is_titled_described_and_deleted(as_person: LogIn) -> None:
    owner = as_person("owner")
    page = owner.go("/collections")
    expect(page.locator(".collection-card").first).to_be_visible()
    before = page.locator(".collection-card").count()  # other tests may have added some
    page = owner.go("/add")
    page.get_by_role("button", name="Import an archive").click()
    page.locator("input[type=file]").set_input_files(
        {"name": "small.zip", "mimeType": "application/zip", "buffer": packed()}
    )
    page.get_by_role("button", name="Send").click()
    expect(page.get_by_text(re.compile("1 added"))).to_be_visible()

    page = owner.go("/collections")
    page.get_by_role("button", name="Edit “Small”").click()
    form = page.get_by_role("dialog")
    for label, text in (
        ("Title (Chinese)", "小集"),
        ("Title (English)", "A few works"),
        ("Description (Chinese)", "試試看。"),
        ("Description (English)", "To try it out."),
    ):
        form.get_by_label(label).fill(text)
    assert faults(page) == []
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0)
    card = page.locator(".collection-card").filter(has_text="A few works")
    expect(card).to_contain_text("To try it out.")
    expect(card).not_to_contain_text("· ·")
    page.get_by_role("button", name="中文").click()
    expect(page.locator(".collection-card").filter(has_text="小集")).to_contain_text("試試看。")
    page.get_by_role("button", name="English").click()

    page.get_by_role("button", name="Delete “A few works”").click()
    dialog = page.get_by_role("dialog")
    delete = dialog.get_by_role("button", name="Delete")
    expect(dialog).to_contain_text("works: 1")
    expect(delete).to_be_disabled()
    dialog.get_by_role("button", name="Cancel").click()
    expect(card).to_have_count(1)
    page.get_by_role("button", name="Delete “A few works”").click()
    dialog.get_by_role("checkbox").check()
    delete.click()
    expect(dialog).to_have_count(0)
    expect(card).to_have_count(0)
    expect(page.locator(".collection-card")).to_have_count(before)


def test_nobody_else_is_offered_to(visitor: Visitor, as_person: LogIn) -> None:
    for page in (visitor.go("/collections"), as_person("teacher").go("/collections")):
        expect(page.locator(".collection-card").first).to_be_visible()
        expect(page.get_by_role("button", name=re.compile("^(Edit|Delete)"))).to_have_count(0)


def test_what_is_below_the_pictures_stays_where_it_is_when_they_arrive(visitor: Visitor) -> None:
    """Else a click that began on a button ends beside it, and nothing happens."""
    page, held = visitor.page, list[Route]()

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/api/works?collection=*", hold)
    page.goto(f"{visitor.url}/#/collections")
    headings = page.locator(".collection-card h2")
    expect(headings.first).to_be_visible()
    top = "(all) => all.map((heading) => Math.round(heading.getBoundingClientRect().top))"
    before = headings.evaluate_all(top)
    for route in held:
        route.continue_()
    expect(page.locator(".collection-card").first.locator("img").first).to_be_visible()
    assert headings.evaluate_all(top) == before
