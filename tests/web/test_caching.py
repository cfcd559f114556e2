"""Responses kept in memory: made once for many, and never those of before a change."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from rumu.web.caching import ETagMiddleware
from rumu.web.responses import IMMUTABLE


class Titles:
    """An application with one title, which a GET reads at once and sends when it is let go.

    more_headers: of every response.
    """

    def __init__(self, *more_headers):
        self.title, self.made = "old", 0
        self.more_headers = more_headers
        self.let_go = asyncio.Event()
        self.let_go.set()

    async def __call__(self, scope, receive, send):
        if scope["method"] == "GET":
            self.made += 1
            body = json.dumps({"title": self.title}).encode()
            await self.let_go.wait()
        elif scope["path"].endswith("fails"):
            self.title = "new"
            raise RuntimeError("after the change")
        else:
            self.title, body = "new", b"{}"
        headers = [(b"content-type", b"application/json"), *self.more_headers]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": body})


async def request(app, method="GET", path="/api/works"):
    """The JSON of an answer."""
    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "raw_path": path.encode(),
        "root_path": "",
        "query_string": b"",
        "headers": [],
        "scheme": "http",
    }
    sent = []

    async def send(message):
        sent.append(message)

    await app(scope, None, send)
    return json.loads(sent[-1]["body"])


def run(work: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine in a thread of its own: tests in a browser leave their loop running in this one."""
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, work).result()


def test_many_who_ask_at_once_are_served_from_one():
    async def ask():
        titles = Titles()
        app = ETagMiddleware(titles)
        for _ in range(5):
            assert await request(app) == {"title": "old"}
        assert titles.made == 1
        await request(app, "PATCH")
        assert await request(app) == {"title": "new"} and titles.made == 2

    run(ask())


def test_requests_that_change_nothing_open_leave_what_is_kept():
    async def ask():
        titles = Titles()
        app = ETagMiddleware(titles)
        await request(app)
        for path in ("/api/marks", "/api/attempts/a", "/api/login"):
            await request(app, "POST", path)
        await request(app)
        assert titles.made == 1
        await request(app, "POST", "/api/sheets")  # a sheet's master may become a work
        await request(app)
        assert titles.made == 2

    run(ask())


@pytest.mark.parametrize(("caching", "made"), [(IMMUTABLE, 1), ("no-cache", 2)])
def test_only_a_file_that_never_changes_is_kept_for_longer(caching, made, monkeypatch):
    async def ask():
        length = (b"content-length", b"16")
        titles = Titles((b"etag", b'"a"'), (b"cache-control", caching.encode()), length)
        app = ETagMiddleware(titles)
        assert await request(app) == {"title": "old"}
        monkeypatch.setattr("time.monotonic", lambda: 1e9)
        assert await request(app) == {"title": "old"} and titles.made == made
        await request(app, "DELETE")
        assert await request(app) == {"title": "new"} and titles.made == made + 1

    run(ask())


@pytest.mark.parametrize("fails", [False, True])
def test_what_was_read_before_a_change_is_not_kept(fails):
    async def ask():
        titles = Titles()
        app = ETagMiddleware(titles)
        titles.let_go.clear()
        slow = asyncio.create_task(request(app))
        await asyncio.sleep(0)
        assert titles.made == 1  # it has read
        if fails:
            with pytest.raises(RuntimeError):
                await request(app, "PATCH", "/api/works/fails")
        else:
            await request(app, "PATCH")
        titles.let_go.set()
        assert await slow == {"title": "old"}  # it had been asked before
        assert await request(app) == {"title": "new"}

    run(ask())
