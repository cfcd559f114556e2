"""A teacher's lesson: a class, links for its pupils, a task, their copies, a mark beside ours; judging."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect
from tests.e2e.brush import write
from tests.e2e.conftest import Arrive, Visitor

LogIn = Callable[..., Visitor]


def joined(page: Page, link: str, name: str) -> None:
    page.goto(link)
    page.locator("input[autocomplete=username]").fill(name)
    for field in page.locator("input[type=password]").all():
        field.fill(f"brush and ink {name}")
    page.locator("form button[type=submit]").click()
    expect(page.get_by_role("button", name="Log out")).to_be_visible()


def test_a_lesson(as_person: LogIn, arrive: Arrive) -> None:
    teacher = as_person("teacher")
    page = teacher.go("/classes")
    page.get_by_label("Name of the class").fill("三年二班")
    page.get_by_role("button", name="Make it").click()
    page.wait_for_url(re.compile("#/classes/"))
    page.locator(".invitation > button").click()
    link = page.get_by_label("Invitation link").input_value()
    page.get_by_text("Give a task").click()
    page.get_by_label("Search for a master").fill("人")
    page.locator(".pick-row label").filter(has=page.locator("img[alt*='人'][alt*='regular']")).click()
    page.get_by_label("Title").fill("First week")
    page.get_by_role("button", name="Give it").click()
    page.wait_for_url(re.compile("#/tasks/"))
    task = page.url

    pupil = arrive()
    joined(pupil.page, link, "Amy")
    pupil.page.wait_for_url(task)  # a pupil who joins is led to what is to be written
    pupil.page.get_by_role("link", name="Write it").click()
    expect(pupil.page.locator(".cell")).to_be_visible()
    pupil.page.wait_for_load_state("networkidle")
    write(pupil.page, "regular-ren")
    with pupil.page.expect_response(re.compile("/api/marks")) as coming:
        pupil.page.get_by_role("button", name="Mark it").click()
    attempt = coming.value.json()
    assert attempt["task"] and task.endswith(attempt["task"])
    assert attempt["mark"]["score"] is not None, attempt["mark"]["refused"]
    handed_in = pupil.page.locator(".handed-in")
    expect(handed_in).to_contain_text("Handed in: First week")
    expect(handed_in).to_contain_text("This one counts")
    handed_in.get_by_role("link", name="To the task").click()
    expect(pupil.page.locator(".attempt-counts")).to_have_count(1)
    pupil.page.locator(".attempt-card").click()
    expect(pupil.page.locator("main")).to_contain_text("this is the one that counts")

    page.reload()
    row = page.locator("tbody tr").filter(has_text="Amy")
    expect(row).to_contain_text(str(int(attempt["mark"]["score"] + 0.5)))
    page.get_by_role("button", name="Your mark for Amy").click()
    page.get_by_role("dialog").get_by_label(re.compile("^Your mark")).fill("71")
    page.get_by_role("button", name="Save").click()
    page.reload()
    expect(page.locator("tbody tr").filter(has_text="Amy")).to_contain_text("71")

    assert pupil.page.url.endswith(f"#/attempts/{attempt['id']}")
    pupil.page.reload()
    expect(pupil.page.locator("main")).to_contain_text("Teacher Ouyang")
    expect(pupil.page.locator("svg title", has_text="Teacher's mark: 71")).to_have_count(1)
    pupil.page.goto(f"{pupil.url}/#/practice")
    printed = pupil.page.get_by_role("link", name="Print (PDF)").first.get_attribute("href")
    assert printed
    assert pupil.page.request.get(f"{pupil.url}/{printed}").body().startswith(b"%PDF-")


def test_a_class_ends_and_its_pupils_keep_what_they_wrote(as_person: LogIn, arrive: Arrive) -> None:
    page = as_person("teacher").go("/classes")
    page.get_by_label("Name of the class").fill("四年一班")
    page.get_by_role("button", name="Make it").click()
    page.wait_for_url(re.compile("#/classes/"))
    page.get_by_role("button", name="Rename").click()
    page.get_by_role("dialog").get_by_label("Name of the class").fill("五年一班")
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("五年一班")
    expect(page.get_by_role("button", name="Rename")).to_be_focused()
    page.locator(".invitation > button").click()
    link = page.get_by_label("Invitation link").input_value()
    page.get_by_text("Give a task").click()
    page.locator(".pick-row label").filter(has=page.locator("img[alt*='人'][alt*='regular']")).click()
    page.get_by_role("button", name="Give it").click()
    page.wait_for_url(re.compile("#/tasks/"))

    pupil = arrive()
    joined(pupil.page, link, "Bo")
    pupil.page.goto(page.url)
    pupil.page.get_by_role("link", name="Write it").click()
    expect(pupil.page.locator(".cell")).to_be_visible()
    pupil.page.wait_for_load_state("networkidle")
    write(pupil.page, "regular-ren")

    page.get_by_role("link", name="To the class").click()
    page.get_by_role("button", name="Delete this class").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("tasks: 1, names on its list of pupils: 1")
    expect(dialog.get_by_role("button", name="Keep it")).to_be_focused()
    page.keyboard.press("Enter")
    expect(dialog).to_have_count(0)
    page.get_by_role("button", name="Delete this class").click()
    dialog.get_by_role("button", name="Yes, delete").click()
    page.wait_for_url(re.compile("#/classes$"))
    expect(page.locator("main")).not_to_contain_text("五年一班")

    pupil.page.get_by_role("button", name="Mark it").click()
    expect(pupil.page.locator(".desk-mark")).to_contain_text("kept in your own practice")
    pupil.forgive()
    pupil.page.goto(f"{pupil.url}/#/practice")
    expect(pupil.page.locator("main")).to_contain_text("attempts: 1")


def test_a_pair_is_judged_once(as_person: LogIn) -> None:
    visitor = as_person("teacher")
    page = visitor.go("/judge")
    expect(page.locator(".judge-copy").first).to_be_enabled()
    with page.expect_response(re.compile(r"/api/comparisons$")) as response:
        page.keyboard.press("1")
    assert response.value.ok
    first = response.value.request.post_data_json
    expect(page.get_by_role("progressbar")).to_have_attribute("value", "1")
    with page.expect_response(re.compile(r"/api/comparisons$")) as again:
        page.keyboard.press("3")
    second = again.value.request.post_data_json
    assert {first["left"], first["right"]} != {second["left"], second["right"]}
    assert (first["winner"], second["winner"]) == ("left", "same")


def test_a_work_that_is_no_character_is_no_master(as_person: LogIn) -> None:
    work = "clerical-tian"
    owner = as_person("owner")
    change = """async ([work, character]) => {
        const { csrf } = await (await fetch("/api/session")).json();
        const headers = { "Content-Type": "application/json", "X-CSRF-Token": csrf };
        const body = JSON.stringify({ character });
        return (await fetch(`/api/works/${work}`, { method: "PATCH", headers, body })).status;
    }"""
    page = owner.go("/studio?q=天")
    card = page.locator(f"a[href='#/studio/{work}']")
    expect(card).to_be_visible()
    assert page.evaluate(change, [work, ""]) == 200
    page.reload()
    expect(page.locator("a[href^='#/studio/']").first).to_be_visible()
    expect(card).to_have_count(0)
    owner.go(f"/studio/{work}")
    expect(page.locator("main")).to_contain_text("no character that could be copied")
    assert page.evaluate(change, [work, "天"]) == 200
