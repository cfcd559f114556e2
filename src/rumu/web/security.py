"""Security middleware: session, CSRF token, size of the body and security headers of every request.

It is pure ASGI, so that a body is counted while it streams in, and a request is refused before it is read.
"""

from __future__ import annotations

from anyio.to_thread import run_sync
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.studio.errors import NotAllowed, StudioError
from rumu.studio.tickets import Ticket
from rumu.web.error_handlers import error_response
from rumu.web.service import Service

COOKIE = "rumu_session"
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
_LARGE_UPLOADS = ("/api/works", "/api/imports")  # by teachers only, who are known before the body is read


class SecurityMiddleware:
    """Wraps the whole application; routes find the session's ticket in the request's state."""

    def __init__(self, app: ASGIApp, *, service: Service) -> None:
        self._app, self._service = app, service

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        ticket = self._service.tickets.read(connection.cookies.get(COOKIE))
        scope.setdefault("state", {})["ticket"] = ticket
        send = _add_headers(send, is_api=scope["path"].startswith("/api/"))
        try:
            await self._check(connection, ticket)
        except (StudioError, HTTPException) as error:
            response = error_response(error)
            response.headers["Connection"] = "close"  # the rest of the body is not read
            await response(scope, receive, send)
        else:
            await self._app(scope, _limit_body(receive, self._max_body(scope["path"])), send)

    async def _check(self, connection: HTTPConnection, ticket: Ticket | None) -> None:
        """Raise the error of a request that the application must not see."""
        scope, headers, service = connection.scope, connection.headers, self._service
        service.rate_limiter.hit(service.settings.rate_limits.all, "all", client_address(connection))
        if scope["method"] in SAFE_METHODS:
            return
        if ticket is None or not service.tickets.has_csrf_token(ticket, headers.get("x-csrf-token")):
            raise HTTPException(403, "csrf")
        if scope["method"] == "POST" and scope["path"] in _LARGE_UPLOADS:
            user = await run_sync(service.identify, ticket)
            if user is None:
                raise HTTPException(401, "login")
            if not user.teaches:
                raise NotAllowed
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > self._max_body(scope["path"]):
            raise HTTPException(413, "too_large")

    def _max_body(self, path: str) -> int:
        limits = self._service.settings.body_limits
        sizes = {"/api/marks": limits.mark, "/api/works": limits.work, "/api/imports": limits.zip}
        return sizes.get(path, limits.default)


def client_address(connection: HTTPConnection) -> str:
    """The IP address of the client. uvicorn trusts the forwarding headers of this machine's proxy only."""
    return connection.client.host if connection.client else "unknown"


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


def _add_headers(send: Send, *, is_api: bool) -> Send:
    """`send` that adds the security headers to every response."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
            if is_api:  # a response that does not say it is public is for this client alone
                headers.setdefault("Cache-Control", "private, no-cache")
        await send(message)

    return send_with_headers
