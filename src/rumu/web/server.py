"""The server around the application: where it listens, what it says when it does, how it ends."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rumu.errors import RumuError

if TYPE_CHECKING:
    import uvicorn

    from rumu.web.settings import ServiceSettings


@dataclass(frozen=True, slots=True)
class Listening:
    """url: of the gallery. owner_link: for the first owner, None when there is one."""

    url: str
    owner_link: str | None


def serve(
    settings: ServiceSettings,
    *,
    host: str,
    port: int,
    says: Callable[[Listening], object],
    ready: Callable[[Listening], object] | None = None,
) -> None:
    """Serve until Ctrl-C or SIGTERM. port: 0 for any that is free.

    says: called once the port is ours. ready: called, in a thread, once the first request would be answered.
    Raises RumuError when the port is taken, or when others could reach a service that has no owner yet.
    """
    import uvicorn

    from rumu.web.app import create_app

    taken = listen(host, port)
    with contextlib.closing(taken):
        app = create_app(settings)
        service = app.state.service
        if not is_loopback(host) and not service.has_owner():
            raise RumuError(
                f"expected an owner before others can reach this ({host}): "
                "run rumu serve without --host once, open the link that it prints and choose a name"
            )
        name = f"[{host}]" if ":" in host else host
        url = f"http://{name}:{taken.getsockname()[1]}"
        link = service.owner_link()
        listening = Listening(f"{url}/", link and f"{url}{link}")
        says(listening)
        server = uvicorn.Server(
            uvicorn.Config(
                app, log_level="warning", access_log=False, timeout_graceful_shutdown=5, timeout_keep_alive=65
            )
        )
        if ready is not None:
            threading.Thread(target=_when_ready, args=(server, listening, ready), daemon=True).start()
        server.run(sockets=[taken])


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens. Raises RumuError when it cannot be had."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # asyncio sends small answers at once only where the socket says TCP; else each waits 40 ms for an echo
    taken = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind((host, port))
        taken.listen(512)
    except (OSError, OverflowError) as error:
        taken.close()
        why = getattr(error, "strerror", None) or error
        raise RumuError(f"{host}:{port}: cannot be listened on ({why}); try another --port") from error
    return taken


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches it."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _when_ready(server: uvicorn.Server, listening: Listening, ready: Callable[[Listening], object]) -> None:
    while not server.started:
        if server.should_exit:
            return
        time.sleep(0.05)
    ready(listening)
