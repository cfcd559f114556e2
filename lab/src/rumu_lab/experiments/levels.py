"""Table 1: how often the level is right, script by script, and on copies that people marked.

The true level of a simulated copy is the degree it was made at, a convention; that of a person's copy is the
level of the panel's mark. People's marks have cut-offs of their own, since a score keeps to the middle
where it is unsure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rumu.assessment.calibration import CUT_OFFS
from rumu.errors import CalibrationError
from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments import human_marks
from rumu_lab.experiments.agreement import CONSTANT, constant, held_out, raw_grades
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.grading import OURS, Grades, GradingTask, grade
from rumu_lab.experiments.marked_copies import chosen_copies
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.simulated_copies import AtDegree
from rumu_lab.experiments.statistics import exact_interval, weighted_kappa

DEGREES = ("bad", "medium", "good", "excellent")


@dataclass(frozen=True, slots=True)
class DegreeCopy:
    """A simulated copy, what it was made as, and what was measured of it."""

    script: str
    degree: str
    grades: Grades


def run(settings: RunSettings) -> Findings:
    """Table 1 on simulated copies and, where the data is there, on human marks."""
    made = grade_degrees(settings)
    cuts = settings.protocol.cut_offs
    truth = [DEGREES.index(m.degree) for m in made]
    given = [level_number(m.grades.mark, CUT_OFFS["panel"]) for m in made]
    scripts = [m.script for m in made]
    rows = [
        level_row(
            script,
            [t for t, s in zip(truth, scripts, strict=True) if s == script],
            [g for g, s in zip(given, scripts, strict=True) if s == script],
        )
        for script in settings.protocol.scripts
    ]
    rows.append(level_row("all five", truth, given))
    people, missing = human_rows(settings)
    methods = method_rows(made, cuts)
    facts = {
        "copies": len(made),
        "refused": sum(m.grades.refused is not None for m in made),
        "scripts": rows,
        "human": people,
        "human_missing": missing,
        "methods": methods,
        "confusion": confusion(truth, given),
        "cut_offs": cuts,
    }
    return Findings("levels", facts, _tables(facts), _sentences(facts))


def grade_degrees(settings: RunSettings) -> list[DegreeCopy]:
    """Every work at the four degrees, for each seed."""
    from rumu.gallery.starter import find_work

    works = [find_work(work) for work in settings.protocol.works]
    seeds = settings.protocol.level_seeds
    plan = [(w, degree, seed) for w in works for degree in DEGREES for seed in seeds]
    tasks = [
        GradingTask(f"levels/{w.id}/{degree}/{seed}", w.id, w.path, AtDegree(w.path, degree, seed))
        for w, degree, seed in plan
    ]
    measured = measure_each(grade, tasks, settings)
    return [DegreeCopy(w.script, degree, m) for (w, degree, _), m in zip(plan, measured, strict=True)]


def level_number(mark: float, cuts: Mapping[Any, float]) -> int:
    """0 bad to 3 excellent. A refused copy (NaN) counts as bad: it got no better level."""
    return sum(mark >= low for low in cuts.values())


def level_row(name: str, truth: Sequence[int], given: Sequence[int]) -> dict[str, Cell]:
    """N, levels that are right with the exact interval, weighted kappa, and those off by two or more."""
    right = sum(t == g for t, g in zip(truth, given, strict=True))
    low, high = exact_interval(right, len(truth))
    return {
        "where": name,
        "n": len(truth),
        "right": right,
        "accuracy": 100.0 * right / len(truth),
        "low": 100.0 * low,
        "high": 100.0 * high,
        "kappa": weighted_kappa(truth, given, levels=4),
        "far": sum(abs(t - g) > 1 for t, g in zip(truth, given, strict=True)),
    }


def human_rows(settings: RunSettings) -> tuple[list[dict[str, Cell]], str | None]:
    """Levels of our held-out marks against levels of the panel's marks; or why there are none."""
    try:
        copies = chosen_copies(settings)
    except CalibrationError as error:
        return [], str(error)
    measured = human_marks.grade_copies(copies, settings)
    pairs = [(c, m) for c, m in zip(copies, measured, strict=True) if m.refused is None]
    own = human_marks.own_marks([c for c, _ in pairs], [m for _, m in pairs], settings)
    cuts = settings.protocol.cut_offs
    truth = [level_number(c.mark, cuts) for c, _ in pairs]
    others = [level_number(10.0 * float(np.mean(c.ratings[1:])), cuts) for c, _ in pairs]
    first = [level_number(10.0 * c.ratings[0], cuts) for c, _ in pairs]
    return [
        level_row("regular script, human marks", truth, [level_number(s, CUT_OFFS["panel"]) for s in own]),
        level_row("one rater, human marks", others, first),
        level_row("always the commonest level", truth, [max(set(truth), key=truth.count)] * len(truth)),
    ], None


def method_rows(made: Sequence[DegreeCopy], cuts: Mapping[str, float]) -> list[dict[str, Cell]]:
    """Every method through the shared calibrator, fitted to the middle of each level on the other scripts."""
    kept = [m for m in made if m.grades.refused is None]
    middles = level_middles(cuts)
    marks = np.array([middles[DEGREES.index(m.degree)] for m in kept])
    truth, scripts = [DEGREES.index(m.degree) for m in kept], [m.script for m in kept]
    given: dict[str, FloatArray] = {
        name: held_out(raw, marks, scripts) for name, raw in raw_grades([m.grades for m in kept]).items()
    }
    given[CONSTANT] = constant(marks, scripts).given
    rows = [level_row(name, truth, [level_number(v, cuts) for v in values]) for name, values in given.items()]
    return sorted(rows, key=lambda row: -float(row["accuracy"] or 0.0))


def level_middles(cuts: Mapping[str, float]) -> list[float]:
    """The middle of the marks of each level, bad first."""
    edges = [0.0, *sorted(cuts.values()), 100.0]
    return [(a + b) / 2 for a, b in pairwise(edges)]


def confusion(truth: Sequence[int], given: Sequence[int]) -> list[list[int]]:
    """Copies of each degree (rows, bad first) that got each level (columns)."""
    seen = np.zeros((4, 4), dtype=int)
    np.add.at(seen, (np.asarray(truth), np.asarray(given)), 1)
    return [[int(v) for v in row] for row in seen]


_COLUMNS = (
    Column("where", Bilingual("書體", "where")),
    Column("n", Bilingual("件數", "N")),
    Column("right", Bilingual("正確", "right")),
    Column("accuracy", Bilingual("正確率 %", "accuracy %"), 1),
    Column("low", Bilingual("下限", "low"), 1),
    Column("high", Bilingual("上限", "high"), 1),
    Column("kappa", Bilingual("二次加權 κ", "weighted kappa"), 3),
    Column("far", Bilingual("差兩級以上", "off by two or more")),
)


def _tables(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    exact = Bilingual(
        "區間為 95 % 精確（Clopper-Pearson）區間；κ 為二次加權。",
        "Intervals are exact (Clopper-Pearson), 95 %; kappa is quadratic weighted.",
    )
    made = Bilingual(
        "模擬臨作的「真」級別是製作時聲明的程度，不是評分；配方早先是看着我們的分數拉開的，故以真人評分為重。",
        "The true level of a simulated copy is the degree it was made at, no mark; its recipes were spaced "
        "earlier with a mark of ours in view, so the human levels weigh more.",
    )
    same = Bilingual(
        "所有方法用同一個校準器，在其餘四種書體上擬合到各級的中點。",
        "One calibrator for all, fitted to the middle of each level on the other four scripts.",
    )
    tables = [
        Table(
            "table-1-scripts",
            Bilingual(
                "表一：五體定級正確率（模擬臨作）", "Table 1: level accuracy by script, simulated copies"
            ),
            _COLUMNS,
            tuple(facts["scripts"]),
            (exact, made),
        ),
        Table(
            "table-1-methods",
            Bilingual("同樣的臨作，各方法定級", "The same copies, levels by every method"),
            _COLUMNS,
            tuple(facts["methods"]),
            (same, made),
        ),
    ]
    if facts["human"]:
        tables.insert(
            1,
            Table(
                "table-1-human",
                Bilingual("表一：真人評分的楷書", "Table 1: regular script, human marks"),
                _COLUMNS,
                tuple(facts["human"]),
                (exact,),
            ),
        )
    return tuple(tables)


def _sentences(facts: Mapping[str, Any]) -> tuple[Bilingual, ...]:
    whole, best = facts["scripts"][-1], facts["methods"][0]
    ours = next(row for row in facts["methods"] if row["where"] == OURS)
    span = f"{whole['accuracy']:.0f} % [{whole['low']:.0f}, {whole['high']:.0f}]"
    found = [
        Bilingual(
            f"模擬臨作定級正確率 {span}；同一校準器下我們 {ours['accuracy']:.0f} %，"
            f"最高為 {best['where']} {best['accuracy']:.0f} %。",
            f"Levels of simulated copies are right in {span}; through the shared calibrator ours reaches "
            f"{ours['accuracy']:.0f} %, the best is {best['where']} with {best['accuracy']:.0f} %.",
        )
    ]
    if facts["human"]:
        us, rater, common = (f"{row['accuracy']:.0f} %" for row in facts["human"])
        found.append(
            Bilingual(
                f"真人評分的楷書：我們 {us}，一位評委 {rater}，總猜最常見的一級 {common}。",
                f"On human marks (regular script): ours {us}, one rater {rater}, "
                f"always the commonest level {common}.",
            )
        )
    return tuple(found)
