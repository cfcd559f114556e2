"""sheet: practice sheets to print; and the marks of their photographs, which `rumu page` reads."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.options import AsJson, known_script_name
from rumu.cli.terminal import Outcome, bar, counted, print_outcome, working

_TOLD = 20  # photographs that were not read, of which the terminal tells


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
    from rumu.pages.sheet_layout import SheetPage, characters_to_write, lay_out
    from rumu.pages.sheet_pdf import sheet_pdf

    characters = characters_to_write(text)
    if not characters:
        raise typer.BadParameter(f"expected characters to write, got {text!r}", param_hint="'TEXT'")
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
    lines = [f"{out}: {counted(len(printed), 'page')}, sheet {pages[0].sheet}"]
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


def are_sheets(photos: Sequence[Path]) -> bool:
    """Whether photographs are read as our own sheets: several, a folder, a zip, a PDF, or one of a sheet."""
    if len(photos) != 1 or photos[0].is_dir():
        return True
    from rumu.errors import ImageError
    from rumu.inputs import open_file
    from rumu.pages.sheet_reading import is_sheet
    from rumu.studio.sheet_inputs import SheetPhoto, read_photo

    with open_file(photos[0], error_type=ImageError, expected="an image") as stream:
        head = stream.read(1024)
    if head.startswith(b"PK\x03\x04") or b"%PDF-" in head:
        return True
    return is_sheet(read_photo(SheetPhoto(photos[0].name, photos[0])))


def mark_sheet_photos(
    photos: Sequence[Path], out: Path, *, jobs: int | None, dask: str | None, language: Literal["zh", "en"]
) -> Outcome:
    """Mark photographs of sheets into a folder: a table, JSON, PDFs for each pupil and for the teacher."""
    from statistics import fmean

    from rumu.studio.sheet_marks import FACTS, TABLE, mark_sheets
    from rumu.studio.sheet_reports import TEACHER, write_reports

    started = time.perf_counter()
    with bar("Marking") as advance:
        found = mark_sheets(photos, out, jobs=jobs, dask=dask, advance=advance)
    reports = write_reports(found, out, language=language)
    cells = [cell for one in found for cell in one["cells"]]
    scores = [cell["score"] for cell in cells if cell["score"] is not None]
    refused = [one for one in found if one["refused"]]
    facts = {
        "out": out, "seconds": round(time.perf_counter() - started, 3), "photos": found,
        "cells": len(cells), "marked": len(scores), "reports": reports,
    }  # fmt: skip
    mean = f", mean {fmean(scores):.0f}" if scores else ""
    lines = [
        f"{counted(len(found), 'photograph')}, {len(refused)} not read; {counted(len(cells), 'character')}, "
        f"{len(scores)} marked{mean}",
        *(f"  {one['photo']}: {one['refused']}" for one in refused[:_TOLD]),
        f"  {out / TABLE}, {FACTS}, {TEACHER}, {len(reports) - 1} PDFs of pupils",
    ]
    nothing = None if scores else f"no character was marked; {TABLE} in {out} says why"
    return Outcome(facts, "\n".join(lines), refused=nothing)
