"""The service under a path of a host, behind a reverse proxy, in a real browser."""

from __future__ import annotations

import http.client
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, expect

from conftest import absent, copy_home

ROOT = "/calligraphy"
STATIC = Path(__file__).parents[2] / "src" / "rumu" / "web" / "static"


class Proxy(ThreadingHTTPServer):
    """Passes on what is below ROOT, and nothing else. cuts: whether it takes ROOT off the path."""

    daemon_threads = True

    def __init__(self, port: int, *, cuts: bool) -> None:
        super().__init__(("127.0.0.1", 0), PassOn)
        self.behind, self.cuts = port, cuts
        self.asked: list[tuple[str, int]] = []


class PassOn(BaseHTTPRequestHandler):
    """One request, with the headers that docs/service.md asks of a proxy."""

    protocol_version = "HTTP/1.1"
    server: Proxy

    def pass_on(self) -> None:
        path = self.path
        if path != ROOT and not path.startswith(f"{ROOT}/"):
            self._answer(404, [], b"another page of this host")
            return
        if self.server.cuts and path == ROOT:  # the service could not see what is missing
            self._answer(301, [("Location", f"{ROOT}/")], b"")
            return
        if self.server.cuts:
            path = path.removeprefix(ROOT)
        body = self.rfile.read(int(self.headers.get("content-length", 0)))
        behind = http.client.HTTPConnection("127.0.0.1", self.server.behind, timeout=60)
        headers = dict(self.headers.items()) | {"Connection": "close", "X-Forwarded-For": "192.0.2.1"}
        behind.request(self.command, path, body, headers)
        answer = behind.getresponse()
        dropped = ("transfer-encoding", "content-length", "connection")
        kept = [(name, value) for name, value in answer.getheaders() if name.lower() not in dropped]
        self._answer(answer.status, kept, answer.read())
        behind.close()

    do_GET = do_POST = do_PATCH = do_PUT = do_DELETE = do_HEAD = pass_on  # noqa: N815  http.server's names

    def _answer(self, status: int, headers: list[tuple[str, str]], body: bytes) -> None:
        self.server.asked.append((self.path, status))
        self.send_response_only(status)
        for name, value in headers:
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if status != 304:
            self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing of each request."""


@pytest.fixture(params=[False, True], ids=["path left on", "path taken off"])
def proxy(request: pytest.FixtureRequest, tmp_path: Path, started_home: Path) -> Iterator[tuple[Proxy, str]]:
    """(the proxy, the path of the owner's link)."""
    if not (STATIC / "index.html").is_file():
        absent("the built front end (scripts/install builds it)")
    server = subprocess.Popen(
        [sys.executable, "-m", "rumu.cli", "serve", "--port", "0", "--json", "--root-path", ROOT],
        env=os.environ | {"RUMU_HOME": str(copy_home(started_home, tmp_path, link=True))},
        stdout=subprocess.PIPE,
    )
    assert server.stdout is not None
    facts = json.loads(server.stdout.readline())
    running = Proxy(urlsplit(facts["url"]).port or 0, cuts=request.param)
    thread = threading.Thread(target=running.serve_forever, daemon=True)
    thread.start()
    link = urlsplit(facts["owner_link"])
    yield running, f"{link.path}#{link.fragment}"
    running.shutdown()
    running.server_close()
    server.terminate()
    server.wait(30)


def test_the_pages_work_below_a_path(proxy: tuple[Proxy, str], browser: Browser) -> None:
    running, owner_link = proxy
    host = f"http://127.0.0.1:{running.server_address[1]}"
    context = browser.new_context(locale="en-GB")
    context.set_default_timeout(60_000)
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    page.goto(f"{host}{ROOT}")
    expect(page.locator("main img").first).to_be_visible()
    assert page.url.startswith(f"{host}{ROOT}/")
    shown = "() => [...document.querySelectorAll('main img')].some(image => image.naturalWidth > 0)"
    page.goto(f"{host}{ROOT}/#/gallery")
    expect(page.locator("main .card").first).to_be_visible()
    page.wait_for_function(shown)
    page.goto(f"{host}{ROOT}/#/works/regular-shui")
    page.wait_for_load_state("networkidle")
    expect(page.locator("main canvas, main img").first).to_be_visible()
    page.goto(f"{host}{owner_link}")
    page.reload()
    page.locator("input[autocomplete=username]").fill("館主")
    for field in page.locator("input[type=password]").all():
        field.fill("tiger bamboo river")
    page.locator("button[type=submit]").click()
    expect(page.get_by_role("link", name="館主")).to_be_visible()
    page.reload()
    expect(page.get_by_role("link", name="館主")).to_be_visible()  # the cookie came back
    page.goto(f"{host}{ROOT}/#/people")
    page.get_by_role("button", name="Make an invitation link").click()
    link = page.locator(".invitation-link input").input_value()
    assert link.startswith(f"{host}{ROOT}/#/join/")
    page.goto(f"{host}{ROOT}/#/account")
    page.get_by_role("button", name="Log out everywhere").click()
    page.wait_for_url(f"{host}{ROOT}/#/login")
    context.close()
    assert complaints == []
    assert [one for one in running.asked if one[1] >= 400] == []
    assert len(running.asked) > 30 and all(path.startswith(ROOT) for path, _ in running.asked)
