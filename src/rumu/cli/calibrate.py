"""calibrate: a teacher's own marks -> a calibration that follows them, or why they do not carry one."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from rumu.cli.options import AsJson, check_writable, find_copy, find_master, not_an_input
from rumu.cli.pairs import reason_in_one_line
from rumu.cli.terminal import Outcome, bar, print_outcome, working
from rumu.csv_tables import Table, TableRow, read_table
from rumu.errors import CalibrationError
from rumu.executors import by_group, cores
from rumu.outputs import whole_file

if TYPE_CHECKING:
    from rumu.assessment.features import Features
    from rumu.assessment.teacher import TeacherFit
    from rumu.cli.terminal import Advance

COLUMNS = ("image", "reference", "mark")
NAMES = {
    "image": ("圖片", "图片", "圖像", "图像", "照片", "臨作", "临作", "習作", "习作", "作業", "作业"),
    "reference": ("範本", "范本", "字帖", "原帖", "碑帖", "參照", "参照"),
    "mark": ("score", "分數", "分数", "成績", "成绩", "評分", "评分", "得分"),
}
"""Column of a table of marks -> its other names."""


class MarkedRow(NamedTuple):
    """One row: the copy, its master, a teacher's mark from 0 to 100, and the line it stands in."""

    image: str
    reference: str
    mark: float
    line: int


class MeasuredRow(NamedTuple):
    """What a row holds: features of the copy and the file of its master, or why it is left out."""

    features: Features | None
    master: str = ""
    refused: str = ""


@print_outcome
def calibrate(
    marks: Annotated[
        Path, typer.Argument(metavar="MARKS", help="CSV with the columns image,reference,mark (0-100).")
    ],
    out: Annotated[Path, typer.Option("-o", "--out", metavar="FILE", help="The calibration to write.")],
    root: Annotated[
        Path | None, typer.Option(help="Folder of the paths in MARKS (default: the folder of MARKS).")
    ] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Processes (default: all cores).")] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Fit the mark to your own marks; keeps the default, and says so, when they do not carry more."""
    not_an_input(out, marks)
    table, rows = read_marks(marks)
    check_writable(whole_file(out))
    with bar("Measuring") as advance:
        measured = _measure_rows(rows, root=root or marks.parent, jobs=jobs, advance=advance)
    left_out = [(row, one.refused) for row, one in zip(rows, measured, strict=True) if one.refused]
    with working("Fitting"):
        fit = _fit(rows, measured, name=marks.name)
    if fit.calibration is not None:
        from rumu.assessment.calibration import write_calibration

        write_calibration(fit.calibration, out)
    none = (
        f"{marks}: no copy of the {len(rows)} could be measured; {left_out[0][1]}" if not fit.copies else None
    )
    facts = _facts(fit, left_out, out) | {"encoding": table.encoding, "separator": table.separator}
    return Outcome(facts, _describe(fit, left_out, table, out), refused=none)


def read_marks(path: Path) -> tuple[Table, list[MarkedRow]]:
    """A table with the columns image, reference and mark, and its rows.

    Raises CalibrationError that names the file and the line of whatever is no such row.
    """
    table = read_table(path, NAMES, required=COLUMNS, error_type=CalibrationError)
    rows = [_row(row, table=table) for row in table.rows()]
    if not rows:
        raise CalibrationError(f"{path}: expected at least one row below the header, found none")
    return table, rows


def _row(row: TableRow, *, table: Table) -> MarkedRow:
    image, reference, mark = (row.get(name) for name in COLUMNS)
    where = f"{table.path}, line {row.line}"
    if not image or not reference:
        raise CalibrationError(f"{where}: expected an image and a reference")
    value = table.number(mark.removesuffix("分"))
    if value is None or not 0 <= value <= 100:
        raise CalibrationError(f"{where}: expected a mark from 0 to 100, got {mark or 'nothing'!r}")
    return MarkedRow(image, reference, value, row.line)


def measure_row(row: MarkedRow, *, root: Path) -> MeasuredRow:
    """One copy against its master, as for a mark; whatever goes wrong is said in `refused`."""
    from rumu import pipeline

    try:
        path = find_master(row.reference, root=root).path
        measurement = pipeline.measure(
            pipeline.surface_of(find_copy(row.image, root=root)), pipeline.prepare_master(path)
        )
    except Exception as error:  # one row must never cost the others
        return MeasuredRow(None, refused=reason_in_one_line(error))
    if measurement.refusal is not None:
        return MeasuredRow(None, refused=f"{measurement.refusal.code}: {measurement.refusal.en}")
    return MeasuredRow(measurement.features, str(path.resolve()))


def _measure_rows(
    rows: Sequence[MarkedRow], *, root: Path, jobs: int | None, advance: Advance
) -> list[MeasuredRow]:
    """What each row holds, in order; measured master by master, so that a master is read once."""
    measured: dict[int, MeasuredRow] = {}
    for k, answer in by_group(
        functools.partial(measure_row, root=root),
        rows,
        group=lambda row: row.reference,
        processes=min(jobs or cores(), len(rows)),
    ):
        measured[k] = answer
        advance(len(measured), len(rows))
    return [measured[k] for k in range(len(rows))]


def _fit(rows: Sequence[MarkedRow], measured: Sequence[MeasuredRow], *, name: str) -> TeacherFit:
    from rumu.assessment.calibration import panel
    from rumu.assessment.teacher import fit_teacher

    usable = [
        (one.features, row.mark, one.master)
        for row, one in zip(rows, measured, strict=True)
        if one.features is not None
    ]
    features, marks, masters = zip(*usable, strict=True) if usable else ((), (), ())
    return fit_teacher(features, marks, masters, base=panel(), name=name)


LeftOut = Sequence[tuple[MarkedRow, str]]


def _facts(fit: TeacherFit, left_out: LeftOut, out: Path) -> dict[str, Any]:
    own = fit.calibration
    return {
        "out": out if own is not None else None,
        "kept": fit.chosen,
        "why": fit.why,
        "why_zh": fit.why_zh,
        "marks": fit.copies,
        "masters": fit.masters,
        "held_out": fit.held_out,
        **{
            kind: None if one is None else {"error": one.error, "spearman": one.spearman}
            for kind, one in (("default", fit.default), ("scale", fit.scale), ("weights", fit.weights))
        },
        "inside": fit.inside,
        "interval": own and own.interval,
        "provenance": own and own.provenance,
        "left_out": [
            {"line": row.line, "image": row.image, "reference": row.reference, "refused": why}
            for row, why in left_out
        ],
    }


_HELD_OUT = {
    "masters": "whole masters held out",
    "copies": "copies held out; too few masters to hold any out, so expect less on others",
    "none": "nothing was fitted",
}


def _describe(fit: TeacherFit, left_out: LeftOut, table: Table, out: Path) -> str:
    fits = (("default", fit.default), ("scale", fit.scale), ("weights", fit.weights))
    rows = [
        f"  {kind:<8}  mean error {one.error:5.1f}   rank agreement {one.spearman:6.3f}"
        f"{'   <- kept' if kind == fit.chosen else ''}"
        for kind, one in fits
        if one is not None
    ]
    ending = (
        "The default is kept; nothing was written. 保留默認，未寫文件。"
        if fit.calibration is None
        else f"{out}: use it with rumu assess --calibration {out}"
    )
    return "\n".join(
        [
            f"{table.path}: {fit.copies} marks of copies of {fit.masters} masters, "
            f"{len(left_out)} rows left out",
            f"  read as {table.description.en}",
            *(f"  line {row.line}: {row.image}: {why}" for row, why in left_out),
            f"{_HELD_OUT[fit.held_out]}:",
            *rows,
            *(
                []
                if fit.inside is None
                else [f"  {fit.inside:.0%} of the marks lie in the default's 80% interval"]
            ),
            f"{fit.why} {fit.why_zh}",
            ending,
        ]
    )
