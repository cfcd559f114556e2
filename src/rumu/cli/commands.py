"""The commands, thin: every heavy import stands inside its command, so that `rumu --help` is instant."""

from __future__ import annotations

from typing import Annotated, cast

import typer

import rumu
from rumu.cli import (
    assess,
    calibrate,
    card,
    demo,
    extensions,
    find,
    gallery,
    gallery_import,
    lamps,
    page,
    reconstruct,
    rti,
    serve,
    sheet,
    surfaces,
)
from rumu.cli.terminal import FINE, speak_plainly, tell_wrong_usage

_UsageError = cast("type[Exception]", typer.BadParameter.__base__)  # typer has no name for it
app = typer.Typer(
    name="rumu",
    help="Chinese calligraphy as 3-D surfaces, and an honest mark for a learner's copy.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # the rich help costs more time than the rest of the start
    pretty_exceptions_enable=False,
)
for command in (
    demo.demo,
    card.card,
    lamps.lamps,
    reconstruct.reconstruct,
    rti.rti,
    surfaces.relief,
    surfaces.relight,
    surfaces.stl,
    surfaces.mesh,
    assess.assess,
    sheet.sheet,
    calibrate.calibrate,
    find.find,
    page.page,
    serve.serve,
):
    app.command()(command)
gallery.app.command("import")(gallery_import.import_works)
app.add_typer(gallery.app, name="gallery")
extensions.register(app)


def _version(asked: bool) -> None:
    if asked:
        print(f"rumu {rumu.__version__}")
        raise typer.Exit


@app.callback()
def _rumu(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    pass


def run(arguments: list[str]) -> object:
    """Run one command and return what the process ends with, as sys.exit takes it."""
    speak_plainly()
    try:
        ended = app(args=arguments, prog_name="rumu", standalone_mode=False)
    except _UsageError as error:
        return tell_wrong_usage(error, as_json="--json" in arguments)
    except SystemExit as end:
        return end.code
    return ended if isinstance(ended, int) else FINE
