"""demo: the whole system on what comes with the package."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rumu.cli.assess import assess_files, mark_facts, write_page
from rumu.cli.options import AsJson, level_cuts
from rumu.cli.terminal import Advance, Outcome, bar, plain, print_outcome

if TYPE_CHECKING:
    from rich.console import Group

    from rumu.gallery.starter import Sample
    from rumu.report.pages import IndexSample

MARKS = "marks.json"  # also the sign by which an earlier demo is known and may be replaced


@print_outcome
def demo(
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Write the samples' marks as static pages, too.")
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the gallery.")] = 8000,
    no_serve: Annotated[
        bool, typer.Option("--no-serve", help="End after the table: no gallery, no browser.")
    ] = False,
    no_open: Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")] = False,
    as_json: AsJson = False,
) -> Outcome:
    """Mark the simulated samples, then show gallery and studio in the browser until Ctrl-C."""
    from rumu.gallery.starter import starter_samples

    samples = starter_samples()
    with bar("Marking") as advance:
        if out is None:
            rows = _mark_samples(samples, advance, total=len(samples))
        else:
            rows = _write_pages(samples, out, advance)
    outcome = Outcome(_facts(samples, rows, out), _table(samples, rows, out))
    if no_serve or as_json:
        return outcome
    from rich.console import Console

    # now, and not when the command ends: the gallery is served until Ctrl-C
    Console(soft_wrap=not sys.stdout.isatty()).print(outcome.text)
    _serve_gallery(port, opens=not no_open and _has_display())
    raise typer.Exit


def _serve_gallery(port: int, *, opens: bool) -> None:
    """Serve the starter gallery, in a folder of its own unless RUMU_HOME names one, and open a browser."""
    import webbrowser

    from rumu.cli.serve import announce
    from rumu.errors import RumuError
    from rumu.gallery.catalog import open_gallery
    from rumu.homes import user_home
    from rumu.studio.job_handlers import make_first_files
    from rumu.studio.storage import Storage
    from rumu.web.server import listen, serve
    from rumu.web.settings import ServiceSettings

    home = user_home() if os.environ.get("RUMU_HOME") else user_home() / "demo"
    storage = Storage(database=str(home / "rumu.sqlite"), files=str(home / "files"))
    with bar("Hanging the gallery") as advance:
        gallery = open_gallery(database=storage.database, files=storage.files)
        make_first_files(gallery, advance)
        gallery.database.close()
    try:
        listen("127.0.0.1", port).close()
    except RumuError:
        port = 0  # somebody else serves there; a demo takes what is free
    serve(
        ServiceSettings(storage),
        host="127.0.0.1",
        port=port,
        on_listen=announce,
        on_ready=(lambda address: webbrowser.open(address.url)) if opens else None,
    )


def _write_pages(samples: Sequence[Sample], out: Path, advance: Advance) -> list[IndexSample]:
    """The marks, with a page for each and an index of them and of the starter works."""
    from rumu import pipeline
    from rumu.gallery.starter import starter_works
    from rumu.outputs import whole_folder
    from rumu.report.pages import demo_index

    works = starter_works()
    total = len(samples) + len(works)
    with whole_folder(out, marker=MARKS) as folder:
        rows = _mark_samples(samples, advance, total=total, folder=folder)
        sheet = []
        for done, work in enumerate(works, start=len(samples) + 1):
            sheet.append((work, pipeline.surface_of(work.path)))
            advance(done, total)
        index = demo_index(rows, sheet, title="rumu 入木")
        (folder / "index.html").write_text(index, encoding="utf-8")
        facts = _facts(samples, rows, out)
        (folder / MARKS).write_text(json.dumps(plain(facts), ensure_ascii=False, indent=1), encoding="utf-8")
    return rows


def _mark_samples(
    samples: Sequence[Sample], advance: Advance, *, total: int, folder: Path | None = None
) -> list[IndexSample]:
    """The marks, each with a page in the folder where one is given."""
    from rumu.gallery.starter import find_work
    from rumu.report.pages import IndexSample
    from rumu.report.wording import SIMULATED

    cuts = level_cuts("panel")
    rows = []
    for done, sample in enumerate(samples, start=1):
        work = find_work(sample.work)
        copy, master, mark = assess_files(sample.path, work.path, levels=cuts, script=work.script)
        href = ""
        if folder is not None:
            href = f"{sample.id}.html"
            names = (sample.id, f"{work.title.zh} {work.title.en}")
            target = folder / href
            write_page(
                mark, copy=copy, master=master, names=names, levels=cuts, target=target, note=SIMULATED
            )
        faults = tuple(fault.description for fault in sample.faults)
        rows.append(IndexSample(work.title, sample.degree, faults, mark, href, copy))
        advance(done, total)
    return rows


def _facts(samples: Sequence[Sample], rows: Sequence[IndexSample], out: Path | None) -> dict[str, Any]:
    marks = [
        {
            "id": sample.id,
            "work": sample.work,
            "degree": sample.degree,
            "simulated": sample.simulated,
            "page": row.href or None,
            **mark_facts(row.assessment),
        }
        for sample, row in zip(samples, rows, strict=True)
    ]
    return {"out": out, "index": out and out / "index.html", "samples": marks}


def _table(samples: Sequence[Sample], rows: Sequence[IndexSample], out: Path | None) -> Group:
    """The marks as a table for a terminal."""
    from rich.console import Group
    from rich.table import Table

    table = Table(title="Simulated sample copies (nobody wrote them)", title_justify="left")
    for name in ("work", "degree simulated", "score", "interval", "level"):
        table.add_column(name, justify="right" if name in ("score", "interval") else "left")
    for sample, row in zip(samples, rows, strict=True):
        table.add_row(sample.work, sample.degree, *_mark_cells(row))
    return Group(table, *([] if out is None else [f"Pages: {out / 'index.html'}"]))


def _mark_cells(row: IndexSample) -> tuple[str, str, str]:
    mark = row.assessment
    if mark.score is None or mark.interval is None:
        return "-", "-", f"refused: {mark.refused}"
    return f"{mark.score:.0f}", f"{mark.interval[0]:.0f} to {mark.interval[1]:.0f}", str(mark.level)


def _has_display() -> bool:
    """A browser with windows can be opened; without one, webbrowser would take the terminal over."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
