"""assess --pairs: order kept, a bad row costs nothing but itself, and the table is whole or not there."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from rumu.cli.pairs import COLUMNS, mark_row, pair_rows, read_pairs
from rumu.outputs import UnfinishedRows


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8-sig") as stream:
        return list(csv.DictReader(stream))


def table(desk: Path, *rows: str, header: str = "copy,reference", encoding: str = "utf-8") -> Path:
    path = desk / "pairs.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding=encoding)
    return path


@pytest.mark.parametrize("jobs", [1, 2])
def test_rows_keep_their_order_and_a_bad_one_its_reason(rumu, desk, jobs):
    pairs = table(
        desk,
        "copy.png,master.png",
        "cut.png,master.png",
        "a copy.png,master.png",
        "gone.png,master.png",
        "blank.png,master.png",
        "copy.png,gone.png",
        "copy.png",
        "master.png,regular-ren",
        f"{desk / 'master.png'},master.png",
    )
    ended = rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", jobs, "--json")
    rows = rows_of(desk / "out.csv")
    assert (ended.code, ended.err) == (0, "")
    assert {name: ended.facts[name] for name in ("pairs", "marked", "refused")} == {
        "pairs": 9,
        "marked": 3,
        "refused": 6,
    }
    assert tuple(rows[0]) == COLUMNS
    assert [Path(row["copy"]).name for row in rows] == [
        *("copy.png", "cut.png", "a copy.png", "gone.png", "blank.png"),
        *("copy.png", "copy.png", "master.png", "master.png"),
    ]
    assert [bool(row["refused"]) for row in rows] == [
        False,
        True,
        False,
        True,
        True,
        True,
        True,
        True,  # another character
        False,
    ]
    assert [bool(row["score"]) for row in rows] == [not row["refused"] for row in rows]
    assert "cut.png" in rows[1]["refused"] and "gone.png" in rows[3]["refused"]
    assert "expected a copy and a reference" in rows[6]["refused"]
    assert rows[7]["refused"].startswith("another character")


def test_rows_of_two_masters_in_turn_come_back_in_order(rumu, desk):
    """They are marked master by master."""
    pairs = table(desk, *["copy.png,master.png", "copy.png,a copy.png"] * 3)
    rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1)
    rows = rows_of(desk / "out.csv")
    assert [Path(row["reference"]).name for row in rows] == ["master.png", "a copy.png"] * 3
    assert len({row["score"] for row in rows[::2]}) == 1
    assert rows[0]["score"] != rows[1]["score"]


def test_remarks_are_put_into_the_table_when_asked_for(rumu, desk):
    pairs = table(desk, "copy.png,master.png")
    rumu("assess", "--pairs", pairs, "-o", desk / "plain.csv", "--jobs", 1)
    rumu("assess", "--pairs", pairs, "-o", desk / "full.csv", "--jobs", 1, "--remarks")
    plain, full = rows_of(desk / "plain.csv")[0], rows_of(desk / "full.csv")[0]
    remarks = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json").facts["remarks"]
    assert full["remarks_en"].split(" / ") == [remark["en"] for remark in remarks] != []
    assert full["remarks_zh"].split(" / ") == [remark["zh"] for remark in remarks]
    assert plain["remarks_en"] == plain["remarks_zh"] == ""
    assert plain["score"] == full["score"]


def test_remarks_of_a_table_need_a_table(rumu, desk):
    ended = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--remarks")
    assert ended.code == 2


def test_a_row_says_what_one_command_says(rumu, desk):
    rumu("assess", "--pairs", table(desk, "copy.png,master.png"), "-o", desk / "out.csv", "--jobs", 1)
    row = rows_of(desk / "out.csv")[0]
    facts = rumu("assess", desk / "copy.png", "--reference", desk / "master.png", "--json").facts
    assert float(row["score"]) == pytest.approx(facts["score"], abs=0.01)
    assert row["level"] == facts["level"]
    assert [float(row["low"]), float(row["high"])] == pytest.approx(facts["interval"], abs=0.01)
    assert float(row["ink"]) == pytest.approx(facts["parts"]["ink"], abs=0.01)
    assert float(row["angle"]) == pytest.approx(facts["pose"]["angle"], abs=0.001)


def test_a_table_from_a_spreadsheet(rumu, desk):
    """A BOM, blanks in the header, further columns, Windows line ends."""
    pairs = desk / "pairs.csv"
    pairs.write_bytes(b"\xef\xbb\xbfpupil, copy ,reference\r\nLi,a copy.png,master.png\r\n\r\n")
    assert rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1).code == 0
    assert [row["copy"] for row in rows_of(desk / "out.csv")] == ["a copy.png"]


def test_paths_may_lie_under_another_folder(rumu, desk, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "pairs.csv"
    elsewhere.write_text("copy,reference\ncopy.png,master.png\n")
    ended = rumu("assess", "--pairs", elsewhere, "-o", desk / "out.csv", "--root", desk, "--jobs", 1)
    assert ended.code == 0 and "1 marked, 0 refused" in ended.out


def test_a_table_in_which_nothing_could_be_marked(rumu, desk):
    pairs = table(desk, "gone.png,master.png", "empty.png,master.png")
    ended = rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1, "--json")
    ended.failed_with("no pair", "refused")
    assert ended.facts["refused"] == 2
    assert len(rows_of(desk / "out.csv")) == 2


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("expected the columns copy,reference", "found nothing")),
        (b"copy,master\na,b\n", ("expected the columns copy,reference", "copy, master")),
        (b"copy,reference\n", ("at least one pair",)),
        (b"copy,reference\n\xff\xfe\x00,b\n", ("UTF-8",)),
    ],
)
def test_a_table_that_is_none(rumu, desk, content, words):
    (desk / "pairs.csv").write_bytes(content)
    (desk / "out.csv").write_text("an earlier result\n")
    ended = rumu("assess", "--pairs", desk / "pairs.csv", "-o", desk / "out.csv")
    ended.failed_with("pairs.csv", *words)
    assert (desk / "out.csv").read_text() == "an earlier result\n"


def test_a_table_that_is_not_there(rumu, desk):
    rumu("assess", "--pairs", desk / "gone.csv", "-o", desk / "out.csv").failed_with(
        "gone.csv", "No such file"
    )
    rumu("assess", "--pairs", desk, "-o", desk / "out.csv").failed_with("cannot be read")


@pytest.mark.parametrize("place", ["{desk}/file.txt/out.csv", "/proc/out.csv", "{desk}"])
def test_a_table_that_cannot_be_written(rumu, desk, place):
    place = place.format(desk=desk)
    pairs = table(desk, "copy.png,master.png")
    rumu("assess", "--pairs", pairs, "-o", place, "--jobs", 1).failed_with(place)


def test_an_interrupted_run_leaves_nothing(rumu, desk, monkeypatch):
    def interrupt(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("rumu.cli.pairs.mark_row", interrupt)
    pairs = table(desk, "copy.png,master.png")
    before = sorted(desk.iterdir())
    assert rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1).code == 130
    assert sorted(desk.iterdir()) == before


@pytest.fixture
def interrupted(rumu, desk, monkeypatch):
    """Three of four rows were marked before Ctrl-C; (the arguments, copies that are marked from now on)."""
    pairs = table(
        desk, *["copy.png,master.png", "a copy.png,master.png", "cut.png,master.png", "master.png,master.png"]
    )
    args = ("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1, "--json")
    marked = []

    def mark_three(pair, **how):
        if len(marked) == 3:
            raise KeyboardInterrupt
        marked.append(pair.copy)
        return mark_row(pair, **how)

    monkeypatch.setattr("rumu.cli.pairs.mark_row", mark_three)
    assert rumu(*args).code == 130
    assert not (desk / "out.csv").exists() and (desk / "out.csv.unfinished").exists()
    again = []
    monkeypatch.setattr(
        "rumu.cli.pairs.mark_row", lambda pair, **how: again.append(pair.copy) or mark_row(pair, **how)
    )
    return args, again


def test_an_interrupted_run_goes_on_where_it_was(rumu, desk, interrupted):
    args, again = interrupted
    facts = rumu(*args).facts
    assert again == ["master.png"]
    assert (facts["pairs"], facts["kept"]) == (4, 3)
    whole = rows_of(desk / "out.csv")
    assert rumu(*args).facts["kept"] == 0  # all is marked anew once the table is whole
    assert rows_of(desk / "out.csv") == whole
    assert not list(desk.glob("out.csv.*"))


def test_a_row_that_was_cut_off_is_marked_again(rumu, desk, interrupted):
    args, again = interrupted
    unfinished = desk / "out.csv.unfinished"
    unfinished.write_bytes(unfinished.read_bytes()[:-20])
    assert rumu(*args).facts["kept"] == 2
    assert again == ["cut.png", "master.png"]


def test_a_picture_that_changed_is_marked_again(rumu, desk, interrupted):
    args, again = interrupted
    (desk / "copy.png").write_bytes((desk / "master.png").read_bytes())
    assert rumu(*args).facts["kept"] == 2
    assert again == ["copy.png", "master.png"]
    assert rows_of(desk / "out.csv")[0]["score"] == rows_of(desk / "out.csv")[3]["score"]


def test_other_terms_begin_anew(rumu, desk, interrupted):
    args, again = interrupted
    assert rumu(*args, "--framed").facts["kept"] == 0
    assert len(again) == 4


def test_rows_that_cannot_be_read_begin_anew(rumu, desk, interrupted):
    args, _ = interrupted
    unfinished = desk / "out.csv.unfinished"
    head, *rest = unfinished.read_bytes().splitlines(keepends=True)
    unfinished.write_bytes(head + b"no JSON\n" + b"".join(rest))
    assert rumu(*args).facts["kept"] == 0


def test_two_runs_do_not_write_one_table(rumu, desk):
    pairs = table(desk, "copy.png,master.png")
    other = UnfinishedRows(desk / "out.csv", key={})
    ended = rumu("assess", "--pairs", pairs, "-o", desk / "out.csv")
    other.close(finished=False)
    assert ended.code == 1 and "another run is writing it" in ended.err
    assert rumu("assess", "--pairs", pairs, "-o", desk / "out.csv").code == 0


@pytest.mark.parametrize("address", ["local", "tcp://127.0.0.1:9"])
def test_a_table_is_marked_on_a_dask_cluster(rumu, desk, monkeypatch, address):
    monkeypatch.setattr("rumu.executors._DASK_TIMEOUT", 5)
    pairs = table(desk, "copy.png,master.png", "gone.png,master.png", "a copy.png,master.png")
    out = desk / "out.csv"
    here = rumu("assess", "--pairs", pairs, "-o", out, "--jobs", 1, "--json")
    rows = rows_of(out)
    out.unlink()
    ended = rumu("assess", "--pairs", pairs, "-o", out, "--jobs", 2, "--dask", address, "--json")
    if address == "local":
        assert rows_of(out) == rows and ended.facts["marked"] == here.facts["marked"] == 2
    else:
        assert ended.code == 1 and "expected a Dask scheduler at tcp://127.0.0.1:9" in ended.err
        assert not out.exists()


def test_a_row_survives_a_fault_of_ours(monkeypatch, desk):
    def stumble(*_args, **_kwargs):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr("rumu.pipeline.assess", stumble)
    pair = next(pair_rows(read_pairs(table(desk, "copy.png,master.png"))))
    row = mark_row(pair, root=desk, terms={})
    assert row["refused"] == "unexpected ZeroDivisionError: division by zero"


def test_each_row_may_have_its_script(rumu, desk):
    """The row's own, else that of the command, else that of a starter work."""
    rumu("gallery", "show", "clerical-ren", "-o", desk / "ren.png")
    pairs = table(
        desk,
        "copy.png,master.png,seal",
        "copy.png,master.png, ",
        "copy.png,master.png,printed",
        "ren.png,clerical-ren,",
        header="copy,reference,script",
    )
    weights = ("--weights", "brushwork=1,structure=1,ink=1")
    rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1, *weights)
    seal, unknown, printed, ren = rows_of(desk / "out.csv")
    assert [row["script"] for row in (seal, unknown, printed, ren)] == ["seal", "", "", "clerical"]
    assert seal["score"] == unknown["score"] and float(seal["low"]) < float(unknown["low"])
    parts = [float(seal[name]) for name in ("brushwork", "structure", "ink")]
    assert float(seal["score"]) == pytest.approx(sum(parts) / 3, abs=0.02)
    assert "expected one of seal, clerical" in printed["refused"]
    rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1, "--script", "regular")
    assert [row["script"] for row in rows_of(desk / "out.csv")] == ["seal", "regular", "", "regular"]


def test_rows_are_read_one_by_one(desk):
    pairs = pair_rows(read_pairs(table(desk, *(f"{n}.png,master.png" for n in range(3)))))
    assert next(pairs) == ("0.png", "master.png", None, None, "")
    assert [pair.copy for pair in pairs] == ["1.png", "2.png"]


@pytest.mark.parametrize("name", ["gbk.csv", "semicolon.csv", "utf16.csv"])
def test_tables_of_spreadsheets(rumu, cases, tmp_path, name):
    """Chinese names in GB 18030 and UTF-16, semicolons, tabs; utf16.csv names a file in other characters."""
    ended = rumu(
        "assess", "--pairs", cases / "tables" / name, "-o", tmp_path / "o.csv", "--jobs", 1, "--json"
    )
    (row,) = rows_of(tmp_path / "o.csv")
    found = {"gbk.csv": ("GB 18030", ","), "semicolon.csv": ("UTF-8", ";"), "utf16.csv": ("UTF-16", "\t")}
    assert (ended.facts["encoding"], ended.facts["separator"]) == found[name]
    named = {"gbk.csv": "张三 水.png", "semicolon.csv": "a.png", "utf16.csv": "張三 水.png"}
    assert row["copy"] == named[name] and row["score"]


def test_a_table_opens_in_a_spreadsheet(rumu, desk):
    """With a byte order mark; a name that would be a formula is none; numbers stay numbers."""
    (desk / "copy.png").rename(desk / "=1+1.png")
    pairs = table(desk, "=1+1.png,master.png", "copy.png,master.png,more")
    rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1)
    assert (desk / "out.csv").read_bytes().startswith(b"\xef\xbb\xbfcopy,reference,")
    good, bad = rows_of(desk / "out.csv")
    assert good["copy"] == "'=1+1.png" and not good["refused"]
    assert all(abs(float(good[name])) < 90 for name in ("angle", "shift_x", "shift_y"))
    assert "expected 2 cells, got 3" in bad["refused"]


def test_names_from_another_machine(rumu, desk):
    """Backslashes, other case, decomposed characters, a script in Chinese."""
    (desk / "习作").mkdir()
    (desk / "copy.png").rename(desk / "习作" / "é.png")
    pairs = table(desk, "习作\\é.PNG,MASTER.png,楷书", header="习作,范本,书体", encoding="utf-8")
    assert rumu("assess", "--pairs", pairs, "-o", desk / "out.csv", "--jobs", 1).code == 0
    (row,) = rows_of(desk / "out.csv")
    assert row["score"] and row["script"] == "regular"
