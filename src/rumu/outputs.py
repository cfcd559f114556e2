"""An output appears whole or not at all: it is written beside its target and moved there at the end.

A table that takes hours keeps its rows beside it until then (`UnfinishedRows`).
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from rumu.errors import DiskFull, OutputError
from rumu.workspaces import sweep, temporary_folder

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_FULL_WORDS = re.compile(r"database or disk is full|\d+ requested and \d+ written")  # SQLite, numpy


def is_full(error: BaseException | None) -> bool:
    """Whether an error, or one that led to it, says that a disk or a quota is full."""
    while error is not None:
        if isinstance(error, DiskFull) or (isinstance(error, OSError) and error.errno in _FULL):
            return True
        if _FULL_WORDS.search(str(error)):
            return True
        error = error.__cause__ or error.__context__
    return False


@contextlib.contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path; on success it replaces `path`, on failure nothing is left.

    Raises OutputError when the folder of `path` cannot be written.
    """
    target = Path(path)
    if target.is_dir():
        raise OutputError(f"{target}: expected a file to write, found a folder")
    with _workspace(target) as folder:
        part = folder / target.name
        with _full_disk(target.parent, folder):
            yield part
        with _output_errors(target):
            part.replace(target)


@contextlib.contextmanager
def whole_folder(path: str | Path, *, marker: str) -> Iterator[Path]:
    """Yield an empty temporary folder; on success it takes the place of `path`.

    A folder already at `path` is replaced only when it is empty or holds a file named `marker`, that is,
    when it is an earlier output of the same kind; any other folder is left alone.
    Raises OutputError when it cannot be written.
    """
    target = Path(path)
    replaceable = target.is_dir() and ((target / marker).is_file() or not any(target.iterdir()))
    if target.exists() and not replaceable:
        raise OutputError(
            f"{target}: expected a new or empty folder, or one with {marker}; it holds other things"
        )
    with _workspace(target) as folder:
        part, old = folder / "new", folder / "old"
        part.mkdir()
        with _full_disk(target.parent, folder):
            yield part
        with _output_errors(target):
            if target.exists():
                target.replace(old)
            try:
                part.replace(target)
            except OSError:
                if old.exists():
                    old.replace(target)
                raise


@contextlib.contextmanager
def _workspace(target: Path) -> Iterator[Path]:
    with contextlib.ExitStack() as stack:
        with _output_errors(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            sweep(target.parent)
            making = temporary_folder(parent=target.parent, prefix=f".{target.name}.")
            folder = stack.enter_context(making)
        yield folder


@contextlib.contextmanager
def _full_disk(place: Path, written: Path) -> Iterator[None]:
    """Raise DiskFull where the block could not write for want of space; another error passes.

    written: the folder of what was written until then, which is the least that is needed.
    """
    try:
        yield
    except Exception as error:
        if is_full(error):
            needed = sum(file.stat().st_size for file in written.rglob("*") if file.is_file())
            raise DiskFull(place, needed or None) from error
        raise


@contextlib.contextmanager
def _output_errors(target: Path) -> Iterator[None]:
    """Raise what the system says against writing as an OutputError."""
    try:
        yield
    except OSError as error:
        if is_full(error):
            raise DiskFull(target.parent) from error
        raise OutputError(f"{target}: cannot be written ({os.strerror(error.errno or 0)})") from error


class UnfinishedRows:
    """Rows of a table that takes long to make, kept beside it until it is whole: an interrupted run goes on.

    Parameters
    ----------
    target
        The table that is being made; the rows lie in `NAME.unfinished` beside it.
    key
        What all rows depend on. Rows that were made with another key are dropped.

    Notes
    -----
    Each row is a line of JSON, written at once, so that a process that is killed loses no more than one.
    Values are those of JSON and Decimal. Only where each row lies is kept in memory.
    """

    def __init__(self, target: Path, *, key: Mapping[str, Any]) -> None:
        self.path = target.with_name(f"{target.name}.unfinished")
        told = json.dumps(key, sort_keys=True, default=repr)
        head = hashlib.sha256(told.encode()).hexdigest().encode() + b"\n"
        self._at: dict[int, int] = {}
        self._lock = FileLock(f"{self.path}.lock", timeout=0)
        with _output_errors(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            try:
                self._lock.acquire()
            except Timeout as error:
                raise OutputError(f"{target}: another run is writing it; wait for it to end") from error
            try:
                self.path.touch()
                self._stream = self.path.open("r+b")
                if self._stream.readline() != head or not self._find_rows():
                    self._at = {}
                    self._stream.seek(0)
                    self._stream.truncate()
                    self._stream.write(head)
            except BaseException:
                self._unlock()
                raise

    def numbers(self) -> set[int]:
        """Numbers of the rows that are kept."""
        return set(self._at)

    def add(self, number: int, row: Mapping[str, Any], *, stamp: object = None) -> None:
        """Keep a row, in place of an earlier one of that number. stamp: what it alone depends on, of JSON."""
        line = json.dumps([number, row, stamp], ensure_ascii=False, default=_written_decimal).encode()
        with _output_errors(self.path):
            self._at[number] = self._stream.seek(0, os.SEEK_END)
            self._stream.write(line + b"\n")
            self._stream.flush()

    def row(self, number: int) -> tuple[dict[str, Any], object]:
        """A row that is kept, and its stamp."""
        self._stream.seek(self._at[number])
        _, row, stamp = json.loads(self._stream.readline(), object_hook=_read_decimal)
        return row, stamp

    def close(self, *, finished: bool) -> None:
        """End writing; finished: the table is whole, and the rows are no longer needed."""
        self._stream.close()
        if finished or not self._at:
            self.path.unlink(missing_ok=True)
        self._unlock()

    def _unlock(self) -> None:
        self._lock.release()
        Path(self._lock.lock_file).unlink(missing_ok=True)

    def _find_rows(self) -> bool:
        """Note where rows lie, and cut off a last line that is not whole; False when one cannot be read."""
        while True:
            at = self._stream.tell()
            line = self._stream.readline()
            if not line.endswith(b"\n"):
                self._stream.truncate(at)
                return True
            try:
                number, row, _ = json.loads(line)
            except (ValueError, TypeError):
                return False
            if not isinstance(number, int) or not isinstance(row, dict):
                return False
            self._at[number] = at


def _written_decimal(value: object) -> dict[str, str]:
    if isinstance(value, Decimal):
        return {"decimal": str(value)}
    raise TypeError(f"expected a value of JSON or a Decimal, got {value!r}")


def _read_decimal(found: dict[str, Any]) -> object:
    return Decimal(found["decimal"]) if found.keys() == {"decimal"} else found
