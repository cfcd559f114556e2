"""An output appears whole or not at all: it is written beside its target and moved there at the end."""

from __future__ import annotations

import contextlib
import errno
import os
import re
from collections.abc import Iterator
from pathlib import Path

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
