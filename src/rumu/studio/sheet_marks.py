"""Photographs of practice sheets -> marks of what was written in their cells; never a mark for another cell.

What a photograph gives is kept as soon as it is known, so that a run that was ended goes on where it stood.
The table and the JSON are made of it at the end.
"""

from __future__ import annotations

import functools
import itertools
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import rumu
from rumu.csv_tables import TableWriter
from rumu.errors import OutputError, RefusedImage, RumuError
from rumu.executors import cores, in_order, open_executor, submit
from rumu.outputs import UnfinishedRows, whole_file
from rumu.studio.sheet_inputs import SheetPhoto, read_photo, sheet_photos

if TYPE_CHECKING:
    from rumu.gallery.sheet_masters import SheetMaster
    from rumu.pipeline import PreparedMaster
    from rumu.values import Assessment, Surface

TABLE, FACTS = "marks.csv", "marks.json"
CELLS = "cells"
"""Folder of the pictures of cells, in it one for each photograph under its digest."""
COLUMNS = (
    *("photo", "pupil", "sheet", "page", "row", "column", "character", "score", "level", "low", "high"),
    *("percentile", "brushwork", "structure", "ink", "refused", "refused_zh", "praise_zh", "praise_en"),
    *("remarks_zh", "remarks_en"),
)
_SHADE = 0.15  # step across an outline, over the contrast, below which it is that of a shade and no stroke's
_FEW = 2  # photographs for each process from which they, and not their cells, are spread over processes

Facts = dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class CellTask:
    """What is needed to mark one cell. picture: (n, n) gray. masters: by the name in the sheet's code."""

    picture: npt.NDArray[np.uint8]
    masters: str
    character: str
    terms: Mapping[str, Any]


def mark_sheets(
    paths: Sequence[Path],
    out: Path,
    *,
    jobs: int | None = None,
    dask: str | None = None,
    terms: Mapping[str, Any] | None = None,
    advance: Callable[[int, int], None] = lambda done, total: None,
) -> list[Facts]:
    """Mark the sheets of photographs, folders, zips and PDFs into a folder; what is known of each photograph.

    out: new, empty, or of an earlier run; one that was interrupted goes on. jobs, dask: see `open_executor`.
    terms: levels, calibration and weights, as `pipeline.assess` takes them. advance: called with (done,
    total) photographs.
    Raises ImageError, Unusable or OutputError when nothing can be read or written; what is wrong with one
    photograph stands in its `refused`.
    """
    _check_folder(out)
    terms = dict(terms or {})
    unfinished = UnfinishedRows(out / FACTS, key={"rumu": rumu.__version__, "terms": terms})
    finished = False
    try:
        with sheet_photos(paths) as photos:
            stamps = [[photo.name, photo.digest()] for photo in photos]
            kept = {k for k in unfinished.numbers() if k < len(photos) and unfinished.row(k)[1] == stamps[k]}
            todo = [(k, photo, stamps[k][1]) for k, photo in enumerate(photos) if k not in kept]
            advance(len(kept), len(photos))
            done = itertools.count(len(kept) + 1)
            for k, facts in _mark_all(todo, out, terms, jobs=jobs or cores(), dask=dask):
                unfinished.add(k, facts, stamp=stamps[k])
                advance(next(done), len(photos))
            found = [unfinished.row(k)[0] for k in range(len(photos))]
        write_tables(found, out)
        finished = True
    finally:
        unfinished.close(finished=finished)
    return found


def mark_photo(
    photo: SheetPhoto,
    digest: str,
    *,
    out: Path,
    terms: Mapping[str, Any],
    run: Callable[[Sequence[CellTask]], Iterator[Facts]] | None = None,
) -> Facts:
    """What one photograph gives: its sheet and the marks of its cells, or why it is refused.

    run: marks the cells, in order; one after another in this process by default.
    """
    from rumu.gallery.sheet_masters import open_masters
    from rumu.pages.sheet_reading import locate_sheet, read_cells

    facts: Facts = {"photo": photo.name, "digest": digest, "refused": None, "refused_zh": None, "cells": []}
    try:
        sheet = locate_sheet(read_photo(photo))
        page = sheet.page
        names = ("sheet", "number", "count", "pupil", "master", "text", "paper", "identity")
        facts |= {name: getattr(page, name) for name in names}
        masters = open_masters(page.master, page.text)
        written = read_cells(sheet, masters.shapes)
        tasks = [CellTask(cell.picture, page.master, cell.cell.character, terms) for cell in written]
        marks = run(tasks) if run is not None else map(mark_cell, tasks)
        for found, mark in zip(written, marks, strict=True):
            place = {"row": found.cell.row, "column": found.cell.column, "character": found.cell.character}
            facts["cells"].append({**place, "polygon": np.round(found.polygon, 2).tolist(), **mark})
        facts["empty"] = sum(cell.is_for_writing for cell in page.cells) - len(written)
        _keep_pictures(
            out / CELLS / digest, facts["cells"], [one.picture for one in written], sheet.name_picture()
        )
    except RefusedImage as error:
        facts |= {"refused": f"{error.reason}: {error.en}", "refused_zh": error.zh}
    except RumuError as error:  # one photograph must never cost the others
        facts |= {"refused": " ".join(error.en.split()), "refused_zh": error.zh, "cells": []}
    return facts


def mark_cell(task: CellTask) -> Facts:
    """The mark of one cell, as values of JSON."""
    return cell_facts(assess_cell(task)[0])


def assess_cell(task: CellTask) -> tuple[Assessment, SheetMaster]:
    """The mark of one cell, and the master that was printed there."""
    from rumu import pipeline

    prepared, master = prepared_master(task.masters, task.character)
    mark = pipeline.assess(
        surface_of_cell(task.picture),
        prepared,
        script=master.script,
        character=task.character,
        framed=True,
        **task.terms,
    )
    return mark, master


def surface_of_cell(picture: npt.NDArray[np.uint8]) -> Surface | npt.NDArray[np.uint8]:
    """The surface of a cell's picture, on which no grid is looked for, since the print has been taken away.

    The picture itself where it holds no writing: whoever marks it says why.
    """
    from rumu.surface.ink import InkMaskSettings, find_ink
    from rumu.surface.relief import relief
    from rumu.surface.writing import WritingLimits

    # the sheet as a whole was sharp enough; a small cell of it, enlarged, has edges several pixels wide
    settings = InkMaskSettings(grid=False, writing=WritingLimits(blurred=_SHADE))
    try:
        return relief(find_ink(picture, settings=settings))
    except RefusedImage:
        return picture


@functools.lru_cache(maxsize=64)
def prepared_master(masters: str, character: str) -> tuple[PreparedMaster, SheetMaster]:
    """The master of a cell, made ready once in each process, and as it was printed."""
    from rumu import pipeline
    from rumu.gallery.sheet_masters import open_masters

    master = open_masters(masters, character).by_character[character]
    surface = surface_of_cell(master.picture)
    prepared = pipeline.prepare_master(surface, character=character, script=master.script)
    return prepared, master


def _mark_all(
    todo: Sequence[tuple[int, SheetPhoto, str]],
    out: Path,
    terms: Mapping[str, Any],
    *,
    jobs: int,
    dask: str | None,
) -> Iterator[tuple[int, Facts]]:
    """Number and facts of each photograph: many are spread over processes whole, of few the cells are."""
    work = functools.partial(_mark_numbered, out=out, terms=terms)
    with open_executor(jobs if todo else 1, dask=dask) as (executor, processes):
        if executor is None or len(todo) >= _FEW * processes:
            yield from in_order(work, todo, processes=processes, executor=executor)
            return
        for _ in range(processes):
            submit(executor, _warm_up)  # they load their libraries while the first photograph is read
        run = functools.partial(_mark_by_character, processes=processes, executor=executor)
        for k, photo, digest in todo:
            yield k, mark_photo(photo, digest, out=out, terms=terms, run=run)


def _mark_by_character(tasks: Sequence[CellTask], *, processes: int, executor: Executor) -> Iterator[Facts]:
    """Mark cells, in order; those of one character in one process, which makes its master ready once."""
    groups = by_character([task.character for task in tasks], processes=processes)
    answers = in_order(
        _mark_cells, ([tasks[k] for k in group] for group in groups), processes=processes, executor=executor
    )
    marks = {
        k: mark
        for group, found in zip(groups, answers, strict=True)
        for k, mark in zip(group, found, strict=True)
    }
    yield from (marks[k] for k in range(len(tasks)))


def by_character(characters: Sequence[str], *, processes: int) -> list[list[int]]:
    """Numbers of cells in groups, each of one character; few characters are parted for all processes.

    The longest come first, so that no process waits for it at the end.
    """
    places: dict[str, list[int]] = {}
    for k, character in enumerate(characters):
        places.setdefault(character, []).append(k)
    parts = 1 if len(places) >= processes else processes
    groups = [one[n::parts] for one in places.values() for n in range(parts) if one[n::parts]]
    return sorted(groups, key=len, reverse=True)


def _mark_cells(tasks: Sequence[CellTask]) -> list[Facts]:
    return [mark_cell(task) for task in tasks]


def _mark_numbered(
    one: tuple[int, SheetPhoto, str], *, out: Path, terms: Mapping[str, Any]
) -> tuple[int, Facts]:
    number, photo, digest = one
    return number, mark_photo(photo, digest, out=out, terms=terms)


def _warm_up() -> None:
    from rumu import pipeline

    assert pipeline


# --- what is written -------------------------------------------------------------------------------


def _check_folder(out: Path) -> None:
    """Make the folder. Raises OutputError when it holds something else than marks of sheets."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        names = {entry.name for entry in out.iterdir()}
    except OSError as error:
        raise OutputError(f"{out}: cannot be written ({error.strerror})") from error
    if names and not any(name.startswith(FACTS) for name in names):
        raise OutputError(
            f"{out}: expected a new or empty folder, or one with {FACTS}; it holds other things"
        )


def write_tables(found: Sequence[Facts], out: Path) -> None:
    """Write what was found as a table and as JSON."""
    with whole_file(out / FACTS) as part:
        part.write_text(json.dumps({"photos": list(found)}, ensure_ascii=False, indent=1), encoding="utf-8")
    with whole_file(out / TABLE) as part, part.open("w", newline="", encoding="utf-8") as stream:
        writer = TableWriter(stream, COLUMNS)
        for facts in found:
            for row in _rows(facts):
                writer.write_row(row)


def _rows(facts: Facts) -> Iterator[dict[str, Any]]:
    """The rows of one photograph: one for each cell with writing, or one that says why there is none."""
    of_photo = {"photo": facts["photo"], "pupil": facts.get("pupil", ""), "sheet": facts.get("sheet", "")}
    of_photo["page"] = facts.get("number", "")
    if facts["refused"] or not facts["cells"]:
        reason = facts["refused"] or "empty: nothing is written in its cells"
        yield of_photo | {"refused": reason, "refused_zh": facts["refused_zh"] or "格子裡都沒有寫字。"}
        return
    for cell in facts["cells"]:
        low, high = cell["interval"] or ("", "")
        plain = ("row", "column", "character", "score", "level", "percentile", "refused", "refused_zh")
        row = of_photo | {name: "" if cell[name] is None else cell[name] for name in plain}
        row |= {"low": low, "high": high, **cell["parts"]}
        row |= {
            f"remarks_{tongue}": " / ".join(one[tongue] for one in cell["remarks"]) for tongue in ("zh", "en")
        }
        row |= {f"praise_{tongue}": text for tongue, text in (cell["praise"] or {}).items()}
        yield row


def cell_facts(mark: Assessment) -> Facts:
    """What a table says of the mark of a cell, as values of JSON."""
    interval = mark.interval and [round(bound, 2) for bound in mark.interval]
    return {
        "score": None if mark.score is None else round(mark.score, 2),
        "level": mark.level,
        "interval": interval,
        "percentile": None if mark.percentile is None else round(mark.percentile, 1),
        "parts": {name: round(score, 2) for name, score in mark.parts.items()},
        "refused": mark.refused,
        "refused_zh": mark.refused_zh,
        "praise": mark.praise and mark.praise._asdict(),
        "remarks": [
            {
                "kind": remark.kind,
                "zh": remark.zh,
                "en": remark.en,
                "severity": round(float(remark.severity), 3),
                "stroke": remark.stroke,
                "outline": [[[round(x, 4), round(y, 4)] for x, y in line] for line in remark.outline],
            }
            for remark in mark.remarks
        ],
    }


def _keep_pictures(
    folder: Path,
    cells: Sequence[Facts],
    pictures: Sequence[npt.NDArray[np.uint8]],
    name: npt.NDArray[np.uint8],
) -> None:
    """Write the pictures of cells and of the pupil's name, for the PDFs."""
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    for facts, picture in zip(cells, pictures, strict=True):
        file = f"{facts['row']}-{facts['column']}.png"
        Image.fromarray(picture).save(folder / file)
        facts["picture"] = f"{CELLS}/{folder.name}/{file}"
    Image.fromarray(name).save(folder / "name.jpg", quality=85)
