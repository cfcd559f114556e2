"""Tables as people's programs write them, and as spreadsheets open them.

Reading takes what Excel writes anywhere: UTF-8, UTF-16, GB 18030 or Big5, cells between commas, semicolons or
tabs, a first line `sep=;`, names of columns in other case or in Chinese, decimal commas, full-width digits.
"""

from __future__ import annotations

import csv
import io
import itertools
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from rumu.encodings import decode_text
from rumu.errors import RumuError
from rumu.inputs import MAX_TEXT, read_file
from rumu.values import Bilingual

SEPARATORS = {
    ",": Bilingual("逗號", "commas"),
    ";": Bilingual("分號", "semicolons"),
    "\t": Bilingual("定位字元", "tabs"),
}
"""Separator of cells -> its name, in the plural."""
BYTE_ORDER_MARK = "\ufeff"  # in front of a table in UTF-8, without which Excel misreads it
_FORMULA_STARTS = tuple("=+-@\t\r")
_NEIGHBOURS = 200  # names of files beside the table that help to tell its encoding
_WORKBOOKS = ((b"PK\x03\x04", "an .xlsx or .ods workbook"), (b"\xd0\xcf\x11\xe0", "an .xls workbook"))

Names = Mapping[str, Sequence[str]]
"""Column -> other names that it may have in a table, in any case, with blanks, hyphens or underscores."""


@dataclass(frozen=True, slots=True)
class TableRow:
    """line: in the file, from 1. cells: by column; a column is missing where the row ends too early.

    fault, fault_zh: what is wrong with the row, '' if nothing is.
    """

    line: int
    cells: Mapping[str, str]
    fault: str = ""
    fault_zh: str = ""

    def get(self, *columns: str) -> str:
        """The first of these cells that holds something, without blanks around it; '' if none does."""
        return next((text for name in columns if (text := self.cells.get(name, "").strip())), "")


@dataclass(frozen=True, slots=True)
class Table:
    """A table that was read. columns: their names, as asked for where known. encoding: for people."""

    path: Path
    columns: tuple[str, ...]
    encoding: str
    separator: str
    _text: str
    _error_type: type[RumuError]

    @property
    def description(self) -> Bilingual:
        """How it was read: encoding and separator."""
        quoted = repr(self.separator)
        between = SEPARATORS.get(self.separator, Bilingual(quoted, quoted))
        return Bilingual(
            f"{self.encoding}，以{between.zh}分隔", f"{self.encoding}, cells separated by {between.en}"
        )

    def rows(self, *, with_faulty: bool = False) -> Iterator[TableRow]:
        """The rows below the header, without empty ones.

        with_faulty: give those with a fault, too. Raises RumuError of the reader's type for such a row
        otherwise, and where the text is no CSV.
        """
        body, first, _ = _split_directive(self._text)
        lines = csv.reader(io.StringIO(body, newline=""), delimiter=self.separator)
        filled = (cells for cells in lines if any(cell.strip() for cell in cells))
        try:
            next(filled, None)  # the header
            for cells in filled:
                row = self._row(first + lines.line_num - 1, cells)
                if row.fault and not with_faulty:
                    raise self._error(row.line, row.fault, row.fault_zh)
                yield row
        except csv.Error as error:
            line = first + lines.line_num - 1
            raise self._error(
                line, f"expected a row of a CSV ({error})", f"不是 CSV 的一行（{error}）"
            ) from error

    def _row(self, line: int, cells: Sequence[str]) -> TableRow:
        named = {name: _unguard(cell) for name, cell in zip(self.columns, cells, strict=False)}
        expected, got = len(self.columns), len(cells)
        if not any(cell.strip() for cell in cells[expected:]):
            return TableRow(line, named)
        return TableRow(
            line,
            named,
            f"expected {expected} cells, got {got}; a cell that holds the separator needs quotes",
            f"應有 {expected} 格，卻有 {got} 格；格內若有分隔符號，須加引號",
        )

    def _error(self, line: int, en: str, zh: str) -> RumuError:
        return self._error_type(
            f"{self.path}, line {line}: {en}", zh=f"{self.path.name} 第 {line} 行：{zh}。"
        )

    def number(self, text: str) -> float | None:
        """The number that a cell holds, None if it holds none.

        A decimal point or comma, full-width digits, blanks between groups; '1,234' is no number unless the
        cells are separated by something that leaves the comma to the numbers.
        """
        plain = unicodedata.normalize("NFKC", text)
        plain = re.sub(r"(?<=\d)[\s'’](?=\d{3}(?!\d))", "", plain).strip().replace("−", "-")
        if not re.fullmatch(r"[+-]?[\d.,]*\d[\d.,]*(e[+-]?\d+)?", plain, flags=re.IGNORECASE):
            return None
        if (
            "," in plain and "." in plain
        ):  # the last of the two is the decimal sign, the other parts thousands
            decimal = max(",.", key=plain.rfind)
            plain = plain.replace("." if decimal == "," else ",", "")
        elif re.fullmatch(r"[+-]?[1-9]\d{0,2},\d{3}", plain) and self.separator == ",":
            return None  # thousands or a decimal comma
        try:
            return float(plain.replace(",", "."))
        except ValueError:
            return None


def read_table(
    path: str | os.PathLike[str], names: Names, *, required: Sequence[str], error_type: type[RumuError]
) -> Table:
    """Read a table with these columns and perhaps others.

    names: the columns that are known. required: those that it must have.
    Raises `error_type` that names the file when it is no table or lacks a column.
    """
    path = Path(path)
    data = read_file(path, error_type=error_type, expected="a table", most=MAX_TEXT)
    workbook = next((kind for head, kind in _WORKBOOKS if data.startswith(head)), None)
    if workbook is not None:
        raise error_type(
            f"expected a CSV, found {workbook}; save it as CSV UTF-8 in the spreadsheet",
            name=path,
            zh=f"{path.name} 是試算表活頁簿，請在試算表裡另存為「CSV UTF-8」。",
        )
    aliases = {_plain_name(alias): column for column, more in names.items() for alias in (column, *more)}
    decoded = decode_text(data, words=[*itertools.chain(*names.values()), *_neighbours(path.parent)])
    if decoded is None:
        raise error_type(
            "expected a CSV in UTF-8, UTF-16, GB 18030 or Big5, cannot read it as text",
            name=path,
            zh=f"{path.name} 不是文字檔，或編碼無法辨認；請存為 UTF-8 的 CSV。",
        )
    header, separator = _read_header(decoded.text, aliases)
    columns = _columns(header, aliases)
    if not set(required) <= set(columns):
        found = ", ".join(cell.strip() for cell in header) or "nothing"
        wanted = f"a column {required[0]!r}" if len(required) == 1 else f"the columns {','.join(required)}"
        raise error_type(
            f"expected {wanted}, found {found} in the first line",
            name=path,
            zh=f"{path.name}：第一行應有欄位 {'、'.join(required)}，卻是 {found}。",
        )
    return Table(path, columns, decoded.encoding, separator, decoded.text, error_type)


class TableWriter:
    """Writes rows to a stream as a spreadsheet opens them: UTF-8 with its mark, and no cell a formula.

    stream: opened as UTF-8 with newline="". columns: the first line.
    """

    def __init__(self, stream: TextIO, columns: Sequence[str]) -> None:
        stream.write(BYTE_ORDER_MARK)
        self._table = csv.writer(stream, lineterminator="\n")
        self._columns = tuple(columns)
        self._table.writerow(self._columns)

    def write_row(self, cells: Mapping[str, object]) -> None:
        """Write one row, by column; a column that is not given stays empty."""
        self._table.writerow([guard_cell(cells.get(name, "")) for name in self._columns])


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Rows as the text of a CSV without a byte order mark; no cell is a formula."""
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(columns)
    table.writerows([guard_cell(cell) for cell in row] for row in rows)
    return stream.getvalue()


def guard_cell(cell: object) -> object:
    """A text that a spreadsheet would take for a formula with an apostrophe before it; all else unchanged."""
    if isinstance(cell, str) and cell.startswith(_FORMULA_STARTS):
        return f"'{cell}"
    return cell


def _unguard(cell: str) -> str:
    return cell[1:] if cell[:1] == "'" and cell[1:].startswith(_FORMULA_STARTS) else cell


def _split_directive(text: str) -> tuple[str, int, str]:
    """(the table without a line `sep=;` at its top, the number of its first line, the separator stated)."""
    directive = re.match(r'"?sep=([^\w\s"]|\t)"?[;,\t]*(\r\n|\r|\n)', text, flags=re.IGNORECASE)
    return (text[directive.end() :], 2, directive[1]) if directive else (text, 1, "")


def _read_header(text: str, aliases: Mapping[str, str]) -> tuple[list[str], str]:
    """The cells of the first line that is not empty, and the separator with which most of them are known."""
    body, _, stated = _split_directive(text)
    headers = [(_first_row(body, separator), separator) for separator in stated or SEPARATORS]
    known = set(aliases.values())
    return max(headers, key=lambda one: (len(known.intersection(_columns(one[0], aliases))), len(one[0])))


def _first_row(text: str, separator: str) -> list[str]:
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    try:
        return next((cells for cells in rows if any(cell.strip() for cell in cells)), [])
    except csv.Error:
        return []


def _columns(header: Sequence[str], aliases: Mapping[str, str]) -> tuple[str, ...]:
    """The columns by their known names; a name that comes again, or is not known, stays as it stands."""
    columns: list[str] = []
    for cell in header:
        column = aliases.get(_plain_name(cell), cell.strip())
        columns.append(column if column not in columns else f"{cell.strip()} {len(columns) + 1}")
    while columns and not columns[-1].strip():
        columns.pop()
    return tuple(columns)


def _plain_name(name: str) -> str:
    """A column's name without case, blanks, hyphens, underscores and marks."""
    return re.sub(r"[\s_\-\u200b\ufeff]+", "", unicodedata.normalize("NFKC", name).casefold())


def _neighbours(folder: Path) -> list[str]:
    """Names with characters beyond ASCII of files in a folder, without their suffixes."""
    try:
        names = (Path(entry.name).stem for entry in os.scandir(folder) if not entry.name.isascii())
        return list(itertools.islice(names, _NEIGHBOURS))
    except OSError:
        return []
