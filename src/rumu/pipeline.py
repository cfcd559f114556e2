"""The recipe, and the only place that knows the order: read, reconstruct, measure, mark, remark."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.calibration import Calibration, check_terms, mark_fields
from rumu.assessment.edges import describe_edge
from rumu.assessment.features import Features, measure_features, sim_paper, similarity
from rumu.assessment.refusal import RefusalFigures, RefusalLimits, RefusalReference, check_copy
from rumu.assessment.refusal_reasons import Refusal, refusal_of
from rumu.assessment.remarks import Review, write_remarks
from rumu.capture.folder import read_capture
from rumu.characters.stroke_data import STROKE_SCRIPTS, CanonicalCharacter, find_character
from rumu.errors import RefusedImage, RegistrationError, SurfaceError
from rumu.image_stack import Progress
from rumu.registration.icp import IcpSettings, register_points
from rumu.registration.points import Canvas, canvas_of, ink_mask, sample_points
from rumu.registration.quaternion import Rotation
from rumu.strokes.centre_lines import frame_ink
from rumu.strokes.correspondence import CopyStrokes, MasterStrokes
from rumu.strokes.omissions import MasterInk
from rumu.strokes.recognition import recognise
from rumu.surface.folder import MARKER, read_surface
from rumu.surface.relief import relief
from rumu.values import Assessment, Capture, FloatArray, PointSet, Registration, Surface

SurfaceLike = Surface | str | Path | np.ndarray
_MOST_FILES = 1000  # of a folder whose surface is kept for the next copies


def reconstruct(
    capture: Capture | str | Path,
    *,
    solver: str = "robust",
    integrator: str = "auto",
    rectify: str = "none",
    focal_length: float | None = None,
    level: str = "none",
    progress: Progress | None = None,
) -> Surface:
    """Reconstruct the surface of a capture by photometric stereo.

    Parameters
    ----------
    capture
        Photographs under known lamps, or the path of a capture folder.
    solver
        'least_squares', 'trimmed', 'l1' or 'robust'. Three lamps of the paper's kind take its closed form.
    integrator
        How normals become heights, see `rumu.integrate`.
    rectify
        How uneven lamplight is evened out first: 'none', 'masked' (recommended for a flat sheet), 'bands' or
        'svd' (the paper's).
    focal_length
        Of the camera, in pixels of the photographs; None for a camera that is far away.
    level
        What is taken off the height and the normals in the end: 'none', 'plane', or 'bow', a plane and a
        polynomial of second degree.
    progress
        Called with what is done, how many parts of it are done and how many there are.

    Returns
    -------
    Surface
        Of source 'photometric', in millimetres where the capture knows its scale.

    Raises
    ------
    CaptureError
        When the folder or the photographs cannot be used.
    SurfaceError
        When no surface can be found from them.

    Notes
    -----
    After Woodham, "Photometric method for determining surface orientation from multiple images" (1980), and
    the paper's equations; see docs/paper.md.
    """
    from rumu.capture.illumination import rectify_capture
    from rumu.surface.photometric import photometric

    if not isinstance(capture, Capture):
        capture = read_capture(capture, progress=progress)
    if rectify != "none":
        capture = rectify_capture(capture, method=rectify)  # type: ignore[arg-type]
    return photometric(
        capture,
        solver=solver,
        integrator=integrator,
        focal_length=focal_length,
        level=level,
        progress=progress,
    )


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
    """The surface that rumu wrote into a folder, or that of the capture in it."""
    return read_surface(folder) if (folder / MARKER).is_file() else reconstruct(folder)


def register(probe: SurfaceLike, reference: SurfaceLike, *, rotation: Rotation = "z") -> Registration:
    """Lay the ink of the probe on that of the reference by a rigid motion.

    Parameters
    ----------
    probe, reference
        Surfaces, or what holds one: an image as a path or an array, a folder.
    rotation
        'z' turns the sheet in its plane; 'full' also tilts it, for true 3-D scans.

    Returns
    -------
    Registration
        The pose, and what it leaves. Size is taken out before and recorded. Not converging is a field.

    Raises
    ------
    RumuError
        When either cannot be read or has too little ink.

    Notes
    -----
    Iterative closest points (Besl and McKay 1992) with the paper's closed-form pose by a unit quaternion.
    """
    points = (sample_points(surface_of(x)) for x in (probe, reference))
    return register_points(*points, settings=IcpSettings(rotation=rotation))


@dataclass(frozen=True, eq=False)
class PreparedMaster:
    """A master with everything that is derived from it, to be made once and used for many copies.

    Each part is computed when it is first needed. A master that cannot be compared with raises
    RegistrationError or SurfaceError then.

    surface: the master itself. character: what is written, None where nobody has said it. recognised: whether
    it is then looked for among the characters of copybooks, which its script must be known to write.
    """

    surface: Surface
    character: str | None = None
    recognised: bool = False

    @cached_property
    def canvas(self) -> Canvas:
        """Its ink on the common canvas."""
        return canvas_of(ink_mask(self.surface))

    @cached_property
    def points(self) -> PointSet:
        """Ink points: what copies are registered to."""
        try:
            return sample_points(self.surface, canvas=self.canvas)
        except RefusedImage as refusal:
            raise RegistrationError(f"the master cannot be compared with: {refusal}") from refusal

    @cached_property
    def edges(self) -> FloatArray:
        """(EDGE_NUMBERS,) description of the edge of its ink, see `describe_edge`."""
        return describe_edge(self.canvas.ink)

    @cached_property
    def outline(self) -> RefusalReference:
        """Its outlines as they are, mirrored and turned, for the refusal of copies."""
        return RefusalReference(self.points, self.surface.quality.get("noise", np.inf))

    @cached_property
    def ink(self) -> MasterInk:
        """Its ink points and their centre lines, to look for missing strokes."""
        return MasterInk(self.points)

    @cached_property
    def stroke_model(self) -> MasterStrokes:
        """Its strokes at full resolution, for remarks."""
        return MasterStrokes(self.surface, self.points, self.canonical)

    @cached_property
    def canonical(self) -> CanonicalCharacter | None:
        """The canonical strokes of its character, given or recognised; None where they are not known."""
        if self.character or not self.recognised:
            return find_character(self.character or "")
        found = recognise(self.canvas, frame_ink(ink_mask(self.surface), self.points))
        return found.character if found is not None and found.is_certain else None


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """All that is known of a copy laid on its master, before it is marked.

    strokes: the master's on the copy, where its character was given; None where the mark does without.
    figures: what the refusal rests on, computed on demand. refusal: why the copy cannot be marked, or None.
    highest: the highest mark, 0-100, that it may get; below 100 when it is hardly like its master.
    """

    copy: Surface
    master: PreparedMaster
    registration: Registration
    features: Features
    strokes: CopyStrokes | None
    figures: RefusalFigures
    refusal: Refusal | None
    highest: float


def measure(copy: Surface, master: PreparedMaster, *, limits: RefusalLimits | None = None) -> Measurement:
    """Lay a copy on its master and measure what a mark is made of.

    Raises RefusedImage for a copy with too little ink or no relief, RegistrationError or SurfaceError for
    such a master.
    """
    reference, edges = master.points, master.edges
    try:
        canvas = canvas_of(ink_mask(copy))
        probe = sample_points(copy, canvas=canvas)
    except RegistrationError as error:
        raise RefusedImage(str(error), reason="too small") from error
    except SurfaceError as error:
        raise RefusedImage(f"{error}; mark the ink of one image instead", reason="flat") from error
    registration = register_points(probe, reference)
    edges = describe_edge(canvas.ink) - edges
    strokes = CopyStrokes(copy, registration, master.stroke_model) if master.character else None
    features = measure_features(registration, edges=edges, ink=master.ink, strokes=strokes)
    figures = RefusalFigures(copy, master.outline, registration)
    refusal, highest = check_copy(figures, limits=limits)
    return Measurement(copy, master, registration, features, strokes, figures, refusal, highest)


def prepare_master(
    reference: SurfaceLike | PreparedMaster, *, character: str | None = None, script: str | None = None
) -> PreparedMaster:
    """A master made ready once for many copies; `assess` takes it in place of the master itself.

    character: what is written, where it is known and the master does not know it yet. script: in which; the
    strokes of seal, clerical and cursive script are not those of copybooks, so they are not named. Only of a
    master that is said to be in regular or running script is the character recognised, where that is certain:
    what is 水 in seal script is 巛 in another.

    The last masters that came as paths stay in memory, for the next copies, until their files change.
    """
    if script not in STROKE_SCRIPTS:
        character = None
    recognised = script is not None and script in STROKE_SCRIPTS
    if isinstance(reference, str | Path) and (stamps := _stamps(Path(reference))) is not None:
        return _prepare_stored(Path(reference), stamps, character, recognised)
    if not isinstance(reference, PreparedMaster):
        return PreparedMaster(surface_of(reference), character, recognised)
    if character and reference.character is None:
        return PreparedMaster(reference.surface, character, recognised)
    return reference


@lru_cache(maxsize=4)  # each surface may hold many pixels
def _prepare_stored(
    path: Path, stamps: tuple[tuple[str, int, int], ...], character: str | None, recognised: bool
) -> PreparedMaster:
    """The master in a file or folder; stamps: of its files, which another state of them does not have."""
    return PreparedMaster(surface_of(path), character, recognised)


def _stamps(path: Path) -> tuple[tuple[str, int, int], ...] | None:
    """Name, size and time of change of a file, or of every file in a folder; None of too many files."""
    files = list(islice(path.rglob("*"), _MOST_FILES)) if path.is_dir() else [path]
    if len(files) == _MOST_FILES:
        return None
    stamps = []
    for file in sorted(files):
        try:
            found = file.stat()
        except (OSError, ValueError):
            continue  # reading it will say why
        stamps.append((str(file), found.st_size, found.st_mtime_ns))
    return tuple(stamps)


def assess(
    probe: SurfaceLike,
    reference: SurfaceLike | PreparedMaster,
    *,
    levels: Mapping[str, float] | None = None,
    calibration: Calibration | str | Path | None = None,
    weights: Mapping[str, float] | None = None,
    script: str | None = None,
    character: str | None = None,
    framed: bool = False,
    remarks: bool = True,
) -> Assessment:
    """Mark a copy against its master.

    Parameters
    ----------
    probe
        The copy: a Surface, an image as a path or an array, or a folder.
    reference
        The master, likewise. What is derived from the last few that came as paths is kept for the next
        copies; another kind is prepared once for many copies with `rumu.pipeline.prepare_master`.
    levels
        Own cut-offs of the levels, 0-100: {'excellent': .., 'good': .., 'medium': ..}.
    calibration
        Another than the panel's, or the path of its file.
    weights
        Own weights of the parts: {'brushwork': .., 'structure': .., 'ink': ..}.
    script
        Of the master: 'seal', 'clerical', 'regular', 'running' or 'cursive'. People's marks cover 'regular'
        alone; for the others the interval is wider.
    character
        What is written, where it is known and the master was not prepared with it: the remarks then name its
        strokes and speak of the parts that it has. Without it, in regular
        and running script, it is recognised where that is certain.
    framed
        Whether the picture of the copy is the cell that it was written in, as with a pen on the page or cut
        out along a printed grid. Only then are size, place and lean the writer's doing and worth a remark;
        a photograph that was cropped by hand says nothing of them.
    remarks
        False leaves them out, which saves a third of the time.

    Returns
    -------
    Assessment
        A copy with nothing to mark, or of another master, is refused: then `score` is None and `refused` says
        why.

    Raises
    ------
    ImageError, CaptureError, SurfaceError
        When a file cannot be read or holds no surface.
    RefusedImage, RegistrationError
        When the master holds no writing.
    CalibrationError
        When levels, calibration, weights or script are not as expected.

    Notes
    -----
    docs/what-a-mark-means.md says what the mark rests on and how well it agrees with people.
    """
    terms = check_terms(calibration=calibration, weights=weights, levels=levels, script=script)
    master = prepare_master(reference, character=character, script=script)
    try:
        measurement = measure(surface_of(probe), master)
    except RefusedImage as error:
        refusal = refusal_of(error.reason)
        return _refused_assessment(replace(refusal, en=str(error), zh=error.zh or refusal.zh))
    if measurement.refusal is not None:
        return _refused_assessment(measurement.refusal)
    registration = measurement.registration
    fields = mark_fields(measurement.features, terms=terms, highest=measurement.highest)
    review = Review(None, (), ())
    if remarks:
        review = write_remarks(
            measurement.strokes or CopyStrokes(measurement.copy, registration, master.stroke_model),
            character=master.canonical,
            framed=framed,
            parts=fields["parts"],
        )
    return Assessment(
        **fields,
        sim_paper=sim_paper(registration),
        similarity=similarity(registration),
        character=master.canonical.character if remarks and master.canonical else master.character,
        praise=review.praise,
        remarks=review.remarks,
        untold=review.untold,
        registration=registration,
        source=(measurement.copy.source, master.surface.source),
    )


def _refused_assessment(refusal: Refusal) -> Assessment:
    """An assessment without a mark."""
    nothing = ("score", "level", "interval", "sim_paper", "similarity", "registration", "source")
    fields: dict[str, Any] = dict.fromkeys(nothing)
    refused = f"{refusal.code}: {refusal.en}"
    return Assessment(
        **fields,
        parts={},
        remarks=(),
        refused=refused,
        refused_zh=refusal.zh,
        turned_by=refusal.turned_by,
    )
