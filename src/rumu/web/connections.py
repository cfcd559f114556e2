"""Connections that hold a place without using it are ended: slow heads, slow bodies, readers that stopped.

uvicorn has a time limit between requests, and none within one. This protocol adds them, below the
application, because a request whose head never ends never reaches it. At the server's end what takes long is
ended before uvicorn would cut it off.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import json
import socket
import struct
import threading
from asyncio import Transport
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any, Literal

import uvicorn
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol, RequestResponseCycle

from rumu.web.settings import ConnectionLimits

_CHECK_INTERVAL = 1.0  # seconds between two looks at a connection
_REFUSALS: Mapping[int, tuple[str, str, str]] = {
    400: ("bad_request", "請求的格式不對。", "The request is malformed."),
    408: ("timeout", "請求來得太慢，已經中斷。", "The request came too slowly and was ended."),
    431: ("head_too_large", "請求的標頭太大。", "The head of the request is too large."),
    503: ("busy", "同一部電腦開了太多連線。", "There are too many connections from one address."),
}


class GracefulServer(uvicorn.Server):
    """A server that lets no request be cut off at its end, as long as its work can be ended.

    end_work: called in a thread at half of the time that requests are given; whoever waits for that work then
    answers that the service is busy.
    """

    def __init__(self, config: uvicorn.Config, *, end_work: Callable[[], object]) -> None:
        super().__init__(config)
        self._end_work = end_work

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Answer the open requests, and stop."""
        grace = self.config.timeout_graceful_shutdown or 0
        ending = threading.Thread(target=self._end_work, daemon=True)
        half_way = asyncio.get_running_loop().call_later(grace / 2, ending.start)
        try:
            await super().shutdown(sockets)
        finally:
            half_way.cancel()


class Clients:
    """The open connections of each address. proxies: whose connections are those of many clients."""

    def __init__(self, proxies: str) -> None:
        self._open: defaultdict[str, dict[GuardedProtocol, None]] = defaultdict(dict)  # the oldest first
        words = [word.strip() for word in proxies.split(",")]
        self._all_trusted = "*" in words
        self._trusted = [ipaddress.ip_network(word, strict=False) for word in words if _is_network(word)]

    def add(self, connection: GuardedProtocol, address: str, limit: int) -> bool:
        """Take a connection in; whether there is room for it.

        Beyond the limit the connection that has waited longest for a request makes room. Where all are
        busy there is none, except for a proxy.
        """
        others = self._open[address]
        others[connection] = None
        waiting = [one for one in others if one is not connection and one.waits]
        if len(others) > limit and waiting:
            min(waiting, key=lambda one: one.since).end()
            return True
        return len(others) <= limit or self._all_trusted or self._is_proxy(address)

    def remove(self, connection: GuardedProtocol, address: str) -> None:
        """Forget a connection that has ended."""
        self._open[address].pop(connection, None)
        if not self._open[address]:
            del self._open[address]

    def _is_proxy(self, address: str) -> bool:
        return _is_network(address) and any(ipaddress.ip_address(address) in one for one in self._trusted)


def _is_network(word: str) -> bool:
    try:
        ipaddress.ip_network(word, strict=False)
    except ValueError:
        return False
    return True


class GuardedProtocol(HttpToolsProtocol):
    """uvicorn's HTTP/1.1, ended when a client is too slow.

    since: when the present phase began, on the loop's clock.
    """

    def __init__(self, *arguments: Any, limits: ConnectionLimits, clients: Clients, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._limits, self._clients = limits, clients
        self._phase: Literal["idle", "head", "body", "response", "ended"] = "head"
        self.since = self.loop.time()
        self._head_bytes = self._body_bytes = 0
        self._unsent, self._unsent_since = 0, self.since
        self._answered: RequestResponseCycle | None = None

    @property
    def waits(self) -> bool:
        """Whether there is no complete request."""
        return self._phase in ("idle", "head")

    def connection_made(self, transport: Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._address = self.client[0] if self.client else ""
        self.loop.call_later(_CHECK_INTERVAL, self._check)
        if not self._clients.add(self, self._address, self._limits.per_client):
            self.end(503)

    def connection_lost(self, exc: Exception | None) -> None:
        self._phase = "ended"
        if self._answered is not None:  # of pipelined requests, uvicorn tells the last one alone
            self._answered.disconnected = True
        self.pipeline.clear()
        self._clients.remove(self, self._address)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if self._phase == "ended":
            return
        self._head_bytes += len(data) if self.waits else 0
        super().data_received(data)
        if self._phase == "head" and self._head_bytes > self._limits.head_bytes:
            self.end(431)

    def on_message_begin(self) -> None:
        super().on_message_begin()
        if self._phase not in ("head", "ended"):  # a connection's first request is counted from its start
            self._begin("head")

    def on_headers_complete(self) -> None:
        if sum(len(name) + len(value) for name, value in self.headers) > self._limits.head_bytes:
            self.end(431)
            return
        self._begin("body")
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        if self._phase != "ended":
            self._body_bytes += len(body)
            super().on_body(body)

    def on_message_complete(self) -> None:
        if self._phase != "ended":
            self._begin("response")
            super().on_message_complete()

    def on_response_complete(self) -> None:
        if not self.pipeline and self._phase == "response":
            self._begin("idle")
        super().on_response_complete()

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: Any) -> None:
        self._answered = cycle
        super()._start_asgi_task(cycle, app)

    def send_400_response(self, msg: str) -> None:
        self.end(400)

    def end(self, status: int | None = None) -> None:
        """Close the connection. status: said first, unless a response is on its way."""
        answering = (
            self.cycle is not None and not self.cycle.response_complete and self.cycle.response_started
        )
        self._phase = "ended"
        if self.transport.is_closing():
            return
        if status is not None and not answering:
            self.transport.write(_refusal(status))
        self.transport.close()

    def _begin(self, phase: Literal["idle", "head", "body", "response"]) -> None:
        self._phase, self.since = phase, self.loop.time()
        self._head_bytes = self._body_bytes = 0

    def _check(self) -> None:
        """Look at the connection, every second until it is lost."""
        if self not in self.connections:
            return
        self.loop.call_later(_CHECK_INTERVAL, self._check)
        now, limits = self.loop.time(), self._limits
        if self._phase == "body" and self.flow.read_paused:  # it is the application that waits
            self.since += _CHECK_INTERVAL
        seconds = now - self.since
        slow_body = seconds > limits.body_seconds and self._body_bytes < limits.body_rate * seconds
        if (self._phase == "head" and seconds > limits.head_seconds) or (self._phase == "body" and slow_body):
            self.end(408)
        unsent = self.transport.get_write_buffer_size()
        if unsent != self._unsent or unsent == 0:
            self._unsent, self._unsent_since = unsent, now
        elif now - self._unsent_since > limits.write_seconds:
            self._abort()

    def _abort(self) -> None:
        """End the connection and drop what is unsent, which the system would keep for its client."""
        with contextlib.suppress(OSError, AttributeError):
            linger = struct.pack("ii", 1, 0)
            self.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        self.transport.abort()


def _refusal(status: int) -> bytes:
    code, zh, en = _REFUSALS[status]
    body = json.dumps({"error": {"code": code, "zh": zh, "en": en}}, ensure_ascii=False).encode()
    lines = (
        "content-type: application/json",
        f"content-length: {len(body)}",
        "x-content-type-options: nosniff",
        "cross-origin-resource-policy: same-origin",
        "connection: close",
    )
    return STATUS_LINE[status] + "".join(f"{line}\r\n" for line in lines).encode() + b"\r\n" + body
