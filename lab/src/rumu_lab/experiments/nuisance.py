"""Nuisances of the photograph, which must not move a mark: blur, noise, JPEG, tint, grid, light, resolution.

The drift of a method is the standard deviation of its raw grade over all pictures of one copy, against the
fall of that grade for one step of severity, so that methods on different scales can be compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rumu.values import Bilingual
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.grading import OURS, Grades, GradingTask, grade
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.severities import starter_subjects, step_of, steps_of, whole_series
from rumu_lab.experiments.simulated_copies import AtDegree, Disturbed

PLAIN = "as it is"


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture of one copy. copy: which; nuisance: PLAIN or its name."""

    copy: str
    nuisance: str
    grades: Grades


def run(settings: RunSettings) -> Findings:
    """How far each method drifts, and which nuisances move our mark."""
    steps = steps_of(starter_subjects(settings.protocol), settings)
    series = whole_series(steps)
    shots = grade_shots(settings)
    by_nuisance = nuisance_rows(shots)
    wanted = float(settings.protocol.plain["nuisances"]["wanted"])
    methods = method_rows(shots, {m: -step_of(series, m) for m in series[0][0].grades.raw}, wanted=wanted)
    step = -100.0 * step_of(series, OURS)
    facts: dict[str, Any] = {
        "copies": len({s.copy for s in shots}),
        "pictures": len(shots),
        "refused": sorted(f"{s.copy}: {s.nuisance}" for s in shots if s.grades.refused is not None),
        "step_of_severity": step,
        "wanted": wanted,
        "methods": methods,
        "nuisances": by_nuisance,
        "ours": next(row for row in methods if row["method"] == OURS),
        "losers": [row["nuisance"] for row in by_nuisance if float(row["rms"] or 0.0) > wanted * step],
    }
    return Findings("nuisance", facts, _tables(facts), (_sentence(facts),))


def grade_shots(settings: RunSettings) -> list[Shot]:
    """Every copy as it is and under every nuisance."""
    from rumu.gallery.starter import find_work

    plain = settings.protocol.plain["nuisances"]
    quick = settings.protocol.plain["quick"]
    names = quick["nuisance_works"] if settings.quick else plain["works"]
    kinds = plain["kinds"][: quick["nuisance_kinds"]] if settings.quick else plain["kinds"]
    plan: list[tuple[str, str, GradingTask]] = []
    for work in map(find_work, names):
        for degree in plain["degrees"]:
            copy, name = AtDegree(work.path, degree, plain["seed"]), f"{work.id} {degree}"
            plan.append((name, PLAIN, GradingTask(f"nuisance/{name}", work.id, work.path, copy)))
            for kind in kinds:
                amount = kind["amount"]
                amount = tuple(amount) if isinstance(amount, list) else amount
                made = Disturbed(copy, kind["kind"], amount, plain["seed"])
                key = f"nuisance/{name}/{kind['name']}"
                plan.append((name, kind["name"], GradingTask(key, work.id, work.path, made)))
    measured = measure_each(grade, [t for *_, t in plan], settings)
    return [Shot(copy, nuisance, m) for (copy, nuisance, _), m in zip(plan, measured, strict=True)]


def method_rows(shots: Sequence[Shot], steps: Mapping[str, float], *, wanted: float) -> list[dict[str, Cell]]:
    """One row a method: drift in its own unit, its step of severity, and their ratio, least first.

    A method whose grade does not fall with severity has no step to be measured by: ratio None.
    """
    rows: list[dict[str, Cell]] = []
    for method, step in steps.items():
        spreads = [
            float(np.std([s.grades.raw[method] for s in shots if s.copy == copy and s.grades.raw]))
            for copy in dict.fromkeys(s.copy for s in shots)
        ]
        drift = float(np.mean(spreads))
        ratio = drift / step if step > 0 else None
        kept = "–" if ratio is None else "yes" if ratio < wanted else "NO"
        rows.append({"method": method, "drift": drift, "step": step, "ratio": ratio, "kept": kept})
    return sorted(rows, key=lambda row: float("inf") if row["ratio"] is None else float(row["ratio"]))


def nuisance_rows(shots: Sequence[Shot]) -> list[dict[str, Cell]]:
    """One row a nuisance: by how many points it moves our mark from that of the same copy as it is."""
    still = {s.copy: s.grades.mark for s in shots if s.nuisance == PLAIN}
    rows: list[dict[str, Cell]] = []
    for nuisance in dict.fromkeys(s.nuisance for s in shots if s.nuisance != PLAIN):
        own = [s for s in shots if s.nuisance == nuisance]
        moved = np.array([s.grades.mark - still[s.copy] for s in own])
        moved = moved[np.isfinite(moved)]
        rows.append(
            {
                "nuisance": nuisance,
                "n": len(own),
                "refused": sum(s.grades.refused is not None for s in own),
                "mean": float(moved.mean()) if len(moved) else None,
                "rms": float(np.sqrt(np.mean(moved**2))) if len(moved) else None,
                "most": float(np.abs(moved).max()) if len(moved) else None,
            }
        )
    return sorted(rows, key=lambda row: -float(row["rms"] or 0.0))


def _tables(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    about = Bilingual(
        f"{facts['copies']} 件模擬臨作，共 {facts['pictures']} 張；字跡不變，只換照片。"
        f"每級毛病使我們的分數下降 {facts['step_of_severity']:.2f} 分。",
        f"{facts['copies']} simulated copies, {facts['pictures']} pictures; the writing is the same. "
        f"One step of severity takes {facts['step_of_severity']:.2f} points of our mark.",
    )
    methods = (
        Column("method", Bilingual("方法", "method")),
        Column("drift", Bilingual("漂移（標準差）", "drift (SD), raw"), 4),
        Column("step", Bilingual("每級下降", "fall a step, raw"), 4),
        Column("ratio", Bilingual("比值", "ratio"), 2),
        Column("kept", Bilingual("低於三分之一", "below a third")),
    )
    nuisances = (
        Column("nuisance", Bilingual("干擾", "nuisance")),
        Column("n", Bilingual("件數", "N")),
        Column("refused", Bilingual("拒評", "refused")),
        Column("mean", Bilingual("平均變動", "mean, points")),
        Column("rms", Bilingual("均方根", "rms, points")),
        Column("most", Bilingual("最大", "most, points")),
    )
    title = Bilingual("照片的干擾：漂移與一級毛病之比", "Nuisance drift against one step of severity")
    each = Bilingual("哪些干擾動了我們的分數", "Which nuisances move our mark")
    return (
        Table("nuisance-methods", title, methods, tuple(facts["methods"]), (about,)),
        Table("nuisance-kinds", each, nuisances, tuple(facts["nuisances"]), (about,)),
    )


def _sentence(facts: Mapping[str, Any]) -> Bilingual:
    ratio, losers = facts["ours"]["ratio"], ", ".join(facts["losers"])
    if ratio is None:
        return Bilingual(
            "我們的分數不隨程度下降，無從比較。", "Our mark does not fall with severity: no comparison."
        )
    fine = ratio < facts["wanted"]
    return Bilingual(
        f"我們的漂移是一級毛病的 {ratio:.2f} 倍，{'低於' if fine else '未低於'}三分之一；"
        f"單項超過三分之一的干擾：{losers or '無'}。",
        f"Our drift is {ratio:.2f} of one step of severity, "
        f"{'below' if fine else 'NOT below'} the third that was wanted; "
        f"nuisances that by themselves exceed it: {losers or 'none'}.",
    )
