"""Caching of open JSON: ETags for the clients, and responses kept for a second (RFC 9110 and 9111)."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.web.addresses import route_path
from rumu.web.responses import REVALIDATE, requested_etags

_MAX_AGE = 1.0  # seconds; a list may be this old when another process has changed the gallery
_MAX_RESPONSES = 500
_MAX_BODY = 2**20  # bytes of one response that is kept in memory


@dataclass(frozen=True, slots=True)
class _CachedResponse:
    """A response as it was sent. expires: on the monotonic clock. start: the ASGI message of its head."""

    expires: float
    start: Message
    body: bytes
    etag: str


class ETagMiddleware:
    """Gives open JSON an ETag made from its content, and answers 304 if the client has it.

    Responses stay in memory for a second, or until a request with another method than GET has been served,
    so that a list which many clients request at once is made once. What was read before such a request ended
    is not kept: it may be of before the change.
    """

    OPEN = (
        *("/api/works", "/api/facets", "/api/collections", "/api/tours", "/api/characters"),
        *("/iiif/", "/api/openapi.json"),
    )

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._responses: dict[tuple[object, ...], _CachedResponse] = {}
        self._changes = 0  # requests served with another method than GET

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
        elif scope["method"] != "GET":
            try:
                await self._app(scope, receive, send)
            finally:
                self._changes += 1
                self._responses.clear()
        elif route_path(scope).startswith(self.OPEN):
            await self._get(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _get(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope)
        gzip = "gzip" in headers.get("accept-encoding", "")
        key = (scope["path"], scope["query_string"], gzip, headers.get("host"), scope["scheme"])
        cached = self._responses.get(key)
        if cached is not None and cached.expires > time.monotonic():
            await _send_cached(cached, headers, send)
            return
        messages: list[Message] = []
        changes = self._changes

        async def collect(message: Message) -> None:
            if not messages and not _needs_etag(message):
                await send(message)
                return
            messages.append(message)
            if message["type"] == "http.response.body" and not message.get("more_body"):
                response = _add_etag(messages)
                if self._changes == changes:
                    self._store(key, response)
                await _send_cached(response, headers, send)

        await self._app(scope, receive, collect)

    def _store(self, key: tuple[object, ...], response: _CachedResponse) -> None:
        if len(self._responses) >= _MAX_RESPONSES:
            self._responses.clear()
        if len(response.body) <= _MAX_BODY:
            self._responses[key] = response


def _needs_etag(message: Message) -> bool:
    if message["type"] != "http.response.start" or message["status"] != 200:
        return False
    headers = Headers(raw=message["headers"])
    return "json" in headers.get("content-type", "") and "etag" not in headers


def _add_etag(messages: Sequence[Message]) -> _CachedResponse:
    start, *rest = messages
    body = b"".join(message.get("body", b"") for message in rest)
    etag = hashlib.sha256(body).hexdigest()[:20]
    headers = [*start["headers"], (b"etag", f'W/"{etag}"'.encode())]
    if "cache-control" not in Headers(raw=headers):
        headers.append((b"cache-control", REVALIDATE.encode()))
    return _CachedResponse(time.monotonic() + _MAX_AGE, {**start, "headers": headers}, body, etag)


async def _send_cached(response: _CachedResponse, request_headers: Headers, send: Send) -> None:
    start, body = response.start, response.body
    headers = list(start["headers"])  # middleware outside of this one adds to the list
    if response.etag in requested_etags(request_headers):
        of_body = (b"content-length", b"content-type", b"content-encoding")
        headers = [pair for pair in headers if pair[0] not in of_body]
        start, body = {**start, "status": 304}, b""
    await send({**start, "headers": headers})
    await send({"type": "http.response.body", "body": body})
