"""Files of museums from the web, fetched politely: one after the other, with pauses, and none twice.

What was fetched lies in a folder, under the digest of its address, so that an import that was ended goes on.
A server that says 429 or 503 is asked again when it says (Retry-After), and a request that fails for the
moment a few times more. Every address is checked, also those of redirects; see `public_addresses`.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urljoin, urlsplit, urlunsplit

import rumu
from rumu.errors import GalleryError
from rumu.gallery.public_addresses import Resolve, UnknownHost, destination, resolve_name
from rumu.outputs import whole_file

if TYPE_CHECKING:
    import httpx

_REDIRECTS = frozenset({301, 302, 303, 307, 308})
_LATER = frozenset({429, 503})
_MOMENTARY = frozenset({408, 425, 500, 502, 504})
_MB = 2**20


@dataclass(frozen=True, slots=True, kw_only=True)
class FetchSettings:
    """How museums are asked.

    pause: seconds between two requests to one host. timeout: seconds that an answer may take to begin, or to
    go on. tries: of one request. longest_wait: seconds that a server may have us wait; if it wants more, the
    import ends and can go on later. redirects: that are followed. max_json, max_picture: bytes of an answer.
    keep: seconds that what was fetched is used again.
    private: addresses of the inner network are allowed, for a server of one's own.
    """

    pause: float = 0.5
    timeout: float = 60.0
    tries: int = 5
    longest_wait: float = 600.0
    redirects: int = 5
    max_json: int = 32 * _MB
    max_picture: int = 256 * _MB
    keep: float = 86_400.0
    private: bool = False


class NotThere(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """An address with no such file, or one that is refused for good."""


class NotNow(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """A server that cannot be reached, or asks to come back later; the import may go on another time."""


@dataclass(slots=True)
class MuseumWeb:
    """Fetches files, at most one at a time. folder: where they are kept. fetched: how many came over the net.

    transport: of httpx; None for the network.
    """

    folder: Path
    settings: FetchSettings = field(default_factory=FetchSettings)
    transport: httpx.BaseTransport | None = None
    resolve: Resolve = resolve_name
    sleep: Callable[[float], None] = time.sleep
    clock: Callable[[], float] = time.monotonic
    fetched: int = 0
    _asked: dict[str, float] = field(default_factory=dict)
    _clients: dict[str, httpx.Client] = field(default_factory=dict)
    _plain: set[str] = field(default_factory=set)

    def json_bytes(self, url: str, *, near: str = "") -> bytes:
        """A manifest or a description. near: see `picture_bytes`."""
        accept = "application/ld+json, application/json;q=0.9, */*;q=0.5"
        return self._bytes(url, near, accept=accept, most=self.settings.max_json)

    def picture_bytes(self, url: str, *, near: str = "") -> bytes:
        """A picture or a part of one. near: the address of the document that names it.

        A document that came by https may name addresses with http that belong to https, which is tried first.
        Raises NotThere, NotNow, or GalleryError for an address that is not public.
        """
        return self._bytes(url, near, accept="image/*", most=self.settings.max_picture)

    def forget(self, url: str, *, near: str = "") -> None:
        """Delete what is kept of an address."""
        for one in self._ways(url, near):
            self._kept(one).unlink(missing_ok=True)

    def close(self) -> None:
        """Close the connections."""
        for client in self._clients.values():
            client.close()
        self._clients.clear()

    def _ways(self, url: str, near: str) -> list[str]:
        parts, host = urlsplit(url), urlsplit(url).netloc
        if near.startswith("https://") and parts.scheme == "http":
            secure = urlunsplit(parts._replace(scheme="https"))
            return [url, secure] if host in self._plain else [secure, url]
        return [url]

    def _bytes(self, url: str, near: str, *, accept: str, most: int) -> bytes:
        try:
            ways = self._ways(url, near)
        except ValueError as error:
            raise NotThere(f"{url!r:.200}: expected an address", zh="網址不對。") from error
        for one in ways:
            kept = self._kept(one)
            with suppress(OSError):
                if time.time() - kept.stat().st_mtime < self.settings.keep:
                    return kept.read_bytes()
        for number, one in enumerate(ways, start=1):
            try:
                data = self._fetch(one, accept=accept, most=most, last=number == len(ways))
            except (NotNow, UnknownHost):
                if number == len(ways):
                    raise
                self._plain.add(urlsplit(url).netloc)  # this host has no https
                continue
            self._kept(one).parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self._kept(one)) as part:
                part.write_bytes(data)
            return data
        raise NotThere(f"{url}: cannot be fetched", zh="取不到檔案。")

    def _kept(self, url: str) -> Path:
        # What was fetched where private addresses are allowed serves nobody else.
        known = f"private {url}" if self.settings.private else url
        digest = hashlib.sha256(known.encode()).hexdigest()
        return self.folder / digest[:2] / digest

    # --- one request ---------------------------------------------------------------------------------

    def _fetch(self, url: str, *, accept: str, most: int, last: bool) -> bytes:
        import httpx

        tries = self.settings.tries if last else 1
        for attempt in range(1, tries + 1):
            try:
                data, wait = self._ask(url, accept=accept, most=most)
            except httpx.InvalidURL as error:
                raise NotThere(f"{url}: leads to no address ({error})", zh="網址不對。") from error
            except httpx.TransportError as error:
                if attempt == tries:
                    raise NotNow(
                        f"{url}: cannot be reached ({error}); run the import again to go on",
                        zh=f"連不上 {urlsplit(url).netloc}；再匯入一次就會接著做。",
                    ) from error
                data, wait = None, 2.0**attempt
            if data is not None:
                return data
            if wait > self.settings.longest_wait or attempt == tries:
                raise NotNow(
                    f"{url}: the server asks to come back in {wait:.0f} s; run the import again then",
                    zh=f"{urlsplit(url).netloc} 請我們 {wait:.0f} 秒後再來；到時再匯入一次就會接著做。",
                )
            self.sleep(wait)
        raise NotNow(f"{url}: cannot be reached", zh="連不上。")

    def _ask(self, url: str, *, accept: str, most: int) -> tuple[bytes | None, float]:
        """The content of an address; or None, and the seconds to wait before it is asked for again."""
        for _ in range(self.settings.redirects + 1):
            with self._open(url, accept) as answer:
                status = answer.status_code
                if status in _REDIRECTS and "location" in answer.headers:
                    url = _redirected(url, answer.headers["location"])
                    continue
                if status in _LATER | _MOMENTARY:
                    return None, _seconds_to_wait(answer.headers.get("retry-after"))
                if status != 200:
                    raise NotThere(
                        f"{url}: expected a file, the server answered {status}",
                        zh=f"伺服器回覆 {status}，沒有這個檔案。",
                    )
                return _read_bounded(answer, url, most), 0.0
        raise NotThere(f"{url}: too many redirects", zh="轉址太多次。")

    def _open(self, url: str, accept: str) -> closing[httpx.Response]:
        to = destination(url, private=self.settings.private, resolve=self.resolve)
        self._wait_for_turn(to.host)
        client = self._client_of(to.host)
        address = f"[{to.address}]" if ":" in to.address else to.address
        pinned = urlunsplit(urlsplit(url)._replace(netloc=f"{address}:{to.port}", fragment=""))
        request = client.build_request(
            "GET",
            pinned,
            headers={
                "Host": to.named,
                "Accept": accept,
                "User-Agent": f"rumu/{rumu.__version__} (IIIF import)",
            },
            extensions={"sni_hostname": to.host},
        )
        answer = client.send(request, stream=True)
        self.fetched += 1
        return closing(answer)

    def _client_of(self, host: str) -> httpx.Client:
        """The connections of a host: those of another one at the same address were checked for that one."""
        import httpx

        if host not in self._clients:
            self._clients[host] = httpx.Client(
                timeout=self.settings.timeout,
                follow_redirects=False,
                trust_env=False,
                transport=self.transport,
            )
        return self._clients[host]

    def _wait_for_turn(self, host: str) -> None:
        before = self._asked.get(host)
        if before is not None:
            left = self.settings.pause - (self.clock() - before)
            if left > 0:
                self.sleep(left)
        self._asked[host] = self.clock()


def _redirected(url: str, location: str) -> str:
    try:
        return urljoin(url, location)
    except ValueError as error:
        raise NotThere(
            f"{url}: leads to {location!r:.200}, which is no address", zh="轉址的網址不對。"
        ) from error


def _read_bounded(answer: httpx.Response, url: str, most: int) -> bytes:
    parts, count = [], 0
    for part in answer.iter_bytes():
        count += len(part)
        if count > most:
            raise NotThere(f"{url}: expected at most {most} bytes", zh=f"檔案太大，最多 {most // _MB} MB。")
        parts.append(part)
    return b"".join(parts)


def _seconds_to_wait(header: str | None) -> float:
    """Retry-After in seconds, as a number or a date; 5 when the server does not say."""
    if header is None:
        return 5.0
    if header.strip().isdecimal():
        return float(header)
    try:
        until = parsedate_to_datetime(header)
    except ValueError:
        return 5.0
    return max(0.0, (until.replace(tzinfo=until.tzinfo or UTC) - datetime.now(UTC)).total_seconds())
