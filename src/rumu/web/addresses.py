"""Where the service is reached: its path on the host, its URLs, its clients, and its cookie."""

from __future__ import annotations

import re
from contextvars import ContextVar
from dataclasses import dataclass
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from rumu.errors import RumuError

COOKIE = "rumu_session"
_ROOT: ContextVar[str] = ContextVar("root_path", default="")
_ROOT_PATH = re.compile(r"(/[A-Za-z0-9_~-][A-Za-z0-9._~-]*)*")
_OWN_PATHS = ("api", "iiif", "assets")
_PORTS = {"http": 80, "https": 443}
_MAX_COOKIES = 20  # of our name that are tried; other paths of the host may have set some


def check_root_path(path: str) -> str:
    """The path of the service on its host as '/calligraphy', or '' for none. Raises RumuError."""
    root = "/" + path.strip("/") if path.strip("/") else ""
    if not _ROOT_PATH.fullmatch(root) or root.split("/")[1:2] in ([name] for name in _OWN_PATHS):
        raise RumuError(
            f"expected a path such as /calligraphy, of letters, digits and . _ ~ -, "
            f"that does not begin with {', '.join(f'/{name}' for name in _OWN_PATHS)}; got {path!r}"
        )
    return root


def service_url(path: str) -> str:
    """The URL of a path of the service, as a browser on the same host reaches it."""
    return _ROOT.get() + path


def base_url(connection: HTTPConnection) -> str:
    """The service's address as the client wrote it, without a slash at its end; paths are appended to it."""
    return str(connection.base_url).rstrip("/")


def route_path(scope: Scope) -> str:
    """The path of a request within the service."""
    path: str = scope["path"]
    return path.removeprefix(scope.get("root_path", ""))


def client_address(connection: HTTPConnection) -> str:
    """The IP address of the client. uvicorn trusts the forwarding headers of the named proxies only."""
    return connection.client.host if connection.client else "unknown"


class AddressMiddleware:
    """Sets the root path and the scheme of requests that came through a proxy.

    root_path: as `check_root_path` returns it. A proxy may take it off the path or leave it there.
    https: whether clients use HTTPS, whatever the proxy says.
    """

    def __init__(self, app: ASGIApp, *, root_path: str, https: bool) -> None:
        self._app, self._root, self._https = app, root_path, https

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            _ROOT.set(self._root)
            path: str = scope["path"]
            scope = {**scope, "root_path": self._root}
            if path != self._root and not path.startswith(f"{self._root}/"):
                scope["path"] = self._root + path
                scope["raw_path"] = self._root.encode() + scope.get("raw_path", b"")
            if self._https:
                scope["scheme"] = "https"
        await self._app(scope, receive, send)


@dataclass(frozen=True, slots=True)
class SessionCookie:
    """The cookie of a session as a request may send it, and a response sets it."""

    name: str
    path: str
    secure: bool

    @staticmethod
    def of(connection: HTTPConnection, fingerprint: str) -> SessionCookie:
        """The cookie for the address by which a client reaches the service.

        fingerprint: of the service, because another one on this host, at another port, shares the cookies.
        With HTTPS the name has a prefix by which browsers let no other host or path set it.
        """
        root = connection.scope.get("root_path", "")
        secure = connection.scope["scheme"] == "https"
        prefix = "" if not secure else "__Secure-" if root else "__Host-"
        return SessionCookie(f"{prefix}{COOKIE}_{fingerprint}", f"{root}/", secure)

    def values(self, connection: HTTPConnection) -> list[str]:
        """Every value that the request has for this cookie, in order, whatever else is among its cookies."""
        pairs = (pair for header in connection.headers.getlist("cookie") for pair in header.split(";"))
        split = (pair.partition("=") for pair in pairs)
        return [value.strip().strip('"') for name, _, value in split if name.strip() == self.name][
            :_MAX_COOKIES
        ]


def is_from_another_site(connection: HTTPConnection) -> bool:
    """Whether a browser says that a page of another site makes this request."""
    site, origin = connection.headers.get("sec-fetch-site"), connection.headers.get("origin")
    if site in ("cross-site", "same-site"):
        return True
    if origin is None or site == "same-origin":  # a program, or a browser that compared them itself
        return False
    try:
        of_page = urlsplit(origin)
        # behind a proxy that does not say so, the scheme of the request may be http
        of_host = urlsplit(f"//{connection.headers.get('host', '')}")
        default = _PORTS.get(of_page.scheme)
        secure = connection.scope["scheme"] == "https"
        return (
            default is None
            or (secure and of_page.scheme != "https")
            or of_page.hostname is None
            or (of_page.hostname, of_page.port or default) != (of_host.hostname, of_host.port or default)
        )
    except ValueError:
        return True
