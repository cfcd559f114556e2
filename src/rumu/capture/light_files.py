"""The files that say where each lamp stood: .lp and light_directions.txt.

They are read as other programs and people write them: separated by blanks, tabs, semicolons or commas, with
decimal points or commas, names in quotes, comments, a column of lamp strengths; as UTF-8, UTF-16 or in the
encoding of a Chinese, Japanese or western Windows.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rumu.capture.lamp_text import SEPARATORS, parse_number, read_texts, values_of, written_lines
from rumu.capture.photographs import SUFFIX, FolderImages, capture_error, place
from rumu.errors import CaptureError
from rumu.values import Bilingual, FloatArray

UNIT_TOLERANCE = 0.02
"""How far from length 1 a direction in a text file may be and still be taken for one."""
_QUOTES = {'"': '"', "'": "'", "\u201c": "\u201d", "「": "」"}
_COUNT_OF_VALUES = (3, 4, 6)  # x y z; and a strength; and strengths in red, green and blue


@dataclass(frozen=True, slots=True, eq=False)
class LampLine:
    """One line of an .lp: the image as named there, the lamp, and where the line stands.

    light: (3,) unit vector toward the lamp. length: of the vector as written. strength: of the lamp, as a
    further column tells it, the mean of red, green and blue where it tells three; None without one.
    """

    name: str
    light: FloatArray
    length: float
    strength: float | None
    where: Bilingual


@dataclass(frozen=True, slots=True, eq=False)
class LampList:
    """The lamps of a file, and what a person should know about how it was read.

    named: whether each tells its image; else they stand in the order of the photographs.
    """

    lamps: tuple[LampLine, ...]
    notes: tuple[Bilingual, ...]
    named: bool = True


# --- .lp -------------------------------------------------------------------------------------------


def read_lp(path: Path, images: FolderImages | None = None) -> LampList:
    """The lamps of an .lp file: a count, then `name x y z` for each; see the head of this module.

    images: of the folder that the names are relative to, that of the file unless given; where the file's
    encoding is not certain, the one is taken in which most names are those of images. Vectors are normalised.
    Raises CaptureError naming the file and the line: a wrong count, a malformed line, a zero vector, a lamp
    behind the sheet, an image named twice.
    """
    images = images or FolderImages(path.parent)
    readings: list[LampList] = []
    faults: list[CaptureError] = []
    for text in read_texts(path):
        try:
            readings.append(_read_lp_text(path, text))
        except CaptureError as error:
            faults.append(error)
    if not readings:
        raise faults[0]
    if len(readings) == 1:
        return readings[0]
    return max(readings, key=lambda one: sum(images.is_there(lamp.name) for lamp in one.lamps))


def _read_lp_text(path: Path, text: str) -> LampList:
    lines = written_lines(text)
    if not lines:
        raise capture_error(
            place(path, 1),
            en="expected the number of images, got an empty file",
            zh="這裡應是照片張數，檔案卻是空的",
        )
    notes = []
    count = re.fullmatch(r"(\d{1,6})[\s;,|]*", lines[0][1])
    promised = int(count[1]) if count else None
    if promised is not None:
        lines = lines[1:]
    if lines and re.fullmatch(r"\W*\w+\W+(l?x)\W+(l?y)\W+(l?z)\b.*", lines[0][1], re.IGNORECASE):
        lines = lines[1:]  # the names of the columns
    if promised is None:
        where = place(path)
        notes.append(
            Bilingual(
                f"{where.zh}：第一行沒有照片張數，已讀入全部 {len(lines)} 行。",
                f"{where.en}: the first line does not hold the number of images; all {len(lines)} lines "
                "were read",
            )
        )
    elif promised != len(lines):
        raise capture_error(
            path,
            en=f"line 1 promises {promised} images, {len(lines)} lines follow; mend the number, or add the "
            "lines that are missing",
            zh=f"第 1 行說有 {promised} 張照片，後面卻有 {len(lines)} 行；請改正數目，或補上缺少的行",
        )
    separator = _separator_of([line for _, line in lines], _split_lamp_line)
    lamps = tuple(_lamp_line(place(path, number), line, separator) for number, line in lines)
    return checked_lamps(path, lamps, notes)


def checked_lamps(
    path: Path, lamps: tuple[LampLine, ...], notes: Sequence[Bilingual], *, named: bool = True
) -> LampList:
    """The lamps of a file with its notes. Raises CaptureError for one behind the sheet or named twice."""
    if lamps and all(lamp.light[2] < 0 for lamp in lamps):
        raise capture_error(
            path,
            en="expected lamps on the camera's side (x right, y up, z to the camera), got z below 0 for "
            "all; if z runs away from the camera there, turn its sign, and that of y if y runs downward",
            zh="燈應在相機這一側（x 向右，y 向上，z 朝相機），這裡所有的 z 都小於 0；"
            "若那個程式的 z 背向相機，請把 z 變號；若 y 向下，y 也要變號",
        )
    seen: dict[str, Bilingual] = {}
    for lamp in lamps:
        _check_side(lamp.light, lamp.where)
        if named and lamp.name in seen:
            before = seen[lamp.name]
            raise capture_error(
                lamp.where,
                en=f"{lamp.name} was named before, in {before.en}",
                zh=f"{lamp.name} 在 {before.zh} 已經出現過",
            )
        seen[lamp.name] = lamp.where
    return LampList(lamps, (*notes, *_notes_of(path, lamps)), named)


def _notes_of(path: Path, lamps: Sequence[LampLine]) -> list[Bilingual]:
    where, notes = place(path), []
    lengths = np.array([lamp.length for lamp in lamps])
    if len(lamps) and lengths.max() > 1.1 * lengths.min():
        notes.append(
            Bilingual(
                f"{where.zh}：向量長短不一（{lengths.min():.3g} 到 {lengths.max():.3g}），"
                "當作從紙心量到燈的位置，只取方向。",
                f"{where.en}: the vectors have lengths from {lengths.min():.3g} to {lengths.max():.3g}; "
                "they are taken for positions as seen from the middle of the sheet, of which only the "
                "direction is used",
            )
        )
    for i, lamp in enumerate(lamps):
        twin = next((one for one in lamps[:i] if np.allclose(one.light, lamp.light, atol=1e-6)), None)
        if twin is not None:
            one, other = lamp.name or str(i + 1), twin.name or twin.where.en
            notes.append(
                Bilingual(
                    f"{lamp.where.zh}：{one} 的燈與 {other} 的相同。",
                    f"{lamp.where.en}: {one} has the same lamp as {other}",
                )
            )
            break
    return notes


def _lamp_line(where: Bilingual, line: str, separator: str) -> LampLine:
    name, values = _split_lamp_line(line, separator)
    numbers = [parse_number(value) for value in values]
    fault = _fault_of(name, values, numbers)
    if fault is not None:
        raise capture_error(
            where,
            en=f"expected 'name x y z', got {line!r}: {fault.en}",
            zh=f"這裡應是「檔名 x y z」，卻是「{line}」：{fault.zh}",
        )
    vector = np.array(numbers[:3], dtype=np.float64)
    strengths = np.array(numbers[3:], dtype=np.float64)
    length = float(np.linalg.norm(vector))
    unit = unit_vector(vector, where)
    return LampLine(name, unit, length, float(strengths.mean()) if strengths.size else None, where)


def _fault_of(name: str, values: Sequence[str], numbers: Sequence[float | None]) -> Bilingual | None:
    """What is wrong with the parts of a line; None when nothing is."""
    for value, number in zip(values, numbers, strict=True):
        if number is None:
            return Bilingual(f"「{value}」不是數字", f"{value!r} is not a number")
        if not np.isfinite(number):
            return Bilingual(f"「{value}」不是有限的數", f"{value!r} is not a finite number")
    if not name:
        return Bilingual("沒有檔名", "there is no name")
    if len(numbers) not in _COUNT_OF_VALUES:
        return Bilingual(
            f"檔名後有 {len(numbers)} 個數，應是 3 個（x y z），或再加 1 個或 3 個燈的強度",
            f"{len(numbers)} numbers follow the name, expected 3 (x y z), or 1 or 3 more for the strength "
            "of the lamp",
        )
    if min((number or 0.0 for number in numbers[3:]), default=1.0) <= 0:
        return Bilingual("燈的強度應大於 0", "the strength of the lamp must be above 0")
    return None


def _split_lamp_line(line: str, separator: str) -> tuple[str, list[str]]:
    """The name and what follows it. The name ends with its quote, its suffix, or before three values."""
    closing = _QUOTES.get(line[0])
    if closing is not None and closing in line[1:]:
        end = line.index(closing, 1)
        return line[1:end].strip(), values_of(line[end + 1 :], separator)
    between = "[^" + separator.removeprefix("[")
    parts = [(m.start(), m.end()) for m in re.finditer(between, line)]
    words = [line[start:end] for start, end in parts]
    suffixed = [i for i, word in enumerate(words) if SUFFIX.search(word)]
    before_number = [i for i in suffixed if parse_number(*words[i + 1 : i + 2] or ("",)) is not None]
    if suffixed:
        end = parts[before_number[-1] if before_number else suffixed[0]][1]
        return line[:end].strip(), values_of(line[end:], separator)
    follow = 0  # values at the end of the line
    while follow < min(3, len(words) - 1) and parse_number(words[-1 - follow]) is not None:
        follow += 1
    if follow < 3:  # a word that is no number may stand among them
        return words[0] if words else "", words[1:]
    return line[: parts[-follow - 1][1]].strip(), words[-follow:]


def _separator_of(lines: Sequence[str], split: Any) -> str:
    """The separator by which most lines can be read; without commas if it makes no difference."""

    def readable(separator: str) -> int:
        count = 0
        for line in lines:
            name, values = split(line, separator)
            numbers = [parse_number(value) for value in values]
            count += _fault_of(name, values, numbers) is None
        return count

    return max(SEPARATORS, key=readable)


def unit_vector(vector: FloatArray, where: Bilingual) -> FloatArray:
    """(3,) of length 1. Raises CaptureError, which begins with where it stands, for a zero vector."""
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise capture_error(
            where,
            en="expected a direction toward the lamp, got a zero vector",
            zh="這裡應是朝向燈的方向，卻是零向量",
        )
    return np.asarray(vector / length)


def _check_side(light: FloatArray, where: Bilingual) -> None:
    if light[2] < 0:
        raise capture_error(
            where,
            en="expected a lamp on the camera's side (z > 0, z points to the camera), "
            f"got z = {light[2]:.4g} (of length 1)",
            zh=f"燈應在相機這一側（z > 0，z 朝相機），這裡的 z = {light[2]:.4g}（長度化為 1）",
        )


# --- light_directions.txt --------------------------------------------------------------------------


def read_directions(path: Path) -> FloatArray:
    """(N, 3) unit vectors from a text file of 3 x N or N x 3 numbers, split by blanks, commas or tabs.

    Three by three numbers are read the way round that gives unit vectors. Raises CaptureError, naming the
    file and the line.
    """
    lines = written_lines(read_texts(path)[0])
    tables = [_table(path, lines, separator) for separator in SEPARATORS]
    table = next((one for one in tables if not isinstance(one, CaptureError)), None)
    if table is None:
        raise next(one for one in tables if isinstance(one, CaptureError))
    if table.shape == (3, 3):
        by_row, by_column = (
            bool(np.allclose(np.linalg.norm(table, axis=axis), 1, atol=UNIT_TOLERANCE)) for axis in (1, 0)
        )
        if by_row == by_column:
            raise capture_error(
                path,
                en="3 x 3 numbers may be read by rows or by columns; write an .lp file, "
                "which names each image beside its lamp",
                zh="3 x 3 個數可以按行讀，也可以按列讀；請改寫成 .lp 檔，在每盞燈旁寫出照片檔名",
            )
        table = table if by_row else table.T
    elif table.shape[1] != 3:
        table = table.T
    lights = []
    for i, row in enumerate(table, start=1):
        where = Bilingual(f"{path.name} 第 {i} 盞燈", f"{path.name} lamp {i}")
        lights.append(unit_vector(row, where))
        _check_side(lights[-1], where)
    return np.array(lights)


def _table(path: Path, lines: Sequence[tuple[int, str]], separator: str) -> FloatArray | CaptureError:
    """The numbers of the lines, of shape (3, N) or (N, 3), or why they are no such table."""
    rows = [values_of(line, separator) for _, line in lines]
    numbers = [[parse_number(word) for word in row] for row in rows]
    for (line, _), row, values in zip(lines, rows, numbers, strict=True):
        wrong = next((w for w, v in zip(row, values, strict=True) if v is None or not np.isfinite(v)), None)
        if wrong is not None:
            named = SUFFIX.search(wrong) is not None
            return capture_error(
                place(path, line),
                en=f"expected a table of 3 x N or N x 3 numbers, got {wrong!r}"
                + ("; a file that names its images must end in .lp" if named else ""),
                zh=f"這裡應是 3 x N 或 N x 3 個數的表，卻有「{wrong}」"
                + ("；寫有照片檔名的檔案，檔名要以 .lp 結尾" if named else ""),
            )
        if len(values) != len(numbers[0]):
            return capture_error(
                place(path, line),
                en=f"expected a table of 3 x N or N x 3 numbers, got {len(values)} of them after lines of "
                f"{len(numbers[0])}",
                zh=f"這裡應是 3 x N 或 N x 3 個數的表，這一行卻有 {len(values)} 個數，"
                f"前面每行 {len(numbers[0])} 個",
            )
    shape = (len(numbers), len(numbers[0]) if numbers else 0)
    if 3 not in shape:
        return capture_error(
            path,
            en=f"expected a table of 3 x N or N x 3 finite numbers, got {shape}",
            zh=f"這裡應是 3 x N 或 N x 3 個數的表，卻是 {shape[0]} x {shape[1]}",
        )
    return np.array(numbers, dtype=np.float64)


def lp_text(names: Sequence[str], lights: FloatArray) -> str:
    """The text of an .lp. lights: (N, 3) unit vectors toward the lamps; those that are NaN are left out."""
    told = [(name, light) for name, light in zip(names, lights, strict=True) if np.isfinite(light).all()]
    lines = [f"{name} {light[0]:.6f} {light[1]:.6f} {light[2]:.6f}" for name, light in told]
    return "\n".join([str(len(lines)), *lines]) + "\n"
