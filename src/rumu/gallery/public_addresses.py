"""Which web addresses may be fetched for somebody: those of public machines, and of no others.

An address that a person or a manifest names may lead to a machine of the inner network, by its name or by a
redirect. So a name is resolved once, every address that it has is checked, and the connection goes to the
address that was checked, whatever the name means a moment later.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import urlsplit

from rumu.errors import GalleryError

Resolve = Callable[[str, int], list[str]]
"""The addresses of a host, as text."""


@dataclass(frozen=True, slots=True)
class Destination:
    """Where a request goes.

    host: as the URL names it, in ASCII and without a port; named: with the port, where the URL has one.
    address: of the machine, as text.
    """

    host: str
    port: int
    address: str
    named: str


def resolve_name(host: str, port: int) -> list[str]:
    """The addresses of a host. Raises OSError when it has none."""
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    return list(dict.fromkeys(str(one[4][0]) for one in found))


def destination(url: str, *, private: bool = False, resolve: Resolve = resolve_name) -> Destination:
    """The machine that a URL leads to.

    private: machines of the inner network and this one are allowed, too. Raises RefusedAddress for another
    scheme than http and https, and a host with any address that is not public; UnknownHost for one that
    cannot be found.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if host is None or parts.scheme not in ("http", "https") or parts.username is not None:
        raise RefusedAddress(
            f"expected an address http://... or https://..., got {url!r:.200}",
            zh="網址要以 http:// 或 https:// 開頭。",
        )
    told, port = port, port or (443 if parts.scheme == "https" else 80)
    try:
        host = host if host.isascii() else host.encode("idna").decode("ascii")
        addresses = resolve(host, port)
    except (OSError, UnicodeError) as error:
        raise UnknownHost(host) from error
    if not addresses:
        raise UnknownHost(host)
    if not private and not all(map(is_public, addresses)):
        raise RefusedAddress(
            f"{host}: expected a public machine, got one of the inner network",
            zh=f"{host} 是內部網路的機器，不能從那裡取得。",
        )
    name = f"[{host}]" if ":" in host else host
    return Destination(host, port, addresses[0], name if told is None else f"{name}:{told}")


def is_public(address: str) -> bool:
    """Whether an address is one of the open internet."""
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return False
    if isinstance(ip, ipaddress.IPv6Address):
        within = ip.ipv4_mapped or ip.sixtofour or (ip.teredo[1] if ip.teredo else None)
        if within is not None:
            return is_public(str(within))
        if ip in _NAT64:
            return is_public(str(ipaddress.IPv4Address(int(ip) & 0xFFFFFFFF)))
    return ip.is_global and not ip.is_multicast and not ip.is_reserved


_NAT64 = ipaddress.IPv6Network("64:ff9b::/96")


class RefusedAddress(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """An address that is none of the web, or of a machine that is not public."""


class UnknownHost(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """A host that cannot be found."""

    def __init__(self, host: str) -> None:
        super().__init__(f"{host}: there is no machine of this name", zh=f"找不到主機 {host}。")

    def __reduce__(self) -> tuple[object, ...]:  # as it comes back from another process
        return Exception.__new__, (type(self), *self.args), self.__dict__
