"""Caching of open responses: ETags for the clients, and responses kept in memory (RFC 9110 and 9111)."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

from cachetools import LRUCache
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.web.addresses import route_path
from rumu.web.responses import IMMUTABLE, REVALIDATE, requested_etags

_MAX_AGE = 1.0  # seconds; a list may be this old when another process has changed the gallery
_MAX_MEMORY = 64 * 2**20  # bytes of all responses
_MAX_BODY = 2**20  # bytes of one response that is kept
_HEAD = 2000  # bytes that a head takes, about


@dataclass(frozen=True, slots=True)
class _CachedResponse:
    """A response as it was sent. expires: on the monotonic clock. start: the ASGI message of its head."""

    expires: float
    start: Message
    body: bytes
    etag: str


class ETagMiddleware:
    """Gives open JSON an ETag made from its content, answers 304 if the client has it, and keeps responses.

    JSON stays in memory for a second, and files that never change for as long as there is room; both only
    until a request with another method than GET has been served. So a list, or a picture in it, which many
    clients request at once, is made once. What was read before such a request ended is not kept: it may be of
    before the change. Requests that change nothing open, such as the marks of a class at work, leave the
    responses where they are.
    """

    OPEN = (
        *("/api/works", "/api/facets", "/api/collections", "/api/tours", "/api/characters"),
        *("/iiif/", "/api/openapi.json"),
    )
    PRIVATE = (
        *("/api/marks", "/api/attempts", "/api/comparisons", "/api/photographs", "/api/classes"),
        *("/api/tasks", "/api/login", "/api/logout", "/api/session", "/api/password"),
        *("/api/invitations", "/api/people"),
    )
    """What these change, no open response tells of."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._responses: LRUCache[tuple[object, ...], _CachedResponse] = LRUCache(
            _MAX_MEMORY, getsizeof=lambda response: len(response.body) + _HEAD
        )
        self._changes = 0  # requests served that may have changed what is open

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        path = route_path(scope) if scope["type"] == "http" else ""
        if path == "" or path.startswith(self.PRIVATE):
            await self._app(scope, receive, send)
        elif scope["method"] != "GET":
            try:
                await self._app(scope, receive, send)
            finally:
                self._changes += 1
                self._responses.clear()
        elif path.startswith(self.OPEN):
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
            if not messages and not _is_kept(message):
                await send(message)
                return
            messages.append(message)
            if message["type"] == "http.response.body" and not message.get("more_body"):
                response = _response_of(messages)
                if self._changes == changes and len(response.body) <= _MAX_BODY:
                    self._responses[key] = response
                await _send_cached(response, headers, send)

        await self._app(scope, receive, collect)


def _is_kept(message: Message) -> bool:
    """Whether this is the head of JSON, which has no ETag yet, or of a file that never changes."""
    if message["type"] != "http.response.start" or message["status"] != 200:
        return False
    headers = Headers(raw=message["headers"])
    if "etag" not in headers:
        return "json" in headers.get("content-type", "")
    length = headers.get("content-length", "")
    return headers.get("cache-control") == IMMUTABLE and length.isdecimal() and int(length) <= _MAX_BODY


def _response_of(messages: Sequence[Message]) -> _CachedResponse:
    start, *rest = messages
    body = b"".join(message.get("body", b"") for message in rest)
    headers = Headers(raw=start["headers"])
    if "etag" in headers:
        return _CachedResponse(math.inf, start, body, headers["etag"].strip('"'))
    etag = hashlib.sha256(body).hexdigest()[:20]
    added = [(b"etag", f'W/"{etag}"'.encode())]
    if "cache-control" not in headers:
        added.append((b"cache-control", REVALIDATE.encode()))
    return _CachedResponse(
        time.monotonic() + _MAX_AGE, {**start, "headers": [*start["headers"], *added]}, body, etag
    )


async def _send_cached(response: _CachedResponse, request_headers: Headers, send: Send) -> None:
    start, body = response.start, response.body
    headers = list(start["headers"])  # middleware outside of this one adds to the list
    if response.etag in requested_etags(request_headers):
        of_body = (b"content-length", b"content-type", b"content-encoding")
        headers = [pair for pair in headers if pair[0] not in of_body]
        start, body = {**start, "status": 304}, b""
    await send({**start, "headers": headers})
    await send({"type": "http.response.body", "body": body})
