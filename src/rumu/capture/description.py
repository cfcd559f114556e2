"""What capture.json says of a capture folder beside, or in place of, a list of lamps."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from rumu.capture.formats import ENCODINGS, Encoding
from rumu.capture.lamp_text import read_texts
from rumu.capture.photographs import capture_error, place

DESCRIPTION = "capture.json"
Choice = TypeVar("Choice", bound=str)


@dataclass(frozen=True, slots=True)
class Description:
    """What capture.json says; None where it says nothing.

    slant: degrees, of all lamps. tilts: degrees, by the image's name without its suffix.
    spacing_mm: millimetres per pixel. encoding: 'auto', 'linear' or 'srgb'. mask: a file, relative.
    orientation: 'exif' or 'stored', which way round the photographs are taken.
    lamps_as_given: whether the lamps are taken as they are, even where others fit better.
    """

    slant: float | None = None
    tilts: dict[str, float] = field(default_factory=dict)
    spacing_mm: float | None = None
    encoding: str | None = None
    mask: str | None = None
    orientation: str | None = None
    lamps_as_given: bool = False


def read_description(path: Path) -> Description:
    """What a capture.json says. Raises CaptureError naming the file and the entry that is wrong."""
    try:
        content = json.loads(read_texts(path)[0])
    except json.JSONDecodeError as error:
        raise capture_error(
            place(path, error.lineno),
            en=f"expected JSON, {error.msg} at column {error.colno}",
            zh=f"這裡應是 JSON，第 {error.colno} 個字處有誤（{error.msg}）",
        ) from error
    except RecursionError as error:
        raise capture_error(
            path, en="expected JSON, it is nested too deeply", zh="JSON 的層次太深"
        ) from error
    known = ("slant", "tilts", "spacing_mm", "encoding", "mask", "orientation", "lamps_as_given")
    if not isinstance(content, dict):
        raise capture_error(
            path,
            en=f"expected an object {{...}} with any of {', '.join(known)}",
            zh=f"這裡應是 {{...}}，其中可有 {'、'.join(known)}",
        )
    unknown = [key for key in content if key not in known]
    if unknown:
        found = ", ".join(map(repr, unknown))
        raise capture_error(
            path,
            en=f"expected only {', '.join(known)}, found {found}",
            zh=f"只能有 {'、'.join(known)}，卻有 {found}",
        )
    tilts = content.get("tilts", {})
    if not isinstance(tilts, dict):
        like = '{"a": 0, "b": 90, "c": 180}'
        raise capture_error(
            path,
            en=f'expected "tilts" like {like}, got {tilts!r}',
            zh=f'"tilts" 應如 {like}，卻是 {tilts!r}',
        )
    return Description(
        slant=_number_entry(path, content, "slant", above=0, below=90),
        tilts={name: _number_entry(path, tilts, name, above=-360.1, below=360.1) or 0.0 for name in tilts},
        spacing_mm=_number_entry(path, content, "spacing_mm", above=0, below=1000),
        encoding=_text_entry(path, content, "encoding"),
        mask=_text_entry(path, content, "mask"),
        orientation=_text_entry(path, content, "orientation"),
        lamps_as_given=_flag_entry(path, content, "lamps_as_given"),
    )


def _number_entry(
    path: Path, content: dict[str, Any], key: str, *, above: float, below: float
) -> float | None:
    value = content.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not above < value < below:
        raise capture_error(
            path,
            en=f'expected "{key}" to be a number above {above:g} and below {below:g}, got {value!r}',
            zh=f'"{key}" 應是大於 {above:g}、小於 {below:g} 的數，卻是 {value!r}',
        )
    return float(value)


def _text_entry(path: Path, content: dict[str, Any], key: str) -> str | None:
    value = content.get(key)
    if value is not None and not isinstance(value, str):
        raise capture_error(
            path, en=f'expected "{key}" to be text, got {value!r}', zh=f'"{key}" 應是文字，卻是 {value!r}'
        )
    return value


def _flag_entry(path: Path, content: dict[str, Any], key: str) -> bool:
    value = content.get(key, False)
    if not isinstance(value, bool):
        raise capture_error(
            path,
            en=f'expected "{key}" to be true or false, got {value!r}',
            zh=f'"{key}" 應是 true 或 false，卻是 {value!r}',
        )
    return value


def description_of(folder: Path) -> Description:
    """What the capture.json of a folder says, see `read_description`; nothing where there is none."""
    file = folder / DESCRIPTION
    return read_description(file) if file.is_file() else Description()


def encoding_of(folder: Path, description: Description, *, told: Encoding) -> Encoding:
    """How samples are read: as the caller told, else, when that is 'auto', as capture.json says."""
    return entry_among(folder, "encoding", description.encoding, ENCODINGS) if told == "auto" else told


def entry_among(folder: Path, key: str, value: str | None, known: tuple[Choice, ...]) -> Choice:
    """An entry of capture.json among those that are known; the first where there is none."""
    for one in known:
        if value in (one, None):
            return one
    raise capture_error(
        folder / DESCRIPTION,
        en=f'expected "{key}" among {", ".join(known)}, got {value!r}',
        zh=f'"{key}" 應是 {"、".join(known)} 之一，卻是 {value!r}',
    )
