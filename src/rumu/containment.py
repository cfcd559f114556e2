r"""Names of files that others wrote, found within one folder and never outside it.

Zips, lamp files, labels.csv and capture.json name files. What comes from the network may name anything:
`/etc/passwd`, `..\..\x`, `C:\x`, `\\server\share`, `~/x`, `file:///x`, `NUL`. So every name of an upload is
looked up by `FolderFiles.find`, and every name in a zip is checked by `leads_out` and written as `safe_name`
gives it.
"""

from __future__ import annotations

import hashlib
import os
import re
import unicodedata
from pathlib import Path, PurePosixPath

_ELSEWHERE = re.compile(r"[A-Za-z]:|[A-Za-z][A-Za-z0-9+.-]+:/|/|~([^/]*/|$)")
"""The start of a name that stands for another place: a drive, a URL, a root or a share, a home folder."""

_DEVICES = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])", re.IGNORECASE)
_FORBIDDEN = set('<>:"|?*\\/')  # in the names of files on Windows
_MAX_BYTES = 200  # of one part of a name in UTF-8; file systems take 255
_MAX_PARTS = 40


def leads_out(name: str) -> bool:
    """Whether a name is no relative one that stays in its folder, on any operating system."""
    parts = _split(name)
    return not parts or _ELSEWHERE.match(name.replace("\\", "/")) is not None or ".." in parts


def safe_name(name: str) -> str:
    """A relative name as every file system takes it, with '/' between its parts.

    Composed characters (NFC); '_' in place of what Windows forbids and before the names of its devices;
    very long parts shortened, with a digest in place of what is lost.
    """
    return "/".join(_safe_part(part) for part in _split(name))


class FolderFiles:
    """The files of a folder, by names that others wrote. folder: nothing outside it is ever found."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self._listed: dict[Path, dict[str, list[Path]]] = {}

    def find(self, name: str, *, beside: Path | None = None) -> Path | None:
        """The file of a name, None where there is none or the name leads out of the folder.

        Names match in composed and decomposed characters, with either slash, as `safe_name` writes them, and
        in other case where only one file is meant. beside: a folder within, which the name is relative to.
        """
        start = self._folder if beside is None else beside.resolve()
        if not start.is_relative_to(self._folder) or _ELSEWHERE.match(name.replace("\\", "/")):
            return None
        path: Path | None = start
        for part in _split(name):
            if path is None or (part == ".." and path == self._folder):
                return None
            path = path.parent if part == ".." else self._entry(path, part)
        return path if path is not None and self.holds(path) else None

    def holds(self, path: Path) -> bool:
        """Whether this is a file within the folder, links resolved."""
        try:
            return path.is_file() and path.resolve().is_relative_to(self._folder)
        except (OSError, ValueError):
            return False

    def _entry(self, folder: Path, part: str) -> Path | None:
        plain = folder / _safe_part(part)
        if plain.exists():
            return plain
        alike = self._list(folder).get(_safe_part(part).casefold(), [])
        same = [path for path in alike if _composed(path.name) == _composed(part)] or alike
        return same[0] if len(same) == 1 else None

    def _list(self, folder: Path) -> dict[str, list[Path]]:
        """The entries of a folder by their safe names, whatever their case; read once."""
        if folder not in self._listed:
            entries: dict[str, list[Path]] = {}
            try:
                for name in sorted(os.listdir(folder)):  # noqa: PTH208  of thousands of entries
                    entries.setdefault(_safe_part(name).casefold(), []).append(folder / name)
            except OSError:
                entries = {}
            self._listed[folder] = entries
        return self._listed[folder]


def _split(name: str) -> tuple[str, ...]:
    """The parts of a name, without '.'; nothing for a name that no file system takes.

    '.. ' and '...' are '..', since Windows takes blanks and dots from the end of a part.
    """
    if any(ord(c) < 32 or ord(c) == 127 or 0xD800 <= ord(c) <= 0xDFFF for c in name):
        return ()
    parts = [part for part in name.replace("\\", "/").split("/") if part not in ("", ".")]
    if len(parts) > _MAX_PARTS:
        return ()
    return tuple(part if part.strip(" .") else ".." for part in parts)


def _safe_part(part: str) -> str:
    plain = "".join("_" if c in _FORBIDDEN else c for c in _composed(part)).rstrip(" .") or "_"
    if _DEVICES.fullmatch(plain.split(".")[0].rstrip(" ")):
        plain = f"_{plain}"
    if len(plain.encode()) <= _MAX_BYTES:
        return plain
    suffix = PurePosixPath(plain).suffix
    suffix = suffix if len(suffix.encode()) <= 16 else ""
    start = plain.encode()[: _MAX_BYTES - 40].decode(errors="ignore")
    return f"{start}-{hashlib.sha256(plain.encode()).hexdigest()[:16]}{suffix}"


def _composed(text: str) -> str:
    return unicodedata.normalize("NFC", text)
