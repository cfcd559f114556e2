"""sheet: practice sheets to print, which `rumu page` reads back as marks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.options import AsJson, known_script_name
from rumu.cli.terminal import Outcome, print_outcome, working


@print_outcome
def sheet(
    *,
    text: Annotated[str, typer.Argument(metavar="TEXT", help="The characters to write, such as 永天人水.")],
    out: Annotated[Path, typer.Option("-o", "--out", help="PDF to write.")],
    master: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MASTER",
            help="Whose writing: strokes (of copybooks), a script (its starter works), a work, a collection, "
            "a font, a picture, a folder or labels.csv; may be repeated, the first with a character counts.",
        ),
    ] = None,
    paper: Annotated[Literal["A4", "Letter"], typer.Option(help="The paper.")] = "A4",
    cell: Annotated[float, typer.Option(min=12, max=160, help="Side of a cell in millimetres.")] = 28.0,
    grid: Annotated[
        Literal["mi", "nine", "tian", "hui", "none"],
        typer.Option(
            help="Lines in the cells: mi 米字格, nine 九宮格, tian 田字格, hui 回宮格, none (corners)."
        ),
    ] = "mi",
    model: Annotated[
        Literal["faint", "outlined", "beside", "shrinking", "none"],
        typer.Option(
            help="How the master helps: faint to write over (描紅), outlined (雙鉤), beside, shrinking from "
            "cell to cell, or none."
        ),
    ] = "faint",
    times: Annotated[
        int, typer.Option(min=0, max=500, help="Cells to write for each character; 0 fills whole rows.")
    ] = 0,
    strokes: Annotated[
        bool,
        typer.Option("--strokes/--no-strokes", help="Print the order of strokes above, where known."),
    ] = True,
    pupil: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Print one for this pupil, whom its code names; may be repeated."),
    ] = None,
    pupils: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A text with the name of one pupil on each line.")
    ] = None,
    script: Annotated[
        str | None,
        typer.Option(
            metavar="[seal|clerical|regular|running|cursive]",
            callback=known_script_name,
            help="The script of a font or of pictures, which do not say it.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """A practice sheet to print; photographs of it come back as marks by `rumu page`."""
    from dataclasses import replace

    from rumu.gallery.sheet_masters import choose_masters, masters_file
    from rumu.outputs import whole_file
    from rumu.pages.sheet_layout import SheetPage, lay_out
    from rumu.pages.sheet_pdf import sheet_pdf

    characters = "".join(text.split())
    if not characters:
        raise typer.BadParameter("expected characters to write, got none", param_hint="'TEXT'")
    names = [*(pupil or ()), *(_read_names(pupils) if pupils else ())]
    with working("Drawing"):
        masters = choose_masters(characters, master or (), script=script)  # type: ignore[arg-type]
        whole = SheetPage(
            text=characters, master=masters.name, paper=paper, cell=cell, grid=grid, help=model, times=times,
            strokes=strokes,
        )  # fmt: skip
        pages = lay_out(whole)
        printed = [replace(page, pupil=name) for name in names or ("",) for page in pages]
        data = sheet_pdf(printed, masters.shapes)
        with whole_file(out) as part:
            part.write_bytes(data)
    kept = masters_file(masters.name) if masters.name.startswith("#") else None
    facts = {
        "out": out, "sheet": pages[0].sheet, "pages": len(printed), "pupils": names, "master": masters.name,
        "masters": kept, "cells": sum(cell.is_for_writing for page in pages for cell in page.cells),
    }  # fmt: skip
    lines = [f"{out}: {len(printed)} pages, sheet {pages[0].sheet}"]
    if kept is not None:
        lines.append(f"  its masters are kept in {kept}; to read it on another machine, copy that file there")
    return Outcome(facts, "\n".join(lines))


def _read_names(path: Path) -> list[str]:
    """The names of pupils, one on each line."""
    from rumu.encodings import decode_text
    from rumu.errors import ImageError
    from rumu.inputs import MAX_TEXT, read_file

    decoded = decode_text(read_file(path, error_type=ImageError, expected="names of pupils", most=MAX_TEXT))
    names = [line.strip() for line in (decoded.text if decoded else "").splitlines() if line.strip()]
    if not names:
        raise ImageError("expected the name of a pupil on each line, found none", name=path)
    return names
