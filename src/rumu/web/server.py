"""The server around the application: the address it listens on, its start and its end."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rumu.database.server_lock import lock_server
from rumu.errors import RumuError

if TYPE_CHECKING:
    import uvicorn

    from rumu.web.settings import ServiceSettings


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """url: of the gallery. owner_link: for the first owner, None when there is one."""

    url: str
    owner_link: str | None


def serve(
    settings: ServiceSettings,
    *,
    host: str,
    port: int,
    on_listen: Callable[[ServerAddress], object],
    on_ready: Callable[[ServerAddress], object] | None = None,
    proxies: str | None = None,
) -> None:
    """Serve until Ctrl-C or SIGTERM. port: 0 for any that is free.

    proxies: addresses, separated by commas, whose X-Forwarded headers are believed; None for this machine.

    on_listen: called once the port is ours. on_ready: called, in a thread, once requests are answered.
    Raises RumuError when the port is taken, when another server works on the database, or when others could
    reach a service that has no owner yet.
    """
    import uvicorn

    from rumu.web.app import create_app

    listener = listen(host, port)
    with contextlib.closing(listener), lock_server(settings.storage.database) as lock:
        app = create_app(settings, lock=lock)
        service = app.state.service
        if not is_loopback(host) and not service.has_owner():
            raise RumuError(
                f"cannot listen on {host} until the service has an owner: "
                "run rumu serve without --host once, open the link that it prints and choose a name"
            )
        name = f"[{host}]" if ":" in host else host
        url = f"http://{name}:{listener.getsockname()[1]}{settings.root_path}"
        link = service.owner_link()
        address = ServerAddress(f"{url}/", link and f"{url}{link}")
        on_listen(address)
        server = uvicorn.Server(
            uvicorn.Config(
                app,
                log_level="warning",
                access_log=False,
                server_header=False,
                forwarded_allow_ips=proxies,
                timeout_graceful_shutdown=5,
                timeout_keep_alive=65,
            )
        )
        if on_ready is not None:
            threading.Thread(target=_wait_until_ready, args=(server, address, on_ready), daemon=True).start()
        server.run(sockets=[listener])


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens. Raises RumuError when the address cannot be used."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # asyncio sets TCP_NODELAY only if the protocol is named; else Nagle's algorithm delays small responses
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(512)
    except (OSError, OverflowError) as error:
        listener.close()
        why = getattr(error, "strerror", None) or error
        raise RumuError(f"cannot listen on {host}:{port} ({why}); try another --port") from error
    return listener


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _wait_until_ready(
    server: uvicorn.Server, address: ServerAddress, on_ready: Callable[[ServerAddress], object]
) -> None:
    while not server.started:
        if server.should_exit:
            return
        time.sleep(0.05)
    on_ready(address)
