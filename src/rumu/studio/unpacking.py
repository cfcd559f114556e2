"""Unpack an uploaded zip into a folder: nothing outside it, and no more than the limits allow."""

from __future__ import annotations

import lzma
import shutil
import stat
import struct
import zipfile
import zlib
from collections.abc import Callable, Set
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rumu.containment import leads_out, safe_name
from rumu.errors import DiskFull
from rumu.outputs import is_full
from rumu.studio.errors import Unusable
from rumu.studio.zip_names import ENCODINGS, decode_names
from rumu.values import Bilingual

HEAD = 512  # bytes of a file that tell what it is
_CHUNK = 2**20
_ENCRYPTED = 0x1 | 0x40 | 0x2000  # flags of a zip's entry
_METHODS = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA}
_JUNK = {"__macosx", ".ds_store", "thumbs.db", "ehthumbs.db", "desktop.ini", ".spotlight-v100", ".trashes"}
_JUNK |= {"@eadir", ".fseventsd", ".appledouble", "icon\r"}
"""Names, in lower case, of what systems and network drives add to folders."""

_OTHER_ARCHIVES = (
    (b"Rar!", 0, "RAR"),
    (b"7z\xbc\xaf\x27\x1c", 0, "7z"),
    (b"\x1f\x8b", 0, "gzip"),
    (b"BZh", 0, "bzip2"),
    (b"\xfd7zXZ", 0, "xz"),
    (b"ustar", 257, "tar"),
)
_BROKEN = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, lzma.LZMAError, struct.error,
    EOFError, ValueError, OverflowError, NotImplementedError, RuntimeError,
)  # fmt: skip
"""What Python raises while it reads a zip that is damaged."""


@dataclass(frozen=True, slots=True)
class ZipLimits:
    """Limits of an uploaded zip.

    files: entries. file_bytes, all_bytes: of one entry and of all, unpacked. ratio: how many times larger
    than the zip all entries may be, from ratio_from bytes on; text is compressed 20 to 1 at most, a bomb
    1000 to 1. directory_bytes: of the zip's list of entries, which is read as a whole.
    """

    files: int = 20_000
    file_bytes: int = 512 * 2**20
    all_bytes: int = 4 * 2**30
    ratio: int = 100
    ratio_from: int = 16 * 2**20
    directory_bytes: int = 8 * 2**20


@dataclass(frozen=True, slots=True)
class Unpacked:
    """folder: of the unpacked files. assumed: what had to be assumed of their names, None for nothing."""

    folder: Path
    assumed: Bilingual | None


def folder_name(sent: str) -> str:
    """Return a folder name for a zip's file name: `課堂 一.zip` gives `課堂 一`."""
    name = PurePosixPath(sent.replace("\\", "/")).name.removesuffix(".zip")
    plain = "".join(c for c in name if c.isprintable() and c not in '<>:"|?*')[:60].strip(" .")
    return safe_name(plain) or "collection"


def check_zip(head: bytes) -> None:
    """Raise Unusable unless a file that begins with these HEAD bytes may be a zip."""
    if head.startswith(b"PK"):
        return
    for start, at, kind in _OTHER_ARCHIVES:
        if head[at:].startswith(start):
            raise Unusable(
                "no_zip",
                zh=f"這是 {kind} 檔，不是 zip 檔；請改壓成 zip 再送。",
                en=f"This is a {kind} file, not a zip; pack the files as a zip and send that.",
            )
    raise Unusable("no_zip", zh="這不是 zip 檔。", en="Expected a zip file; this is something else.")


def unpack(
    packed: Path,
    folder: Path,
    *,
    limits: ZipLimits | None = None,
    written: Callable[[str], bool] | None = None,
) -> Unpacked:
    """Unpack a zip into an empty folder.

    written: by its name, whether a file gets its content; the others stay empty. None for all.

    Names are checked before the first byte is written, and bytes are counted as they are written, since
    the sizes that a zip states may be false. Files are written under their `safe_name`; those that macOS,
    Windows and network drives add are left out. Raises Unusable, or DiskFull.
    """
    limits = limits or ZipLimits()
    folder.mkdir(parents=True, exist_ok=True)
    with packed.open("rb") as stream:
        check_zip(stream.read(HEAD))
    _check_directory(packed, limits)
    try:
        archive = zipfile.ZipFile(packed)
    except (*_BROKEN, OSError) as error:
        raise _not_whole() from error
    with archive:
        names, encoding = decode_names(archive, archive.infolist())
        files = _files_by_name(archive.infolist(), names)
        _check_entries(files, packed, folder, limits)
        empty = [name for name in files if written is not None and not written(name)]
        _write_all(archive, files, folder, limits, max_bytes=_max_bytes(packed, limits), empty=set(empty))
    if not encoding:
        return Unpacked(folder, None)
    known_as = ENCODINGS[encoding]
    return Unpacked(
        folder,
        Bilingual(
            zh=f"zip 檔沒有說明檔名的編碼，以 {known_as} 讀出。",
            en=f"The zip does not say how its file names are written; they were read as {known_as}.",
        ),
    )


# --- checks before anything is written -------------------------------------------------------------


def _check_directory(packed: Path, limits: ZipLimits) -> None:
    """Raise Unusable when the zip's list of entries is missing, or too large to be read as a whole."""
    with packed.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(0, size - 22 - 2**16 - 20))
        end = stream.read()
        at = end.rfind(b"PK\x05\x06")
        if at < 0 or len(end) < at + 22:
            raise _not_whole()
        directory = int.from_bytes(end[at + 12 : at + 16], "little")
        if directory == 0xFFFFFFFF and end[max(0, at - 20) : at].startswith(b"PK\x06\x07"):  # zip64
            stream.seek(min(int.from_bytes(end[at - 12 : at - 4], "little"), size))
            directory = int.from_bytes(stream.read(48)[40:48], "little")
    if directory > limits.directory_bytes:
        raise _too_large(zh="檔案太多", en="it holds too many files")


def _files_by_name(entries: list[zipfile.ZipInfo], names: list[str]) -> dict[str, zipfile.ZipInfo]:
    """The entries that are files which a person packed, by names with '/'; the same file twice once.

    Raises Unusable for two different files of one name.
    """
    files: dict[str, zipfile.ZipInfo] = {}
    taken: dict[str, zipfile.ZipInfo] = {}
    for entry, sent in zip(entries, names, strict=True):
        name = sent.replace("\\", "/")
        parts = name.lower().split("/")
        if not parts[-1] or parts[-1].startswith("._") or _JUNK.intersection(parts):
            continue
        first = taken.setdefault(safe_name(name) or name, entry)
        if first is entry:
            files[name] = entry
        elif (first.CRC, first.file_size) != (entry.CRC, entry.file_size):
            raise _two_files(name)
    return files


def _check_entries(files: dict[str, zipfile.ZipInfo], packed: Path, folder: Path, limits: ZipLimits) -> None:
    if len(files) > limits.files:
        raise _too_large(
            zh=f"有 {len(files)} 個檔案，最多 {limits.files} 個",
            en=f"{len(files)} files, at most {limits.files}",
        )
    for name, entry in files.items():
        if stat.S_IFMT(entry.external_attr >> 16) not in (0, stat.S_IFREG):
            raise Unusable(
                "zip_names",
                zh=f"zip 檔裡的「{name[:80]}」是連結或裝置，不是檔案；請放入檔案本身。",
                en=f"The zip holds a link or a device, not a file: {name[:80]!r}. Pack the file itself.",
            )
        if leads_out(name):
            raise Unusable(
                "zip_names",
                zh=f"zip 檔裡有指向資料夾以外的檔名：「{name[:80]}」。請只壓縮資料夾裡的檔案。",
                en=f"The zip names a file that leads out of its folder: {name[:80]!r}. "
                "Pack only files of one folder.",
            )
        if entry.flag_bits & _ENCRYPTED:
            raise Unusable(
                "zip_password",
                zh="zip 檔有密碼；請壓成沒有密碼的 zip 再送。",
                en="The zip file has a password; pack the files without one and send that.",
            )
        if entry.compress_type not in _METHODS:
            method = zipfile.compressor_names.get(entry.compress_type, str(entry.compress_type))  # type: ignore[attr-defined]
            raise Unusable(
                "zip_method",
                zh=f"zip 檔用了無法讀取的壓縮方式（{method}）；請用一般的方式（deflate）壓縮。",
                en=f"The zip is compressed by {method}, which cannot be read; use deflate, the usual one.",
            )
    stated = sum(entry.file_size for entry in files.values())
    if stated > _max_bytes(packed, limits) or any(
        entry.file_size > limits.file_bytes for entry in files.values()
    ):
        raise _too_large(zh="比這麼大的 zip 檔該有的多", en="more than a zip of this size should hold")
    if stated > shutil.disk_usage(folder).free:
        raise DiskFull("files", stated)


def _max_bytes(packed: Path, limits: ZipLimits) -> int:
    return min(limits.all_bytes, max(limits.ratio_from, limits.ratio * packed.stat().st_size))


# --- writing ---------------------------------------------------------------------------------------


def _write_all(
    archive: zipfile.ZipFile,
    files: dict[str, zipfile.ZipInfo],
    folder: Path,
    limits: ZipLimits,
    *,
    max_bytes: int,
    empty: Set[str],
) -> None:
    left = max_bytes
    for name, entry in files.items():
        target = folder.joinpath(*safe_name(name).split("/"))
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            if name in empty:
                target.open("xb").close()
                continue
            left -= _write_entry(archive, entry, target, name, max_bytes=min(limits.file_bytes, left))
        except (FileExistsError, NotADirectoryError, IsADirectoryError) as error:
            raise _two_files(name) from error
        except OSError as error:
            if is_full(error):
                raise DiskFull("files") from error
            raise _damaged(name) from error


def _write_entry(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path, name: str, *, max_bytes: int
) -> int:
    """Write one file; the number of its bytes. Raises Unusable when it is damaged or too large."""
    count = 0
    try:
        with archive.open(entry) as source, target.open("xb") as sink:
            while chunk := source.read(_CHUNK):
                count += len(chunk)
                if count > max_bytes:
                    raise _too_large(
                        zh="比這麼大的 zip 檔該有的多", en="more than a zip of this size should hold"
                    )
                sink.write(chunk)
    except _BROKEN as error:
        raise _damaged(name) from error
    return count


# --- refusals --------------------------------------------------------------------------------------


def _not_whole() -> Unusable:
    return Unusable(
        "no_zip",
        zh="這不是完整的 zip 檔：缺了結尾，可能沒有下載或複製完。請重新壓縮再送。",
        en="Expected a whole zip file; the end of this one is missing or damaged, as after an interrupted "
        "download. Pack the files again and send that.",
    )


def _damaged(name: str) -> Unusable:
    return Unusable(
        "zip_damaged",
        zh=f"zip 檔裡的「{name[:80]}」已損壞，無法解開。請重新壓縮再送。",
        en=f"The file {name[:80]!r} in the zip is damaged and cannot be unpacked. "
        "Pack the files again and send that.",
    )


def _two_files(name: str) -> Unusable:
    return Unusable(
        "zip_names",
        zh=f"zip 檔裡有兩個不同的檔案同名：「{name[:80]}」。請改名再壓縮。",
        en=f"The zip holds two different files of the same name: {name[:80]!r}. "
        "Rename one of them and pack again.",
    )


def _too_large(*, zh: str, en: str) -> Unusable:
    return Unusable("zip_bomb", zh=f"zip 檔解開後太大：{zh}。", en=f"The zip file unpacks to too much: {en}.")
