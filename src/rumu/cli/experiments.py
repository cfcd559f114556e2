"""experiments run: figures on data with human marks, printed so that anyone can check them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.options import AsJson
from rumu.cli.outcome import Outcome, ends_well
from rumu.cli.progress import bar

Name = Literal["e3c"]


def register(app: typer.Typer) -> None:
    rooms = typer.Typer(
        help="What the marks are worth, measured.", no_args_is_help=True, rich_markup_mode=None
    )
    rooms.callback()(lambda: None)  # keeps `run` a word of its own while it is the only one
    rooms.command("run")(run)
    app.add_typer(rooms, name="experiments")


@ends_well
def run(
    name: Annotated[Name, typer.Argument(help="e3c: agreement with human marks, whole characters held out.")],
    data: Annotated[
        Path, typer.Option(envvar="RUMU_DATA", help="Folder of the data sets (or RUMU_DATA).")
    ] = Path("../shared/data"),
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Folder for tables, one row a copy.")
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Run one experiment and print its figures."""
    from importlib import import_module

    experiment = import_module(f"rumu.experiments.{name}")
    with bar(f"Running {name}") as advance:
        result = experiment.run(data, out=out, progress=advance)
    return Outcome(result.summary(), result.text())
