"""Temporary folders that never outlive their process for long: those of killed processes are swept.

Each holds a lock that its process keeps while it lives, however it ends; a folder whose lock is free, and
that says whose it was, belongs to nobody any more.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows, which deletes no file that is open
    fcntl = None  # type: ignore[assignment]

_LOCK = ".owner"  # in each folder: locked while its process lives, with the process's number in it
_MARK = "rumu-"  # in the name of each folder
_NAME = re.compile(rf"(\..+\.)?{_MARK}\w{{8}}")
_UNSURE = 3600.0  # seconds after which a folder without an owner's number, left while it was made, is swept


@contextlib.contextmanager
def temporary_folder(*, parent: Path | None = None, prefix: str = "") -> Iterator[Path]:
    """Yield an empty folder that is deleted afterwards; when this process is killed, by a later `sweep`.

    parent: the system's folder for temporary files by default. prefix: of the name in it.
    Raises OSError when it cannot be made.
    """
    owned = Path(tempfile.mkdtemp(prefix=f"{prefix}{_MARK}", dir=parent))
    try:
        with (owned / _LOCK).open("w", encoding="ascii") as owner:
            if fcntl is not None:
                fcntl.flock(owner, fcntl.LOCK_EX)
            owner.write(f"{os.getpid()}\n")
            owner.flush()
            inner = owned / "files"
            inner.mkdir()
            yield inner
    finally:
        shutil.rmtree(owned, ignore_errors=True)


def sweep(parent: Path | None = None) -> int:
    """Delete the folders that killed processes left in `parent`, and return how many; others' stay.

    parent: the system's folder for temporary files by default.
    """
    swept = 0
    with contextlib.suppress(OSError), os.scandir(parent or tempfile.gettempdir()) as entries:
        for entry in entries:
            if _NAME.fullmatch(entry.name) and entry.is_dir(follow_symlinks=False):
                with contextlib.suppress(OSError):
                    swept += _sweep_folder(Path(entry.path))
    return swept


def _sweep_folder(folder: Path) -> bool:
    facts = folder.stat()
    if hasattr(os, "getuid") and facts.st_uid != os.getuid():
        return False
    old = time.time() - facts.st_mtime > _UNSURE
    if not (folder / _LOCK).exists():  # being made this moment, or not ours
        if old and not any(folder.iterdir()):
            folder.rmdir()
        return False
    with (folder / _LOCK).open("r+", encoding="ascii") as owner:
        if fcntl is not None:
            try:
                fcntl.flock(owner, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return False  # its process lives
        if not owner.read().strip() and not old:
            return False  # its process is about to lock it
        if fcntl is not None:
            shutil.rmtree(folder, ignore_errors=True)
            return True
    (folder / _LOCK).unlink()  # on Windows fails while it is open elsewhere
    shutil.rmtree(folder, ignore_errors=True)
    return True
