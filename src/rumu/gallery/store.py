"""The files of the gallery by key: a folder by default, or any place that fsspec reaches.

A key is a POSIX path that rumu made itself, such as `pictures/3f/3f0a...png`; nothing that a person typed
becomes one. A file appears whole or not at all, so whoever finds a key finds all of it.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

from rumu.errors import GalleryError

_KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._=-]*(/[A-Za-z0-9][A-Za-z0-9._=-]*)*")
_PIECE = 2**20  # bytes of a stream that are in memory at a time
_PART = ".part"  # ends the name of a file that is still being written
_RENAMES = frozenset({"sftp", "ssh", "smb", "ftp", "hdfs", "webhdfs"})
"""File systems where a file can be seen half-written and renaming is one step; an object store has
neither."""


@dataclass(frozen=True, slots=True)
class Store:
    """filesystem: of fsspec. root: where keys begin there. folder: the same on this machine, None
    elsewhere."""

    filesystem: Any
    root: str
    folder: Path | None

    @staticmethod
    def open(place: str | Path) -> Store:
        """The store in a folder, which is made when it is first written to, or at a URL of fsspec.

        Raises GalleryError for a URL that nothing here can reach.
        """
        import fsspec

        if "://" not in str(place):
            place = Path(place).absolute().as_uri()
        try:
            filesystem, root = fsspec.core.url_to_fs(str(place))
        except (ValueError, ImportError, OSError) as error:
            raise GalleryError(
                f"{place}: expected a folder or a URL that fsspec reaches ({error})"
            ) from error
        local = "file" in _protocols(filesystem)
        return Store(filesystem, str(root).rstrip("/"), Path(root) if local else None)

    def write(self, key: str, data: bytes | BinaryIO) -> None:
        """Whole or not at all; what was there is replaced. data: a stream is copied piece by piece.

        Raises GalleryError when it cannot be written.
        """
        place = self._place(key)
        try:
            if self.folder is not None:
                _write_here(Path(place), data)
            elif _RENAMES & _protocols(self.filesystem):
                part = f"{place}.{uuid.uuid4().hex}{_PART}"
                self.filesystem.makedirs(place.rpartition("/")[0], exist_ok=True)
                self._pour(part, data)
                self.filesystem.mv(part, place)
            else:
                self._pour(place, data)
        except OSError as error:
            raise GalleryError(f"{key}: cannot be written to the store ({error})") from error

    def _pour(self, place: str, data: bytes | BinaryIO) -> None:
        if isinstance(data, bytes):
            self.filesystem.pipe_file(place, data)
            return
        with self.filesystem.open(place, "wb") as stream:
            shutil.copyfileobj(data, stream, _PIECE)

    def read(self, key: str) -> bytes:
        """Raises GalleryError when there is no such file."""
        try:
            if self.folder is not None:
                return Path(self._place(key)).read_bytes()
            return bytes(self.filesystem.cat_file(self._place(key)))
        except OSError as error:
            raise GalleryError(f"{key}: expected a file of the store, it cannot be read ({error})") from error

    def exists(self, key: str) -> bool:
        """Whether there is a file, or anything below a folder, of this key."""
        place = self._place(key)
        return Path(place).exists() if self.folder is not None else bool(self.filesystem.exists(place))

    def delete(self, prefix: str) -> None:
        """A file, or everything in a folder; nothing happens when there is none."""
        place = self._place(prefix)
        with contextlib.suppress(FileNotFoundError):
            if self.folder is None:
                self.filesystem.rm(place, recursive=True)
            elif Path(place).is_dir():
                shutil.rmtree(place)
            else:
                Path(place).unlink()

    def keys(self, prefix: str, *, older_than: float = 0.0) -> Iterator[str]:
        """The files below a folder, half-written ones too, that were last written so many seconds ago or
        more."""
        try:
            found = self.filesystem.find(self._place(prefix), detail=True)
        except FileNotFoundError:
            return
        before = time.time() - older_than
        for place, facts in found.items():
            if facts.get("type") == "file" and _written(facts) <= before:
                yield str(PurePosixPath(place).relative_to(self.root or "/"))

    def delete_file(self, key: str) -> None:
        """Delete one file that `keys` gave, complete or partly written."""
        with contextlib.suppress(FileNotFoundError):
            self.filesystem.rm_file(f"{self.root}/{key}")

    def path(self, key: str) -> Path | None:
        """Where it lies on this machine; None in a store elsewhere."""
        return None if self.folder is None else Path(self._place(key))

    @contextlib.contextmanager
    def local(self, key: str) -> Iterator[Path]:
        """A file or folder as a path on this machine, for reading; a copy of a store elsewhere goes
        afterwards."""
        here = self.path(key)
        if here is not None:
            yield here
            return
        with tempfile.TemporaryDirectory(prefix="rumu-") as folder:
            copy = Path(folder) / PurePosixPath(key).name
            for name in [key] if self.filesystem.isfile(self._place(key)) else list(self.keys(key)):
                target = copy / PurePosixPath(name).relative_to(key)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(self.read(name))
            yield copy

    def _place(self, key: str) -> str:
        if not _KEY.fullmatch(key):
            raise GalleryError(f"expected a key of the store, such as works/a.png, got {key!r}")
        return f"{self.root}/{key}"


def _protocols(filesystem: Any) -> set[str]:
    named = filesystem.protocol
    return {named} if isinstance(named, str) else set(named)


def _write_here(target: Path, data: bytes | BinaryIO) -> None:
    part = target.with_name(f"{target.name}.{uuid.uuid4().hex}{_PART}")
    try:
        try:
            stream = part.open("wb")
        except FileNotFoundError:  # asked only now: most files go where others are
            target.parent.mkdir(parents=True, exist_ok=True)
            stream = part.open("wb")
        with stream:
            if isinstance(data, bytes):
                stream.write(data)
            else:
                shutil.copyfileobj(data, stream, _PIECE)
        os.replace(part, target)  # noqa: PTH105  thousands of files are imported at once
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _written(facts: dict[str, Any]) -> float:
    """Seconds since 1970; now, where a file system does not tell, so that nothing is taken for old."""
    for name in ("mtime", "LastModified", "last_modified", "created", "updated"):
        told = facts.get(name)
        if isinstance(told, int | float):
            return float(told)
        if isinstance(told, datetime):
            return told.timestamp()
    return time.time()
