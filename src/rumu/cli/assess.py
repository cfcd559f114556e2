"""assess: the mark of one copy, or of every pair in a table."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rumu.cli.options import AsJson, find_master, known_script_name, level_cuts, not_an_input, part_weights
from rumu.cli.terminal import Outcome, bar, print_outcome, working

if TYPE_CHECKING:
    from rumu.values import Assessment, Bilingual, Surface


@print_outcome
def assess(
    *,
    copy: Annotated[
        Path | None, typer.Argument(metavar="COPY", help="The learner's copy: an image or a surface folder.")
    ] = None,
    reference: Annotated[
        str | None, typer.Option(metavar="MASTER", help="The master: a path, or the id of a starter work.")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write one self-contained HTML page.")] = None,
    pairs: Annotated[
        Path | None, typer.Option(help="CSV with the columns copy,reference, instead of COPY.")
    ] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="CSV to write, with --pairs.")] = None,
    root: Annotated[
        Path | None, typer.Option(help="Folder of the paths in PAIRS (default: the folder of PAIRS).")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes, with --pairs (default: all cores).")
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Mark on a Dask cluster, with --pairs: tcp://HOST:8786, or 'local' for one of this machine.",
        ),
    ] = None,
    remarks: Annotated[
        bool | None,
        typer.Option("--remarks", help="Put the remarks into the table too, with --pairs (slower)."),
    ] = None,
    levels: Annotated[
        str, typer.Option(help="Cut-offs of the levels: panel, rubric, or a JSON file.")
    ] = "panel",
    calibration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A calibration that `rumu calibrate` wrote.")
    ] = None,
    weights: Annotated[
        str | None,
        typer.Option(help="Your own weights of the parts: brushwork=50,structure=50,ink=0, or a JSON file."),
    ] = None,
    script: Annotated[
        str | None,
        typer.Option(
            metavar="[seal|clerical|regular|running|cursive]",
            callback=known_script_name,
            help="The script of the master (a starter work knows its own).",
        ),
    ] = None,
    character: Annotated[
        str | None, typer.Option(metavar="字", help="What is written (a starter work knows its own).")
    ] = None,
    framed: Annotated[
        bool,
        typer.Option(
            "--framed/--free",
            help="Whether a copy's picture is the cell it was written in, so that size, place and lean "
            "are the writer's; a free photograph's crop says nothing of them.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> Outcome:
    """The mark of a copy against its master: score, interval, level, parts, remarks."""
    if pairs is not None:
        _only_with(one={"COPY": copy, "--reference": reference, "--report": report}, mode="--pairs")
        if out is None:
            raise typer.BadParameter("--pairs needs -o OUT.csv")
        not_an_input(out, pairs, calibration)
        terms = _terms(levels, calibration, weights, script) | {"character": character, "framed": framed}
        terms["remarks"] = bool(remarks)
        return _assess_table(pairs, out, root=root, jobs=jobs, terms=terms, dask=dask)
    _only_with(
        one={"-o": out, "--root": root, "--jobs": jobs, "--dask": dask, "--remarks": remarks}, mode="one COPY"
    )
    if copy is None or reference is None:
        raise typer.BadParameter("expected COPY --reference MASTER, or --pairs PAIRS.csv -o OUT.csv")
    not_an_input(report, copy, reference, calibration)
    terms = _terms(levels, calibration, weights, script) | {"character": character, "framed": framed}
    return _assess_one(copy, reference, report=report, terms=terms)


def _terms(levels: str, calibration: Path | None, weights: str | None, script: str | None) -> dict[str, Any]:
    """What `pipeline.assess` takes beside copy and master; files are read once, here."""
    from rumu.assessment.calibration import load_calibration

    return {
        "levels": level_cuts(levels),
        "calibration": calibration and load_calibration(calibration),
        "weights": weights and part_weights(weights),
        "script": script,
    }


def _only_with(*, one: Mapping[str, object], mode: str) -> None:
    given = [name for name, value in one.items() if value is not None]
    if given:
        raise typer.BadParameter(f"{', '.join(given)} cannot go with {mode}")


def _assess_one(copy: Path, reference: str, *, report: Path | None, terms: dict[str, Any]) -> Outcome:
    path, known_script, known_character = find_master(reference)
    terms["script"] = terms["script"] or known_script
    terms["character"] = terms["character"] or known_character
    with working("Comparing"):
        surface, master, mark = assess_files(copy, path, **terms)
        if report is not None:
            names = (str(copy), reference)
            write_page(mark, copy=surface, master=master, names=names, levels=terms["levels"], target=report)
    facts = {"copy": copy, "reference": reference, **mark_facts(mark), "report": report}
    if mark.refused is not None:
        return Outcome(
            {**facts, "error": mark.refused}, f"{copy}: not marked", refused=f"{copy}: {mark.refused}"
        )
    recognised = mark.character if terms["character"] is None else None
    return Outcome(facts, _describe(mark, report, recognised=recognised))


def _assess_table(
    pairs: Path,
    out: Path,
    *,
    root: Path | None,
    jobs: int | None,
    terms: dict[str, Any],
    dask: str | None,
) -> Outcome:
    from rumu.cli.pairs import assess_pairs, read_pairs

    table = read_pairs(pairs)
    started = time.perf_counter()
    with bar("Marking") as advance:
        done = assess_pairs(
            table, out, root=root or pairs.parent, jobs=jobs, terms=terms, advance=advance, dask=dask
        )
    seconds = time.perf_counter() - started
    facts = {"out": out, "pairs": done.marked + done.refused, "marked": done.marked, "refused": done.refused}
    facts |= {"kept": done.kept, "encoding": table.encoding, "separator": table.separator}
    text = (
        f"{out}: {done.marked} marked, {done.refused} refused, {seconds:.1f} s\n"
        + (f"  {done.kept} of them had been done before this run was interrupted\n" if done.kept else "")
        + f"  {pairs}: {table.description.en}"
    )
    none = (
        f"{out}: no pair of {pairs} could be marked; the column 'refused' says why"
        if not done.marked
        else None
    )
    return Outcome({**facts, "seconds": round(seconds, 3)}, text, refused=none)


def assess_files(copy: Path, master: Path, **terms: Any) -> tuple[Surface | None, Surface, Assessment]:
    """(surface of the copy or None when it was refused, surface of the master, the mark).

    terms: levels, calibration, weights, script, character, framed, as `pipeline.assess` takes them.
    """
    from rumu import pipeline
    from rumu.errors import RefusedImage

    reference = pipeline.surface_of(master)
    try:
        probe = pipeline.surface_of(copy)
    except RefusedImage:
        return None, reference, pipeline.assess(copy, reference, **terms)
    return probe, reference, pipeline.assess(probe, reference, **terms)


def write_page(
    mark: Assessment,
    *,
    copy: Surface | None,
    master: Surface,
    names: tuple[str, str],
    levels: Mapping[str, float],
    target: Path,
    note: Bilingual | None = None,
) -> None:
    """Write the page of one mark, whole or not at all."""
    from rumu.outputs import whole_file
    from rumu.report.pages import assessment_page

    copy_name, master_name = names
    html = assessment_page(
        mark,
        copy=copy,
        master=master,
        title=Path(copy_name).stem,
        copy_name=copy_name,
        master_name=master_name,
        levels=levels,
        note=note,
    )
    with whole_file(target) as part:
        part.write_text(html, encoding="utf-8")


def mark_facts(mark: Assessment) -> dict[str, Any]:
    """The mark without its point sets, for JSON."""
    pose = mark.registration
    terms = ("interval_note", "interval_note_zh", "script", "character", "weights", "calibration")
    names = (
        "score",
        "level",
        "percentile",
        "interval",
        *terms,
        "sim_paper",
        "similarity",
        "parts",
        "deductions",
        "remarks",
    )
    of_pose = ("angle", "shift", "scale", "overlap", "d_ms", "converged", "iterations")
    return (
        {name: getattr(mark, name) for name in names}
        | {"praise": mark.praise and mark.praise._asdict()}
        | {"pose": pose and {name: getattr(pose, name) for name in of_pose}}
        | {name: getattr(mark, name) for name in ("source", "refused", "refused_zh", "turned_by")}
    )


def _describe(mark: Assessment, report: Path | None, *, recognised: str | None) -> str:
    from rumu.report.wording import LEVELS, SOURCES, basis

    low, high = mark.interval or (0.0, 100.0)
    level = LEVELS[mark.level] if mark.level else None
    lines = [
        f"{mark.score:.0f} of 100 ({low:.0f} to {high:.0f})" + (f", {level.en} {level.zh}" if level else ""),
        "  " + ", ".join(f"{name} {value:.0f}" for name, value in mark.parts.items()),
        *(f"  {text.en} {text.zh}" for text in basis(mark)),
        f"  the master is read as {recognised} 範本讀作「{recognised}」" if recognised else "",
        f"  + {mark.praise.en} {mark.praise.zh}" if mark.praise else "",
        *(f"  - {remark.en} {remark.zh}" for remark in sorted(mark.remarks, key=lambda r: -r.severity)),
        *(f"  {SOURCES[source].en}" for source in dict.fromkeys(mark.source or ())),
    ]
    if report is not None:
        lines.append(f"  report: {report}")
    return "\n".join(line for line in lines if line.strip())
