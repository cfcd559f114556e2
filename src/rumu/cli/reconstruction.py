"""How `reconstruct` makes a surface by its settings: photographs read, solved, told of, and written."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from rumu.cli.lighting import Encoding, LampSource, LitCapture, read_lit_capture
from rumu.cli.options import check_writable
from rumu.cli.run_time import Stage, reconstruct_stages
from rumu.cli.surfaces import REPORT, write_result
from rumu.cli.terminal import Outcome, stages
from rumu.errors import SurfaceError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rumu.capture.exif import PhotographFacts
    from rumu.image_stack import Progress
    from rumu.surface.folder import Processing
    from rumu.surface.photograph_table import PhotographRow
    from rumu.values import Bilingual, Capture, Surface

CAPTURE_REPORT = "capture-report.pdf"
"""The report of a capture that is signed."""

LAMPS = "lamps.lp"
"""Where the lamps stood, of a capture in which no file told it."""


@dataclass(frozen=True, slots=True)
class ReconstructSettings:
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
    near_lamps: bool = False
    flat_field: str | None = None
    align: bool = False
    encoding: Encoding = "auto"
    write: str = "all"
    capture_report: str | None = None

    @classmethod
    def of_record(cls, record: Processing) -> ReconstructSettings:
        """The settings that a record tells. Raises SurfaceError for others than these."""
        told: dict[str, Any] = dict(record.settings)
        try:
            for name in ("leave_out", "sphere"):
                told[name] = tuple(map(str, told.get(name, ())))
            return cls(**told)
        except TypeError as error:
            raise SurfaceError(f"expected the settings of a reconstruct, got others ({error})") from error

    @property
    def source(self) -> LampSource:
        """What tells the lamps."""
        return LampSource(self.sphere, self.card, self.lamps_unknown, self.inside_out, self.near_lamps)

    @property
    def folder(self) -> Path:
        """What is read: a folder, or the file of lamps in it."""
        return Path(self.capture)


@dataclass(frozen=True, slots=True, eq=False)
class _Photographs:
    """The photographs of one run. inputs: digests of the files that they were read from, by path."""

    lit: LitCapture
    capture: Capture
    inputs: Mapping[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class _Account:
    """What is told of a surface. beside: further files, by name. card: what the card told, for --json."""

    notes: tuple[Bilingual, ...]
    table: tuple[PhotographRow, ...]
    processing: Processing
    beside: Mapping[str, str | bytes]
    card: Mapping[str, Any]


def make_surface(settings: ReconstructSettings, out: Path, made_by: str | None) -> tuple[Outcome, Surface]:
    """Make a surface by its settings and write it into a folder.

    made_by: a person's name, for the record. Raises wrong usage for settings that exclude each other, and as
    `rumu.reconstruct` does.
    """
    from rumu.image_stack import begin
    from rumu.outputs import whole_folder
    from rumu.surface.folder import MARKER
    from rumu.surface.photograph_table import table_text

    files = _files_to_write(settings.write)
    check_writable(whole_folder(out, marker=MARKER))
    with stages(_stages(settings, files)) as progress:
        photographs = _read(settings, progress)
        surface = _solve(photographs.capture, settings, progress)
        begin("Looking at each photograph", progress)
        account = _account(settings, photographs, surface, made_by)
        del photographs  # they take memory, which writing needs
        done = write_result(
            surface,
            out,
            title=settings.folder.name,
            notes=account.notes,
            files=files,
            beside=account.beside,
            processing=account.processing,
            progress=progress,
        )
    facts = {**done.facts, **account.card, "photographs": [asdict(row) for row in account.table]}
    return Outcome(facts, f"{done.text}\n{table_text(account.table)}"), surface


def _stages(settings: ReconstructSettings, files: Sequence[str]) -> list[Stage]:
    """The stages to come, for how long the whole will take."""
    return reconstruct_stages(
        files,
        solver=settings.solver,
        align=settings.align,
        near=settings.near_lamps,
        card=settings.card,
    )


def _read(settings: ReconstructSettings, progress: Progress) -> _Photographs:
    """The photographs and their lamps."""
    from rumu.surface.processing import digest_files

    flat_field = None if settings.flat_field is None else Path(settings.flat_field)
    lit = read_lit_capture(
        settings.folder,
        settings.source,
        flat_field=flat_field,
        align=settings.align,
        leave_out=settings.leave_out,
        mm_per_pixel=settings.mm_per_pixel,
        encoding=settings.encoding,
        progress=progress,
    )
    capture = lit.capture
    lamps_found = bool(settings.sphere) or settings.card or settings.lamps_unknown
    inputs = digest_files(_files_read(settings.folder, capture, flat_field, lamps_found=lamps_found))
    if settings.lamps_as_given:
        capture = capture.changed(lamps_as_given=True)
    return _Photographs(lit, capture, inputs)


def _solve(capture: Capture, settings: ReconstructSettings, progress: Progress) -> Surface:
    from rumu import pipeline

    return pipeline.reconstruct(
        capture,
        solver=settings.solver,
        integrator=settings.integrator,
        focal_length=settings.focal_length,
        level=settings.level,
        rectify=settings.rectify,
        progress=progress,
    )


def _account(
    settings: ReconstructSettings, photographs: _Photographs, surface: Surface, made_by: str | None
) -> _Account:
    """The table of the photographs, the notes, the record, and the files that lie beside the surface."""
    from rumu.capture.exif import read_facts
    from rumu.capture.light_files import lp_text
    from rumu.surface.encoding_check import encoding_notes
    from rumu.surface.frame_check import exposure_notes
    from rumu.surface.gloss_check import gloss_notes
    from rumu.surface.lamp_positions import near_notes
    from rumu.surface.photograph_table import fault_notes, photograph_table
    from rumu.surface.processing import record_processing

    capture, lit = photographs.capture, photographs.lit
    table = photograph_table(capture, surface, aligned=lit.moved)
    notes = (
        *capture.notes,
        *exposure_notes(capture, surface),
        *encoding_notes(capture, surface),
        *gloss_notes(capture, surface),
        *fault_notes(table),
        *near_notes(capture, surface),
    )
    facts = [read_facts(_place_of(settings.folder) / name) for name in capture.names]
    processing = record_processing(
        surface,
        settings=asdict(settings),
        inputs=photographs.inputs,
        made_by=made_by,
        lamps=_lamps_of(capture, settings.source),
        photographs=_told_by_the_photographs(capture.names, facts),
    )
    account = _Account(notes, tuple(table), processing, {}, _told_by_the_card(lit))
    beside: dict[str, str | bytes] = {}
    if settings.source != LampSource():
        beside[LAMPS] = lp_text(capture.names, capture.lights)
    if settings.capture_report is not None:
        beside[CAPTURE_REPORT] = _report_to_sign(settings, capture, surface, account, facts)
    return replace(account, beside=beside)


def _report_to_sign(
    settings: ReconstructSettings,
    capture: Capture,
    surface: Surface,
    account: _Account,
    facts: Sequence[PhotographFacts],
) -> bytes:
    """The report of a capture as a PDF. facts: what each photograph says of itself."""
    from rumu.report.capture_report import CaptureReport, capture_pdf
    from rumu.surface.residual_map import residual_map

    report = CaptureReport(
        settings.folder.name,
        surface,
        capture.lights,
        settings.source.words,
        account.table,
        facts,
        residual_map(capture, surface),
        account.notes,
        account.processing,
    )
    return capture_pdf(report, language=settings.capture_report)  # type: ignore[arg-type]


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


def _files_read(folder: Path, capture: Capture, flat_field: Path | None, *, lamps_found: bool) -> list[Path]:
    """The files that a capture was read from: photographs, lamps, mask, description, flat-field frames.

    lamps_found: whether the photographs told the lamps, and no file.
    """
    from rumu.capture.description import description_of
    from rumu.capture.lamp_files import LAMP_SUFFIXES, lamp_files_within
    from rumu.capture.masks import mask_file
    from rumu.capture.photographs import FolderImages, files

    place = _place_of(folder)
    images = FolderImages(place)
    description = description_of(place)
    told = [one for one in files(place) if one.suffix.lower() in LAMP_SUFFIXES]
    if not lamps_found and not any(one.suffix.lower() in LAMP_SUFFIXES[:3] for one in told):
        told += lamp_files_within(images)
    mask = mask_file(images, description)
    ambient = images.by_stem("ambient")
    found = [*told, *(place / name for name in capture.names), *(one for one in (mask, ambient) if one)]
    if flat_field is not None:
        found += FolderImages(flat_field).images() if flat_field.is_dir() else [flat_field]
    return found


def _files_to_write(wanted: str) -> list[str]:
    """The files that `--write` asks for: by groups, by arrays, or by their names."""
    from rumu.surface.array_files import ARRAYS
    from rumu.surface.folder import FILES, FLOATS, MESH, ON_REQUEST, PICTURES

    groups: dict[str, tuple[str, ...]] = {
        "all": (*FILES, REPORT),
        "floats": FLOATS,
        "pictures": PICTURES,
        "mesh": (MESH,),
        "report": (REPORT,),
        **{name: (f"{name}.tif", f"{name}.png") for name in ARRAYS},
        **{name: (name,) for name in (*FILES, *ON_REQUEST, REPORT)},
    }
    found: list[str] = []
    for one in filter(None, (part.strip().lower() for part in wanted.split(","))):
        if one not in groups:
            raise typer.BadParameter(f"{one!r} is none of {', '.join(groups)}", param_hint="'--write'")
        found += [name for name in groups[one] if name not in found]
    if not found:
        raise typer.BadParameter("expected something to write", param_hint="'--write'")
    return found
