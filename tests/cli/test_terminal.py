"""Whatever happens in a command, a person gets one line and a script gets one object."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, plain, print_outcome
from rumu.errors import ImageError


def ended(command, *arguments, debug=""):
    """Run a command that holds nothing but `command()`."""
    app = typer.Typer(pretty_exceptions_enable=False)

    @app.command()
    @print_outcome
    def only(*, as_json: AsJson = False) -> Outcome:
        return command()

    return CliRunner(env={"RUMU_DEBUG": debug}).invoke(app, arguments)


def fail(error):
    def command():
        raise error

    return command


def test_a_result_is_text_or_json():
    outcome = Outcome({"score": 57.0}, "57 of 100")
    assert ended(lambda: outcome).stdout == "57 of 100\n"
    assert json.loads(ended(lambda: outcome, "--json").stdout) == {"score": 57.0}


def test_a_refusal_is_told_twice_and_exits_1():
    result = ended(lambda: Outcome({"refused": "blank"}, "not marked", refused="x.png: blank"), "--json")
    assert (result.exit_code, result.stderr) == (1, "rumu: x.png: blank\n")
    assert json.loads(result.stdout) == {"refused": "blank"}


@pytest.mark.parametrize("flag", [(), ("--json",)])
def test_an_error_of_ours_is_one_line(flag):
    result = ended(fail(ImageError("x.png: expected an image,\n  got text")), *flag)
    assert (result.exit_code, result.stderr) == (1, "rumu: x.png: expected an image, got text\n")
    assert result.stdout == ('{"error": "x.png: expected an image, got text"}\n' if flag else "")


def test_an_unexpected_error_says_how_to_see_more():
    result = ended(fail(KeyError("height")))
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "rumu: unexpected KeyError: 'height' (RUMU_DEBUG=1 shows where)\n"


def test_debugging_shows_the_traceback():
    result = ended(fail(KeyError("height")), debug="1")
    assert result.exit_code == 1
    assert "Traceback" in result.stderr and "in command" in result.stderr


def test_an_error_of_the_system_names_the_file():
    result = ended(fail(PermissionError(13, "Permission denied", "shut.png")))
    assert (result.exit_code, result.stderr[:36]) == (1, "rumu: shut.png: Permission denied (R")


def test_ctrl_c_is_quiet():
    result = ended(fail(KeyboardInterrupt()))
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "")


def test_wrong_usage_exits_2():
    assert ended(fail(typer.BadParameter("no"))).exit_code == 2


@dataclass(frozen=True)
class _Mark:
    score: float
    where: Path


def test_json_holds_no_nan_and_no_numpy():
    value = {"a": np.float32(np.nan), "b": np.arange(2), "c": _Mark(float("inf"), Path("x")), "d": (1, None)}
    assert plain(value) == {"a": None, "b": [0, 1], "c": {"score": None, "where": "x"}, "d": [1, None]}


RUMU = [sys.executable, "-m", "rumu.cli"]


def test_a_reader_that_leaves_is_no_error():
    with subprocess.Popen([*RUMU, "gallery", "list", "--json"], stdout=-1, stderr=-1) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


def test_a_latin_terminal_gets_escapes_instead_of_a_crash():
    env = os.environ | {"PYTHONIOENCODING": "latin-1", "PYTHONUTF8": "0"}
    answer = subprocess.run([*RUMU, "gallery", "list", "--json"], env=env, capture_output=True, check=True)
    assert "天" in {work["character"] for work in json.loads(answer.stdout)["works"]}


START = (
    # a shell that runs the tests in the background ignores the signal, and so would the child
    "import signal, sys, time\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "print('up', flush=True)\n"
)


def end_of(script: str, *arguments: object, after: float, times: int = 1) -> tuple[int, bytes]:
    """Exit code and stderr of a program that is interrupted so many seconds after it says that it is up."""
    with subprocess.Popen(
        [sys.executable, "-c", START + script, *map(str, arguments)], stdout=-1, stderr=-1
    ) as process:
        assert process.stdout.readline()
        for _ in range(times):
            time.sleep(after)
            process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    return process.returncode, said


def test_ctrl_c_on_the_whole_program():
    script = (
        "import rumu.cli, rumu.cli.commands as c\n"
        "c.app = lambda **k: (time.sleep(0.2), print('up', flush=True), time.sleep(30))\nrumu.cli.main()"
    )
    assert end_of(script, after=1.0) == (130, b"")


def test_ctrl_c_that_a_library_swallows():
    script = (
        "import rumu.cli, rumu.cli.commands as c\n"
        "def app(**k):\n    try:\n        time.sleep(30)\n    except BaseException:\n        pass\n"
        "c.app = app\nrumu.cli.main()"
    )
    assert end_of(script, after=1.0) == (130, b"")


def test_ctrl_c_twice_ends_a_cleanup_that_hangs():
    script = (
        "import rumu.cli, rumu.cli.commands as c\n"
        "def app(**k):\n    try:\n        time.sleep(30)\n    finally:\n        time.sleep(30)\n"
        "c.app = app\nrumu.cli.main()"
    )
    assert end_of(script, after=1.5, times=2) == (130, b"")


def test_ctrl_c_while_it_imports():
    """From the first line of ours on: whatever module is being loaded."""
    script = "import rumu.cli\nsys.argv = ['rumu', *sys.argv[1:]]\nrumu.cli.main()"
    for number in range(6):
        assert end_of(script, "gallery", "list", after=0.05 + 0.07 * number)[0] in (0, 130)


@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_at_any_moment_of_a_command_with_workers(desk, jobs):
    """Before, while and after its processes start; it leaves no more than the rows that were marked.

    Each run goes on where the one before was stopped, so there are more rows than fast machines mark in all.
    """
    rows = "copy.png,master.png\n" * 5000
    (desk / "pairs.csv").write_text(f"copy,reference\n{rows}")
    before = set(desk.iterdir())
    script = "import rumu.cli\nrumu.cli.main()"
    for number in range(5):
        arguments = ("assess", "--pairs", desk / "pairs.csv", "-o", desk / "out.csv", "--jobs", jobs)
        assert end_of(script, *arguments, after=0.12 + 0.31 * number) == (130, b"")
    left = set(desk.iterdir()) - before
    assert {path.name for path in left} <= {"out.csv.unfinished"}


def test_ctrl_c_stays_ignored_where_it_was():
    """As in the background of a shell without job control."""
    script = (
        "signal.signal(signal.SIGINT, signal.SIG_IGN)\nimport rumu.cli, rumu.cli.commands as c\n"
        "c.app = lambda **k: time.sleep(1)\nrumu.cli.main()"
    )
    assert end_of(script, after=0.5) == (0, b"")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("sheet",), "Missing argument 'TEXT'."),
        (("nothing",), "No such command 'nothing'."),
        (("card", "-o", "c.pdf", "--paper", "A5"), "'A5' is not one of 'A4', 'Letter'."),
        (("sheet", "永", "-o", "s.pdf", "--cell", "500"), "expected less than or equal to 160, got '500'"),
        (("find", "copy.png"), "Missing option '--masters'."),
        (("assess", "copy.png"), "expected COPY --reference MASTER, or --pairs PAIRS.csv -o OUT.csv"),
    ],
)
def test_wrong_usage_is_an_object_too_where_one_is_asked_for(arguments, told, capsys, tmp_path, monkeypatch):
    from rumu.cli.commands import run

    monkeypatch.chdir(tmp_path)
    assert run(list(arguments)) == 2
    plainly = capsys.readouterr()
    assert plainly.out == "" and told in plainly.err
    assert run([*arguments, "--json"]) == 2
    asked = capsys.readouterr()
    assert told in json.loads(asked.out)["error"] and asked.err == plainly.err
