"""A table of lamps, .csv or .tsv, as people keep it in a spreadsheet or a program exports it.

Read is what can mean one thing alone: columns that the first line names (x, y, z, or azimuth and elevation),
or three numbers for each lamp that can only be x, y, z. Everything else is refused with what to write.
"""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rumu.capture.lamp_text import parse_number, read_texts
from rumu.capture.light_files import UNIT_TOLERANCE, LampLine, LampList, checked_lamps, unit_vector
from rumu.capture.lights import direction
from rumu.capture.photographs import FolderImages, capture_error, place
from rumu.errors import CaptureError
from rumu.values import Bilingual, FloatArray

_SEPARATORS = ("\t", ";", ",", "|")
_COMMENT = ("#", "//", "%")
_COLUMNS: Mapping[str, tuple[str, ...]] = {
    "name": (
        *("name", "image", "imagename", "img", "file", "filename", "photo", "photograph", "picture", "path"),
        *("檔名", "檔案", "文件", "文件名", "照片", "圖片", "图片", "影像", "名稱", "名称"),
    ),
    "x": ("x", "lx", "lightx", "lampx", "ledx", "posx", "dirx"),
    "y": ("y", "ly", "lighty", "lampy", "ledy", "posy", "diry"),
    "z": ("z", "lz", "lightz", "lampz", "ledz", "posz", "dirz"),
    "azimuth": ("azimuth", "azimuthangle", "azimut", "azi", "az", "方位", "方位角"),
    "elevation": ("elevation", "elevationangle", "elev", "el", "altitude", "仰角", "高度角"),
    "slant": ("slant", "zenith", "zenithangle", "polarangle", "天頂角", "天顶角"),
    "strength": ("strength", "intensity", "強度", "强度"),
}
"""What the columns are called: without case, blanks, signs and units."""
_UNITS = ("deg", "degs", "degree", "degrees", "度", "mm", "cm", "m", "px")
_RADIANS = ("rad", "radian", "radians", "弧度")
_PLACES = (("x", "y", "z"), ("azimuth", "elevation"), ("azimuth", "slant"))
_ANGLES = ("azimuth", "elevation", "slant")
_FULL_TURN = 6.2832  # radians
_EXPECTED = Bilingual(
    "第一行應寫欄名：name,x,y,z（x 向右，y 向上，z 朝相機），或 name,azimuth,elevation（度）",
    "name the columns in the first line: name,x,y,z (x right, y up, z to the camera), or "
    "name,azimuth,elevation in degrees",
)


@dataclass(frozen=True, slots=True)
class _Line:
    """line: in the file, from 1. cells: without blanks around them."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _LampColumns:
    """Which cell of a row holds what. columns: by name. radians: whether angles are. other: left out."""

    columns: Mapping[str, int]
    width: int
    radians: bool = False
    other: tuple[str, ...] = ()


def read_lamp_table(path: Path, images: FolderImages) -> LampList:
    """The lamps of a table; see the head of this module.

    images: of the folder; where the encoding is not certain, the one is taken in which most names are those
    of images. The list is not `named` where the table names no image: its rows are then in the order of the
    photographs. Raises CaptureError, naming the file and the line.
    """
    readings: list[LampList] = []
    faults: list[CaptureError] = []
    for text in read_texts(path):
        try:
            readings.append(_read_text(path, text, images))
        except CaptureError as error:
            faults.append(error)
    if not readings:
        raise faults[0]
    return max(readings, key=lambda one: sum(images.is_there(lamp.name) for lamp in one.lamps))


def _read_text(path: Path, text: str, images: FolderImages) -> LampList:
    rows = _without_count(path, _rows(text))
    if not rows:
        raise capture_error(
            path,
            en=f"expected a table of lamps, got no row; {_EXPECTED.en}",
            zh=f"表中沒有內容；{_EXPECTED.zh}",
        )
    headed = not any(_is_number(cell) for cell in rows[0].cells)
    layout = _layout_of_header(path, rows[0]) if headed else _layout_of_numbers(path, rows)
    rows = rows[1:] if headed else rows
    told = [_numbers(place(path, row.line), row, layout) for row in rows]
    _check_degrees(path, told, layout)
    lamps = tuple(_lamp(path, row, one, layout) for row, one in zip(rows, told, strict=True))
    names = [lamp.name for lamp in lamps]
    numbered = _counts_up(names) and not any(images.is_there(name) for name in names)
    return checked_lamps(path, lamps, _notes(path, layout), named="name" in layout.columns and not numbered)


def _rows(text: str) -> list[_Line]:
    """The rows that hold something, by the separator with which most cells are numbers."""
    stated = re.match(r'"?sep=([^\w\s"]|\t)"?[;,\t]*(\r\n|\r|\n)', text, flags=re.IGNORECASE)
    lines = text.splitlines()
    readings = []
    for separator in (stated[1],) if stated else _SEPARATORS:
        rows = []
        for number, line in enumerate(lines, 1):
            if line.lstrip().startswith(_COMMENT) or (stated and number == 1):
                continue
            cells = next(csv.reader(io.StringIO(line), delimiter=separator, skipinitialspace=True), [])
            plain = [cell.strip(" \t\xa0\u3000\ufeff\u200b") for cell in cells]
            while plain and not plain[-1]:
                plain.pop()
            if plain:
                rows.append(_Line(number, tuple(plain)))
        readings.append(rows)
    return max(readings, key=lambda rows: sum(_is_number(cell) for row in rows for cell in row.cells))


def _number(cell: str) -> float | None:
    """The number in a cell, which may have a sign of degrees behind it."""
    return parse_number(unicodedata.normalize("NFKC", cell).removesuffix("°").strip())


def _is_number(cell: str) -> bool:
    return _number(cell) is not None


def _without_count(path: Path, rows: list[_Line]) -> list[_Line]:
    """The rows without the number of images that an .lp has in its first line."""
    if not rows or len(rows[0].cells) > 1 or not rows[0].cells[0].isdigit():
        return rows
    if int(rows[0].cells[0]) != len(rows) - 1:
        raise capture_error(
            path,
            en=f"line {rows[0].line} promises {rows[0].cells[0]} images, {len(rows) - 1} lines follow",
            zh=f"第 {rows[0].line} 行說有 {rows[0].cells[0]} 張照片，後面卻有 {len(rows) - 1} 行",
        )
    return rows[1:]


def _layout_of_header(path: Path, header: _Line) -> _LampColumns:
    """The columns by what the first line calls them."""
    known = {alias: column for column, aliases in _COLUMNS.items() for alias in aliases}
    columns: dict[str, int] = {}
    other, radians = [], False
    for i, cell in enumerate(header.cells):
        words = [word for word in re.split(r"[\W_]+", unicodedata.normalize("NFKC", cell).casefold()) if word]
        column = known.get("".join(word for word in words if word not in (*_UNITS, *_RADIANS)))
        if column is None or column in columns:
            other.append(cell)
            continue
        columns[column] = i
        radians |= column in _ANGLES and any(word in _RADIANS for word in words)
    if not any(set(one) <= set(columns) for one in _PLACES):
        found = ", ".join(header.cells)
        raise capture_error(
            place(path, header.line),
            en=f"expected columns that say where the lamps stood, got {found}; {_EXPECTED.en}",
            zh=f"這裡應有說明燈位的欄，卻是 {found}；{_EXPECTED.zh}",
        )
    places = next(one for one in _PLACES if set(one) <= set(columns))
    used = {column: i for column, i in columns.items() if column in (*places, "name", "strength")}
    other += [header.cells[i] for column, i in columns.items() if column not in used]
    return _LampColumns(used, len(header.cells), radians, tuple(other))


def _layout_of_numbers(path: Path, rows: Sequence[_Line]) -> _LampColumns:
    """The columns of a table without a header: x, y, z, if they can be nothing else, and perhaps a name."""
    width = len(rows[0].cells)
    whole = [row for row in rows if len(row.cells) == width]
    words = [i for i in range(width) if not all(_is_number(row.cells[i]) for row in whole)]
    numbers = [i for i in range(width) if i not in words]
    if len(numbers) == 4 and _counts_up([row.cells[numbers[0]] for row in whole]):
        numbers = numbers[1:]
    if len(words) > 1 or len(numbers) != 3 or not _surely_xyz(whole, numbers):
        raise capture_error(
            place(path, rows[0].line),
            en=f"cannot tell what the numbers mean in {', '.join(rows[0].cells)!r}; {_EXPECTED.en}",
            zh=f"看不出「{'，'.join(rows[0].cells)}」中各數的意思；{_EXPECTED.zh}",
        )
    columns = dict(zip("xyz", numbers, strict=True))
    return _LampColumns({**columns, "name": words[0]} if words else columns, width)


def _surely_xyz(rows: Sequence[_Line], columns: Sequence[int]) -> bool:
    """Whether three columns are x, y, z: of length 1, or with a second that is no elevation in degrees."""
    told = np.array([[_number(row.cells[i]) for i in columns] for row in rows], dtype=np.float64)
    of_one = bool((np.abs(np.linalg.norm(told, axis=1) - 1) <= UNIT_TOLERANCE).all())
    return of_one or bool(((told[:, 1] < 0) | (told[:, 1] > 90)).any())


def _counts_up(cells: Sequence[str]) -> bool:
    """Whether they are 0, 1, 2... or 1, 2, 3..."""
    first = int(cells[0]) if cells and cells[0].isdigit() else 2
    return first < 2 and all(cell.isdigit() and int(cell) == i for i, cell in enumerate(cells, first))


def _numbers(where: Bilingual, row: _Line, layout: _LampColumns) -> dict[str, float]:
    """What a row tells, by column."""
    if len(row.cells) > layout.width:
        raise capture_error(
            where,
            en=f"expected {layout.width} cells, as in the first line, got {len(row.cells)}; decimal commas "
            "need another sign between the cells",
            zh=f"應像第一行有 {layout.width} 格，卻有 {len(row.cells)} 格；小數用逗號時，格間要用別的符號",
        )
    told = {}
    for column, i in layout.columns.items():
        cell = row.cells[i] if i < len(row.cells) else ""
        if column == "name":
            continue
        number = _number(cell)
        if number is None or not np.isfinite(number):
            raise capture_error(
                where,
                en=f"expected a number for {column}, got {cell!r}",
                zh=f"{column} 應是數字，卻是「{cell}」",
            )
        told[column] = number
    return told


def _check_degrees(path: Path, told: Sequence[Mapping[str, float]], layout: _LampColumns) -> None:
    """Raise CaptureError for angles that are so small that they seem to be radians."""
    angles = [abs(one[column]) for one in told for column in _ANGLES if column in one]
    if layout.radians or "x" in layout.columns or max(angles, default=360.0) > _FULL_TURN:
        return
    raise capture_error(
        path,
        en=f"expected angles in degrees, got none above {max(angles):g}; if they are radians, say so in the "
        "first line: azimuth (rad)",
        zh=f"角度應以度計，卻都不超過 {max(angles):g}；若是弧度，請在第一行註明：azimuth (rad)",
    )


def _lamp(path: Path, row: _Line, told: Mapping[str, float], layout: _LampColumns) -> LampLine:
    where, at = place(path, row.line), layout.columns.get("name")
    name = "" if at is None or at >= len(row.cells) else row.cells[at]
    if at is not None and not name:
        raise capture_error(
            where, en="expected the name of an image, got none", zh="這裡應有照片檔名，卻沒有"
        )
    if told.get("strength", 1.0) <= 0:
        raise capture_error(
            where,
            en=f"the strength of the lamp must be above 0, got {told['strength']:g}",
            zh=f"燈的強度應大於 0，卻是 {told['strength']:g}",
        )
    vector = _vector(where, told, radians=layout.radians)
    length = float(np.linalg.norm(vector))
    return LampLine(name, unit_vector(vector, where), length, told.get("strength"), where)


def _vector(where: Bilingual, told: Mapping[str, float], *, radians: bool) -> FloatArray:
    """(3,) toward the lamp, of any length."""
    if "azimuth" not in told:
        return np.array([told["x"], told["y"], told["z"]])
    column = "elevation" if "elevation" in told else "slant"
    turn = 180 / np.pi if radians else 1.0
    tilt, up = told["azimuth"] * turn, told[column] * turn
    if not 0 <= up <= 90:
        raise capture_error(
            where,
            en=f"expected {column} from 0 to 90 degrees, got {up:g}",
            zh=f"{column} 應在 0 到 90 度之間，卻是 {up:g}",
        )
    return direction(tilt=tilt, slant=90 - up if column == "elevation" else up)


def _notes(path: Path, layout: _LampColumns) -> list[Bilingual]:
    where, notes = place(path), []
    if "x" not in layout.columns:
        notes.append(
            Bilingual(
                f"{where.zh}：方位角從照片右方起、逆時針計；若是別的算法，浮雕會轉向或反轉。",
                f"{where.en}: azimuth is taken to run counter-clockwise from the right of the photographs; "
                "where it was counted otherwise, the relief comes out turned or mirrored",
            )
        )
    if layout.other:
        names = ", ".join(layout.other)
        notes.append(
            Bilingual(
                f"{where.zh}：這些欄沒有用到：{names}。", f"{where.en}: columns that are not used: {names}"
            )
        )
    return notes
