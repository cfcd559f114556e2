"""Answers that a browser need not fetch twice: names for contents, and nothing sent where they are known."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass

from fastapi import Request, Response
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.web.files import Sent

FOR_EVER = "public, max-age=31536000, immutable"
ASK_FIRST = "no-cache"


def known_tag(request: Request) -> str | None:
    """The tag that the asker holds."""
    tags = _tags(request.headers.get("if-none-match", ""))
    return tags[0] if len(tags) == 1 else None


def file_answer(request: Request, sent: Sent, *, name: str | None = None, private: bool = False) -> Response:
    """A file, packed where both sides like it; 304 where the asker has it. name: to be saved as.

    One that is asked for with its version is the asker's for ever.
    """
    versioned = "v" in request.query_params and not private
    headers = {
        "ETag": f'"{sent.tag}"',
        "Cache-Control": FOR_EVER if versioned else f"private, {ASK_FIRST}" if private else ASK_FIRST,
        "Vary": "Accept-Encoding",
    }
    if sent.tag in _tags(request.headers.get("if-none-match", "")):
        return Response(status_code=304, headers=headers)
    if name is not None:
        headers["Content-Disposition"] = f'attachment; filename="{name}"'
    if sent.packed is not None and "gzip" in request.headers.get("accept-encoding", ""):
        return Response(
            sent.packed, media_type=sent.media_type, headers=headers | {"Content-Encoding": "gzip"}
        )
    return Response(sent.data, media_type=sent.media_type, headers=headers)


def _tags(text: str) -> Sequence[str]:
    return [tag.strip().removeprefix("W/").strip('"') for tag in text.split(",")]


_LASTS = 1.0  # seconds: as old as an open list may be where another process changed the gallery
_MOST = 500  # answers in memory
_LARGEST = 2**20


@dataclass(frozen=True, slots=True)
class _Held:
    """An answer as it went out."""

    until: float
    start: Message
    body: bytes
    tag: str


class Fresh:
    """Open JSON gets a name from its content, so that a list that has not changed is not sent again.

    What many ask for at once is made once: it stays for a second, or until something is changed here.
    """

    OPEN = ("/api/works", "/api/facets", "/api/collections", "/api/tours", "/iiif/", "/api/openapi.json")

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._held: dict[tuple[object, ...], _Held] = {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
        elif scope["method"] != "GET":
            await self._app(scope, receive, send)
            self._held.clear()
        elif scope["path"].startswith(self.OPEN):
            await self._open(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _open(self, scope: Scope, receive: Receive, send: Send) -> None:
        asked = Headers(scope=scope)
        packed = "gzip" in asked.get("accept-encoding", "")
        key = (scope["path"], scope["query_string"], packed, asked.get("host"), scope["scheme"])
        held = self._held.get(key)
        if held is not None and held.until > time.monotonic():
            await _sent_once(held, asked, send)
            return
        parts: list[Message] = []

        async def gathered(message: Message) -> None:
            if parts or _nameable(message):
                parts.append(message)
                if not message.get("more_body") and message["type"] == "http.response.body":
                    made = _named(parts)
                    self._keep(key, made)
                    await _sent_once(made, asked, send)
            else:
                await send(message)

        await self._app(scope, receive, gathered)

    def _keep(self, key: tuple[object, ...], made: _Held) -> None:
        if len(self._held) >= _MOST:
            self._held.clear()
        if len(made.body) <= _LARGEST:
            self._held[key] = made


def _nameable(message: Message) -> bool:
    if message["type"] != "http.response.start" or message["status"] != 200:
        return False
    headers = Headers(raw=message["headers"])
    return "json" in headers.get("content-type", "") and "etag" not in headers


def _named(parts: Sequence[Message]) -> _Held:
    start, *rest = parts
    body = b"".join(part.get("body", b"") for part in rest)
    tag = hashlib.sha256(body).hexdigest()[:20]
    more = [(b"etag", f'W/"{tag}"'.encode())]
    if "cache-control" not in Headers(raw=start["headers"]):
        more.append((b"cache-control", ASK_FIRST.encode()))
    named = {**start, "headers": [*start["headers"], *more]}
    return _Held(time.monotonic() + _LASTS, named, body, tag)


async def _sent_once(held: _Held, asked: Headers, send: Send) -> None:
    start, body = held.start, held.body
    headers = list(start["headers"])  # others may add to theirs
    if held.tag in _tags(asked.get("if-none-match", "")):
        of_body = (b"content-length", b"content-type", b"content-encoding")
        headers = [pair for pair in headers if pair[0] not in of_body]
        start, body = {**start, "status": 304}, b""
    await send({**start, "headers": headers})
    await send({"type": "http.response.body", "body": body})
