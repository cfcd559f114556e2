"""A table of pairs, marked in parallel; what was marked before an interruption is not marked again."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rumu import __version__
from rumu.cli.options import find_copy, find_master
from rumu.csv_tables import Table, TableWriter, read_table
from rumu.errors import ImageError, RumuError
from rumu.executors import by_group, cores, open_executor
from rumu.outputs import UnfinishedRows, whole_file

if TYPE_CHECKING:
    from rumu.cli.terminal import Advance
    from rumu.values import Assessment

COLUMNS = (
    "copy",
    "reference",
    "score",
    "level",
    "low",
    "high",
    "sim_paper",
    "similarity",
    "brushwork",
    "structure",
    "ink",
    "angle",
    "shift_x",
    "shift_y",
    "scale",
    "refused",
    "script",
    "remarks_zh",
    "remarks_en",
    "character",
    "praise_zh",
    "praise_en",
    "percentile",
)
NAMES = {
    "copy": ("臨作", "临作", "臨本", "临本", "習作", "习作", "作業", "作业", "副本"),
    "reference": ("範本", "范本", "字帖", "原帖", "碑帖", "參照", "参照"),
    "script": ("書體", "书体", "字體", "字体"),
    "character": ("字", "漢字", "汉字", "單字", "单字"),
}
"""Column of a table of pairs -> its other names."""
_WINDOW = 2000  # rows among which those of one master are brought together


class PairRow(NamedTuple):
    """One row as it stands in the table; None where a cell is empty or not there. fault: of the row."""

    copy: str | None
    reference: str | None
    script: str | None = None
    character: str | None = None
    fault: str = ""


class PairsDone(NamedTuple):
    """How many rows were marked and refused, and how many of them an earlier, interrupted run had done."""

    marked: int
    refused: int
    kept: int


def assess_pairs(
    pairs: Table,
    out: Path,
    *,
    root: Path,
    jobs: int | None,
    terms: Mapping[str, Any],
    advance: Advance,
    dask: str | None = None,
) -> PairsDone:
    """Mark every row of `pairs` and write `out` in the same order.

    pairs: see `read_pairs`. terms: levels, calibration, weights, script, character, framed, remarks,
    as `pipeline.assess` takes them; a row's own script and character win; without remarks their columns stay
    empty. dask: see `open_executor`.
    A row that cannot be marked carries its reason in `refused` and stops nothing. Rows are kept beside `out`
    until it is whole: after an interruption the same call goes on where it was, but for rows whose pictures
    have changed. Raises RumuError when the table holds no pair, OutputError when `out` cannot be written.
    """
    every = list(pair_rows(pairs))
    if not every:
        raise ImageError(f"{pairs.path}: expected at least one pair below the header, found none")
    unfinished = UnfinishedRows(
        out, key={"rumu": __version__, "columns": COLUMNS, "terms": terms, "root": root.resolve()}
    )
    finished = False
    try:
        kept = _kept_rows(unfinished, every, root=root)
        todo = [k for k in range(len(every)) if k not in kept]
        done = itertools.count(len(kept) + 1)
        work = functools.partial(mark_row, root=root, terms=terms)
        with open_executor(max(min(jobs or cores(), len(todo)), 1), dask=dask) as (executor, processes):
            for start in range(0, len(todo), _WINDOW):
                window = todo[start : start + _WINDOW]
                answers = by_group(
                    work,
                    [every[k] for k in window],
                    group=lambda pair: pair.reference or "",  # a master is read once
                    executor=executor,
                    processes=processes,
                )
                for number, row in answers:
                    k = window[number]
                    unfinished.add(k, row, stamp=[list(every[k]), _file_stamps(every[k], root=root)])
                    advance(next(done), len(every))
        marked_rows = 0
        with whole_file(out) as part, part.open("w", newline="", encoding="utf-8") as stream:
            writer = TableWriter(stream, COLUMNS)
            for k in range(len(every)):
                row, _ = unfinished.row(k)
                marked_rows += row["refused"] == ""
                writer.write_row(row)
        finished = True
    finally:
        unfinished.close(finished=finished)
    return PairsDone(marked_rows, len(every) - marked_rows, len(kept))


def _kept_rows(unfinished: UnfinishedRows, every: Sequence[PairRow], *, root: Path) -> set[int]:
    """Numbers of rows that an earlier run marked, whose line and pictures are the same today."""
    return {
        k
        for k in unfinished.numbers()
        if k < len(every) and unfinished.row(k)[1] == [list(every[k]), _file_stamps(every[k], root=root)]
    }


def _file_stamps(pair: PairRow, *, root: Path) -> list[list[int] | None]:
    """Size and time of the pair's files; None for what is no file."""
    stamps: list[list[int] | None] = []
    for name in (pair.copy, pair.reference):
        try:
            found = (root / (name or "")).stat()
            stamps.append([found.st_size, found.st_mtime_ns])
        except (OSError, ValueError):
            stamps.append(None)
    return stamps


def read_pairs(path: Path) -> Table:
    """A table with the columns copy, reference and perhaps script and character.

    Raises ImageError naming the file when it cannot be read as one.
    """
    return read_table(path, NAMES, required=("copy", "reference"), error_type=ImageError)


def pair_rows(table: Table) -> Iterator[PairRow]:
    """The rows of a table of pairs; one with a fault carries it."""
    for row in table.rows(with_faulty=True):
        yield PairRow(
            row.get("copy") or None,
            row.get("reference") or None,
            row.get("script") or None,
            row.get("character") or None,
            row.fault,
        )


def mark_row(pair: PairRow, *, root: Path, terms: Mapping[str, Any]) -> dict[str, Any]:
    """One row of the result; whatever goes wrong is said in its column `refused`."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS, "") | {"copy": pair.copy, "reference": pair.reference}
    if pair.fault or pair.copy is None or pair.reference is None:
        return row | {"refused": pair.fault or "expected a copy and a reference in this row"}
    from rumu import pipeline
    from rumu.gallery.vocabulary import script_key

    try:
        path, known_script, known_character = find_master(pair.reference, root=root)
        character = pair.character or terms.get("character") or known_character
        script = (pair.script and script_key(pair.script)) or terms.get("script") or known_script
        mark = pipeline.assess(
            find_copy(pair.copy, root=root),
            path,
            **{**terms, "script": script, "character": character},
        )
        return row | _cells(mark)
    except Exception as error:  # one row must never cost the others
        return row | {"refused": reason_in_one_line(error)}


def reason_in_one_line(error: Exception) -> str:
    """Why a row cannot be used."""
    unexpected = "" if isinstance(error, RumuError) else f"unexpected {type(error).__name__}: "
    return unexpected + " ".join(str(error).split())


def _cells(mark: Assessment) -> dict[str, Any]:
    if mark.refused is not None:
        return {"refused": " ".join(mark.refused.split())}
    low, high = mark.interval or (None, None)
    cells: dict[str, Any] = {
        "score": _number(mark.score, 2),
        "level": mark.level or "",
        "percentile": _number(mark.percentile, 1),
        "script": mark.script or "",
        "character": mark.character or "",
        "low": _number(low, 2),
        "high": _number(high, 2),
        "sim_paper": _number(mark.sim_paper, 6),
        "similarity": _number(mark.similarity, 6),
    }
    cells |= {name: _number(mark.parts.get(name), 2) for name in ("brushwork", "structure", "ink")}
    cells |= {
        f"remarks_{tongue}": " / ".join(getattr(r, tongue) for r in mark.remarks) for tongue in ("zh", "en")
    }
    if mark.praise is not None:
        cells |= {"praise_zh": mark.praise.zh, "praise_en": mark.praise.en}
    pose = mark.registration
    if pose is not None:
        cells |= {"angle": _number(pose.angle, 3), "scale": _number(pose.scale, 5)}
        cells |= {"shift_x": _number(float(pose.shift[0]), 5), "shift_y": _number(float(pose.shift[1]), 5)}
    return cells


def _number(value: float | None, digits: int) -> Decimal | str:
    """The value as it is written; no text, in which a minus would look like a formula's."""
    return "" if value is None else Decimal(f"{value:.{digits}f}")
