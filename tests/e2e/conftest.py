"""The whole system as a person meets it: the real server, the built pages, a real browser."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, Request, Response, expect

from conftest import absent, copy_home

STATIC = Path(__file__).parents[2] / "src" / "rumu" / "web" / "static"
PATIENCE = 30_000  # milliseconds: the lamp is drawn by a processor here

_REFUSED = "Failed to load resource"  # how the browser reports an answer from 400 on

expect.set_options(timeout=PATIENCE)


@dataclass(frozen=True, slots=True)
class Site:
    """url: of the running server, without its last slash. owner_link: makes the first login."""

    url: str
    owner_link: str


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory, started_home: Path) -> Iterator[Site]:
    if not (STATIC / "index.html").is_file():
        absent("the built front end (scripts/install builds it)")
    home = copy_home(started_home, tmp_path_factory.mktemp("site"), link=True)
    command = [sys.executable, "-m", "rumu.cli", "serve", "--port", "0", "--json"]
    with (home / "stderr").open("wb") as errors:
        server = subprocess.Popen(
            command, env=os.environ | {"RUMU_HOME": str(home)}, stdout=subprocess.PIPE, stderr=errors
        )
    assert server.stdout is not None
    line = server.stdout.readline()
    try:
        assert line, (home / "stderr").read_text()
        facts = json.loads(line)
        yield Site(facts["url"].rstrip("/"), facts["owner_link"])
    finally:
        server.terminate()
        server.wait(timeout=20)
        assert "Traceback" not in (home / "stderr").read_text()


@dataclass(frozen=True, slots=True)
class Visitor:
    """A person at a browser. complaints: the page's errors. refused: responses with a status from 400 on.
    open_requests: the page's calls of the server that have no answer yet."""

    page: Page
    url: str
    complaints: list[str]
    refused: list[Response]
    open_requests: list[Request]

    def forgive(self) -> None:
        """Forget the complaints so far, once every request is answered and every refusal reported."""
        until = time.monotonic() + PATIENCE / 1000
        while self.open_requests or sum(_REFUSED in text for text in self.complaints) < len(self.refused):
            assert time.monotonic() < until, "the browser has not reported every refusal"
            self.page.wait_for_timeout(20)
        self.complaints.clear()
        self.refused.clear()

    def go(self, path: str) -> Page:
        self.page.goto(f"{self.url}/#{path}")
        self.page.wait_for_load_state("networkidle")
        return self.page


Arrive = Callable[..., Visitor]


def _context(browser: Browser, **options: Any) -> BrowserContext:
    """A browser context of its own, with timeouts for a slow machine."""
    context = browser.new_context(**({"locale": "en-GB"} | options))
    context.set_default_timeout(PATIENCE)
    context.set_default_navigation_timeout(3 * PATIENCE)  # the first page also wakes browser and server
    return context


@pytest.fixture
def arrive(site: Site, browser: Browser) -> Iterator[Arrive]:
    """Make visitors, each with a browser of their own; at the end no page may have reported an error."""
    contexts: list[BrowserContext] = []
    visitors: list[Visitor] = []

    def make(**options: Any) -> Visitor:
        context = _context(browser, **({"viewport": {"width": 1280, "height": 800}} | options))
        page = context.new_page()
        complaints: list[str] = []
        refused: list[Response] = []
        requests: list[Request] = []
        page.on("request", lambda asked: requests.append(asked) if asked.resource_type == "fetch" else None)
        for end in ("requestfinished", "requestfailed"):
            page.on(end, lambda asked: requests.remove(asked) if asked in requests else None)
        page.on("response", lambda answer: refused.append(answer) if answer.status >= 400 else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "console", lambda message: complaints.append(message.text) if message.type == "error" else None
        )
        contexts.append(context)
        visitors.append(Visitor(page, site.url, complaints, refused, requests))
        return visitors[-1]

    yield make
    for context in contexts:
        context.close()
    assert [complaint for visitor in visitors for complaint in visitor.complaints] == []


@pytest.fixture
def visitor(arrive: Arrive) -> Visitor:
    return arrive()


@pytest.fixture(scope="session")
def people(site: Site, browser: Browser) -> dict[str, tuple[str, str]]:
    """Names and passwords of an owner, a teacher and two pupils: the owner joined by their link, the others
    as its page does."""
    made = {"owner": ("Mistress Wei", _password("owner"))}
    context = _context(browser)
    page = context.new_page()
    page.goto(site.owner_link)
    page.get_by_label("Name").fill(made["owner"][0])
    for field in page.locator("input[type=password]").all():
        field.fill(made["owner"][1])
    page.locator("form button[type=submit]").click()
    expect(page.get_by_role("button", name="Log out")).to_be_visible()
    for key, name in (("teacher", "Teacher Ouyang"), ("pupil", "Xiao Ming"), ("other pupil", "Xiao Hua")):
        token = page.evaluate(
            """async (role) => {
                const { csrf } = await (await fetch("/api/session")).json();
                const headers = { "Content-Type": "application/json", "X-CSRF-Token": csrf };
                const body = JSON.stringify({ role });
                const answer = await fetch("/api/invitations", { method: "POST", headers, body });
                return (await answer.json()).token;
            }""",
            key.removeprefix("other "),
        )
        with httpx.Client(base_url=site.url, timeout=PATIENCE / 1000, trust_env=False) as other:
            headers = {"X-CSRF-Token": other.get("/api/session").json()["csrf"]}
            facts = {"name": name, "password": _password(key)}
            joined = other.post(f"/api/invitations/{token}", json=facts, headers=headers)
        assert joined.status_code == 201, joined.text
        made[key] = (name, facts["password"])
    context.close()
    return made


def _password(key: str) -> str:
    return f"brush and ink {key}"


@pytest.fixture(scope="session")
def sessions() -> dict[str, Any]:
    """The cookies of those who have logged in by the form, which need not do it for each test."""
    return {}


@pytest.fixture
def as_person(
    arrive: Arrive, people: dict[str, tuple[str, str]], sessions: dict[str, Any]
) -> Callable[..., Visitor]:
    """A visitor who logged in as 'owner', 'teacher', 'pupil' or 'other pupil'."""

    def log_in(key: str, **options: Any) -> Visitor:
        visitor = arrive(**options)
        page = visitor.page
        if key in sessions:
            page.context.add_cookies(sessions[key])
            visitor.go("/about")
        else:
            visitor.go("/login")
            name, password = people[key]
            page.locator("input[autocomplete=username]").fill(name)
            page.locator("input[type=password]").fill(password)
            page.locator("form button[type=submit]").click()
        expect(page.get_by_role("button", name=re.compile("Log out|登出"))).to_be_visible()
        sessions[key] = page.context.cookies()
        return visitor

    return log_in


@pytest.fixture(scope="module")
def sent(site: Site, sessions: dict[str, Any]) -> Iterator[dict[str, str]]:
    """What is known of the work that a module sends, once its first test has sent it. path: that of its page.

    It is deleted afterwards: other modules count what is in the gallery.
    """
    known: dict[str, str] = {}
    yield known
    if "path" not in known:
        return
    cookies = {one["name"]: one["value"] for one in sessions["owner"]}
    with httpx.Client(base_url=site.url, cookies=cookies, timeout=60, trust_env=False) as owner:
        headers = {"X-CSRF-Token": owner.get("/api/session").json()["csrf"]}
        deleted = owner.delete(f"/api{known['path']}", headers=headers)
    assert deleted.is_success, deleted.text
