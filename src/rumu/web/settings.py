"""Settings of the service."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rumu.studio.storage import Storage
from rumu.web.rate_limits import RateLimitSettings

MIB = 2**20


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Largest body of a request, in bytes. default: of every route that is not named here."""

    default: int = 256 * 1024
    mark: int = 12 * MIB
    sheet: int = 32 * MIB
    work: int = 80 * MIB
    zip: int = 1024 * MIB


@dataclass(frozen=True, slots=True)
class ConnectionLimits:
    """How long a connection may hold a place, and how many an address may have.

    head_seconds: until the head of a request is complete. head_bytes: of all headers; browsers send all
    cookies of a host. body_seconds: after which a body must have come at body_rate, in bytes each second, on
    average.
    write_seconds: for which a client may take nothing of a response. per_client: connections of one address,
    which a school may share, and requests of one client at a time.
    """

    head_seconds: float = 10.0
    head_bytes: int = MIB
    body_seconds: float = 20.0
    body_rate: float = 1024.0
    write_seconds: float = 60.0
    per_client: int = 300


@dataclass(frozen=True, slots=True)
class ServiceSettings:
    """How a service runs.

    storage: the gallery's database and files.
    processes: that make marks; 0 makes them in threads, None as many as there are cores, 4 at most.
    root_path: path on the host under which a proxy shows the service, such as '/calligraphy'; '' for none.
    https: whether clients use HTTPS even where the proxy does not say so.
    prepare: whether thumbnails and samples are made at the first start.
    static: folder of the built pages.
    """

    storage: Storage
    processes: int | None = None
    root_path: str = ""
    https: bool = False
    prepare: bool = True
    rate_limits: RateLimitSettings = field(default_factory=RateLimitSettings)
    body_limits: BodyLimits = field(default_factory=BodyLimits)
    connections: ConnectionLimits = field(default_factory=ConnectionLimits)
    static: Path = Path(__file__).parent / "static"
