"""reconstruct: photographs of one sheet into a surface, and the same again from an earlier record."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.lighting import (
    AlignOption,
    CardOption,
    EncodingOption,
    FlatFieldOption,
    InsideOutOption,
    LampsUnknownOption,
    LeaveOutOption,
    NearLampsOption,
    SphereOption,
)
from rumu.cli.options import AsJson, finite
from rumu.cli.reconstruction import ReconstructSettings, make_surface
from rumu.cli.surfaces import Folder
from rumu.cli.terminal import Outcome, print_outcome

Solver = Literal["robust", "least_squares", "trimmed", "l1"]
Integrator = Literal["auto", "dct", "frankot_chellappa", "masked", "bilateral"]
Level = Literal["none", "plane", "bow"]
Rectify = Literal["none", "bands", "svd", "masked"]


@print_outcome
def reconstruct(
    *,
    context: typer.Context,
    capture_dir: Annotated[
        Path | None,
        typer.Argument(
            metavar="CAPTURE_DIR", help="Folder of photographs of one sheet, each under one lamp."
        ),
    ] = None,
    out: Folder,
    solver: Annotated[Solver, typer.Option(help="How normals are solved for.")] = "robust",
    integrator: Annotated[Integrator, typer.Option(help="How normals become height.")] = "auto",
    focal_length: Annotated[
        float | None,
        typer.Option(min=1.0, help="Of the camera, in pixels of the photographs; far away when not given."),
    ] = None,
    level: Annotated[
        Level, typer.Option(help="Take off how the sheet leans (plane), and how it is bowed, too (bow).")
    ] = "none",
    rectify: Annotated[Rectify, typer.Option(help="Even out the lighting first.")] = "none",
    mm_per_pixel: Annotated[
        float | None, typer.Option(min=1e-6, help="Scale of the photographs; the height is then in mm.")
    ] = None,
    lamps_as_given: Annotated[
        bool,
        typer.Option("--lamps-as-given", help="Take the lamps as they are, though others fit better."),
    ] = False,
    leave_out: LeaveOutOption = None,
    sphere: SphereOption = None,
    card: CardOption = False,
    lamps_unknown: LampsUnknownOption = False,
    inside_out: InsideOutOption = False,
    near_lamps: NearLampsOption = False,
    flat_field: FlatFieldOption = None,
    align: AlignOption = False,
    encoding: EncodingOption = "auto",
    write: Annotated[
        str,
        typer.Option(
            help="What is written, separated by commas: all, floats, pictures, mesh, report, height..."
        ),
    ] = "all",
    capture_report: Annotated[
        Literal["zh", "en"] | None,
        typer.Option(help="Also write capture-report.pdf, a report to be signed, in this language."),
    ] = None,
    made_by: Annotated[
        str | None, typer.Option("--by", help="Who makes it, for the record in surface.json.")
    ] = None,
    again: Annotated[
        Path | None,
        typer.Option(
            "--again", help="surface.json of an earlier result: make it again as it says, and compare."
        ),
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Photographs of one sheet under three or more lamps -> albedo, normals, height, mesh, report."""
    if again is not None:
        _refuse_settings(context)
        return _made_again(again, capture_dir, out, made_by)
    if capture_dir is None:
        raise typer.BadParameter("expected a folder of photographs, or --again", param_hint="'CAPTURE_DIR'")
    settings = ReconstructSettings(
        capture=str(capture_dir.resolve()),
        solver=solver,
        integrator=integrator,
        focal_length=None if focal_length is None else finite(focal_length),
        level=level,
        rectify=rectify,
        mm_per_pixel=None if mm_per_pixel is None else finite(mm_per_pixel),
        lamps_as_given=lamps_as_given,
        leave_out=tuple(leave_out or ()),
        sphere=tuple(sphere or ()),
        card=card,
        lamps_unknown=lamps_unknown,
        inside_out=inside_out,
        near_lamps=near_lamps,
        flat_field=None if flat_field is None else str(flat_field.resolve()),
        align=align,
        encoding=encoding,
        write=write,
        capture_report=capture_report,
    )
    outcome, _ = make_surface(settings, out, made_by)
    return outcome


def _refuse_settings(context: typer.Context) -> None:
    """Raise wrong usage where an option is given that the record of --again tells."""
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        given = source is not None and source.name == "COMMANDLINE"
        if given and name not in ("again", "capture_dir", "out", "made_by", "as_json"):
            raise typer.BadParameter("--again takes the settings of the record", param_hint=f"'{name}'")


def _made_again(again: Path, moved_to: Path | None, out: Path, made_by: str | None) -> Outcome:
    """Make the result of a record again, from the same files and by the same settings, and compare.

    moved_to: where the capture lies now; None where it was.
    """
    from rumu.surface.processing import check_inputs, compare_results, moved_record, read_processing

    record = read_processing(again)
    if moved_to is not None:
        record = moved_record(record, place=moved_to)
    earlier = again if again.is_dir() else again.parent
    if out.resolve() == earlier.resolve():
        raise typer.BadParameter("expected another folder than that of the earlier result", param_hint="'-o'")
    check_inputs(record)
    outcome, surface = make_surface(ReconstructSettings.of_record(record), out, made_by)
    found = compare_results(record, surface, earlier=earlier)
    if found.same:
        words = "the same as the earlier result, to the last bit"
    else:
        parts = [
            f"{name} by up to {found.largest[name]:.3g}" if name in found.largest else name
            for name in found.differs
        ]
        words = f"not the same as the earlier result: {', '.join(parts)}"
    before, now = found.versions
    text = f"{outcome.text}\n  again: {words} (made {record.made} by rumu {before}, now {now})"
    return Outcome({**outcome.facts, "again": asdict(found)}, text)
