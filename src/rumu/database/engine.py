"""Open a database, SQLite in a file or PostgreSQL by its URL, and bring its tables up to date."""

from __future__ import annotations

import sqlite3
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from threading import BoundedSemaphore, Lock
from typing import Any

from sqlalchemy import Engine, create_engine, event, text
from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError, OperationalError, TimeoutError
from sqlalchemy.orm import Session, sessionmaker

from rumu.errors import DatabaseBusy, DiskFull, GalleryError
from rumu.outputs import is_full

_WRITES = "rumu_writes"  # execution option of connections that write
_UPGRADE_LOCK = 0x72756D75  # key of PostgreSQL's advisory lock for upgrades of the tables
_UPGRADING = Lock()
_TIMEOUT = 30.0  # seconds that a writer waits for another on SQLite, unless told otherwise
_MAX_WRITERS = 6  # sessions of one process that write at a time
_TURN_TIMEOUT = 1.0  # seconds that a further one waits for its turn, where writers are told not to wait long
_FULL_CODES = ("SQLITE_FULL", "53100")  # of SQLite and of PostgreSQL
_BUSY_CODES = ("SQLITE_BUSY", "SQLITE_LOCKED", "08", "57P", "55P03", "53300")


@dataclass(frozen=True, slots=True)
class Database:
    """An open database.

    reading, writing: open a session, whose transaction is committed unless the block raises. One that writes
    takes SQLite's write lock at its start, because a transaction that begins to write later may be refused.
    """

    engine: Engine
    reading: Callable[[], AbstractContextManager[Session]]
    writing: Callable[[], AbstractContextManager[Session]]

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()


def open_database(url: str | Path, *, wait: float = _TIMEOUT) -> Database:
    """Open the database at a URL (`sqlite:///FILE`, `postgresql://...`) or in a file of SQLite.

    Missing tables are created. wait: seconds that a writer waits for another on SQLite; its sessions raise
    DatabaseBusy after that, and DiskFull where there is no space.
    Raises GalleryError for another kind of URL, a database that cannot be reached, or one of another version
    of rumu.
    """
    from alembic.util.exc import CommandError

    engine = make_engine(database_address(url), wait=wait)
    try:
        with connect_error(url):
            _upgrade(engine)
    except GalleryError:
        engine.dispose()
        raise
    except CommandError as error:
        engine.dispose()
        raise GalleryError(
            f"{shown_address(url)}: was written by a newer rumu or from before the first release; "
            f"open it with that version, or start with a new database ({error})"
        ) from error
    writer = engine.execution_options(**{_WRITES: True})
    read, write = (sessionmaker(one, expire_on_commit=False).begin for one in (engine, writer))
    place, turns = shown_address(url), BoundedSemaphore(_MAX_WRITERS)

    @contextmanager
    def reading() -> Iterator[Session]:
        with _known_errors(place), read() as session:
            yield session

    @contextmanager
    def writing() -> Iterator[Session]:
        # further writers wait briefly: while the database is locked, they must not take all threads
        if not turns.acquire(timeout=min(wait, _TURN_TIMEOUT) if wait < _TIMEOUT else None):
            raise _busy(place)
        try:
            with _known_errors(place), write() as session:
                yield session
        finally:
            turns.release()

    return Database(engine, reading, writing)


@contextmanager
def _known_errors(place: str) -> Iterator[None]:
    """Raise DatabaseBusy or DiskFull for what a database says when it is locked, away or out of space."""
    try:
        yield
    except TimeoutError as error:
        raise _busy(place) from error
    except OperationalError as error:
        reason = getattr(error.orig, "sqlite_errorname", None) or getattr(error.orig, "sqlstate", None)
        if reason in _FULL_CODES or (reason == "SQLITE_IOERR_WRITE" and _quota_is_full(place)):
            raise DiskFull(place) from error
        if reason is None or reason.startswith(_BUSY_CODES):
            raise _busy(place) from error
        raise


def _quota_is_full(place: str) -> bool:
    """Whether nothing can be written beside an SQLite file for want of space: SQLite tells no quota apart."""
    try:
        with tempfile.NamedTemporaryFile(dir=Path(place.removeprefix("sqlite:///")).parent) as probe:
            probe.write(b"\0" * 65536)
            probe.flush()
    except OSError as error:
        return is_full(error)
    return False


def _busy(place: str) -> DatabaseBusy:
    return DatabaseBusy(
        "the database is locked by another program, or cannot be reached; nothing was stored, try again",
        name=place,
        zh="資料庫被別的程式鎖住，或者連不上；什麼都沒有存下，請稍後再試。",
    )


def shown_address(url: str | Path) -> str:
    """The address of a database for messages, without its password."""
    text = str(url)
    return make_url(text).render_as_string(hide_password=True) if "://" in text else text


@contextmanager
def connect_error(url: str | Path) -> Iterator[None]:
    """Raise what a database says against being opened as a GalleryError."""
    try:
        yield
    except DBAPIError as error:
        reason = str(error.orig).strip()
        raise GalleryError(f"{shown_address(url)}: cannot be opened ({reason})") from error


def database_address(url: str | Path) -> str:
    """The URL of a database as SQLAlchemy reads it. The folder of an SQLite file is made.

    Raises GalleryError when it cannot be made.
    """
    text = str(url)
    if "://" not in text:
        path = Path(text)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise GalleryError(f"{path}: its folder cannot be made ({error.strerror})") from error
        return f"sqlite:///{path}"
    # people write postgresql:// as psql does; the driver is psycopg
    return text.replace("postgresql://", "postgresql+psycopg://", 1).replace(
        "postgres://", "postgresql+psycopg://", 1
    )


def make_engine(address: str, *, wait: float = _TIMEOUT) -> Engine:
    """The connections of a database. Raises GalleryError for another kind, or without a driver."""
    try:
        name = make_url(address).get_backend_name()
        if name not in ("sqlite", "postgresql"):
            raise GalleryError(f"expected a database sqlite:///FILE or postgresql://..., got {name}")
        if name == "sqlite":
            engine = create_engine(address, connect_args={"timeout": wait})
            event.listen(engine, "connect", _prepare_sqlite)
            event.listen(engine, "begin", _begin_sqlite)
            return engine
        return create_engine(address, pool_size=10, max_overflow=20, pool_pre_ping=True)
    except (ArgumentError, NoSuchModuleError) as error:
        raise GalleryError(
            f"expected a database sqlite:///FILE or postgresql://..., got {address!r}"
        ) from error
    except ModuleNotFoundError as error:
        raise GalleryError(f"PostgreSQL needs: pip install 'rumu[postgresql]' ({error})") from error


def _prepare_sqlite(connection: Any, _: Any) -> None:
    connection.isolation_level = None  # _begin_sqlite begins transactions
    _to_wal(connection)
    for pragma in ("synchronous=NORMAL", "foreign_keys=ON"):
        connection.execute(f"PRAGMA {pragma}")


def _to_wal(connection: Any) -> None:
    """Set the journal's mode, waiting for other processes: SQLite itself does not wait here."""
    until = time.monotonic() + _TIMEOUT
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
            return
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > until:
                raise
            time.sleep(0.01)


def _begin_sqlite(connection: Any) -> None:
    writes = connection.get_execution_options().get(_WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _upgrade(engine: Engine) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(resources.files("rumu.database").joinpath("migrations")))
    # If several processes start together, one creates the tables and the others wait; threads take turns, as
    # Alembic keeps the migration that runs in a module's globals.
    with _UPGRADING, engine.execution_options(**{_WRITES: True}).begin() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _UPGRADE_LOCK})
        config.attributes["connection"] = connection
        command.upgrade(config, "head")
