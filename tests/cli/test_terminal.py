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


def test_ctrl_c_on_the_whole_program(tmp_path):
    """Interrupted while it starts or runs: code 130, no traceback."""
    script = (
        # a shell that runs the tests in the background ignores the signal, and so would the child
        "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import rumu.cli as c, time\nc.app = lambda **k: (print('up', flush=True), time.sleep(30))\nc.main()"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=-1, stderr=-1, cwd=tmp_path) as process:
        process.stdout.readline()
        time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == b""
    assert process.returncode == 130
