"""The darkness of ink as its height, against inflation, on simulated faults of the ink.

The copies that people marked are binarised, so that their ink has one darkness and no relief to compare.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from rumu.values import Bilingual
from rumu_lab.experiments.findings import Cell, Column, RunSettings, Table
from rumu_lab.experiments.measuring import GradingTask, Measured, drawn, measure_by, residual_grade
from rumu_lab.experiments.severities import Subject, key_of, starter_subjects, task_of
from rumu_lab.experiments.statistics import spearman

FAULTS = ("pale", "dry", "blot")
METHODS: tuple[Literal["inflation", "density"], ...] = ("inflation", "density")


def measure_density(task: GradingTask, *, pictures: Path | None = None) -> Measured:
    """One copy by the 5-D residual, once with each kind of height; 0 where there is no relief to compare."""
    from rumu.errors import RefusedImage, RumuError
    from rumu.registration.icp import register_points
    from rumu.registration.points import sample_points
    from rumu.surface.relief import relief

    grades: dict[str, float] = {}
    for method in METHODS:
        try:
            surfaces = [relief(p, method=method) for p in (drawn(task.copy, pictures), task.master)]
            grades[method] = residual_grade(register_points(*map(sample_points, surfaces)))
        except RefusedImage as refusal:
            return Measured(task.key, task.cluster, refused=str(refusal))
        except RumuError:
            grades[method] = 0.0
    return Measured(task.key, task.cluster, grades)


def density_table(settings: RunSettings) -> Table:
    """Mean Spearman with falling severity, fault by fault, for both kinds of height."""
    subjects = [
        replace(s, faults=tuple(f for f in s.faults if f in FAULTS))
        for s in starter_subjects(settings.protocol)
    ]
    return _table(density_rows([s for s in subjects if s.faults], settings))


def density_rows(subjects: list[Subject], settings: RunSettings) -> list[dict[str, Cell]]:
    """One row a fault: series, how many could be measured, and each kind's mean Spearman, best 1."""
    protocol = settings.protocol
    severities = (0, *protocol.severities)
    plan = [(s, fault, k) for s in subjects for fault in s.faults for k in severities]
    tasks = {key_of(*step): task_of(*step, seed=protocol.simulation_seed) for step in plan}
    found = measure_by(
        measure_density, list(tasks.values()), store=settings.store, progress=settings.progress
    )
    by_key = {m.key: m for m in found}
    rows: list[dict[str, Cell]] = []
    for fault in dict.fromkeys(f for s in subjects for f in s.faults):
        series = [[by_key[key_of(s, fault, k)] for k in severities] for s in subjects if fault in s.faults]
        whole = [one for one in series if all(m.refused is None for m in one)]
        rows.append({"fault": fault, "n": len(series), "whole": len(whole), **_ranks(whole, severities)})
    return rows


def _ranks(series: list[list[Measured]], severities: tuple[int, ...]) -> dict[str, Cell]:
    if not series:
        return {}
    good = -np.array(severities, float)
    return {
        method: float(np.mean([spearman(np.array([m.raw[method] for m in one]), good) for one in series]))
        for method in METHODS
    }


def _table(rows: list[dict[str, Cell]]) -> Table:
    columns = (
        Column("fault", Bilingual("毛病", "fault")),
        Column("n", Bilingual("系列", "series")),
        Column("whole", Bilingual("可量的", "measured")),
        Column("inflation", Bilingual("充氣為高度", "height by inflation")),
        Column("density", Bilingual("墨色為高度", "height by density")),
    )
    note = Bilingual(
        "真人評分的臨作已二值化，墨色只有一種，故此項只能在模擬的墨病上比。數為與程度的等級相關，一為最好。",
        "Copies with human marks are binarised, so this is compared on simulated faults of the ink. Spearman "
        "with falling severity, 1 is best.",
    )
    title = Bilingual("以墨色濃淡為高度", "Ink density as height")
    return Table("ablation-density", title, columns, tuple(rows), (note,))
