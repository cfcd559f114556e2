"""A gallery, and its store of files by key: a folder by default, or any file system that fsspec reaches.

A key is a POSIX path such as `pictures/3f/3f0a...png`, built by rumu and never from what a user typed. A file
is written completely or not at all.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, BinaryIO

from rumu.containment import leads_out
from rumu.errors import DiskFull, GalleryError
from rumu.outputs import is_full
from rumu.workspaces import temporary_folder

if TYPE_CHECKING:
    from rumu.database.engine import Database

_KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._=-]*(/[A-Za-z0-9][A-Za-z0-9._=-]*)*")
_CHUNK = 2**20  # bytes of a stream that are in memory at a time
_USED_AGAIN = 3600.0  # seconds after which the use of a file is remembered anew
PART_SUFFIX = ".part"  # of a file that is still being written
_RENAMING = frozenset({"sftp", "ssh", "smb", "ftp", "hdfs", "webhdfs"})
"""Protocols where partly written files are visible and renaming is atomic, unlike object stores."""


@dataclass(frozen=True, slots=True)
class StoreFile:
    """A file of a store. size: bytes. written: when it was written or last used, in seconds since 1970."""

    key: str
    size: int
    written: float


@dataclass(frozen=True, slots=True)
class Store:
    """A store. filesystem: of fsspec. root: path that keys are relative to. folder: root, if it is local."""

    filesystem: Any
    root: str
    folder: Path | None

    @staticmethod
    def open(location: str | Path) -> Store:
        """Open the store in a folder, which is created by the first write, or at a URL of fsspec.

        Raises GalleryError for a URL that fsspec cannot reach.
        """
        import fsspec

        if "://" not in str(location):
            location = Path(location).absolute().as_uri()
        try:
            filesystem, root = fsspec.core.url_to_fs(str(location))
        except (ValueError, ImportError, OSError) as error:
            raise GalleryError(
                f"{location}: expected a folder or a URL that fsspec reaches ({error})"
            ) from error
        local = "file" in _protocols(filesystem)
        return Store(filesystem, str(root).rstrip("/"), Path(root) if local else None)

    def write(self, key: str, data: bytes | BinaryIO) -> None:
        """Write a file completely or not at all; an existing one is replaced. data: bytes or a stream.

        Raises GalleryError when it cannot be written, DiskFull when there is no space.
        """
        path = self._path(key)
        try:
            if self.folder is not None:
                _write_local(Path(path), data)
            elif _RENAMING & _protocols(self.filesystem):
                part = f"{path}.{uuid.uuid4().hex}{PART_SUFFIX}"
                self.filesystem.makedirs(path.rpartition("/")[0], exist_ok=True)
                try:
                    self._write_remote(part, data)
                    self.filesystem.mv(part, path)
                except OSError:
                    with contextlib.suppress(OSError):
                        self.filesystem.rm_file(part)
                    raise
            else:
                self._write_remote(path, data)
        except OSError as error:
            if is_full(error):
                raise DiskFull(self.root, _size(data)) from error
            raise GalleryError(
                f"{key}: cannot be written to the store ({_reason(error)})",
                zh=f"檔案無法存入（{_reason(error)}）。",
            ) from error

    @contextlib.contextmanager
    def whole_folder(self, key: str) -> Iterator[None]:
        """Delete the folder with this key if the block raises, unless it was there before."""
        existed = self.exists(key)
        try:
            yield
        except BaseException:
            if not existed:
                self.delete(key)
            raise

    def _write_remote(self, path: str, data: bytes | BinaryIO) -> None:
        if isinstance(data, bytes):
            self.filesystem.pipe_file(path, data)
            return
        with self.filesystem.open(path, "wb") as stream:
            shutil.copyfileobj(data, stream, _CHUNK)

    def read(self, key: str) -> bytes:
        """The content of a file. Raises GalleryError when it cannot be read."""
        try:
            if self.folder is not None:
                return Path(self._path(key)).read_bytes()
            return bytes(self.filesystem.cat_file(self._path(key)))
        except OSError as error:
            raise GalleryError(
                f"{key}: expected a file of the store, it cannot be read ({_reason(error)})",
                zh=f"讀不到檔案 {key}（{_reason(error)}）。",
            ) from error

    def read_part(self, key: str, first: int, size: int) -> bytes:
        """Bytes of a file from `first` on. Raises GalleryError when it cannot be read, or is too short."""
        with self.open_file(key) as stream:
            stream.seek(first)
            data = stream.read(size)
        if len(data) != size:
            raise GalleryError(f"{key}: expected {size} bytes from {first} on, got {len(data)}")
        return bytes(data)

    @contextlib.contextmanager
    def open_file(self, key: str) -> Iterator[BinaryIO]:
        """A file for reading parts of it. Raises GalleryError when it cannot be read."""
        try:
            with self.filesystem.open(self._path(key), "rb") as stream:
                yield stream
        except OSError as error:
            raise GalleryError(
                f"{key}: expected a file of the store, it cannot be read ({_reason(error)})",
                zh=f"讀不到檔案 {key}（{_reason(error)}）。",
            ) from error

    def state(self, key: str) -> StoreFile | None:
        """Size and time of a file; None if there is none."""
        try:
            info = self.filesystem.info(self._path(key))
        except FileNotFoundError:
            return None
        return StoreFile(key, int(info.get("size") or 0), _modification_time(info))

    def exists(self, key: str) -> bool:
        """Whether there is a file with this key, or a folder with any files."""
        path = self._path(key)
        return Path(path).exists() if self.folder is not None else bool(self.filesystem.exists(path))

    def delete(self, prefix: str) -> None:
        """Delete a file, or a folder with everything in it, if it exists."""
        path = self._path(prefix)
        with contextlib.suppress(FileNotFoundError):
            if self.folder is None:
                self.filesystem.rm(path, recursive=True)
            elif Path(path).is_dir():
                shutil.rmtree(path)
            else:
                Path(path).unlink()

    def keys(self, prefix: str, *, older_than: float = 0.0) -> Iterator[str]:
        """The keys of the files below a folder, also of partly written ones.

        older_than: seconds since the last write, at least.
        """
        before = time.time() - older_than
        return (file.key for file in self.files(prefix) if file.written <= before)

    def files(self, prefix: str) -> Iterator[StoreFile]:
        """The files below a folder, also partly written ones."""
        try:
            found = self.filesystem.find(self._path(prefix), detail=True)
        except FileNotFoundError:
            return
        for path, info in found.items():
            if info.get("type") == "file":
                key = str(PurePosixPath(path).relative_to(self.root or "/"))
                yield StoreFile(key, int(info.get("size") or 0), _modification_time(info))

    def mark_as_used(self, key: str) -> None:
        """Remember that a file is used, once an hour, where the store is on this machine."""
        path = self.path(key)
        with contextlib.suppress(OSError):
            if path is not None and time.time() - path.stat().st_mtime > _USED_AGAIN:
                os.utime(path)

    def delete_file(self, key: str) -> None:
        """Delete one file that `keys` gave, complete or partly written."""
        with contextlib.suppress(FileNotFoundError):
            self.filesystem.rm_file(f"{self.root}/{key}")

    def path(self, key: str) -> Path | None:
        """The path of a file on this machine; None if the store is remote."""
        return None if self.folder is None else Path(self._path(key))

    @contextlib.contextmanager
    def local(self, key: str) -> Iterator[Path]:
        """A file or folder as a path on this machine, for reading; of a remote store a temporary copy."""
        path = self.path(key)
        if path is not None:
            yield path
            return
        with temporary_folder() as folder:
            copy = folder / PurePosixPath(key).name
            for name in [key] if self.filesystem.isfile(self._path(key)) else list(self.keys(key)):
                target = copy / PurePosixPath(name).relative_to(key)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(self.read(name))
            yield copy

    def _path(self, key: str) -> str:
        if not _KEY.fullmatch(key) or leads_out(key):
            raise GalleryError(f"expected a key of the store, such as works/a.png, got {key!r}")
        return f"{self.root}/{key}"


@dataclass(frozen=True, slots=True)
class Gallery:
    """A gallery. database: what is known of its works. store: their files."""

    database: Database
    store: Store


def _protocols(filesystem: Any) -> set[str]:
    names = filesystem.protocol
    return {names} if isinstance(names, str) else set(names)


def _reason(error: OSError) -> str:
    """What the system says, without the path that it says it of."""
    return error.strerror or type(error).__name__


def _size(data: bytes | BinaryIO) -> int | None:
    if isinstance(data, bytes):
        return len(data)
    try:
        return data.seek(0, os.SEEK_END)
    except (OSError, ValueError):
        return None


def _write_local(target: Path, data: bytes | BinaryIO) -> None:
    part = target.with_name(f"{target.name}.{uuid.uuid4().hex}{PART_SUFFIX}")
    try:
        try:
            stream = part.open("wb")
        except FileNotFoundError:  # checked only now, because most folders exist
            target.parent.mkdir(parents=True, exist_ok=True)
            stream = part.open("wb")
        with stream:
            if isinstance(data, bytes):
                stream.write(data)
            else:
                shutil.copyfileobj(data, stream, _CHUNK)
        os.replace(part, target)  # noqa: PTH105  thousands of files are imported at once
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _modification_time(info: dict[str, Any]) -> float:
    """The time of the last write in seconds since 1970; now, if unknown, so that the file counts as new."""
    for name in ("mtime", "LastModified", "last_modified", "created", "updated"):
        time_there = info.get(name)
        if isinstance(time_there, int | float):
            return float(time_there)
        if isinstance(time_there, datetime):
            return time_there.timestamp()
    return time.time()
