"""demo: the whole system on what comes with the package."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rumu.cli.assess import mark_facts, marked, page
from rumu.cli.options import AsJson, level_cuts
from rumu.cli.outcome import Outcome, ends_well, plain
from rumu.cli.progress import Advance, bar

if TYPE_CHECKING:
    from rumu.gallery.works import Bilingual, Sample, Work
    from rumu.report.pages import IndexSample, IndexWork
    from rumu.report.wording import Text

MARKS = "marks.json"  # also the sign by which an earlier demo is known and may be replaced


def register(app: typer.Typer) -> None:
    app.command()(demo)


@ends_well
def demo(
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the pages.")] = Path("rumu-demo"),
    no_open: Annotated[bool, typer.Option("--no-open", help="Do not open the pages in a browser.")] = False,
    as_json: AsJson = False,
) -> Outcome:
    """Mark the simulated sample copies against their masters, and show the starter works."""
    from rumu.gallery.works import starter_samples, starter_works
    from rumu.outputs import whole_folder
    from rumu.report.pages import demo_index

    samples, works = starter_samples(), starter_works()
    with whole_folder(out, marker=MARKS) as folder, bar("Marking and drawing") as advance:
        total = len(samples) + len(works)
        rows = _sample_pages(samples, folder, advance=advance, total=total)
        sheet = _sheet(works, advance=advance, done=len(samples), total=total)
        index = demo_index(rows, sheet, title="rumu 入木")
        (folder / "index.html").write_text(index, encoding="utf-8")
        facts = {"out": out, "index": out / "index.html", "samples": _facts(samples, rows)}
        (folder / MARKS).write_text(json.dumps(plain(facts), ensure_ascii=False, indent=1), encoding="utf-8")
    if not (no_open or as_json) and _has_display():
        import webbrowser

        webbrowser.open((out / "index.html").resolve().as_uri())
    return Outcome(facts, _Table(samples, rows, out))


def _sample_pages(
    samples: Sequence[Sample], folder: Path, *, advance: Advance, total: int
) -> list[IndexSample]:
    from rumu.gallery.works import find_work
    from rumu.report.pages import IndexSample
    from rumu.report.wording import SIMULATED

    cuts = level_cuts("panel")
    rows = []
    for done, sample in enumerate(samples, start=1):
        work = find_work(sample.work)
        copy, master, mark = marked(sample.path, work.path, levels=cuts, script=work.script)
        href = f"{sample.id}.html"
        names = (sample.id, f"{work.title.zh} {work.title.en}")
        page(mark, copy=copy, master=master, names=names, levels=cuts, target=folder / href, note=SIMULATED)
        faults = tuple(_both(fault.description) for fault in sample.faults)
        rows.append(IndexSample(_both(work.title), sample.degree, faults, mark, href, copy))
        advance(done, total)
    return rows


def _sheet(works: Sequence[Work], *, advance: Advance, done: int, total: int) -> list[IndexWork]:
    from rumu import pipeline
    from rumu.report.pages import IndexWork

    sheet = []
    for count, work in enumerate(works, start=1):
        surface = pipeline.surface_of(work.path)
        sheet.append(IndexWork(work.id, _both(work.title), _both(work.hand), surface))
        advance(done + count, total)
    return sheet


def _both(words: Bilingual) -> Text:
    from rumu.report.wording import Text

    return Text(words.zh, words.en)


def _facts(samples: Sequence[Sample], rows: Sequence[IndexSample]) -> list[dict[str, Any]]:
    return [
        {
            "id": sample.id,
            "work": sample.work,
            "degree": sample.degree,
            "simulated": sample.simulated,
            "page": row.href,
            **mark_facts(row.assessment),
        }
        for sample, row in zip(samples, rows, strict=True)
    ]


class _Table:
    """The marks as a table for a terminal, drawn only when it is printed."""

    def __init__(self, samples: Sequence[Sample], rows: Sequence[IndexSample], out: Path) -> None:
        self.samples, self.rows, self.out = samples, rows, out

    def __rich_console__(self, console: Any, options: Any) -> Any:
        from rich.table import Table

        table = Table(title="Simulated sample copies (nobody wrote them)", title_justify="left")
        for name in ("work", "degree simulated", "score", "interval", "level"):
            table.add_column(name, justify="right" if name in ("score", "interval") else "left")
        for sample, row in zip(self.samples, self.rows, strict=True):
            table.add_row(sample.work, sample.degree, *_mark_cells(row))
        yield table
        yield f"Pages: {self.out / 'index.html'}"


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
