"""Before anything is read of a request: who asks, whether a page of ours made them ask, and how much they
may send.

Pure ASGI, so that a body is counted as it streams in and a refusal costs nothing.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any

from anyio.to_thread import run_sync
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.studio.tickets import Ticket
from rumu.web.rate_limits import TooOften
from rumu.web.service import Service

COOKIE = "rumu_session"
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self'; script-src 'self'; "
    "connect-src 'self'; "
    "worker-src 'self' blob:; object-src 'none'; base-uri 'none'; frame-ancestors 'self'; form-action 'self'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Permissions-Policy": "camera=(self), microphone=(), geolocation=(), payment=(), usb=()",
    "Cross-Origin-Opener-Policy": "same-origin",
}
_BIG = ("/api/works", "/api/imports")  # what teachers send; the rest is small


class Guard:
    """Around the whole application."""

    def __init__(self, app: ASGIApp, *, service: Service) -> None:
        self._app, self._service = app, service

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        ticket = self._service.tickets.read(_cookie(headers))
        scope.setdefault("state", {})["ticket"] = ticket
        answer = _with_headers(send, of_api=scope["path"].startswith("/api/"))
        refused = self._too_often(scope) or await self._refused(scope, headers, ticket)
        if refused is not None:
            await refused.send(answer)
            return
        await self._app(scope, _bounded(receive, self._most(scope["path"])), answer)

    def _too_often(self, scope: Scope) -> Refused | None:
        try:
            self._service.rates.count(self._service.settings.rates.all, "all", address(scope))
        except TooOften as error:
            return Refused(429, error.code, error.zh, error.en, {"Retry-After": str(error.seconds)})
        return None

    async def _refused(self, scope: Scope, headers: Headers, ticket: Ticket | None) -> Refused | None:
        if scope["method"] in SAFE:
            return None
        if ticket is None or not self._service.tickets.says(ticket, headers.get("x-csrf-token")):
            return Refused(403, "csrf", "頁面已過期，請重新載入。", "The page is out of date; load it again.")
        if scope["method"] == "POST" and scope["path"] in _BIG:
            who = await run_sync(self._service.who, ticket)
            if who is None:
                return Refused(401, "login", "請先登入。", "Log in first.")
            if not who.teaches:
                return Refused(403, "not_allowed", "您沒有這個權限。", "You may not do this.")
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > self._most(scope["path"]):
            return Refused(413, "too_large", "送來的資料太大。", "More was sent than is taken here.")
        return None

    def _most(self, path: str) -> int:
        bodies = self._service.settings.bodies
        sizes = {"/api/marks": bodies.mark, "/api/works": bodies.work, "/api/imports": bodies.zip}
        return sizes.get(path, bodies.usual)


@dataclass(frozen=True, slots=True)
class Refused:
    """An answer that needs no application."""

    status: int
    code: str
    zh: str
    en: str
    headers: dict[str, str] | None = None

    async def send(self, send: Send) -> None:
        body = json.dumps({"error": {"code": self.code, "zh": self.zh, "en": self.en}}, ensure_ascii=False)
        headers = {"content-type": "application/json", "connection": "close"} | (self.headers or {})
        raw = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
        await send({"type": "http.response.start", "status": self.status, "headers": raw})
        await send({"type": "http.response.body", "body": body.encode()})


def address(scope: Scope) -> str:
    """Where a request comes from, as uvicorn tells it; proxies other than this machine are not believed."""
    client = scope.get("client")
    return str(client[0]) if client else "unknown"


def _cookie(headers: Headers) -> str | None:
    held = SimpleCookie()
    try:
        held.load(headers.get("cookie", ""))
    except CookieError:
        return None
    return held[COOKIE].value if COOKIE in held else None


def _bounded(receive: Receive, most: int) -> Receive:
    """`receive` that stops when more comes than was announced or is allowed."""
    came = 0

    async def counted() -> Message:
        nonlocal came
        message = await receive()
        if message["type"] == "http.request":
            came += len(message.get("body", b""))
            if came > most:
                raise HTTPException(413, "too_large")
        return message

    return counted


def _with_headers(send: Send, *, of_api: bool) -> Send:
    async def sent(message: Any) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
            if of_api:  # what is not said to be open is for who asked alone
                headers.setdefault("Cache-Control", "private, no-cache")
        await send(message)

    return sent
