"""The documentation says what is there, and all of it."""

from __future__ import annotations

import inspect
import re
import shlex
import typing
from pathlib import Path

import pytest
import typer

from rumu.cli.commands import app

ROOT = Path(__file__).parents[1]
CLI = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def commands(group=None, path=("rumu",)) -> dict[str, object]:
    """'rumu gallery list' -> its command, for every command there is."""
    group = group or typer.main.get_command(app)
    found = {}
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            found |= commands(command, (*path, name))
        else:
            found[" ".join((*path, name))] = command
    return found


COMMANDS = commands()


def sections() -> dict[str, str]:
    """'rumu gallery list' -> the text below that heading."""
    parts = re.split(r"^## (.+)$", CLI, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def options(command) -> set[str]:
    return {
        name
        for parameter in command.params
        if parameter.param_type_name == "option"
        for name in (*parameter.opts, *parameter.secondary_opts)
        if name != "--help"
    }


def test_there_are_the_commands_that_were_promised():
    assert {name.split()[1] for name in COMMANDS} == {
        *("card", "demo", "reconstruct", "relief", "relight", "assess", "calibrate", "find", "gallery"),
        *("experiments", "lamps", "mesh", "page", "rti", "serve", "sheet", "stl"),
    }


def test_exactly_the_commands_are_documented():
    assert set(sections()) == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_exactly_the_options_are_documented(name):
    rows = re.findall(r"^\| (`-.*?) \|", sections()[name], flags=re.MULTILINE)
    documented = {option for row in rows for option in re.findall(r"`(-[^`]+)`", row)}
    assert documented == options(COMMANDS[name])


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_speaks_json(name):
    assert "--json" in options(COMMANDS[name])


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_and_option_has_help(name):
    assert COMMANDS[name].help
    assert all(p.help for p in COMMANDS[name].params if p.name != "help")


@pytest.mark.parametrize("name", COMMANDS)
def test_choices_are_listed(name):
    hints = typing.get_type_hints(inspect.unwrap(COMMANDS[name].callback)).values()
    choices = [
        c for hint in hints if typing.get_origin(hint) is typing.Literal for c in typing.get_args(hint)
    ]
    assert [choice for choice in choices if str(choice) not in sections()[name]] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if not re.match(r"\w+:", target):
            assert (page.parent / target).exists(), f"{page.name} -> {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_in_code_exist(page):
    text = page.read_text(encoding="utf-8")
    for line in re.findall(r"^    (rumu .+)$", text, flags=re.MULTILINE):
        for call in re.split(r"&&", line.split(" # ")[0]):
            words = shlex.split(call)
            name = next((n for n in COMMANDS if words[: len(n.split())] == n.split()), None)
            assert name, call
            given = {word for word in words if word.startswith("-")}
            assert given <= options(COMMANDS[name]), call


def rows_of_the_paper() -> list[tuple[int, int, str, str]]:
    """(first equation, last equation, file, function) of each row of docs/paper.md's table."""
    text = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| \((\d+)\)(?:-\((\d+)\))? \|.*\| `([\w/]+\.py)` `(\w+)` \|$", text, flags=re.MULTILINE
    )
    return [(int(first), int(last or first), file, function) for first, last, file, function in rows]


def test_the_paper_s_table_is_what_the_code_says():
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location("paper", Path(__file__).with_name("test_paper.py"))
    paper = module_from_spec(spec)
    spec.loader.exec_module(paper)
    homes, _ = paper.citations()
    told = {
        n: {(file, name)} for first, last, file, name in rows_of_the_paper() for n in range(first, last + 1)
    }
    assert told == dict(homes)
    assert sorted(told) == list(range(1, 27))
