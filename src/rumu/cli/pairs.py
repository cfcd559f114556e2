"""A table of pairs, marked in parallel: read and written in order, in windows, so memory stays flat."""

from __future__ import annotations

import csv
import functools
import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rumu.cli.options import find_master
from rumu.errors import ImageError, RumuError
from rumu.executors import by_group, cores
from rumu.outputs import whole_file

if TYPE_CHECKING:
    from rumu.cli.terminal import Advance
    from rumu.pipeline import PreparedMaster
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
)
_WINDOW = 2000  # rows that are in memory at a time


class PairRow(NamedTuple):
    """One row as it stands in the table; None where the row ends too early or the column is not there."""

    copy: str | None
    reference: str | None
    script: str | None = None


def assess_pairs(
    pairs: Path, out: Path, *, root: Path, jobs: int | None, terms: Mapping[str, Any], advance: Advance
) -> tuple[int, int]:
    """Mark every row of `pairs` and write `out` in the same order; returns (marked, refused) rows.

    terms: levels, calibration, weights, script, remarks, as `pipeline.assess` takes them; a row's own script
    wins; without remarks their columns stay empty.
    A row that cannot be marked carries its reason in `refused` and stops nothing. Raises RumuError when the
    table itself cannot be read, OutputError when `out` cannot be written; then nothing is written.
    """
    total = sum(1 for _ in read_pairs(pairs))
    if total == 0:
        raise ImageError(f"{pairs}: expected at least one pair below the header, found none")
    marked = 0
    with whole_file(out) as part, part.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        work = functools.partial(mark_row, root=root, terms=terms)
        processes = min(jobs or cores(), total)
        done = itertools.count(1)
        pairs_in_order = read_pairs(pairs)
        while window := list(itertools.islice(pairs_in_order, _WINDOW)):
            rows = by_group(
                work,
                window,
                group=lambda pair: pair.reference or "",  # a master is read once
                processes=processes,
                advance=lambda: advance(next(done), total),
            )
            marked += sum(row["refused"] == "" for row in rows)
            writer.writerows(rows)
    return marked, total - marked


def read_pairs(path: Path) -> Iterator[PairRow]:
    """The rows of a CSV with the columns copy, reference and perhaps script; see `read_rows`."""
    for _, row in read_rows(path, ("copy", "reference"), error_type=ImageError):
        yield PairRow(
            row["copy"] or None, row["reference"] or None, (row.get("script") or "").strip() or None
        )


def read_rows(
    path: Path, columns: Sequence[str], *, error_type: type[RumuError]
) -> Iterator[tuple[int, dict[str, Any]]]:
    """The lines and rows of a CSV with these columns and perhaps others, UTF-8 with or without BOM.

    Raises `error_type` naming the file when it is missing, no UTF-8 text, or lacks a column.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            table = csv.DictReader(stream)
            table.fieldnames = names = [name.strip() for name in table.fieldnames or ()]
            if not set(columns) <= set(names):
                raise error_type(
                    f"{path}: expected the columns {','.join(columns)} in the first line, "
                    f"found {', '.join(names) or 'nothing'}"
                )
            yield from ((table.line_num, row) for row in table)
    except OSError as error:
        raise error_type(f"{path}: cannot be read ({os.strerror(error.errno or 0)})") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise error_type(f"{path}: expected a CSV in UTF-8, cannot read it ({error})") from error


def mark_row(pair: PairRow, *, root: Path, terms: Mapping[str, Any]) -> dict[str, Any]:
    """One row of the result; whatever goes wrong is said in its column `refused`."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS, "") | {"copy": pair.copy, "reference": pair.reference}
    if pair.copy is None or pair.reference is None:
        return row | {"refused": "expected a copy and a reference in this row"}
    from rumu import pipeline

    try:
        path, known_script = find_master(pair.reference, root=root)
        script = pair.script or terms.get("script") or known_script
        mark = pipeline.assess(root / pair.copy, prepared_master(path), **{**terms, "script": script})
        return row | _cells(mark)
    except Exception as error:  # one row must never cost the others
        return row | {"refused": reason_in_one_line(error)}


@functools.lru_cache(maxsize=4)  # rows come by master; each surface may hold many pixels
def prepared_master(path: Path) -> PreparedMaster:
    """The master in a file or folder; the last ones stay in memory."""
    from rumu import pipeline

    return pipeline.prepare_master(path)


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
        "script": mark.script or "",
        "low": _number(low, 2),
        "high": _number(high, 2),
        "sim_paper": _number(mark.sim_paper, 6),
        "similarity": _number(mark.similarity, 6),
    }
    cells |= {name: _number(mark.parts.get(name), 2) for name in ("brushwork", "structure", "ink")}
    cells |= {
        f"remarks_{tongue}": " / ".join(getattr(r, tongue) for r in mark.remarks) for tongue in ("zh", "en")
    }
    pose = mark.registration
    if pose is not None:
        cells |= {"angle": _number(pose.angle, 3), "scale": _number(pose.scale, 5)}
        cells |= {"shift_x": _number(float(pose.shift[0]), 5), "shift_y": _number(float(pose.shift[1]), 5)}
    return cells


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"
