"""reconstruct: photographs of one sheet into a surface, and the same again from an earlier record."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from rumu.cli.lighting import (
    AlignOption,
    CardOption,
    FlatFieldOption,
    InsideOutOption,
    LampSource,
    LampsUnknownOption,
    LeaveOutOption,
    LitCapture,
    SphereOption,
    read_lit_capture,
)
from rumu.cli.options import AsJson, check_writable, finite
from rumu.cli.surfaces import REPORT, Folder, write_result
from rumu.cli.terminal import Outcome, print_outcome, stages
from rumu.errors import SurfaceError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rumu.capture.exif import PhotographFacts
    from rumu.surface.folder import Processing
    from rumu.values import Capture

Solver = Literal["robust", "least_squares", "trimmed", "l1"]
Integrator = Literal["auto", "dct", "frankot_chellappa", "masked", "bilateral"]
Level = Literal["none", "plane", "bow"]
Rectify = Literal["none", "bands", "svd", "masked"]

CAPTURE_REPORT = "capture-report.pdf"
"""The report of a capture that is signed."""

LAMPS = "lamps.lp"
"""Where the lamps stood, of a capture whose spheres told it."""


@dataclass(frozen=True, slots=True)
class _Settings:
    """The options that a result depends on; paths are absolute, so that they hold from anywhere."""

    capture: str
    solver: str = "robust"
    integrator: str = "auto"
    focal_length: float | None = None
    level: str = "none"
    rectify: str = "none"
    mm_per_pixel: float | None = None
    lamps_as_given: bool = False
    leave_out: tuple[str, ...] = ()
    sphere: tuple[str, ...] = ()
    card: bool = False
    lamps_unknown: bool = False
    inside_out: bool = False
    flat_field: str | None = None
    align: bool = False
    write: str = "all"
    capture_report: str | None = None

    @classmethod
    def of_record(cls, record: Processing) -> _Settings:
        """The settings that a record tells. Raises SurfaceError for others than these."""
        told: dict[str, Any] = dict(record.settings)
        try:
            for name in ("leave_out", "sphere"):
                told[name] = tuple(map(str, told.get(name, ())))
            return cls(**told)
        except TypeError as error:
            raise SurfaceError(f"expected the settings of a reconstruct, got others ({error})") from error


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
    flat_field: FlatFieldOption = None,
    align: AlignOption = False,
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
        return _made_again(again, out, made_by)
    if capture_dir is None:
        raise typer.BadParameter("expected a folder of photographs, or --again", param_hint="'CAPTURE_DIR'")
    settings = _Settings(
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
        flat_field=None if flat_field is None else str(flat_field.resolve()),
        align=align,
        write=write,
        capture_report=capture_report,
    )
    outcome, _ = _made(settings, out, made_by)
    return outcome


def _refuse_settings(context: typer.Context) -> None:
    """Raise wrong usage where an option is given that the record of --again tells."""
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        given = source is not None and source.name == "COMMANDLINE"
        if given and name not in ("again", "out", "made_by", "as_json"):
            raise typer.BadParameter("--again takes the settings of the record", param_hint=f"'{name}'")


def _made(settings: _Settings, out: Path, made_by: str | None) -> tuple[Outcome, Any]:
    """Make a surface by its settings and write it; also the surface."""
    from rumu import pipeline
    from rumu.capture.exif import read_facts
    from rumu.capture.light_files import lp_text
    from rumu.outputs import whole_folder
    from rumu.report.capture_report import CaptureReport, capture_pdf
    from rumu.surface.folder import MARKER
    from rumu.surface.frame_check import exposure_notes
    from rumu.surface.photograph_table import fault_notes, photograph_table, table_text
    from rumu.surface.processing import digest_files, record_processing
    from rumu.surface.residual_map import residual_map

    files = _files_to_write(settings.write)
    source = LampSource(settings.sphere, settings.card, settings.lamps_unknown, settings.inside_out)
    check_writable(whole_folder(out, marker=MARKER))
    folder = Path(settings.capture)
    flat_field = None if settings.flat_field is None else Path(settings.flat_field)
    with stages() as progress:
        lit = read_lit_capture(
            folder,
            source,
            flat_field=flat_field,
            align=settings.align,
            leave_out=settings.leave_out,
            progress=progress,
        )
        capture = lit.capture
        inputs = digest_files(_files_read(folder, capture, flat_field))
        if settings.mm_per_pixel is not None:
            capture = capture.changed(spacing=settings.mm_per_pixel)
        if settings.lamps_as_given:
            capture = capture.changed(lamps_as_given=True)
        surface = pipeline.reconstruct(
            capture,
            solver=settings.solver,
            integrator=settings.integrator,
            focal_length=settings.focal_length,
            level=settings.level,
            rectify=settings.rectify,
            progress=progress,
        )
        table = photograph_table(capture, surface, aligned=lit.moved)
        notes = (*capture.notes, *exposure_notes(capture, surface), *fault_notes(table))
        beside: dict[str, str | bytes] = {}
        if source != LampSource():
            beside[LAMPS] = lp_text(capture.names, capture.lights)
        facts_of = [read_facts(_place_of(folder) / name) for name in capture.names]
        processing = record_processing(
            surface,
            settings=asdict(settings),
            inputs=inputs,
            made_by=made_by,
            lamps=_lamps_of(capture, source),
            photographs=_told_by_the_photographs(capture.names, facts_of),
        )
        if settings.capture_report is not None:
            report = CaptureReport(
                folder.name,
                surface,
                capture.lights,
                source.words,
                table,
                facts_of,
                residual_map(capture, surface),
                notes,
                processing,
            )
            beside[CAPTURE_REPORT] = capture_pdf(report, language=settings.capture_report)  # type: ignore[arg-type]
        told = _told_by_the_card(lit)
        del capture, lit  # the photographs
        done = write_result(
            surface,
            out,
            title=folder.name,
            notes=notes,
            files=files,
            beside=beside,
            processing=processing,
            progress=progress,
        )
    facts = {**done.facts, **told, "photographs": [asdict(row) for row in table]}
    return Outcome(facts, f"{done.text}\n{table_text(table)}"), surface


def _lamps_of(capture: Capture, source: LampSource) -> dict[str, Any]:
    """Where the lamps stood and what told it, for the record."""
    directions = {
        name: [round(float(value), 6) for value in light]
        for name, light in zip(capture.names, capture.lights, strict=True)
    }
    return {"from": source.words.en, "directions": directions}


def _told_by_the_photographs(
    names: Sequence[str], facts: Sequence[PhotographFacts]
) -> dict[str, dict[str, Any]]:
    """What each photograph says of itself, for the record; nothing of those that say nothing."""
    told = {
        name: {key: value for key, value in asdict(one).items() if value is not None}
        for name, one in zip(names, facts, strict=True)
    }
    return {name: one for name, one in told.items() if one}


def _told_by_the_card(lit: LitCapture) -> dict[str, Any]:
    """What the card told, for --json; nothing without one."""
    if lit.card is None:
        return {}
    card = lit.card
    facts = {
        "lamps": [asdict(lamp) for lamp in card.lamps],
        "pixel_mm": card.pixel_mm,
        "off_mm": card.off,
        "ball_mm": card.ball,
        "curve": card.curve,
        "residual": card.residual,
    }
    return {"card": facts}


def _place_of(capture: Path) -> Path:
    """The folder of the photographs; a capture may be told by a file in it."""
    return capture if capture.is_dir() else capture.parent


def _files_read(folder: Path, capture: Capture, flat_field: Path | None) -> list[Path]:
    """The files that a capture was read from: photographs, lamps, mask, description, flat-field frames."""
    from rumu.capture.description import description_of
    from rumu.capture.masks import mask_file
    from rumu.capture.photographs import FolderImages, files

    place = _place_of(folder)
    images = FolderImages(place)
    told = [one for one in files(place) if one.suffix.lower() in (".lp", ".dome", ".txt", ".json")]
    mask = mask_file(images, description_of(place))
    ambient = images.by_stem("ambient")
    found = [*told, *(place / name for name in capture.names), *(one for one in (mask, ambient) if one)]
    if flat_field is not None:
        found += FolderImages(flat_field).images() if flat_field.is_dir() else [flat_field]
    return found


def _made_again(again: Path, out: Path, made_by: str | None) -> Outcome:
    """Make the result of a record again, from the same files and by the same settings, and compare."""
    from rumu.surface.processing import check_inputs, compare_results, read_processing

    record = read_processing(again)
    earlier = again if again.is_dir() else again.parent
    if out.resolve() == earlier.resolve():
        raise typer.BadParameter("expected another folder than that of the earlier result", param_hint="'-o'")
    check_inputs(record)
    outcome, surface = _made(_Settings.of_record(record), out, made_by)
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


def _files_to_write(wanted: str) -> list[str]:
    """The files that `--write` asks for: by groups, by arrays, or by their names."""
    from rumu.surface.array_files import ARRAYS
    from rumu.surface.folder import FILES, FLOATS, MESH, PICTURES

    groups: dict[str, tuple[str, ...]] = {
        "all": (*FILES, REPORT),
        "floats": FLOATS,
        "pictures": PICTURES,
        "mesh": (MESH,),
        "report": (REPORT,),
        **{name: (f"{name}.tif", f"{name}.png") for name in ARRAYS},
        **{name: (name,) for name in (*FILES, REPORT)},
    }
    found: list[str] = []
    for one in filter(None, (part.strip().lower() for part in wanted.split(","))):
        if one not in groups:
            raise typer.BadParameter(f"{one!r} is none of {', '.join(groups)}", param_hint="'--write'")
        found += [name for name in groups[one] if name not in found]
    if not found:
        raise typer.BadParameter("expected something to write", param_hint="'--write'")
    return found
