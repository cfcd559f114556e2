"""The walk, in order: photographs -> surface; copy and master -> registration -> mark. All pure functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.calibration import Calibration
from rumu.assessment.marking import checked_terms, mark_fields
from rumu.assessment.measurement import PreparedMaster, measure
from rumu.assessment.refusal import Refusal, reason
from rumu.assessment.remarks import write_remarks
from rumu.assessment.similarity import sim_paper, similarity
from rumu.capture.folder import read_capture
from rumu.errors import RefusedImage
from rumu.registration.icp import IcpSettings, register_points
from rumu.registration.points import sample_points
from rumu.registration.quaternion import Rotation
from rumu.surface.folder import MARKER, read_surface
from rumu.surface.relief import relief
from rumu.values import Assessment, Capture, Registration, Surface

SurfaceLike = Surface | str | Path | np.ndarray


def reconstruct(
    capture: Capture | str | Path, *, solver: str = "robust", integrator: str = "auto", rectify: str = "none"
) -> Surface:
    """The surface of a capture, or of the capture folder at a path.

    solver: 'least_squares', 'trimmed', 'l1' or 'robust'; three lamps of the paper's kind take its closed
        form by themselves. integrator: see `rumu.integrate`. rectify: 'none', or how uneven lamplight is
        evened out first: 'masked' (recommended for a flat sheet), 'bands' or 'svd' (the paper's).
    Raises CaptureError or SurfaceError.
    """
    from rumu.capture.illumination import rectify_capture
    from rumu.surface.photometric import photometric

    if not isinstance(capture, Capture):
        capture = read_capture(capture)
    if rectify != "none":
        capture = rectify_capture(capture, method=rectify)  # type: ignore[arg-type]
    return photometric(capture, solver=solver, integrator=integrator)


def surface_of(thing: SurfaceLike) -> Surface:
    """A surface from whatever holds one: itself, an image (array or path), or a folder.

    A folder is a surface that rumu wrote, or else a capture to reconstruct.
    Raises ImageError, CaptureError, SurfaceError, or RefusedImage when a picture holds no ink.
    """
    if isinstance(thing, Surface):
        return thing
    if isinstance(thing, str | Path) and Path(thing).is_dir():
        return _read_folder(Path(thing))
    return relief(thing)


def _read_folder(folder: Path) -> Surface:
    return read_surface(folder) if (folder / MARKER).is_file() else reconstruct(folder)


def register(probe: SurfaceLike, reference: SurfaceLike, *, rotation: Rotation = "z") -> Registration:
    """Lay the ink of the probe on that of the reference.

    rotation: 'z' turns the sheet in its plane; 'full' also tilts it, for true 3-D scans.
    Raises RumuError when either has too little ink; not converging is a field of the result.
    """
    points = (sample_points(surface_of(x)) for x in (probe, reference))
    return register_points(*points, settings=IcpSettings(rotation=rotation))


def prepare_master(reference: SurfaceLike | PreparedMaster) -> PreparedMaster:
    """A master made ready once for many copies; `assess` takes it in place of the master itself."""
    return reference if isinstance(reference, PreparedMaster) else PreparedMaster(surface_of(reference))


def assess(
    probe: SurfaceLike,
    reference: SurfaceLike | PreparedMaster,
    *,
    levels: Mapping[str, float] | None = None,
    calibration: Calibration | str | Path | None = None,
    weights: Mapping[str, float] | None = None,
    script: str | None = None,
    remarks: bool = True,
) -> Assessment:
    """The mark of a copy against its master.

    levels: own cut-offs, {'excellent': .., 'good': .., 'medium': ..}. calibration: another than the panel's,
    or its file. weights: own, {'brushwork': .., 'structure': .., 'ink': ..}. script: of the master; people's
    marks cover 'regular' alone. remarks: False leaves them out, which saves a third of the time. A copy with
    nothing to mark, or of another master, is refused; wrong masters and terms raise.
    """
    terms = checked_terms(calibration=calibration, weights=weights, levels=levels, script=script)
    master = prepare_master(reference)
    try:
        measurement = measure(surface_of(probe), master)
    except RefusedImage as error:
        return _refused(replace(reason(error.reason), en=str(error)))
    if measurement.refusal is not None:
        return _refused(measurement.refusal)
    registration = measurement.registration
    return Assessment(
        **mark_fields(measurement.features, terms=terms, highest=measurement.highest),
        sim_paper=sim_paper(registration),
        similarity=similarity(registration),
        remarks=write_remarks(measurement) if remarks else (),
        registration=registration,
        source=(measurement.copy.source, master.surface.source),
    )


def _refused(why: Refusal) -> Assessment:
    nothing = ("score", "level", "interval", "sim_paper", "similarity", "registration", "source")
    fields: dict[str, Any] = dict.fromkeys(nothing)
    return Assessment(**fields, parts={}, remarks=(), refused=f"{why.code}: {why.en}", refused_zh=why.zh)
