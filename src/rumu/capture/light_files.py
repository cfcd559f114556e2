"""The files that say where the lamps stood: .lp, light_directions.txt and capture.json."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import CaptureError
from rumu.values import FloatArray

_UNIT_TOLERANCE = 0.02  # how far from length 1 a direction in a text file may be and still be taken for one


@dataclass(frozen=True, slots=True, eq=False)
class LampLine:
    """One line of an .lp: the image as named there, the lamp's unit vector, and where the line stands."""

    name: str
    light: FloatArray
    where: str


@dataclass(frozen=True, slots=True)
class Description:
    """What capture.json says; None where it says nothing.

    slant: degrees, of all lamps. tilts: degrees, by the image's name without its suffix.
    spacing_mm: millimetres per pixel. encoding: 'auto', 'linear' or 'srgb'. mask: a file, relative.
    """

    slant: float | None = None
    tilts: dict[str, float] = field(default_factory=dict)
    spacing_mm: float | None = None
    encoding: str | None = None
    mask: str | None = None


# --- .lp -------------------------------------------------------------------------------------------


def read_lp(path: Path) -> tuple[LampLine, ...]:
    """The lines of an .lp file: a count, then `name x y z`; names may hold spaces and folders.

    Vectors are normalised. Raises CaptureError naming the file and the line: a wrong count, a malformed line,
    a zero vector, a lamp behind the sheet, an image named twice.
    """
    lines = [
        (i, line.strip()) for i, line in enumerate(_read_text(path).splitlines(), start=1) if line.strip()
    ]
    if not lines or not lines[0][1].isdecimal():
        found = repr(lines[0][1]) if lines else "an empty file"
        raise CaptureError(f"{path} line 1: expected the number of images, got {found}")
    expected, got = int(lines[0][1]), len(lines) - 1
    if expected != got:
        raise CaptureError(f"{path}: line 1 promises {expected} images, {got} lines follow")
    lamps = tuple(_lp_line(f"{path} line {number}", line) for number, line in lines[1:])
    seen: dict[str, str] = {}
    for lamp in lamps:
        if lamp.name in seen:
            raise CaptureError(f"{lamp.where}: {lamp.name} was named before, in {seen[lamp.name]}")
        seen[lamp.name] = lamp.where
    return lamps


def _lp_line(where: str, line: str) -> LampLine:
    name, *numbers = line.rsplit(None, 3)
    try:
        vector = np.array([float(n) for n in numbers])
    except ValueError:
        vector = np.array([])
    if vector.size != 3 or not np.isfinite(vector).all():
        raise CaptureError(f"{where}: expected 'name x y z', got {line!r}")
    return LampLine(name, _unit(vector, where), where)


def _unit(vector: FloatArray, where: str) -> FloatArray:
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise CaptureError(f"{where}: expected a direction toward the lamp, got a zero vector")
    if vector[2] < 0:
        raise CaptureError(
            f"{where}: expected a lamp on the camera's side (z > 0, z points to the camera), "
            f"got z = {vector[2]:g}"
        )
    return np.asarray(vector / length)


# --- light_directions.txt --------------------------------------------------------------------------


def read_directions(path: Path) -> FloatArray:
    """(N, 3) unit vectors from a text file of 3 x N or N x 3 numbers, split by blanks, commas or tabs.

    Three by three numbers are read the way round that gives unit vectors. Raises CaptureError, naming the
    file.
    """
    rows = [line.replace(",", " ").split() for line in _read_text(path).splitlines()]
    try:
        table = np.array([[float(n) for n in row] for row in rows if row and not row[0].startswith("#")])
    except ValueError:
        raise CaptureError(f"{path}: expected a table of 3 x N or N x 3 numbers") from None
    if table.ndim != 2 or 3 not in table.shape or not np.isfinite(table).all():
        raise CaptureError(f"{path}: expected a table of 3 x N or N x 3 finite numbers, got {table.shape}")
    if table.shape == (3, 3):
        by_row, by_column = (
            bool(np.allclose(np.linalg.norm(table, axis=axis), 1, atol=_UNIT_TOLERANCE)) for axis in (1, 0)
        )
        if by_row == by_column:
            raise CaptureError(
                f"{path}: 3 x 3 numbers may be read by rows or by columns; write an .lp file, "
                "which names each image beside its lamp"
            )
        table = table if by_row else table.T
    elif table.shape[1] != 3:
        table = table.T
    return np.array([_unit(row, f"{path} lamp {i}") for i, row in enumerate(table, start=1)])


# --- capture.json ----------------------------------------------------------------------------------


def read_description(path: Path) -> Description:
    """What a capture.json says. Raises CaptureError naming the file and the entry that is wrong."""
    try:
        content = json.loads(_read_text(path))
    except json.JSONDecodeError as error:
        raise CaptureError(f"{path} line {error.lineno}: expected JSON, {error.msg}") from error
    known = ("slant", "tilts", "spacing_mm", "encoding", "mask")
    if not isinstance(content, dict):
        raise CaptureError(f"{path}: expected an object {{...}} with any of {', '.join(known)}")
    unknown = [key for key in content if key not in known]
    if unknown:
        raise CaptureError(f"{path}: expected only {', '.join(known)}, found {', '.join(map(repr, unknown))}")
    tilts = content.get("tilts", {})
    if not isinstance(tilts, dict):
        raise CaptureError(f'{path}: expected "tilts" like {{"a": 0, "b": 90, "c": 180}}, got {tilts!r}')
    return Description(
        slant=_number_entry(path, content, "slant", above=0, below=90),
        tilts={name: _number_entry(path, tilts, name, above=-360.1, below=360.1) or 0.0 for name in tilts},
        spacing_mm=_number_entry(path, content, "spacing_mm", above=0, below=1000),
        encoding=_text_entry(path, content, "encoding"),
        mask=_text_entry(path, content, "mask"),
    )


def _number_entry(
    path: Path, content: dict[str, Any], key: str, *, above: float, below: float
) -> float | None:
    value = content.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not above < value < below:
        limits = f"above {above:g} and below {below:g}"
        raise CaptureError(f'{path}: expected "{key}" to be a number {limits}, got {value!r}')
    return float(value)


def _text_entry(path: Path, content: dict[str, Any], key: str) -> str | None:
    value = content.get(key)
    if value is not None and not isinstance(value, str):
        raise CaptureError(f'{path}: expected "{key}" to be text, got {value!r}')
    return value


def _read_text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CaptureError(f"{path}: cannot be read ({error.strerror})") from error
    for encoding in ("utf-8-sig", "gb18030"):  # file names written on a Chinese Windows
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise CaptureError(f"{path}: expected a text file, found other data")
