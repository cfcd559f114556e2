"""How a service is run: where its gallery lies, how much it takes, how often it may be asked."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rumu.studio.place import Place

MIB = 2**20


@dataclass(frozen=True, slots=True)
class Rates:
    """How often, in the notation of `limits`. login: for each address, and again for each name. marks: for
    each
    person; tries: for each address without a login; uploads: for each person; all: requests of one
    address."""

    login: str = "60/minute"
    login_name: str = "10/minute"
    marks: str = "120/minute"
    tries: str = "60/minute"
    uploads: str = "60/hour"
    all: str = "30000/minute"


@dataclass(frozen=True, slots=True)
class Bodies:
    """Bytes of a request that are read before it is refused."""

    usual: int = 256 * 1024
    mark: int = 12 * MIB
    work: int = 80 * MIB
    zip: int = 1024 * MIB


@dataclass(frozen=True, slots=True)
class ServiceSettings:
    """place: the gallery. processes: that mark; 0 marks in threads, None as many as there are cores (4 at
    most).
    secure: cookies go over https only. prepare: make thumbnails and samples at the start. static: the
    folder of
    the built pages."""

    place: Place
    processes: int | None = None
    secure: bool = False
    prepare: bool = True
    rates: Rates = field(default_factory=Rates)
    bodies: Bodies = field(default_factory=Bodies)
    static: Path = Path(__file__).parent / "static"
