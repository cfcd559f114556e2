"""What a mark must not be fooled by: impostors of the starter works and of the E3C templates, assessed.

Required: nothing above 40 but what is a right copy all the same, and blank paper is refused. A character that
is its own mirror image (or its own half turn) is right when mirrored; a character in another script may be
written alike. Both are shown apart, with their figures.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rumu.gallery.starter import starter_works
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import read_templates
from rumu_lab.experiments.measuring import master_at, measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.simulation.impostors import IMPOSTORS, impostor

LIMIT = 40.0
OTHER, SCRIPT = "other_character", "same_character_other_script"
SEEDS = {"one_stroke": 3, "outline": 3, "blobs": 3, "scribble": 3}
"""How many are made of a kind that chance has a hand in; one of the others."""
ITSELF = 0.5
"""Likeness of a master to its own mirror image (or half turn) from which that is no impostor."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One impostor of one master: made by `impostor`, or the picture of another work."""

    kind: str
    master: Path
    name: str
    seed: int = 0
    other: Path | None = None


@dataclass(frozen=True, slots=True)
class ImpostorMark:
    """What an impostor got.

    score: None when refused; refused: the code of the reason. right: it is a right copy after all.
    """

    trial: Trial
    score: float | None
    refused: str | None
    right: bool = False


def run(settings: RunSettings, *, chosen: Sequence[Trial] | None = None) -> Findings:
    """Assess every impostor of the starter works and, where the data holds them, of the E3C templates.

    Writes OUT/tables/gaming.csv, one row a trial. chosen: other trials than all of them.
    """
    chosen = list(trials(settings.data)) if chosen is None else chosen
    marks = measure_each(mark_trial, chosen, settings)
    if settings.tables is not None:
        write_table(marks, settings.tables / "gaming.csv")
    facts = figures(marks)
    return Findings("gaming", facts, words=text(facts, masters=len({m.trial.name for m in marks})))


def figures(marks: Sequence[ImpostorMark]) -> dict[str, Any]:
    """All figures, plain; right copies apart, and other scripts not among those above the limit."""

    def by_kind(*, right: bool) -> dict[str, Any]:
        of_kind = {
            kind: [m for m in marks if m.trial.kind == kind and m.right == right]
            for kind in dict.fromkeys(m.trial.kind for m in marks)
        }
        return {kind: _count(some) for kind, some in of_kind.items() if some or not right}

    above = [
        m for m in marks if not m.right and m.trial.kind != SCRIPT and m.score is not None and m.score > LIMIT
    ]
    return {
        "limit": LIMIT,
        "trials": len(marks),
        "above": [{"kind": m.trial.kind, "master": m.trial.name, "score": m.score} for m in above],
        "blank_refused": all(m.refused for m in marks if m.trial.kind == "blank"),
        "kinds": by_kind(right=False),
        "right_after_all": by_kind(right=True),
    }


def text(facts: Mapping[str, Any], *, masters: int) -> str:
    """The figures as a person reads them; masters: how many there were."""
    heads = ("", "tried", "refused", "highest", "above 40", "why refused")
    rows = [heads, *(_row(kind, count) for kind, count in facts["kinds"].items())]
    rows += [_row(f"{kind} (its own)", count) for kind, count in facts["right_after_all"].items()]
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
    table = ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in rows]
    worst = ", ".join(f"{a['kind']} of {a['master']} {a['score']:.0f}" for a in facts["above"]) or "none"
    return "\n".join(
        [
            f"{facts['trials']} impostors of {masters} masters.",
            *table,
            f"Above {LIMIT:.0f}, other scripts aside: {worst}.",
            "its own: characters much like their own mirror image or half turn; mirrored they are right.",
        ]
    )


def trials(data: Path) -> Iterator[Trial]:
    """All trials: every kind of impostor of every master, and every other work in its place."""
    works = starter_works()
    templates = read_templates(data)
    masters = [(w.path, w.id) for w in works] + [(t, f"template {t.stem}") for t in templates]
    for path, name in masters:
        for kind in IMPOSTORS:
            for seed in range(SEEDS.get(kind, 1)):
                yield Trial(kind, path, name, seed)
    for work in works:
        for other in works:
            if other.script == work.script and other.character != work.character:
                yield Trial(OTHER, work.path, work.id, other=other.path)
            elif other.script != work.script and other.character == work.character:
                yield Trial(SCRIPT, work.path, work.id, other=other.path)
    for k, template in enumerate(templates):
        for step in (1, 3, 5, 7):
            yield Trial(
                OTHER, template, f"template {template.stem}", other=templates[(k + step) % len(templates)]
            )


def mark_trial(trial: Trial) -> ImpostorMark:
    """The mark of one impostor."""
    from rumu import pipeline

    master = master_at(trial.master)
    copy = trial.other if trial.other else impostor(master.surface.mask, trial.kind, seed=trial.seed)
    mark = pipeline.assess(copy, master, remarks=False)
    code = mark.refused.split(":")[0] if mark.refused else None
    return ImpostorMark(trial, mark.score, code, right=_is_its_own(trial))


def write_table(marks: Sequence[ImpostorMark], path: Path) -> None:
    """One row a trial: kind, master, seed, other, score, why refused, whether it is right after all."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["kind", "master", "seed", "other", "score", "refused", "right"])
        for m in marks:
            other = m.trial.other.stem if m.trial.other else ""
            score = "" if m.score is None else f"{m.score:.2f}"
            writer.writerow(
                [m.trial.kind, m.trial.name, m.trial.seed, other, score, m.refused or "", m.right]
            )


def _is_its_own(trial: Trial) -> bool:
    from rumu.registration.descriptor import describe, likeness, mirror, turn

    points = master_at(trial.master).points
    if trial.kind == "mirrored":
        changed = mirror(points)
    elif trial.kind == "upside_down":
        changed = turn(points, degrees=180)
    else:
        return False
    return float(likeness(describe(changed), describe(points))) >= ITSELF


def _count(marks: list[ImpostorMark]) -> dict[str, Any]:
    scores = [m.score for m in marks if m.score is not None]
    return {
        "tried": len(marks),
        "refused": len(marks) - len(scores),
        "highest": max(scores, default=None),
        "above": sum(score > LIMIT for score in scores),
        "why": dict(Counter(m.refused for m in marks if m.refused).most_common()),
    }


def _row(kind: str, count: Mapping[str, Any]) -> tuple[str, ...]:
    highest = "-" if count["highest"] is None else f"{count['highest']:.0f}"
    why = ", ".join(f"{code} {number}" for code, number in count["why"].items())
    counts = (str(count["tried"]), str(count["refused"]), highest, str(count["above"]))
    return (kind.replace("_", " "), *counts, why)
