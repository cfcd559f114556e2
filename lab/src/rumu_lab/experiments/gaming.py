"""What a mark must not be fooled by: impostors of the starter works and of the E3C templates, assessed.

Required: nothing above 40 but what is a right copy all the same, and blank paper is refused. A character that
is its own mirror image (or its own half turn) is right when mirrored; a character in another script may be
written alike. Both are shown apart, with their figures.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.measurement import PreparedMaster
from rumu.executors import in_order
from rumu.gallery.starter import starter_works
from rumu_lab.simulation.impostors import IMPOSTORS, impostor

Progress = Callable[[int, int], None]

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
class Verdict:
    """score: None when refused, with the code of the reason. right: it is a right copy after all."""

    trial: Trial
    score: float | None
    refused: str | None
    right: bool = False


@dataclass(frozen=True, slots=True)
class Result:
    """Every verdict, in the order of the trials."""

    verdicts: tuple[Verdict, ...]

    def of(self, kind: str, *, right: bool = False) -> list[Verdict]:
        """The verdicts on one kind; those that are right copies after all apart."""
        return [v for v in self.verdicts if v.trial.kind == kind and v.right == right]

    @property
    def above(self) -> list[Verdict]:
        """The impostors that scored above the limit; other scripts are not among them."""
        return [v for v in self.verdicts if not v.right and v.trial.kind != SCRIPT and _points(v) > LIMIT]

    def summary(self) -> dict[str, Any]:
        """All figures, plain."""
        return {
            "limit": LIMIT,
            "trials": len(self.verdicts),
            "above": [{"kind": v.trial.kind, "master": v.trial.name, "score": v.score} for v in self.above],
            "blank_refused": all(v.refused for v in self.of("blank")),
            "kinds": {kind: _figures(self.of(kind)) for kind in _kinds(self.verdicts)},
            "right_after_all": {
                kind: _figures(self.of(kind, right=True))
                for kind in _kinds(self.verdicts)
                if self.of(kind, right=True)
            },
        }

    def text(self) -> str:
        """The figures as a person reads them."""
        facts = self.summary()
        heads = ("", "tried", "refused", "highest", "above 40", "why refused")
        rows = [heads, *(_row(kind, figures) for kind, figures in facts["kinds"].items())]
        rows += [_row(f"{kind} (its own)", f) for kind, f in facts["right_after_all"].items()]
        widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
        table = ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in rows]
        worst = ", ".join(f"{a['kind']} of {a['master']} {a['score']:.0f}" for a in facts["above"]) or "none"
        return "\n".join(
            [
                f"{facts['trials']} impostors of {len({v.trial.name for v in self.verdicts})} masters.",
                *table,
                f"Above {LIMIT:.0f}, other scripts aside: {worst}.",
                "its own: characters much like their own mirror image or half turn; mirrored they are right.",
            ]
        )


def run(
    data: str | Path,
    *,
    out: str | Path | None = None,
    progress: Progress | None = None,
    most: int | None = None,
) -> Result:
    """Assess every impostor of the starter works and, where `data` holds them, of the E3C templates.

    most: only so many trials, spread evenly, for a quick look. out: a folder for gaming.csv.
    """
    every = list(trials(Path(data)))
    chosen = every if most is None else every[:: max(len(every) // most, 1)]
    verdicts: list[Verdict] = []
    for verdict in in_order(judge, chosen):
        verdicts.append(verdict)
        if progress:
            progress(len(verdicts), len(chosen))
    result = Result(tuple(verdicts))
    if out is not None:
        write_table(result, Path(out) / "gaming.csv")
    return result


def trials(data: Path) -> Iterator[Trial]:
    """All trials: every kind of impostor of every master, and every other work in its place."""
    works = starter_works()
    templates = sorted((data / "e3c" / "templates").glob("*.png"))
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


def judge(trial: Trial) -> Verdict:
    """The mark of one impostor."""
    from rumu import pipeline

    master = _master(trial.master)
    copy = trial.other if trial.other else impostor(master.surface.mask, trial.kind, seed=trial.seed)
    mark = pipeline.assess(copy, master, remarks=False)
    code = mark.refused.split(":")[0] if mark.refused else None
    return Verdict(trial, mark.score, code, right=_is_its_own(trial))


def write_table(result: Result, path: Path) -> None:
    """One row a trial: kind, master, seed, other, score, why refused, whether it is right after all."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["kind", "master", "seed", "other", "score", "refused", "right"])
        for v in result.verdicts:
            other = v.trial.other.stem if v.trial.other else ""
            score = "" if v.score is None else f"{v.score:.2f}"
            writer.writerow(
                [v.trial.kind, v.trial.name, v.trial.seed, other, score, v.refused or "", v.right]
            )


def _is_its_own(trial: Trial) -> bool:
    from rumu.registration.descriptor import describe, likeness, mirrored, turned

    change = {"mirrored": mirrored, "upside_down": turned}.get(trial.kind)
    if change is None:
        return False
    points = _master(trial.master).points
    return float(likeness(describe(change(points)), describe(points))) >= ITSELF


def _points(verdict: Verdict) -> float:
    return -np.inf if verdict.score is None else verdict.score


def _kinds(verdicts: Sequence[Verdict]) -> list[str]:
    return list(dict.fromkeys(v.trial.kind for v in verdicts))


def _figures(verdicts: list[Verdict]) -> dict[str, Any]:
    scores = [v.score for v in verdicts if v.score is not None]
    return {
        "tried": len(verdicts),
        "refused": len(verdicts) - len(scores),
        "highest": max(scores, default=None),
        "above": sum(score > LIMIT for score in scores),
        "why": dict(Counter(v.refused for v in verdicts if v.refused).most_common()),
    }


def _row(kind: str, figures: dict[str, Any]) -> tuple[str, ...]:
    highest = "-" if figures["highest"] is None else f"{figures['highest']:.0f}"
    why = ", ".join(f"{code} {count}" for code, count in figures["why"].items())
    counts = (str(figures["tried"]), str(figures["refused"]), highest, str(figures["above"]))
    return (kind.replace("_", " "), *counts, why)


@lru_cache(maxsize=64)
def _master(path: Path) -> PreparedMaster:
    from rumu.pipeline import prepare_master

    return prepare_master(path)
