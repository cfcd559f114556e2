"""Our mark on copies that people marked, as `e3c` finds it: measured once, asked by several experiments."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rumu_lab.experiments.findings import Findings, RunSettings
from rumu_lab.experiments.measuring import BEHIND, code_hash


@dataclass(frozen=True, slots=True)
class Marked:
    """What `e3c` found, plain, one entry a copy that was not refused.

    images: names of the pictures. scores: our marks, 0-100, with the copy's character held out. panel: the
    panel's marks. evidence: what the mark weighs, in the order of `assessment.features.EVIDENCE`.
    facts, words: the figures, and as a person reads them.
    """

    images: tuple[str, ...]
    characters: tuple[str, ...]
    panel: tuple[float, ...]
    scores: tuple[float, ...]
    evidence: tuple[tuple[float, ...], ...]
    facts: Mapping[str, Any]
    words: str


def run(settings: RunSettings) -> Findings:
    """Agreement of the mark with the panel, whole characters held out."""
    marked = marked_copies(settings)
    return Findings("e3c", marked.facts, words=marked.words)


def marked_copies(settings: RunSettings) -> Marked:
    """All marked copies; kept like what is measured. Raises CalibrationError when the data is not there."""
    file = None
    if settings.store is not None:
        code = code_hash((*BEHIND["measure_ours"], "rumu_lab/experiments/e3c.py"))
        file = settings.store / f"marked-{code[:16]}.json"
        if file.is_file():
            return _marked(json.loads(file.read_text("utf-8")))
    marked = _measured(settings)
    if file is not None:
        _write(marked, file)
    return marked


def _measured(settings: RunSettings) -> Marked:
    from rumu_lab.experiments import e3c

    tables = None if settings.out is None else settings.out / "tables"
    result = e3c.run(settings.data, out=tables, progress=settings.progress)
    kept = [(m.copy, m.features) for m in result.measured if m.features is not None]
    return Marked(
        images=tuple(copy.image.name for copy, _ in kept),
        characters=tuple(copy.character for copy, _ in kept),
        panel=tuple(copy.mark for copy, _ in kept),
        scores=tuple(map(float, result.scores)),
        evidence=tuple(tuple(map(float, features.evidence())) for _, features in kept),
        facts=result.summary(),
        words=result.text(),
    )


def _marked(plain: Mapping[str, Any]) -> Marked:
    whole = {**plain, "evidence": tuple(map(tuple, plain["evidence"]))}
    for name in ("images", "characters", "panel", "scores"):
        whole[name] = tuple(plain[name])
    return Marked(**whole)


def _write(marked: Marked, file: Path) -> None:
    from rumu.outputs import whole_file

    with whole_file(file) as part:
        part.write_text(json.dumps(asdict(marked), ensure_ascii=False), "utf-8")
