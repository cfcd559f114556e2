"""All methods on simulated faults that grow: Table 2 on declared severities, and whether marks fall.

Agreement with a declared scale on simulated faults, not with people.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import CalibrationError
from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments.agreement import (
    COLUMNS,
    FEW_CLUSTERS,
    GradedMethod,
    constant,
    held_out,
    raw_grades,
    side_by_side,
    verdict,
    verdict_sentence,
)
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.grading import OURS, OWN, Grades, GradingTask, grade
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.protocol import ExperimentProtocol, share_faults
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.simulated_copies import Faulty, Written
from rumu_lab.experiments.statistics import kendall, order_accuracy, rising_steps, spearman

SHIPPED = "rumu, as shipped"
SHARED = "rumu, the shared calibrator"


@dataclass(frozen=True, slots=True)
class Subject:
    """A master that faults are put into. fold: held out together; a script, or a character."""

    name: str
    fold: str
    master: Path
    faults: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Step:
    """One member of a series: which subject, fault and severity; severity 0 is shared by its series."""

    subject: Subject
    fault: str
    severity: int
    grades: Grades


def run(settings: RunSettings) -> Findings:
    """The series of the starter works."""
    return findings_on(
        starter_subjects(settings.protocol), settings, name="severities", where="the starter works"
    )


def starter_subjects(protocol: ExperimentProtocol) -> list[Subject]:
    """The starter works with the faults that each was given; quick keeps the numbers of the whole list."""
    from rumu.gallery.starter import find_work

    works = [find_work(work) for work in protocol.works]
    everyone = list(protocol.plain["works"])
    return [
        Subject(w.id, w.script, w.path, share_faults(everyone.index(w.id), protocol=protocol)) for w in works
    ]


def steps_of(subjects: Sequence[Subject], settings: RunSettings) -> list[Step]:
    """Every series of every subject, severity 0 to 5, measured."""
    protocol = settings.protocol
    plan = [
        (s, fault, severity) for s in subjects for fault in s.faults for severity in (0, *protocol.severities)
    ]
    tasks = {key_of(*step): task_of(*step, seed=protocol.simulation_seed) for step in plan}
    by_key = {g.key: g for g in measure_each(grade, list(tasks.values()), settings)}
    return [Step(*step, by_key[key_of(*step)]) for step in plan]


def findings_on(subjects: Sequence[Subject], settings: RunSettings, *, name: str, where: str) -> Findings:
    """All that the series of some subjects show."""
    steps = steps_of(subjects, settings)
    series = whole_series(steps)
    protocol = settings.protocol
    declared, *others = protocol.expected_scores.items()
    rows = _rows(steps, declared[1], protocol)
    besides = (SHIPPED, *OWN[1:])
    ranks = rank_rows(series)
    facts: dict[str, Any] = {
        "where": where,
        "subjects": len(subjects),
        "series": len(series),
        "copies": len({s.grades.key for s in steps}),
        "refused": sorted({s.grades.key for s in steps if s.grades.refused is not None}),
        "methods": rows,
        "verdict": verdict(rows, ours=SHARED, besides=besides),
        "ranks": ranks,
        "by_fault": fault_rows(series),
        "steps": {method: step_of(series, method) for method in series[0][0].grades.raw},
        "marks_by_severity": _marks_by_severity(steps, protocol),
        "worst_fold": _worst_fold(steps, declared[1]),
    }
    facts["sensitivity"] = _sensitivity(steps, rows, dict(others), protocol, besides)
    return Findings(name, facts, _tables(name, facts), _sentences(facts))


def whole_series(steps: Sequence[Step]) -> list[list[Step]]:
    """The series of which no member was refused. Raises CalibrationError when there is none."""
    groups: dict[tuple[str, str], list[Step]] = {}
    for step in steps:
        groups.setdefault((step.subject.name, step.fault), []).append(step)
    whole = [g for g in groups.values() if all(s.grades.refused is None for s in g)]
    if not whole:
        raise CalibrationError("expected simulated copies that can be marked, every series had refused ones")
    return whole


def rank_rows(series: Sequence[Sequence[Step]]) -> list[dict[str, Cell]]:
    """One row a method: means over the series; Spearman and Kendall with falling severity, best 1."""
    rows: list[dict[str, Cell]] = []
    for method in series[0][0].grades.raw:
        raws = [np.array([s.grades.raw[method] for s in one]) for one in series]
        good = [-np.array([s.severity for s in one], float) for one in series]
        figures = [
            (spearman(r, g), kendall(r, g), order_accuracy(r, g), rising_steps(r))
            for r, g in zip(raws, good, strict=True)
        ]
        means = np.mean(figures, axis=0)
        names = ("spearman", "kendall", "order", "violations")
        rows.append({"method": method, "n": len(series), **dict(zip(names, map(float, means), strict=True))})
    return sorted(rows, key=lambda row: -float(row["spearman"] or 0.0))


def fault_rows(series: Sequence[Sequence[Step]]) -> list[dict[str, Cell]]:
    """One row a fault family: series, and each method's mean Spearman with falling severity."""
    rows: list[dict[str, Cell]] = []
    for fault in dict.fromkeys(one[0].fault for one in series):
        own = [one for one in series if one[0].fault == fault]
        ranks = {str(r["method"]): r["spearman"] for r in rank_rows(own)}
        rows.append({"fault": fault, "n": len(own), "ours_fall": -step_of(own, OURS) * 100.0, **ranks})
    return rows


def step_of(series: Sequence[Sequence[Step]], method: str) -> float:
    """Mean slope of a raw grade for one step of severity, by least squares over severities 1 and above."""
    slopes = [
        np.polyfit(
            [s.severity for s in one if s.severity], [s.grades.raw[method] for s in one if s.severity], 1
        )[0]
        for one in series
    ]
    return float(np.mean(slopes))


def key_of(subject: Subject, fault: str, severity: int) -> str:
    """The name of one member of a series."""
    if severity == 0:
        return f"severities/{subject.name}/0"
    return f"severities/{subject.name}/{fault}/{severity}"


def task_of(subject: Subject, fault: str, severity: int, *, seed: int) -> GradingTask:
    """What is measured of it."""
    recipe = Faulty(subject.master, fault, severity, seed) if severity else Written(subject.master)
    return GradingTask(key_of(subject, fault, severity), subject.name, subject.master, recipe)


def _each_once(steps: Sequence[Step]) -> list[Step]:
    """Each copy once, without the refused ones; severity 0 belongs to all series of its subject."""
    once = {s.grades.key: s for s in steps if s.grades.refused is None}
    return list(once.values())


def _rows(
    steps: Sequence[Step], expected: Sequence[float], protocol: ExperimentProtocol
) -> list[dict[str, Cell]]:
    once = _each_once(steps)
    marks = np.array([expected[s.severity] for s in once])
    folds, clusters = [s.subject.fold for s in once], [s.subject.name for s in once]
    return side_by_side(_grade_methods(once, marks, folds), marks, clusters, ours=SHARED, protocol=protocol)


def _grade_methods(once: Sequence[Step], marks: FloatArray, folds: list[str]) -> list[GradedMethod]:
    raw = raw_grades([s.grades for s in once])
    shipped = np.array([s.grades.mark for s in once])
    graded = [GradedMethod(SHARED if n == OURS else n, r, held_out(r, marks, folds)) for n, r in raw.items()]
    return [GradedMethod(SHIPPED, shipped, shipped), *graded, constant(marks, folds)]


def _worst_fold(steps: Sequence[Step], expected: Sequence[float]) -> dict[str, Any]:
    """Our mean absolute error, through the shared calibrator, on the fold where it is largest."""
    once = _each_once(steps)
    marks = np.array([expected[s.severity] for s in once])
    folds = np.array([s.subject.fold for s in once])
    raw = raw_grades([s.grades for s in once])[OURS]
    error = np.abs(held_out(raw, marks, folds) - marks)
    by_fold = {str(f): float(error[folds == f].mean()) for f in np.unique(folds)}
    worst = max(by_fold, key=lambda fold: by_fold[fold])
    return {"fold": worst, "mae": by_fold[worst], "all": by_fold}


def _marks_by_severity(steps: Sequence[Step], protocol: ExperimentProtocol) -> list[float]:
    once = _each_once(steps)
    levels = (0, *protocol.severities)
    return [float(np.mean([s.grades.mark for s in once if s.severity == k])) for k in levels]


def _sensitivity(
    steps: Sequence[Step],
    rows: Sequence[Mapping[str, Cell]],
    tables: Mapping[str, Sequence[float]],
    protocol: ExperimentProtocol,
    besides: Sequence[str],
) -> dict[str, Any]:
    """The order of the methods by error under other tables of expected scores, and whether it changes."""

    def order(found: Sequence[Mapping[str, Cell]]) -> list[str]:
        return [str(r["method"]) for r in found if r["method"] not in besides]

    orders = {"declared": order(rows)}
    for name, expected in tables.items():
        orders[name] = order(_rows(steps, expected, protocol))
    first = {found[0] for found in orders.values()}
    return {
        "orders": orders,
        "order_changes": len({tuple(found) for found in orders.values()}) > 1,
        "first_changes": len(first) > 1,
        "places_of_ours": {name: found.index(SHARED) + 1 for name, found in orders.items()},
    }


def _tables(name: str, facts: Mapping[str, Any]) -> tuple[Table, ...]:
    about = (
        Bilingual(
            f"與所聲明的程度表一致與否，不是與人一致與否。{facts['series']} 個系列、{facts['copies']} 件；"
            "每次留出一種書體（或一個字）。",
            "Agreement with a declared severity scale on simulated faults, not with people. "
            f"{facts['series']} series, {facts['copies']} copies of {facts['where']}; "
            "one script (or character) held out at a time.",
        ),
    )
    ranks = tuple(
        Column(key, Bilingual(zh, en), 3)
        for key, zh, en in (
            ("method", "方法", "method"),
            ("n", "系列", "series"),
            ("spearman", "等級相關", "Spearman"),
            ("kendall", "肯德爾 τ", "Kendall's tau"),
            ("order", "成對次序正確率", "pairs in order"),
            ("violations", "不降反升", "steps that rise"),
        )
    )
    methods = [str(row["method"]) for row in facts["ranks"]]
    faults = (
        Column("fault", Bilingual("毛病", "fault")),
        Column("n", Bilingual("系列", "series")),
        Column("ours_fall", Bilingual("我們每級扣分", "our fall a step"), 1),
        *(Column(method, Bilingual(method, method)) for method in methods),
    )
    return (
        Table(
            f"table-2-{name}",
            Bilingual("表二（模擬毛病）：與聲明程度的差距", "Table 2 on simulated severities"),
            COLUMNS,
            tuple(facts["methods"]),
            (*about, FEW_CLUSTERS),
        ),
        Table(
            f"ranks-{name}",
            Bilingual("毛病越重，分數是否越低", "Whether marks fall as a fault grows"),
            ranks,
            tuple(facts["ranks"]),
            about,
        ),
        Table(
            f"faults-{name}",
            Bilingual("逐項毛病的等級相關", "Spearman with falling severity, fault by fault"),
            faults,
            tuple(facts["by_fault"]),
            about,
        ),
    )


def _sentences(facts: Mapping[str, Any]) -> tuple[Bilingual, ...]:
    sensitivity, worst = facts["sensitivity"], facts["worst_fold"]
    places = sensitivity["places_of_ours"]
    en = ", ".join(f"{place} ({name})" for name, place in places.items())
    stable_zh = "換一張程度表，名次會變：不成結論" if sensitivity["order_changes"] else "換程度表，名次不變"
    stable_en = (
        "the order of the methods changes with the table of expected scores, so it is no result"
        if sensitivity["order_changes"]
        else "the order of the methods is the same under all three tables"
    )
    return (
        verdict_sentence(facts["verdict"], zh="在模擬毛病上", en="On simulated severities"),
        Bilingual(
            f"{stable_zh}；我們的名次：{en}。最差一組：{worst['fold']}，{worst['mae']:.2f}。",
            f"Sensitivity: {stable_en}; place of ours: {en}. "
            f"Worst fold: {worst['fold']}, mean absolute error {worst['mae']:.2f}.",
        ),
    )
