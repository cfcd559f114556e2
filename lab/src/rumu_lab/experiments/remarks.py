"""Whether the remarks name a fault that is known to be there.

Each fault of the simulation is put into masters of three kinds - the works of the starter gallery, the
templates of the E3C copies, samples of steles - and remarks are made on the copy. A fault is named when a
remark of its kind is among them that speaks of the stroke that the fault is in, if it is in one. The
thresholds of the remarks were set on the masters that are 'seen'; the others took no part, and their figures
count.
"""

from __future__ import annotations

import csv
import functools
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import CalibrationError, RumuError, SurfaceError
from rumu.pipeline import PreparedMaster
from rumu.values import BoolArray, Remark
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import FOLDERS, read_templates
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.simulation.faults import FaultyGlyph, apply
from rumu_lab.simulation.glyph import Glyph

ANSWERS: Mapping[str, tuple[str, ...]] = {
    "missing": ("missing",),
    "squeeze": ("squeeze",),
    "lean": ("lean",),
    "entry": ("entry_heavy",),
    "blunt": ("exit_blunt",),
    "small": ("size",),
    "shift": ("displaced",),
    "angle": ("stroke_angle",),
    "horizontal": ("stroke_angle",),
    "thick": ("heavy",),
    "thin": ("thin",),
    "stroke_thick": ("stroke_heavy",),
    "stroke_thin": ("stroke_thin",),
    "short": ("stroke_short",),
    "extra": ("extra",),
    "off_centre": ("offset",),
    "uneven": ("spacing", "displaced"),
    "wobble": ("rough",),
    "blot": ("blot",),
    "pale": ("pale",),
    "dry": ("dry",),
}
"""The kinds of remark that name a fault, the faults that were asked for first."""
SEVERITIES = (2.0, 3.0, 4.0, 5.0)
MIDDLE = (3.0,)
"""What `run` puts in unless told otherwise: all four take four times as long."""
ASKED: tuple[tuple[str, float], ...] = (("lean", 1.5), ("small", 1.5), ("horizontal", 3.0))
"""A lean of 6 degrees, a character 12 % too small, a horizontal that leans by 6 degrees."""
_SEEN = """
seal-tian seal-yue seal-ren seal-shui seal-shu clerical-ri clerical-shui clerical-ren regular-shu regular-shui
regular-ri running-shui running-tian cursive-ren cursive-shu
"""
SEEN = frozenset(_SEEN.split())
"""Starter works that were looked at while the thresholds were set; the other half was not."""
SIDE = 256
"""Pixels of the longer side of a master, at most; a sixteenth of paper is added all round."""
STELES = 12
"""Samples of masters/regular, spread evenly over the list."""
SEEN_INK = 0.01
"""Share of the ink that blunt tips must add to be there at all."""
NEAR = 0.07
"""Fraction of the picture within which a remark's outline must keep to the struck stroke's path."""


@dataclass(frozen=True, slots=True)
class RemarkMaster:
    """One master. seen: whether the thresholds were set with it in view. character: what is written."""

    name: str
    path: Path
    seen: bool
    character: str | None = None


@dataclass(frozen=True, slots=True)
class FaultTrial:
    """One copy with one fault, and the remarks on it.

    position: of the remark that names the fault among the remarks, 0 first; None when none does.
    kinds: of the remarks. refused: why the copy was not marked.
    """

    master: str
    seen: bool
    fault: str
    severity: float
    position: int | None
    kinds: tuple[str, ...]
    refused: str | None = None


def run(
    settings: RunSettings,
    *,
    masters: Sequence[RemarkMaster] | None = None,
    severities: tuple[float, ...] = MIDDLE,
) -> Findings:
    """Put every fault into every master, and see whether the remarks name it.

    Writes OUT/tables/remarks.csv, one row a copy. masters: others than the standard ones. severities: of
    SEVERITIES. Raises CalibrationError when the data is not there.
    """
    masters = standard_masters(settings.data) if masters is None else masters
    work = functools.partial(try_master, severities=severities)
    trials = [trial for some in measure_each(work, masters, settings) for trial in some]
    if settings.tables is not None:
        write_table(trials, settings.tables / "remarks.csv")
    facts = figures(trials)
    return Findings("remarks", facts, words=text(facts))


def text(facts: Mapping[str, Any]) -> str:
    """The figures as a person reads them."""
    head = ("fault", "copies", "told back", "told first", "", "on seen masters")
    rows = [head]
    for name, f in facts["faults"].items():
        held, seen = f["held_out"], f["seen"]
        shares = (f"{held[k]:.0%}" for k in ("told", "first"))
        rows.append((name, str(held["copies"]), *shares, "", f"{seen['told']:.0%} of {seen['copies']}"))
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    table = "\n".join(
        "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows
    )
    clean = facts["clean"]
    return "\n".join(
        [
            f"Faults told back by name, severity {facts['severities']}: "
            f"N = {facts['copies']} copies of {facts['held_out_masters']} masters that no "
            "threshold was set on.",
            table,
            f"Clean copies, at another size or place: {clean['copies']}, of which {clean['stroke']} "
            f"got a remark on a stroke and {clean['any']} any remark.",
        ]
    )


def standard_masters(data: Path) -> list[RemarkMaster]:
    """The thirty starter works, the E3C templates, and samples of steles."""
    from rumu.gallery.starter import starter_works

    templates = read_templates(data)
    steles = sorted((data / "masters" / "regular").rglob("*.png"))
    if not templates or not steles:
        raise CalibrationError(f"{data}: expected e3c/templates and masters/regular here, found none")
    spread = [steles[k] for k in np.linspace(0, len(steles) - 1, STELES).astype(int)]
    folder = data / "masters" / "regular"
    written = {
        data / part / file: character
        for part in FOLDERS
        for file, character in _characters(data / part / "scores.csv", "template").items()
    }
    carved = _characters(folder / "labels.csv", "file")
    return [
        *(RemarkMaster(w.id, w.path, w.id in SEEN, w.character) for w in starter_works()),
        *(RemarkMaster(f"e3c-{p.stem}", p, False, written.get(p)) for p in templates),
        *(
            RemarkMaster(f"stele-{p.stem}", p, False, carved.get(p.relative_to(folder).as_posix()))
            for p in spread
        ),
    ]


def _characters(table: Path, column: str) -> dict[str, str]:
    """What is written in each file that a column names; nothing where the table is not there."""
    if not table.is_file():
        return {}
    with table.open(encoding="utf-8") as stream:
        return {row[column]: row["character"] for row in csv.DictReader(stream)}


def try_master(master: RemarkMaster, severities: tuple[float, ...]) -> list[FaultTrial]:
    """All faults of one master. A fault that the glyph cannot have is left out."""
    from rumu import pipeline

    glyph = _glyph(master.path)
    prepared = pipeline.prepare_master(_picture(glyph.mask), character=master.character)
    cases = list(dict.fromkeys([(fault, s) for fault in ANSWERS for s in severities] + list(ASKED)))
    trials: list[FaultTrial] = []
    for fault, severity in cases:
        seed = zlib.crc32(f"{master.name} {fault} {severity:g}".encode()) % 10_000
        try:
            copy = apply(glyph.mask, fault, severity=severity, seed=seed)
        except SurfaceError:  # no stroke to leave out, none that lies
            continue
        if fault == "squeeze" and not has_halves(master.character):
            continue  # of a character without a left and a right part nothing is said of them
        if fault == "blunt" and (copy.mask ^ glyph.mask).sum() < SEEN_INK * glyph.mask.sum():
            continue  # no tip that tapers, as in seal script
        remarks, refused = _remarks(copy.ink, prepared)
        right = [r.kind in ANSWERS[fault] and speaks_of(r, copy, glyph) for r in remarks]
        position = right.index(True) if any(right) else None
        kinds = tuple(r.kind for r in remarks)
        trials.append(FaultTrial(master.name, master.seen, fault, severity, position, kinds, refused))
    for name, ink in _clean_copies(glyph).items():
        remarks, refused = _remarks(ink, prepared)
        kinds = tuple(r.kind for r in remarks)
        trials.append(FaultTrial(master.name, master.seen, f"clean {name}", 0.0, None, kinds, refused))
    return trials


def speaks_of(remark: Remark, copy: FaultyGlyph, glyph: Glyph) -> bool:
    """Whether a remark speaks of strokes that the fault struck, or of the place where it is."""
    if not copy.strokes:
        return remark.region is None or copy.fault not in ("extra", "blot") or _meet(remark, copy)
    if not remark.outline:
        return False
    if copy.fault == "entry" and not _meet(remark, copy):
        return False  # a heavy beginning, but of another stroke or at the wrong end
    points = np.concatenate([np.array(line) for line in remark.outline])
    size = np.array(glyph.mask.shape, float)
    paths = np.concatenate([(glyph.strokes[k].points / size)[:, ::-1] for k in copy.strokes])
    away = np.sqrt(((points[:, None] - paths[None]) ** 2).sum(axis=2)).min(axis=1)
    return float((away < NEAR).mean()) >= 0.6


def _meet(remark: Remark, copy: FaultyGlyph) -> bool:
    a, b = remark.region or copy.region, copy.region
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _clean_copies(glyph: Glyph) -> dict[str, np.ndarray]:
    """The ink itself at half and at one and a half times its size, and a little aside."""
    import cv2

    ink = glyph.mask.astype(np.float32)
    aside = np.array([[1.0, 0.0, 3.3], [0.0, 1.0, -2.6]])
    return {
        "half": cv2.resize(ink, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA),
        "larger": cv2.resize(ink, None, fx=1.5, fy=1.5, interpolation=cv2.INTER_LINEAR),
        "aside": cv2.warpAffine(ink, aside, ink.shape[::-1]),
    }


def has_halves(character: str | None) -> bool:
    """Whether a character is made of a left and a right part."""
    from rumu.assessment.part_measures import AXES
    from rumu.characters.stroke_data import find_character

    known = find_character(character) if character else None
    return known is not None and known.structure is not None and AXES.get(known.structure) == "across"


def _remarks(ink: np.ndarray, master: PreparedMaster) -> tuple[tuple[Remark, ...], str | None]:
    """Remarks on a copy with this ink in its cell; or none, and why it cannot be marked."""
    from rumu import pipeline

    try:
        return pipeline.assess(_picture(ink), master, framed=True).remarks, None
    except RumuError as error:
        return (), str(error)


def _picture(ink: np.ndarray) -> np.ndarray:
    """Dark ink on white paper, (H, W) uint8; ink: from 0 to 1."""
    return np.asarray(np.round(255.0 * (1.0 - ink.astype(np.float32))), np.uint8)


def _glyph(path: Path) -> Glyph:
    import cv2

    from rumu import pipeline

    mask: BoolArray = pipeline.surface_of(path).mask
    share = SIDE / max(mask.shape)
    if share < 1.0:
        smaller = cv2.resize(mask.astype(np.float32), None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
        mask = np.asarray(smaller > 0.5)
    return Glyph(np.pad(mask, SIDE // 16))  # what a fault moves must stay in the picture


def figures(trials: Sequence[FaultTrial]) -> dict[str, Any]:
    """Shares named, and named first, by fault, on held-out and on seen masters; and false alarms."""
    faulted = [t for t in trials if not t.fault.startswith("clean")]
    clean = [t for t in trials if t.fault.startswith("clean")]
    asked = {(name, severity) for name, severity in ASKED}
    usual = {(name, severity) for name in ANSWERS for severity in SEVERITIES}
    names = {
        name: [t for t in faulted if t.fault == name and (name, t.severity) not in asked - usual]
        for name in ANSWERS
    }
    names |= {f"{name} {severity:g}": [t for t in faulted if (t.fault, t.severity) == (name, severity)]
              for name, severity in ASKED}  # fmt: skip
    severities = sorted({t.severity for t in faulted if (t.fault, t.severity) not in asked})
    return {
        "severities": ", ".join(f"{s:g}" for s in severities),
        "copies": sum(not t.seen for t in faulted),
        "held_out_masters": len({t.master for t in trials if not t.seen}),
        "seen_masters": sorted({t.master for t in trials if t.seen}),
        "faults": {
            name: {
                "held_out": _shares([t for t in some if not t.seen]),
                "seen": _shares([t for t in some if t.seen]),
                "by_severity": {
                    f"{s:g}": _shares([t for t in some if not t.seen and t.severity == s])
                    for s in sorted({t.severity for t in some})
                },
            }
            for name, some in names.items()
        },
        "clean": {
            "copies": len(clean),
            "any": sum(bool(t.kinds) for t in clean),
            "stroke": sum(any(kind not in WHOLE for kind in t.kinds) for t in clean),
            "refused": sum(t.refused is not None for t in clean),
        },
    }


WHOLE = frozenset(("lean", "size", "offset", "heavy", "thin", "pale", "rough", "dry", "squeeze"))
"""Remarks on the whole character."""


def _shares(trials: list[FaultTrial]) -> dict[str, float]:
    n = max(len(trials), 1)
    return {
        "copies": len(trials),
        "told": sum(t.position is not None for t in trials) / n,
        "first": sum(t.position == 0 for t in trials) / n,
    }


def write_table(trials: Sequence[FaultTrial], path: Path) -> None:
    """One row a copy: master, whether seen, fault, severity, position of the remark that names it, kinds."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["master", "seen", "fault", "severity", "told", "kinds", "refused"])
        for t in trials:
            told = "" if t.position is None else t.position + 1
            writer.writerow(
                [t.master, t.seen, t.fault, f"{t.severity:g}", told, " ".join(t.kinds), t.refused or ""]
            )
