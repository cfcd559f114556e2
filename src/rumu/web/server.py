"""The server around the application: the address it listens on, its start and its end."""

from __future__ import annotations

import contextlib
import gc
import ipaddress
import socket
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from rumu.database.server_lock import lock_server
from rumu.errors import RumuError

if TYPE_CHECKING:
    import uvicorn
    from fastapi import FastAPI

    from rumu.web.service import Service
    from rumu.web.settings import ConnectionLimits, ServiceSettings

_THIS_MACHINE = "127.0.0.1,::1"
_SWITCH_INTERVAL = 0.001  # seconds that a thread computes before another may go on; Python's is 0.005


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
    from rumu.web.app import create_app
    from rumu.web.connections import GracefulServer

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
        _allow_open_files()
        server = GracefulServer(
            server_config(app, settings.connections, proxies=proxies), end_work=service.workers.stop
        )
        if on_ready is not None:
            threading.Thread(target=_wait_until_ready, args=(server, address, on_ready), daemon=True).start()
        threading.Thread(target=_spare_readers, args=(server, service), daemon=True).start()
        server.run(sockets=[listener])


def server_config(app: FastAPI, limits: ConnectionLimits, *, proxies: str | None = None) -> uvicorn.Config:
    """How uvicorn runs the application. proxies: as of `serve`."""
    import uvicorn

    from rumu.web.connections import Clients, GuardedProtocol

    trusted = proxies or _THIS_MACHINE
    protocol = partial(GuardedProtocol, limits=limits, clients=Clients(trusted))
    return uvicorn.Config(
        app,
        http=protocol,  # type: ignore[arg-type]  # uvicorn calls it as it calls a class
        log_level="warning",
        access_log=False,
        server_header=False,
        forwarded_allow_ips=trusted,
        timeout_graceful_shutdown=5,
        timeout_keep_alive=65,
    )


def _allow_open_files() -> None:
    """Allow as many open files, and so connections, as the system lets this process allow itself."""
    with contextlib.suppress(ImportError, OSError, ValueError):  # Windows has no such limit
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


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
    if _has_started(server):
        on_ready(address)


def _spare_readers(server: uvicorn.Server, service: Service) -> None:
    """Keep short what no page can be sent in: Python's own pauses.

    The thread that talks to the clients waits for others at every request. Collecting garbage stops all of
    them, for a tenth of a second or more where every object is looked at, and what is there once the service
    has started stays until its end.
    """
    sys.setswitchinterval(_SWITCH_INTERVAL)
    if _has_started(server):
        service.wait_until_started()
        gc.freeze()


def _has_started(server: uvicorn.Server) -> bool:
    """Wait until a server answers; False when it ends before."""
    while not server.started:
        if server.should_exit:
            return False
        time.sleep(0.05)
    return True
