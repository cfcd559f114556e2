"""Mark a copy, and describe the mark for pages: both languages, alignment with the master, residuals."""

from __future__ import annotations

import io
import json
import time
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from rumu import pipeline
from rumu.assessment.calibration import CUT_OFFS, Calibration, load_calibration
from rumu.pipeline import PreparedMaster
from rumu.registration.points import RADIUS
from rumu.report.overlay import OverlaySettings, plane_points
from rumu.report.wording import LEVELS, PARTS, SOURCES, deduction_note, kind_name
from rumu.studio.attempts import MarkedCopy
from rumu.studio.pictures import normalise_picture
from rumu.studio.storage import Storage
from rumu.values import Assessment, FloatArray, IntArray, PointSet, Registration, Remark

POINTS = 1500  # of a cell, at most, in what a page receives
_FAR = OverlaySettings().full  # rms radii at which a point counts as far off


def mark_copy(
    data: bytes,
    master: PreparedMaster,
    *,
    script: str,
    calibration: Calibration | None,
    framed: bool = False,
) -> MarkedCopy:
    """Mark an encoded picture against a master. Raises Unusable when it is no picture.

    script: of the master, '' where not known. framed: as `pipeline.assess` takes it.
    """
    from PIL import Image

    started = time.perf_counter()
    picture = normalise_picture(data)
    with Image.open(io.BytesIO(picture.data)) as image:
        samples = np.asarray(image, dtype=np.float32) / np.float32(255)
    assessment = pipeline.assess(
        samples,
        master,
        script=script or None,
        calibration=calibration,
        framed=framed,
    )
    registration = assessment.registration
    residual = None if registration is None else encode_residual(residual_facts(registration))
    facts = mark_facts(assessment, seconds=time.perf_counter() - started) | {"framed": framed}
    return MarkedCopy(picture, facts, residual)


@lru_cache(maxsize=2)
def load_calibration_of(storage: Storage) -> Calibration | None:
    """Return the calibration that a storage names, None for the one that ships with rumu."""
    return None if storage.calibration is None else load_calibration(storage.calibration)


def mark_facts(mark: Assessment, *, seconds: float) -> dict[str, Any]:
    """Return everything of a mark that a page shows, as values of JSON, except the residual points.

    untold: faults that no page shows, which the next attempt is compared with (see `studio.progress`).
    """
    return {
        "score": _round(mark.score, 2),
        "level": mark.level,
        "level_text": None if mark.level is None else LEVELS[mark.level]._asdict(),
        "cuts": dict(CUT_OFFS["panel"]),
        "percentile": _round(mark.percentile, 1),
        "interval": None if mark.interval is None else [_round(bound, 2) for bound in mark.interval],
        "interval_note": _interval_note(mark),
        "deduction_note": (note := deduction_note(mark)) and note._asdict(),
        "parts": [_part_facts(name, score) for name, score in mark.parts.items()],
        "praise": mark.praise and mark.praise._asdict(),
        "remarks": [_remark_facts(remark) for remark in mark.remarks],
        "untold": [_untold_facts(remark) for remark in mark.untold],
        "similarity": _round(mark.similarity, 4),
        "sim_paper": _round(mark.sim_paper, 4),
        "pose": None if mark.registration is None else _pose_facts(mark.registration),
        "refused": _refusal(mark),
        "source": None if mark.source is None else list(mark.source),
        "source_text": _source_text(mark),
        "calibration": mark.calibration,
        "align": None if mark.registration is None else {"matrix": alignment(mark.registration)},
        "seconds": round(seconds, 3),
    }


def residual_facts(registration: Registration) -> dict[str, list[list[float]]]:
    """Return {'copy', 'master'}: [[x, y, r], ...], at most POINTS each.

    x, y: fractions of the cell of this writing, origin top left. r: distance in the plane to the nearest
    point of the other writing once the copy is laid on the master, from 0 to 1 at 0.3 rms radii or more.
    """
    copy, master = plane_points(registration)
    sides = (
        ("copy", registration.probe, copy, master),
        ("master", registration.reference, master, copy),
    )
    residuals = {}
    for name, points, plane, other in sides:
        chosen = _thin_out(plane)
        distance = np.clip(cKDTree(other).query(plane[chosen])[0] / _FAR, 0, 1)
        residuals[name] = np.round(np.column_stack([in_cell(points)[chosen], distance]), 4).tolist()
    return residuals


def encode_residual(facts: dict[str, list[list[float]]]) -> bytes:
    """The residual points as they are stored and sent."""
    return json.dumps(facts, separators=(",", ":")).encode()


def alignment(registration: Registration) -> list[float]:
    """Return [a, b, c, d, e, f] with x' = a x + c y + e, y' = b x + d y + f, as CSS takes a matrix.

    From fractions of the copy's cell, origin top left, to fractions of the master's.
    """
    probe, reference = registration.probe, registration.reference
    pose = registration.T_reference_probe
    turn, shift = pose[:2, :2], pose[:2, 3]
    to_points = _linear(probe) / probe.radius
    linear = np.linalg.inv(_linear(reference)) * reference.radius @ turn @ to_points
    half = np.array([0.5, 0.5])
    centre = np.zeros(2) - probe.centre / probe.radius  # the middle of the copy's cell, among its points
    moved = reference.radius * (turn @ centre + shift) + reference.centre
    offset = np.linalg.inv(_linear(reference)) @ moved + half - linear @ half
    (a, c), (b, d) = linear
    return [round(float(value), 6) for value in (a, b, c, d, *offset)]


def in_cell(points: PointSet) -> FloatArray:
    """Return (N, 2): the points in fractions of their cell, origin top left."""
    from_middle = points.xyz[:, :2] * points.radius + points.centre
    return np.asarray(from_middle @ np.linalg.inv(_linear(points)).T + 0.5)


def _linear(points: PointSet) -> FloatArray:
    """Return (2, 2): from fractions of the cell, y down, to fractions of its longer side, y up."""
    width, height = points.cell
    return np.array([[width, 0.0], [0.0, -height]])


def _thin_out(points: FloatArray) -> IntArray:
    """Return indices of at most POINTS, one in each square of a grid that is just wide enough."""
    side = 1.0 / RADIUS  # a pixel of the canvas that the points come from: all of them
    while True:
        square = np.floor(points / side).astype(np.int64)
        _, first = np.unique(square, axis=0, return_index=True)
        if len(first) <= POINTS:
            return np.sort(first)
        side *= 1.1


def _part_facts(name: str, score: float) -> dict[str, Any]:
    title, meaning = PARTS[name]
    return {"name": name, "zh": title.zh, "en": title.en, "score": _round(score, 2)} | {
        "meaning": meaning._asdict()
    }


def _remark_facts(remark: Remark) -> dict[str, Any]:
    name = kind_name(remark.kind)
    return {
        "kind": remark.kind,
        "name": name._asdict(),
        "zh": remark.zh,
        "en": remark.en,
        "severity": _round(remark.severity, 3),
        "size": _round(remark.size, 4),
        "unit": remark.unit,
        "region": None if remark.region is None else [_round(edge, 4) for edge in remark.region],
        "outline": _line_facts(remark.outline),
        "master_outline": _line_facts(remark.master_outline),
        "stroke": remark.stroke,
    }


def _untold_facts(remark: Remark) -> dict[str, Any]:
    """Return what a comparison needs of a fault; of its lines few points, since there can be many faults."""
    facts = _remark_facts(remark)
    lines = {name: [_few(line) for line in facts[name]] for name in ("outline", "master_outline")}
    return {name: facts[name] for name in ("kind", "severity", "size", "unit", "stroke")} | lines


def _few(line: list[Any], *, most: int = 12) -> list[Any]:
    """Return at most so many points of a line, both ends among them."""
    if len(line) <= most:
        return line
    return [line[round(k * (len(line) - 1) / (most - 1))] for k in range(most)]


def _line_facts(lines: tuple[tuple[tuple[float, float], ...], ...]) -> list[list[list[float | None]]]:
    return [[[_round(x, 4), _round(y, 4)] for x, y in line] for line in lines]


def _pose_facts(registration: Registration) -> dict[str, Any]:
    return {
        "angle": _round(registration.angle, 3),
        "scale": _round(registration.scale, 4),
        "shift": [_round(float(part), 4) for part in registration.shift],
    }


def _refusal(mark: Assessment) -> dict[str, Any] | None:
    if mark.refused is None:
        return None
    code, _, sentence = mark.refused.partition(": ")
    words = {"code": code, "zh": mark.refused_zh or sentence, "en": sentence}
    return words | {"turned_by": mark.turned_by}


def _interval_note(mark: Assessment) -> dict[str, str] | None:
    if mark.interval_note is None:
        return None
    return {"zh": mark.interval_note_zh or mark.interval_note, "en": mark.interval_note}


def _source_text(mark: Assessment) -> dict[str, str] | None:
    """Return where the heights come from; one sentence if it is the same for copy and master."""
    if mark.source is None:
        return None
    texts = [SOURCES[source] for source in dict.fromkeys(mark.source)]
    if len(texts) == 1:
        return texts[0]._asdict()
    (copy, master) = texts
    return {
        "zh": f"臨作：{copy.zh}範字：{master.zh}",
        "en": f"The copy: {copy.en} The master: {master.en}",
    }


def _round(value: float | None, digits: int) -> float | None:
    return None if value is None else round(float(value), digits)
