import json
from pathlib import Path

import pytest
from pypdf import PdfReader
from typer.testing import CliRunner

from rumu.cli.commands import app


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))


def run(*arguments: object):
    return CliRunner().invoke(app, [str(one) for one in arguments])


def test_a_sheet_for_every_pupil(tmp_path: Path):
    (tmp_path / "names.txt").write_text("王小明\n\n李小華\n", encoding="utf-8")
    out = tmp_path / "sheet.pdf"
    done = run(
        "sheet", "永天 人水", "-o", out, "--pupils", tmp_path / "names.txt", "--pupil", "陳大文", "--json"
    )
    assert done.exit_code == 0
    facts = json.loads(done.stdout)
    assert facts["pages"] == 3 and facts["pupils"] == ["陳大文", "王小明", "李小華"]
    assert facts["master"] == "strokes" and facts["masters"] is None
    text = "".join(page.extract_text() for page in PdfReader(out).pages)
    assert all(name in text for name in facts["pupils"])


def test_where_masters_are_kept_is_said(tmp_path: Path):
    done = run("sheet", "永天", "-o", tmp_path / "s.pdf", "--master", "regular", "--master", "strokes")
    assert done.exit_code == 0 and "copy that file there" in done.stdout


def test_what_cannot_be_printed_is_said_in_one_line(tmp_path: Path):
    for arguments, code in (
        (("永龘", "--master", "regular"), 1),
        ((" ",), 2),
        (("永", "--cell", "5"), 2),
        (("永", "--cell", "120", "--times", "9"), 1),
    ):
        done = run("sheet", *arguments, "-o", tmp_path / "s.pdf")
        assert done.exit_code == code and not (tmp_path / "s.pdf").exists()
        if code == 1:
            assert done.stderr.count("\n") == 1


def test_punctuation_of_a_text_gets_no_cells(tmp_path: Path):
    done = run("sheet", "天，人。\n（水）", "-o", tmp_path / "s.pdf", "--times", "1", "--json")
    assert done.exit_code == 0 and json.loads(done.stdout)["cells"] == 3


def test_a_name_that_is_too_long_is_told_by_itself(tmp_path: Path):
    done = run("sheet", "永", "-o", tmp_path / "s.pdf", "--pupil", "陳" * 25)
    assert done.exit_code == 1 and done.stderr.startswith("rumu: expected a pupil's name of at most 24")


def test_masters_that_are_neither_file_nor_work_are_told_as_both(tmp_path: Path):
    done = run("sheet", "永", "-o", tmp_path / "s.pdf", "--master", "mine.png")
    assert done.exit_code == 1 and "mine.png: there is no such file or folder, and no work" in done.stderr
