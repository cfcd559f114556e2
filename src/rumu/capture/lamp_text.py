"""Lamp files as text: their encoding, their lines without comments, and the numbers in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from rumu.capture.photographs import capture_error
from rumu.errors import CaptureError
from rumu.inputs import open_file

SEPARATORS = (r"[\s;|]+", r"[\s;|,]+")
"""What stands between two values; with the first a comma inside a number is its decimal sign."""

_MOST_BYTES = 4 * 2**20  # of a lamp file: a dome of a thousand lamps has 100 KB
_LEGACY_ENCODINGS = ("gb18030", "big5hkscs", "cp932", "cp1252")  # of a Windows, tried where it is not Unicode
_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # .xlsx and .ods, .xls
_COMMENT = ("#", "//", ";", "%")
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?", re.IGNORECASE)


def parse_number(word: str) -> float | None:
    """A number with a decimal point or comma; NaN and infinity as they are called; None for other words."""
    plain = word.replace("\u2212", "-")
    if re.fullmatch(r"[+-]?(nan|inf|infinity)", plain, re.IGNORECASE):
        return float(plain)
    return float(plain.replace(",", ".")) if _NUMBER.fullmatch(plain) else None


def values_of(text: str, separator: str) -> list[str]:
    """The words of a text up to a comment."""
    words = [word.strip("\"'") for word in re.split(separator, text.strip()) if word.strip("\"'")]
    ends = (i for i, word in enumerate(words) if word.startswith(("#", "//")))
    return words[: next(ends, len(words))]


def written_lines(text: str) -> list[tuple[int, str]]:
    """The lines that hold something, with their numbers, without comments."""
    lines = (
        (i, line.strip(" \t\r\n\f\xa0\u3000\u200b\ufeff")) for i, line in enumerate(text.splitlines(), 1)
    )
    return [(i, line) for i, line in lines if line and not line.startswith(_COMMENT)]


def read_texts(path: Path) -> list[str]:
    """What the file says, once for each encoding that may be meant."""
    with open_file(path, error_type=CaptureError, expected="a text file") as file:
        data = file.read(_MOST_BYTES + 1).rstrip(b"\x1a")
    if data.startswith(_WORKBOOKS):
        raise capture_error(
            path,
            en="expected a text file, found the workbook of a spreadsheet; save it as CSV UTF-8 there",
            zh="這裡應是文字檔，卻是試算表活頁簿；請在試算表裡另存為「CSV UTF-8」",
        )
    texts = [] if len(data) > _MOST_BYTES else [_decode(data, encoding) for encoding in _encodings(data)]
    readable = [text for text in texts if text is not None and not re.search(r"[\0-\x08\x0e-\x1f]", text)]
    if not readable:
        raise capture_error(
            path, en="expected a text file, found other data", zh="這裡應是文字檔，內容卻不是文字"
        )
    return readable


def _encodings(data: bytes) -> Sequence[str]:
    if data.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return ("utf-32",)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return ("utf-16",)
    if b"\0" in data:  # Latin letters in UTF-16 without a mark at the head: every second byte is 0
        return ("utf-16-le",) if data[1::2].count(0) > data[::2].count(0) else ("utf-16-be",)
    return ("utf-8-sig",) if _decode(data, "utf-8-sig") is not None else _LEGACY_ENCODINGS


def _decode(data: bytes, encoding: str) -> str | None:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return None
