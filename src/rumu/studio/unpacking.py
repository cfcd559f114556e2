"""A zip that somebody sent becomes a folder: nothing outside of it, and no more than was agreed."""

from __future__ import annotations

import stat
import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rumu.studio.errors import Unusable

_PIECE = 2**20
_ODD = set('\\:*?"<>|')  # in names: other systems read more into them


@dataclass(frozen=True, slots=True)
class ZipLimits:
    """files: entries. file_bytes, all_bytes: of one and of all, unpacked. ratio: how many times larger than
    the zip
    all may be; text packs at 20 to 1 at most, a bomb at 1000."""

    files: int = 20_000
    file_bytes: int = 512 * 2**20
    all_bytes: int = 4 * 2**30
    ratio: int = 100
    ratio_from: int = 16 * 2**20


def folder_name(sent: str) -> str:
    """What a zip's own name says, as the name of a folder: `課堂 一.zip` is `課堂 一`."""
    name = PurePosixPath(sent.replace("\\", "/")).name.removesuffix(".zip")
    plain = "".join(c for c in name if c.isprintable() and c not in _ODD)[:60].strip(" .")
    return plain or "collection"


def unpack(packed: Path, folder: Path, *, limits: ZipLimits | None = None) -> Path:
    """Unpack a zip into an empty folder, made where there is none; the folder that holds its files, one level
    down where all lie in one.

    Names are looked at before the first byte is written, and bytes are counted as they are written: what a
    zip says of itself proves nothing. Raises Unusable.
    """
    limits = limits or ZipLimits()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with zipfile.ZipFile(packed) as archive:
            entries = [entry for entry in archive.infolist() if _wanted(entry)]
            if len(entries) > limits.files:
                raise _too_much(f"{len(entries)} files, at most {limits.files}")
            targets = [_target(entry, folder) for entry in entries]
            _write_all(archive, entries, targets, limits, most=_most(packed, limits))
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


def _most(packed: Path, limits: ZipLimits) -> int:
    return min(limits.all_bytes, max(limits.ratio_from, limits.ratio * packed.stat().st_size))


def _wanted(entry: zipfile.ZipInfo) -> bool:
    """Neither a folder nor what a Mac leaves in every zip."""
    return not (
        entry.is_dir() or entry.filename.startswith("__MACOSX/") or entry.filename.endswith(".DS_Store")
    )


def _target(entry: zipfile.ZipInfo, folder: Path) -> Path:
    """Where an entry goes. labels.csv speaks of files by their names, so names stay, once they prove
    harmless."""
    name = PurePosixPath(entry.filename)
    kind = stat.S_IFMT(entry.external_attr >> 16)
    harmless = (
        not name.is_absolute()
        and 0 < len(name.parts) <= 12
        and all(_plain(part) for part in name.parts)
        and kind in (0, stat.S_IFREG)
    )
    target = folder.joinpath(*name.parts) if harmless else folder
    if not harmless or not target.resolve().is_relative_to(folder.resolve()) or target == folder:
        raise Unusable(
            "zip_names",
            zh="zip 檔裡有不安全的檔名。",
            en=f"The zip names a file that leads out of its folder: {entry.filename[:80]!r}.",
        )
    return target


def _plain(part: str) -> bool:
    return part not in ("", ".", "..") and len(part) <= 150 and part.isprintable() and not set(part) & _ODD


def _write_all(
    archive: zipfile.ZipFile,
    entries: list[zipfile.ZipInfo],
    targets: list[Path],
    limits: ZipLimits,
    *,
    most: int,
) -> None:
    written = 0
    for entry, target in zip(entries, targets, strict=True):
        target.parent.mkdir(parents=True, exist_ok=True)
        own = 0
        with archive.open(entry) as source, target.open("xb") as sink:
            while piece := source.read(_PIECE):
                own, written = own + len(piece), written + len(piece)
                if own > limits.file_bytes or written > most:
                    raise _too_much("more than a zip of this size should hold")
                sink.write(piece)


def _too_much(what: str) -> Unusable:
    return Unusable("zip_bomb", zh="zip 檔解開後太大。", en=f"The zip file unpacks to too much: {what}.")
