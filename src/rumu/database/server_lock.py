"""One server at a time works on a database: it holds a lock that ends with its process, however that ends.

On SQLite it is a lock on a file beside the database, on PostgreSQL an advisory lock of a connection. Commands
such as `rumu gallery import` do not take it, because they may read and write beside a server: what must not
happen is that two servers run the same jobs.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, text
from sqlalchemy.exc import SQLAlchemyError

from rumu.database.engine import connect_error, database_address, make_engine, shown_address
from rumu.errors import GalleryError

_KEY = 0x72756D76  # of PostgreSQL's advisory lock for servers
_KEEPALIVE = {"tcp_keepalives_idle": 15, "tcp_keepalives_interval": 5, "tcp_keepalives_count": 3}
"""Seconds until PostgreSQL asks after a silent holder, seconds between two questions, and how many."""


class DatabaseInUse(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """Another server works on the database."""

    def __init__(self, shown: str, holder: str) -> None:
        zh = f"另一個 rumu serve 正在使用這個資料庫（{holder}）。請先結束它，或用 --database 選別的資料庫。"
        en = f"another rumu serve works on this database ({holder}); end it, or choose another --database"
        super().__init__(f"{shown}: {en}  {zh}", zh=zh)


class ServerLock:
    """The lock of a server on a database. Made by `lock_server`."""

    def is_held(self) -> bool:
        """Whether this server still holds the lock; a lost connection is made again."""
        return True


@contextlib.contextmanager
def lock_server(url: str | Path) -> Iterator[ServerLock]:
    """Hold the lock of the one server of a database.

    Raises DatabaseInUse, which says who holds it, or GalleryError when it cannot be reached or locked.
    """
    engine = make_engine(database_address(url))
    try:
        if engine.dialect.name == "postgresql":
            with connect_error(url):
                lock = _PostgresLock(engine, shown_address(url))
            with contextlib.closing(lock):
                yield lock
        elif engine.url.database in (None, "", ":memory:"):
            yield ServerLock()
        else:
            with _lock_beside(Path(str(engine.url.database)).resolve()):
                yield ServerLock()
    finally:
        engine.dispose()


@contextlib.contextmanager
def _lock_beside(database: Path) -> Iterator[None]:
    from filelock import FileLock, Timeout

    path = database.with_name(f"{database.name}.lock")
    told = database.with_name(f"{database.name}.server.json")  # whoever tries the lock empties its own file
    lock = FileLock(path, timeout=0, thread_local=False)
    try:
        lock.acquire()
    except Timeout:
        raise DatabaseInUse(str(database), _holder_beside(told)) from None
    except OSError as error:
        raise GalleryError(f"{path}: cannot be locked ({error.strerror})") from error
    try:
        with contextlib.suppress(OSError):  # on a full disk the lock holds without it
            told.write_text(json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "since": _now()}))
        yield
    finally:
        told.unlink(missing_ok=True)
        lock.release()


def _holder_beside(told: Path) -> str:
    try:
        facts: dict[str, Any] = json.loads(told.read_text())
        return f"pid {facts['pid']}, host {facts['host']}, since {facts['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "pid ?"


class _PostgresLock(ServerLock):
    def __init__(self, engine: Engine, shown: str) -> None:
        self._engine = engine
        self._connection: Connection | None = None
        self._take(shown)

    def is_held(self) -> bool:
        try:
            if self._connection is not None:
                self._connection.execute(text("SELECT 1"))
                return True
        except SQLAlchemyError:
            self.close()
        try:
            self._take("")
        except (SQLAlchemyError, DatabaseInUse):
            return False
        return True

    def close(self) -> None:
        """Give the lock up with its connection."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _take(self, shown: str) -> None:
        connection = self._engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        if connection.scalar(text("SELECT pg_try_advisory_lock(:key)"), {"key": _KEY}):
            settings = {"application_name": f"rumu pid {os.getpid()} host {socket.gethostname()}"[:63]}
            for name, value in (settings | _KEEPALIVE).items():
                connection.execute(
                    text("SELECT set_config(:name, :value, false)"), {"name": name, "value": str(value)}
                )
            self._connection = connection
            return
        holder = connection.execute(
            text(
                "SELECT application_name, client_addr, backend_start FROM pg_stat_activity "
                "JOIN pg_locks USING (pid) WHERE locktype = 'advisory' AND granted AND objid = :key"
                " AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
            ),
            {"key": _KEY},
        ).first()
        connection.close()
        raise DatabaseInUse(shown, "pid ?" if holder is None else _holder_there(*holder))


def _holder_there(name: str | None, address: object, since: datetime | None) -> str:
    words = (name or "").split()  # as _take names the connection
    pid, host = (words[2], words[4]) if len(words) == 5 and words[0] == "rumu" else ("?", str(address))
    return f"pid {pid}, host {host}" + (f", since {since:%Y-%m-%d %H:%M:%S%z}" if since else "")


def _now() -> str:
    return f"{datetime.now().astimezone():%Y-%m-%d %H:%M:%S%z}"
