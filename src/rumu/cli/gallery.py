"""gallery list | show: the works that come with the package."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rumu.cli.options import AsJson
from rumu.cli.outcome import Outcome, ends_well

if TYPE_CHECKING:
    from rumu.gallery.works import Work


def register(app: typer.Typer) -> None:
    rooms = typer.Typer(help="The works that come with rumu.", no_args_is_help=True, rich_markup_mode=None)
    rooms.command("list")(list_works)
    rooms.command("show")(show)
    app.add_typer(rooms, name="gallery")


@ends_well
def list_works(
    script: Annotated[
        str | None, typer.Option(help="Only this script: seal, clerical, regular, running, cursive.")
    ] = None,
    character: Annotated[str | None, typer.Option(help="Only this character.")] = None,
    as_json: AsJson = False,
) -> Outcome:
    """The works: id, character, script, hand, licence."""
    from rumu.gallery.works import starter_works

    works = starter_works(script=script, character=character)
    if not works:
        return Outcome({"works": []}, "no work matches")
    lines = [f"{w.id:<18} {w.character}  {w.script:<9} {w.hand.en} {w.hand.zh}" for w in works]
    return Outcome({"works": [_facts(work) for work in works]}, "\n".join(lines))


@ends_well
def show(
    work_id: Annotated[str, typer.Argument(metavar="ID", help="Id of a work, as `gallery list` prints it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="PNG to write the picture to.")] = None,
    as_json: AsJson = False,
) -> Outcome:
    """One work: whose hand, from where, under which licence; with -o its picture."""
    from rumu.gallery.works import find_work

    work = find_work(work_id)
    if out is not None:
        _copied(work.path, out)
    lines = [
        f"{work.title.zh} {work.title.en} ({work.id})",
        f"  hand: {work.hand.zh} {work.hand.en}, {work.period.zh} {work.period.en}",
        f"  shows: {work.material.zh} {work.material.en}",
        f"  source: {work.source}",
        f"  licence: {work.licence}; {work.attribution}",
        f"  picture: {out or work.path}",
    ]
    return Outcome({**_facts(work), "file": out}, "\n".join(lines))


def _copied(source: Path, target: Path) -> None:
    from rumu.outputs import whole_file

    if target.suffix.lower() != ".png":
        raise typer.BadParameter(f"expected a name that ends in .png, got {target}", param_hint="'-o'")
    with whole_file(target) as part:
        part.write_bytes(source.read_bytes())


def _facts(work: Work) -> dict[str, Any]:
    from rumu.cli.outcome import plain

    facts: dict[str, Any] = plain(work)
    return facts
