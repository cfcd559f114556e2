"""Files that are read: regular ones only, and no more of one than its kind can hold.

Reading a pipe, a socket, a device or a file of the kernel may never end; a regular file may grow while it is
read.
"""

from __future__ import annotations

import json
import math
import os
import stat
from pathlib import Path
from typing import Any, BinaryIO

from rumu.errors import RumuError

MAX_BYTES = 2**31
"""Most bytes of any file that is read at once: more than the largest image that is decoded takes."""
MAX_TEXT = 64 * 2**20
"""Most bytes of a text that a person writes or exports: a table, a list of lamps, JSON."""

_KERNEL_FOLDERS = ("/proc/", "/sys/")
_KINDS = (
    (stat.S_ISDIR, "a folder", "資料夾"),
    (stat.S_ISFIFO, "a pipe", "管道"),
    (stat.S_ISSOCK, "a socket", "通訊端"),
    (stat.S_ISCHR, "a device", "裝置"),
    (stat.S_ISBLK, "a device", "裝置"),
)


def path_of(value: object, *, error_type: type[RumuError], expected: str) -> Path:
    """The path that somebody gave. Raises `error_type` for what is neither text nor a path."""
    if not isinstance(value, str | os.PathLike) or isinstance(os.fspath(value), bytes):
        kind = type(value)
        name = (
            kind.__qualname__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__qualname__}"
        )
        raise error_type(f"expected {expected}, got {name}")
    return Path(value)


def open_file(
    path: str | os.PathLike[str], *, error_type: type[RumuError], expected: str = "a file"
) -> BinaryIO:
    """Open a regular file for reading, without ever waiting.

    expected: what the message says should be there.
    Raises `error_type` naming the file when it cannot be opened or is no regular file.
    """
    try:
        _check_kind(path, os.stat(path), error_type=error_type, expected=expected)  # noqa: PTH116
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)
        descriptor = os.open(path, flags | getattr(os, "O_NOCTTY", 0))
        try:  # again: it may have been replaced in between
            _check_kind(path, os.fstat(descriptor), error_type=error_type, expected=expected)
            return os.fdopen(descriptor, "rb")
        except BaseException:
            os.close(descriptor)
            raise
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise _unreadable(path, error, error_type) from error


def read_file(
    path: str | os.PathLike[str],
    *,
    error_type: type[RumuError],
    expected: str = "a file",
    most: int = MAX_BYTES,
) -> bytes:
    """The content of a regular file.

    Raises `error_type` as `open_file` does, and when there are more than `most` bytes.
    """
    with open_file(path, error_type=error_type, expected=expected) as file:
        try:
            data = file.read(most + 1)
        except OSError as error:
            raise _unreadable(path, error, error_type) from error
    if len(data) > most:
        size = f"{most / 2**20:.0f} MB"
        raise error_type(
            f"expected at most {size}, it holds more",
            name=path,
            zh=f"{Path(path).name}：最多 {size}，內容太大。",
        )
    return data


def read_json(
    path: str | os.PathLike[str],
    *,
    error_type: type[RumuError],
    expected: str = "JSON",
    most: int = MAX_TEXT,
) -> Any:
    """What a file of JSON holds.

    Raises `error_type` as `read_file` does, and when it is no JSON in UTF-8. Whether its numbers are finite
    is for the caller to check.
    """
    data = read_file(path, error_type=error_type, expected="a file", most=most)
    try:
        return json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise error_type(
            f"expected {expected}, cannot read it ({error})",
            name=path,
            zh=f"{Path(path).name}：應該是 JSON，讀不出來（{error}）。",
        ) from error


def parse_json(text: str) -> Any:
    """What a text of JSON says. Raises ValueError also for NaN and infinity, RecursionError for bombs."""
    return json.loads(text, parse_constant=_parse_number, parse_float=_parse_number)


def _parse_number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"expected finite numbers, got {text}")
    return value


def is_kernel_file(path: str | os.PathLike[str]) -> bool:
    """Whether a path leads into /proc or /sys, whose files look regular and may have no end."""
    return os.path.realpath(path).startswith(_KERNEL_FOLDERS)


def _check_kind(
    path: str | os.PathLike[str], facts: os.stat_result, *, error_type: type[RumuError], expected: str
) -> None:
    kind = next(((en, zh) for is_kind, en, zh in _KINDS if is_kind(facts.st_mode)), None)
    if kind is None and is_kernel_file(path):
        kind = ("a file of the kernel", "系統核心的檔案")
    if kind is not None:
        found, found_zh = kind
        raise error_type(
            f"cannot be read: expected {expected}, found {found}",
            name=path,
            zh=f"{Path(path).name}：應該是檔案，卻是{found_zh}。",
        )


def _unreadable(
    path: str | os.PathLike[str], error: OSError | ValueError, error_type: type[RumuError]
) -> RumuError:
    reason = getattr(error, "strerror", None) or error
    return error_type(f"cannot be read ({reason})", name=path, zh=f"{Path(path).name}：讀不到（{reason}）。")
