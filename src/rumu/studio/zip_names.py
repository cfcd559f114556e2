"""The names of a zip's files, of which old programs do not say in which encoding they are written.

A zip says that a name is UTF-8, or says nothing; then Windows has written GBK in China, Big5 in Taiwan and
Shift-JIS in Japan. All such names of a zip are taken as written in one encoding: the one in which a table of
the zip names the files, else the one in which their characters are the most common. A library that guesses
from longer texts is wrong for one name in four, when there are only two short ones.
"""

from __future__ import annotations

import contextlib
import struct
import unicodedata
import zipfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import PurePosixPath

ENCODINGS = {"gb18030": "GBK", "cp950": "Big5", "cp932": "Shift-JIS", "cp949": "EUC-KR", "cp437": "CP 437"}
"""What names may be written in, by Python's name, with the name that people know."""

_IS_UTF8 = 0x800  # flag of a zip's entry
_UNICODE_NAME = 0x7075  # extra field that Info-ZIP writes
_MAX_TABLE = 2**20  # bytes of a table that is read for the names in it
_MAX_TABLES = 8
_COMMON, _RARE, _UNUSUAL = 1.0, 0.35, 0.05  # weights of characters by the level of their standard


def decode_names(archive: zipfile.ZipFile, entries: Sequence[zipfile.ZipInfo]) -> tuple[list[str], str]:
    """The names of entries, and the encoding that was assumed; '' when the zip says it or all are ASCII.

    Of a name with an end within (NUL) the whole is returned.
    """
    stated = {index: name for index, entry in enumerate(entries) if (name := _stated_name(entry)) is not None}
    raw = {
        index: entry.orig_filename.encode("cp437")
        for index, entry in enumerate(entries)
        if index not in stated
    }
    encoding = _choose_encoding(list(raw.values()), lambda: _tables(archive, entries))
    names = stated | {index: data.decode(encoding, "replace") for index, data in raw.items()}
    return [names[index] for index in range(len(entries))], encoding if encoding in ENCODINGS else ""


def _stated_name(entry: zipfile.ZipInfo) -> str | None:
    """The name of an entry if the zip says how it is encoded, or if it is ASCII."""
    if entry.flag_bits & _IS_UTF8 or entry.orig_filename.isascii():
        return entry.orig_filename
    raw, extra = entry.orig_filename.encode("cp437"), entry.extra
    while len(extra) >= 4:
        kind, size = struct.unpack_from("<HH", extra)
        field, extra = extra[4 : 4 + size], extra[4 + size :]
        if kind == _UNICODE_NAME and field[:5] == struct.pack("<BI", 1, zlib.crc32(raw)):
            with contextlib.suppress(UnicodeDecodeError):
                return field[5:].decode()
    return None


def _choose_encoding(raw: Sequence[bytes], tables: Callable[[], str]) -> str:
    if not raw:
        return "utf-8"
    if (names := _decode_all(raw, "utf-8")) is not None and _are_words(names):
        return "utf-8"
    candidates = {
        encoding: names
        for encoding in ("gb18030", "cp950", "cp932")
        if (names := _decode_all(raw, encoding)) is not None
    }
    if not candidates:
        return "cp949" if _decode_all(raw, "cp949") is not None else "cp437"
    text = tables()
    found = {
        encoding: sum(_stem(name) in text for name in names if not name.isascii())
        for encoding, names in candidates.items()
    }
    return max(
        candidates, key=lambda encoding: (found[encoding], _commonness(candidates[encoding], encoding))
    )


def _decode_all(raw: Sequence[bytes], encoding: str) -> list[str] | None:
    try:
        return [data.decode(encoding) for data in raw]
    except UnicodeDecodeError:
        return None


def _are_words(names: Sequence[str]) -> bool:
    """Whether names read as UTF-8 are words; 水 in GBK is also UTF-8 for a sign that nobody writes."""
    letters = [c for name in names for c in name if not c.isascii()]
    return any(ord(c) > 0x7FF for c in letters) or all(
        unicodedata.combining(c) or unicodedata.name(c, "").startswith("LATIN") for c in letters
    )


def _commonness(names: Sequence[str], encoding: str) -> float:
    """How common the characters are on average, by the levels of the standard that they belong to."""
    weights = [_weight(c.encode(encoding), encoding) for name in names for c in name if not c.isascii()]
    return sum(weights) / max(1, len(weights))


def _weight(code: bytes, encoding: str) -> float:
    if len(code) != 2:
        return _UNUSUAL
    value = code[0] << 8 | code[1]
    if encoding == "gb18030":
        if code[1] < 0xA1:  # beyond GB 2312
            return _UNUSUAL
        return _COMMON if 0xB000 <= value < 0xD800 else _RARE if 0xA100 <= value < 0xF800 else _UNUSUAL
    if encoding == "cp950":
        return _COMMON if 0xA440 <= value < 0xC680 else _RARE if 0xA140 <= value < 0xF9D6 else _UNUSUAL
    kana_or_common = 0x829F <= value < 0x8397 or 0x889F <= value < 0x9873
    return _COMMON if kana_or_common else _RARE if 0x8140 <= value < 0xEAA5 else _UNUSUAL


def _stem(name: str) -> str:
    return unicodedata.normalize("NFC", PurePosixPath(name.replace("\\", "/")).name)


def _tables(archive: zipfile.ZipFile, entries: Sequence[zipfile.ZipInfo]) -> str:
    """The text of the zip's tables and lamp files, as far as they are in UTF-8 or UTF-16."""
    endings = (".csv", ".lp", ".dome", ".txt", ".jsonl")
    tables = [entry for entry in entries if entry.orig_filename.lower().endswith(endings)]
    texts = []
    for entry in tables[:_MAX_TABLES]:
        with contextlib.suppress(Exception):  # a table that cannot be read is told of when it is unpacked
            with archive.open(entry) as stream:
                data = stream.read(_MAX_TABLE)
            encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8"
            texts.append(data.decode(encoding, "ignore" if len(data) == _MAX_TABLE else "strict"))
    return unicodedata.normalize("NFC", "\n".join(texts))
