"""Commands of other distributions: an entry point's are there, and a missing one says how to install it."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest
import typer
from typer.testing import CliRunner

from rumu.cli import extensions


def register(app: typer.Typer) -> None:
    """What the entry point of the test names."""
    app.command("experiments")(lambda: print("loaded"))


@pytest.fixture
def run(monkeypatch):
    """Runs a command of an application to which only these entry points add commands."""

    def run_with(entries: list[EntryPoint], *words: str):
        asked = {}
        monkeypatch.setattr(extensions, "entry_points", lambda **group: asked.update(group) or entries)
        app = typer.Typer()
        app.callback()(lambda: None)
        extensions.register(app)
        assert asked == {"group": "rumu.commands"}
        return CliRunner().invoke(app, words)

    return run_with


def test_an_entry_point_brings_its_command(run):
    entry = EntryPoint("experiments", f"{__name__}:register", "rumu.commands")
    ended = run([entry], "experiments")
    assert (ended.exit_code, ended.stdout) == (0, "loaded\n")


def test_without_the_laboratory_one_line_says_how_to_install_it(run):
    ended = run([], "experiments", "run", "e3c", "--data", "somewhere")
    assert ended.exit_code == 1 and ended.stdout == ""
    (line,) = ended.stderr.splitlines()
    assert line.startswith("rumu experiments: ") and "pip install ./lab" in line


def test_a_missing_command_is_not_listed(run):
    assert "experiments" not in run([], "--help").stdout
