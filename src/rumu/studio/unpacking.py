"""Unpack an uploaded zip into a folder: nothing outside it, and no more than the limits allow."""

from __future__ import annotations

import stat
import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rumu.studio.errors import Unusable

_CHUNK = 2**20
_UNSAFE = set('\\:*?"<>|')  # in names: with a meaning on other systems


@dataclass(frozen=True, slots=True)
class ZipLimits:
    """Limits of an uploaded zip.

    files: entries. file_bytes, all_bytes: of one entry and of all, unpacked. ratio: how many times larger
    than the zip all entries may be, from ratio_from bytes on; text is compressed 20 to 1 at most, a bomb
    1000 to 1.
    """

    files: int = 20_000
    file_bytes: int = 512 * 2**20
    all_bytes: int = 4 * 2**30
    ratio: int = 100
    ratio_from: int = 16 * 2**20


def folder_name(sent: str) -> str:
    """Return a folder name for a zip's file name: `課堂 一.zip` gives `課堂 一`."""
    name = PurePosixPath(sent.replace("\\", "/")).name.removesuffix(".zip")
    plain = "".join(c for c in name if c.isprintable() and c not in _UNSAFE)[:60].strip(" .")
    return plain or "collection"


def unpack(packed: Path, folder: Path, *, limits: ZipLimits | None = None) -> Path:
    """Unpack a zip into an empty folder and return the folder of its files, one level down if all lie in one.

    Names are checked before the first byte is written, and bytes are counted as they are written, since
    the sizes that a zip states may be false. Raises Unusable.
    """
    limits = limits or ZipLimits()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        max_bytes = min(limits.all_bytes, max(limits.ratio_from, limits.ratio * packed.stat().st_size))
        with zipfile.ZipFile(packed) as archive:
            entries = [entry for entry in archive.infolist() if _is_file(entry)]
            if len(entries) > limits.files:
                raise _too_large(f"{len(entries)} files, at most {limits.files}")
            targets = [_target(entry, folder) for entry in entries]
            _write_all(archive, entries, targets, limits, max_bytes=max_bytes)
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, EOFError, RuntimeError) as error:
        raise Unusable(
            "no_zip",
            zh="這不是完整的 zip 檔。",
            en=f"Expected a whole zip file without a password ({error}).",
        ) from error
    except (OSError, ValueError) as error:
        raise Unusable(
            "no_zip", zh="這個 zip 檔無法解開。", en=f"The zip file cannot be unpacked ({error})."
        ) from error
    inside = list(folder.iterdir())
    return inside[0] if len(inside) == 1 and inside[0].is_dir() else folder


def _is_file(entry: zipfile.ZipInfo) -> bool:
    """Whether an entry is neither a folder nor a file that macOS adds to every zip."""
    return not (
        entry.is_dir() or entry.filename.startswith("__MACOSX/") or entry.filename.endswith(".DS_Store")
    )


def _target(entry: zipfile.ZipInfo, folder: Path) -> Path:
    """Return where to write an entry, under its name, since labels.csv refers to it. Raises Unusable."""
    name = PurePosixPath(entry.filename)
    kind = stat.S_IFMT(entry.external_attr >> 16)
    safe = (
        not name.is_absolute()
        and 0 < len(name.parts) <= 12
        and all(part not in ("", ".", "..") and len(part) <= 150 for part in name.parts)
        and all(part.isprintable() and not set(part) & _UNSAFE for part in name.parts)
        and kind in (0, stat.S_IFREG)
    )
    target = folder.joinpath(*name.parts) if safe else folder
    if not safe or not target.resolve().is_relative_to(folder.resolve()) or target == folder:
        raise Unusable(
            "zip_names",
            zh="zip 檔裡有不安全的檔名。",
            en=f"The zip names a file that leads out of its folder: {entry.filename[:80]!r}.",
        )
    return target


def _write_all(
    archive: zipfile.ZipFile,
    entries: list[zipfile.ZipInfo],
    targets: list[Path],
    limits: ZipLimits,
    *,
    max_bytes: int,
) -> None:
    all_bytes = 0
    for entry, target in zip(entries, targets, strict=True):
        target.parent.mkdir(parents=True, exist_ok=True)
        entry_bytes = 0
        with archive.open(entry) as source, target.open("xb") as sink:
            while chunk := source.read(_CHUNK):
                entry_bytes, all_bytes = entry_bytes + len(chunk), all_bytes + len(chunk)
                if entry_bytes > limits.file_bytes or all_bytes > max_bytes:
                    raise _too_large("more than a zip of this size should hold")
                sink.write(chunk)


def _too_large(what: str) -> Unusable:
    return Unusable("zip_bomb", zh="zip 檔解開後太大。", en=f"The zip file unpacks to too much: {what}.")
