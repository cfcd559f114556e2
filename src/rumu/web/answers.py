"""Answers that a browser need not fetch twice: names for contents, and nothing sent where they are known."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

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


class Fresh:
    """Open JSON gets a name from its content, so that a list that has not changed is not sent again."""

    OPEN = ("/api/works", "/api/facets", "/api/collections", "/api/tours", "/iiif/", "/api/openapi.json")

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "GET" or not scope["path"].startswith(self.OPEN):
            await self._app(scope, receive, send)
            return
        held: list[Message] = []

        async def gathered(message: Message) -> None:
            if held or _nameable(message):
                held.append(message)
                if not message.get("more_body") and message["type"] == "http.response.body":
                    await _sent_once(held, Headers(scope=scope), send)
            else:
                await send(message)

        await self._app(scope, receive, gathered)


def _nameable(message: Message) -> bool:
    if message["type"] != "http.response.start" or message["status"] != 200:
        return False
    headers = Headers(raw=message["headers"])
    return "json" in headers.get("content-type", "") and "etag" not in headers


async def _sent_once(held: Sequence[Message], asked: Headers, send: Send) -> None:
    start, *parts = held
    body = b"".join(part.get("body", b"") for part in parts)
    tag = hashlib.sha256(body).hexdigest()[:20]
    more = [(b"etag", f'W/"{tag}"'.encode())]
    if "cache-control" not in Headers(raw=start["headers"]):
        more.append((b"cache-control", ASK_FIRST.encode()))
    if tag in _tags(asked.get("if-none-match", "")):
        kept = [pair for pair in start["headers"] if pair[0] not in (b"content-length", b"content-type")]
        await send({**start, "status": 304, "headers": [*kept, *more]})
        await send({"type": "http.response.body", "body": b""})
        return
    await send({**start, "headers": [*start["headers"], *more]})
    await send({"type": "http.response.body", "body": body})
