"""Security middleware: session, CSRF token, size of the body and security headers of every request.

It is pure ASGI, so that a body is counted while it streams in, and a request is refused before it is read.
"""

from __future__ import annotations

import logging
import re
from collections import Counter

from anyio.to_thread import run_sync
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.studio.errors import Busy, NotAllowed
from rumu.studio.tickets import Ticket
from rumu.web.addresses import SessionCookie, client_address, is_from_another_site, route_path
from rumu.web.error_handlers import error_response
from rumu.web.methods import cross_origin_headers
from rumu.web.service import Service

_log = logging.getLogger(__name__)
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
CONTENT_SECURITY_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self'; script-src 'self'; "
    "connect-src 'self'; "
    "worker-src 'self' blob:; object-src 'none'; base-uri 'none'; frame-ancestors 'self'; form-action 'self'"
)
SECURITY_HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Permissions-Policy": "camera=(self), microphone=(), geolocation=(), payment=(), usb=()",
    "Cross-Origin-Opener-Policy": "same-origin",
}
_SHEETS_OF_CLASS = re.compile(r"/api/classes/[^/]+/sheets")
_LARGE_UPLOADS = re.compile(rf"/api/works|/api/pages|/api/imports|{_SHEETS_OF_CLASS.pattern}")
"""By teachers only, who are known before the body is read."""


_HSTS = "max-age=31536000"  # a year, for this host alone: others of its domain may be without HTTPS


class SecurityMiddleware:
    """Wraps the whole application; routes find the session's tickets in the request's state."""

    def __init__(self, app: ASGIApp, *, service: Service) -> None:
        self._app, self._service = app, service
        self._at_once: Counter[str] = Counter()  # requests of each client that are being answered

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        client = client_address(HTTPConnection(scope))
        self._at_once[client] += 1
        try:
            await self._answer(scope, receive, send, at_once=self._at_once[client])
        finally:
            self._at_once[client] -= 1
            if self._at_once[client] == 0:
                del self._at_once[client]

    async def _answer(self, scope: Scope, receive: Receive, send: Send, *, at_once: int) -> None:
        path = route_path(scope)
        started = False

        async def send_and_note(message: Message) -> None:
            nonlocal started
            started = True
            await send(message)

        send_safely = _add_headers(send_and_note, path, is_https=scope["scheme"] == "https")
        try:
            if at_once > self._service.settings.connections.per_client:
                raise Busy
            tickets = await self._check(HTTPConnection(scope))
        except Exception as error:
            response = error_response(error)
            if response.status_code == 500:
                _log.exception("%s %s", scope["method"], scope["path"])
            response.headers["Connection"] = "close"  # the rest of the body is not read
            await response(scope, receive, send_safely)
            return
        scope.setdefault("state", {})["tickets"] = tickets
        try:
            await self._app(scope, _limit_body(receive, self._max_body(path)), send_safely)
        except Exception as error:  # an error that routes expect was answered further in
            if started:
                raise
            _log.exception("%s %s", scope["method"], scope["path"])
            await error_response(error)(scope, receive, send_safely)

    async def _check(self, connection: HTTPConnection) -> list[Ticket]:
        """The tickets of a request; the cookie of another path of the host may have brought some.

        Raises the error of a request that the application must not see.
        """
        headers, service = connection.headers, self._service
        method, path = connection.scope["method"], route_path(connection.scope)
        service.rate_limiter.hit(service.settings.rate_limits.all, "all", client_address(connection))
        tickets = self._read_tickets(connection)
        if method in SAFE_METHODS:
            return tickets
        if is_from_another_site(connection):
            raise HTTPException(403, "origin")
        token = headers.get("x-csrf-token")
        tickets = [ticket for ticket in tickets if service.tickets.has_csrf_token(ticket, token)]
        if not tickets:
            raise HTTPException(403, "csrf")
        if method == "POST" and _LARGE_UPLOADS.fullmatch(path):
            session = await run_sync(service.identify, tickets)
            if session is None:
                raise HTTPException(401, "login")
            if not session.user.teaches:
                raise NotAllowed
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > self._max_body(path):
            raise HTTPException(413, "too_large")
        return tickets

    def _read_tickets(self, connection: HTTPConnection) -> list[Ticket]:
        tickets = self._service.tickets
        cookie = SessionCookie.of(connection, tickets.fingerprint)
        return [ticket for text in cookie.values(connection) if (ticket := tickets.read(text)) is not None]

    def _max_body(self, path: str) -> int:
        limits = self._service.settings.body_limits
        sizes = {"/api/marks": limits.mark, "/api/works": limits.work, "/api/pages": limits.work}
        sizes |= {"/api/photographs": limits.mark, "/api/photographs/cell": limits.mark}
        sizes |= {"/api/sheets": limits.sheet, "/api/imports": limits.zip}
        if _SHEETS_OF_CLASS.fullmatch(path):
            return limits.zip
        return sizes.get(path, limits.default)


def _limit_body(receive: Receive, max_bytes: int) -> Receive:
    """`receive` that raises when more bytes arrive than are allowed, whatever the headers announced."""
    received = 0

    async def limited() -> Message:
        nonlocal received
        message = await receive()
        if message["type"] == "http.request":
            received += len(message.get("body", b""))
            if received > max_bytes:
                raise HTTPException(413, "too_large")
        return message

    return limited


def _add_headers(send: Send, path: str, *, is_https: bool) -> Send:
    """`send` that adds the security headers to every response."""
    added = SECURITY_HEADERS | cross_origin_headers(path)
    if is_https:
        added["Strict-Transport-Security"] = _HSTS
    if path.startswith("/api/"):  # a response that does not say it is public is for this client alone
        added["Cache-Control"] = "private, no-cache"

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in added.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers
