"""Commands that other distributions add, by the entry point group `rumu.commands`.

An entry point's name is the command's; its object is a function that registers it with a Typer application.
A known command whose distribution is not installed says how to install it.
"""

from __future__ import annotations

from importlib.metadata import entry_points

import typer

GROUP = "rumu.commands"
KNOWN = {
    "experiments": (
        "the experiments come with the laboratory, which is not installed: in a checkout of rumu run "
        "`scripts/install lab`, or `pip install ./lab`"
    ),
}
"""Command -> what to do where nothing provides it."""


def register(app: typer.Typer) -> None:
    """Register the commands of other distributions, and a hint for each known one that is missing."""
    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    for entry in installed.values():
        entry.load()(app)
    for name in KNOWN.keys() - installed.keys():
        app.command(
            name, hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True}
        )(_missing)


def _missing(context: typer.Context) -> None:
    name = str(context.info_name)
    typer.echo(f"rumu {name}: {KNOWN[name]}", err=True)
    raise typer.Exit(1)
