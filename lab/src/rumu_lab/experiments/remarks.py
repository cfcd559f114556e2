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
from rumu_lab.experiments.fault_answers import (
    ANSWERS,
    SEEN_PUSH,
    can_be_named,
    farthest_change,
    find_position,
    is_seen,
)
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import FOLDERS, read_templates
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.simulation.faults import apply
from rumu_lab.simulation.glyph import Glyph

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
    kinds: of the remarks. refused: why the copy was not marked. visible: whether the fault is large enough
    to be seen, see `fault_answers`. moved: how far ink lies off its place at most, fraction of the picture.
    """

    master: str
    seen: bool
    fault: str
    severity: float
    position: int | None
    kinds: tuple[str, ...]
    refused: str | None = None
    visible: bool = True
    moved: float = 0.0


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
    large = f"ink {SEEN_PUSH:.0%} off its place"
    head = ("fault", "copies", "told back", "told first", large, "on seen masters", "too small to be seen")
    rows = [head]
    for name, f in facts["faults"].items():
        held, seen, small, large = f["held_out"], f["seen"], f["too_small"], f["moved"]
        shares = (f"{held[k]:.0%}" for k in ("told", "first"))
        others = (f"{some['told']:.0%} of {some['copies']}" for some in (large, seen, small))
        rows.append((name, str(held["copies"]), *shares, *others))
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
        if not can_be_named(copy, glyph, master.character):
            continue
        remarks, untold, refused = _remarks(copy.ink, prepared)
        position = find_position(remarks, untold, copy, glyph)
        kinds, visible = tuple(r.kind for r in remarks), is_seen(copy, glyph)
        trials.append(
            FaultTrial(
                master.name,
                master.seen,
                fault,
                severity,
                position,
                kinds,
                refused,
                visible,
                farthest_change(copy, glyph),
            )
        )
    for name, ink in _clean_copies(glyph).items():
        remarks, _, refused = _remarks(ink, prepared)
        kinds = tuple(r.kind for r in remarks)
        trials.append(FaultTrial(master.name, master.seen, f"clean {name}", 0.0, None, kinds, refused))
    return trials


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


def _remarks(
    ink: np.ndarray, master: PreparedMaster
) -> tuple[tuple[Remark, ...], tuple[Remark, ...], str | None]:
    """Remarks on a copy with this ink in its cell, the faults besides, and why it cannot be marked."""
    from rumu import pipeline

    try:
        mark = pipeline.assess(_picture(ink), master, framed=True)
    except RumuError as error:
        return (), (), str(error)
    return mark.remarks, mark.untold, None


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
                "held_out": _shares([t for t in some if not t.seen and t.visible]),
                "moved": _shares([t for t in some if not t.seen and t.visible and t.moved >= SEEN_PUSH]),
                "too_small": _shares([t for t in some if not t.seen and not t.visible]),
                "seen": _shares([t for t in some if t.seen and t.visible]),
                "by_severity": {
                    f"{s:g}": _shares([t for t in some if not t.seen and t.visible and t.severity == s])
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


WHOLE = frozenset(("lean", "size", "offset", "heavy", "thin", "pale", "rough", "dry", "squeeze", "aspect"))
"""Remarks on the whole character."""


def _shares(trials: list[FaultTrial]) -> dict[str, float]:
    n = max(len(trials), 1)
    return {
        "copies": len(trials),
        "told": sum(t.position is not None for t in trials) / n,
        "first": sum(t.position == 0 for t in trials) / n,
    }


def write_table(trials: Sequence[FaultTrial], path: Path) -> None:
    """One row a copy, as of `FaultTrial`; told: position of the remark that names the fault, from 1."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        head = ["master", "seen", "fault", "severity", "told", "kinds", "refused", "visible", "moved"]
        writer.writerow(head)
        for t in trials:
            told = "" if t.position is None else t.position + 1
            kinds, severity = " ".join(t.kinds), f"{t.severity:g}"
            fault = (t.master, t.seen, t.fault, severity)
            writer.writerow([*fault, told, kinds, t.refused or "", t.visible, f"{t.moved:.4f}"])
