"""Security middleware: session, CSRF token, size of the body and security headers of every request.

It is pure ASGI, so that a body is counted while it streams in, and a request is refused before it is read.
"""

from __future__ import annotations

from anyio.to_thread import run_sync
from fastapi import Response
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.studio.errors import NotAllowed, StudioError
from rumu.studio.tickets import Ticket
from rumu.web.error_handlers import LoginNeededError, error_response, studio_response
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
_CLOSE = {"Connection": "close"}  # the rest of the body is not read


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
            refusal = await self._refuse(connection, ticket)
        except StudioError as error:
            refusal = studio_response(error, _CLOSE)
        if refusal is not None:
            await refusal(scope, receive, send)
            return
        await self._app(scope, _limit_body(receive, self._max_body(scope["path"])), send)

    async def _refuse(self, connection: HTTPConnection, ticket: Ticket | None) -> Response | None:
        """The response to a request that the application must not see. Raises StudioError, too."""
        scope, headers, service = connection.scope, connection.headers, self._service
        service.rate_limiter.hit(service.settings.rate_limits.all, "all", client_address(connection))
        if scope["method"] in SAFE_METHODS:
            return None
        if ticket is None or not service.tickets.has_csrf_token(ticket, headers.get("x-csrf-token")):
            return error_response(
                403, "csrf", "頁面已過期，請重新載入。", "The page is out of date; load it again.", _CLOSE
            )
        if scope["method"] == "POST" and scope["path"] in _LARGE_UPLOADS:
            user = await run_sync(service.identify, ticket)
            if user is None:
                raise LoginNeededError
            if not user.teaches:
                raise NotAllowed
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > self._max_body(scope["path"]):
            return error_response(
                413, "too_large", "送來的資料太大。", "More was sent than is taken here.", _CLOSE
            )
        return None

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
