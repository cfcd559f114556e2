"""Tables of spreadsheets all over the world, read and written."""

from __future__ import annotations

import csv
import io
import itertools

import pytest

from rumu.csv_tables import TableWriter, csv_text, read_table
from rumu.errors import CalibrationError, ImageError

NAMES = {"image": ("copy", "圖片", "图片"), "reference": ("範本", "范本"), "mark": ("分數", "分数", "Score")}
ROWS = [("張三 水.png", "regular-shui", "87"), ('a "b".png', "m;x,y\tz.png", "90")]


def table_of(tmp_path, data, *, required=("image", "reference")):
    path = tmp_path / "t.csv"
    path.write_bytes(data)
    return read_table(path, NAMES, required=required, error_type=ImageError)


def cells(table):
    return [tuple(row.get(name) for name in ("image", "reference", "mark")) for row in table.rows()]


def written(header, rows, *, separator=",", end="\r\n"):
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=separator, lineterminator=end)
    writer.writerow(header)
    writer.writerows(rows)
    return stream.getvalue()


ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "gb18030", "cp950"]


@pytest.mark.parametrize(("separator", "end"), [*itertools.product(",;\t", ["\n", "\r\n", "\r"])])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_encoding_separator_and_line_end(tmp_path, encoding, separator, end):
    text = written(("image", "reference", "mark"), ROWS, separator=separator, end=end)
    table = table_of(tmp_path, text.encode(encoding))
    assert cells(table) == ROWS and table.separator == separator
    assert [row.line for row in table.rows()] == [2, 3]


@pytest.mark.parametrize(
    "header",
    [
        "Image,REFERENCE,Score",
        " image , Reference ,分数",
        "圖片,範本,分數",
        "图片,范本,分数",
        "ｃｏｐｙ,范本,mark",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "gb18030"])
def test_names_of_columns_in_other_case_and_in_chinese(tmp_path, header, encoding):
    data = f"no,{header}\n1,a.png,b.png,87\n".encode(encoding)
    assert cells(table_of(tmp_path, data)) == [("a.png", "b.png", "87")]


@pytest.mark.parametrize("first", ["sep=;\r\n", "SEP=;\n", '"sep=;"\r\n', "sep=|\r\n"])
def test_a_first_line_that_names_the_separator(tmp_path, first):
    separator = "|" if "|" in first else ";"
    text = first + written(("image", "reference", "mark"), ROWS, separator=separator)
    table = table_of(tmp_path, text.encode("utf-8-sig"))
    assert cells(table) == ROWS and [row.line for row in table.rows()] == [3, 4]
    assert table.separator == separator


def test_empty_rows_and_columns_of_a_spreadsheet_do_not_count(tmp_path):
    table = table_of(
        tmp_path, b"\r\n;;\r\nimage;reference;mark;;\r\na.png;b.png;5;;\r\n;;;;\r\n\r\nc.png;d.png\r\n"
    )
    assert cells(table) == [("a.png", "b.png", "5"), ("c.png", "d.png", "")]


def test_a_row_with_too_many_cells_is_not_read_as_if_it_had_fewer(tmp_path):
    """A decimal comma between commas: 87,5 would become 87."""
    table = table_of(tmp_path, b"image,reference,mark\na.png,b.png,87,5\nc.png,d.png,60\n")
    with pytest.raises(ImageError, match=r"t.csv, line 2: expected 3 cells, got 4") as caught:
        list(table.rows())
    assert "第 2 行" in caught.value.zh
    faults = [row.fault for row in table.rows(with_faulty=True)]
    assert "quotes" in faults[0] and not faults[1]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("87.5", 87.5), ("87,5", 87.5), ("８７．５", 87.5), ("８７", 87.0), ("\u00a087\u00a0", 87.0)),
        *(
            ("1 234,5", 1234.5),
            ("1\u202f234", 1234.0),
            ("1.234,5", 1234.5),
            ("1,234.5", 1234.5),
            ("1,234", 1.234),
        ),
        *(("-3", -3.0), ("−3", -3.0), ("1e2", 100.0), ("0,125", 0.125), ("12 34", None), ("1.2.3", None)),
        *(
            ("nan", None),
            ("inf", None),
            ("", None),
            ("good", None),
            ("1,2,3", None),
            (",", None),
            ("８7分", None),
        ),
    ],
)
def test_numbers_as_people_write_them(tmp_path, text, value):
    assert table_of(tmp_path, b"image;reference\n").number(text) == value


def test_a_comma_before_three_digits_is_not_guessed_between_commas(tmp_path):
    table = table_of(tmp_path, b"image,reference\n")
    assert table.number("1,234") is None and table.number("0,125") == 0.125 and table.number("87,5") == 87.5


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"PK\x03\x04rest", "an .xlsx or .ods workbook; save it as CSV"),
        (b"\xd0\xcf\x11\xe0rest", "an .xls workbook"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\r", "cannot read it as text"),
        (b"name,other\na,b\n", "expected the columns image,reference, found name, other"),
        (b"", "found nothing"),
    ],
)
def test_what_is_no_such_table(tmp_path, data, words):
    with pytest.raises(ImageError) as caught:
        table_of(tmp_path, data)
    assert words in str(caught.value) and caught.value.zh


def test_the_error_is_the_readers_own(tmp_path):
    with pytest.raises(CalibrationError, match=r"gone.csv: cannot be read \(No such file"):
        read_table(tmp_path / "gone.csv", NAMES, required=(), error_type=CalibrationError)
    table = table_of(tmp_path, b'image,reference\n"' + b"x" * 200_000 + b'",b\n')
    with pytest.raises(ImageError, match=r"line \d+: expected a row of a CSV"):
        list(table.rows())


def test_names_of_files_beside_the_table_tell_its_encoding(tmp_path):
    (tmp_path / "嚭卣.png").write_bytes(b"")
    for encoding in ("cp950", "gb18030"):
        table = table_of(tmp_path, "image,reference\n嚭卣.png,x\n".encode(encoding))
        assert cells(table) == [("嚭卣.png", "x", "")]


def test_a_table_is_written_as_a_spreadsheet_opens_it():
    stream = io.StringIO(newline="")
    table = TableWriter(stream, ("a", "b"))
    table.write_row({"a": "=1+1", "b": -1.5})
    table.write_row({"a": "水"})
    assert stream.getvalue() == "\ufeffa,b\n'=1+1,-1.5\n水,\n"


@pytest.mark.parametrize("cell", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1"])
def test_no_text_is_a_formula_and_it_comes_back_as_it_was(tmp_path, cell):
    text = csv_text(("image", "reference"), [[cell, "x"]])
    assert next(csv.reader(io.StringIO(text.split("\n", 1)[1])))[0] == f"'{cell}"
    assert cells(table_of(tmp_path, text.encode()))[0][0] == cell.strip()


def test_numbers_stay_numbers():
    assert csv_text(("a", "b"), [[-1.5, "x"]]) == "a,b\n-1.5,x\n"
