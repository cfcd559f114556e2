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
    work: int = 80 * MIB
    zip: int = 1024 * MIB


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
    static: Path = Path(__file__).parent / "static"
