"""HEAD and OPTIONS of every address, and what pages of other sites may read (CORS and CORP)."""

from __future__ import annotations

import re

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rumu.web.addresses import route_path

_OPEN = re.compile(r"/iiif/.*|/api/works/[^/]+/files/[^/]+")
_METHODS = "GET, HEAD, OPTIONS"
_READABLE = "Cache-Control, Content-Disposition, Content-Length, Content-Type, ETag, Link, Retry-After"
_SENDABLE = "Accept, Accept-Language, Cache-Control, Content-Type, If-Modified-Since, If-None-Match, Range"
_PREFLIGHT_SECONDS = 86400  # that a browser remembers what it may send


def cross_origin_headers(path: str) -> dict[str, str]:
    """The headers by which other sites may use what is at a path: IIIF and files of works, and no more."""
    if not _OPEN.fullmatch(path):
        return {"Cross-Origin-Resource-Policy": "same-origin"}
    return {
        "Cross-Origin-Resource-Policy": "cross-origin",
        "Access-Control-Allow-Origin": "*",
        "Access-Control-Expose-Headers": _READABLE,
    }


class MethodsMiddleware:
    """Answers HEAD as GET without the body, and OPTIONS where other sites may read."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and scope["method"] == "HEAD":
            await self._head(scope, receive, send)
        elif scope["type"] == "http" and scope["method"] == "OPTIONS" and _OPEN.fullmatch(route_path(scope)):
            await _options(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _head(self, scope: Scope, receive: Receive, send: Send) -> None:
        started = False

        async def send_head(message: Message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                await send(message)
                await send({"type": "http.response.body", "body": b""})

        async def receive_until_started() -> Message:  # a stream of events ends when its client has gone
            return {"type": "http.disconnect"} if started else await receive()

        await self._app({**scope, "method": "GET"}, receive_until_started, send_head)


async def _options(scope: Scope, receive: Receive, send: Send) -> None:
    wanted = Headers(scope=scope).get("access-control-request-headers")
    headers = {
        "Allow": _METHODS,
        "Access-Control-Allow-Methods": _METHODS,
        "Access-Control-Allow-Headers": wanted or _SENDABLE,
        "Access-Control-Max-Age": str(_PREFLIGHT_SECONDS),
        "Vary": "Access-Control-Request-Headers",
    }
    await Response(status_code=204, headers=headers)(scope, receive, send)
