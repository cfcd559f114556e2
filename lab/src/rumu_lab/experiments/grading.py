"""Raw grades of copies against their masters: our mark, what comes with it, and every other method.

All methods see the same two surfaces.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rumu_lab.experiments.measuring import master_at
from rumu_lab.experiments.simulated_copies import Recipe

if TYPE_CHECKING:
    from rumu.values import Registration
    from rumu_lab.baselines.cell import Cell

OURS = "rumu"
RESIDUAL = "5-D residual"
SIMILARITY = "two-sided similarity"
SIM_PAPER = "the paper's SIM"
OWN = (OURS, RESIDUAL, SIMILARITY, SIM_PAPER)
"""Raw grades that come with our own registration: the mark over 100, what is left before any calibration (one
less the mean of the upper quartiles both ways, in rms radii), and the two similarities."""


@dataclass(frozen=True, slots=True)
class GradingTask:
    """One copy to be graded. key: unique in its experiment. cluster: its character or work."""

    key: str
    cluster: str
    master: Path
    copy: Recipe


@dataclass(frozen=True, slots=True)
class Grades:
    """What the methods say of one copy.

    raw: method -> grade, better is more; in [0, 1] but for the paper's SIM (per cent) and our residual.
    failed: methods that could not grade it (their raw is then 0). refused: why there is nothing to grade.
    """

    key: str
    cluster: str
    raw: Mapping[str, float] = field(default_factory=dict)
    failed: tuple[str, ...] = ()
    refused: str | None = None

    @property
    def mark(self) -> float:
        """Our mark as shipped, 0-100; NaN when refused."""
        return 100.0 * self.raw[OURS] if self.raw else float("nan")


def grade(task: GradingTask) -> Grades:
    """One copy by our mark and by every other method; a copy that any of them must refuse is refused."""
    from rumu import pipeline
    from rumu.errors import RumuError
    from rumu_lab.baselines.cell import cell_of

    try:
        copy = pipeline.surface_of(task.copy.picture())
        cell = cell_of(copy)
    except RumuError as refusal:
        return Grades(task.key, task.cluster, refused=str(refusal))
    mark = pipeline.assess(copy, master_at(task.master), remarks=False)
    if mark.score is None or mark.registration is None:
        return Grades(task.key, task.cluster, refused=str(mark.refused))
    own = {
        OURS: mark.score / 100.0,
        RESIDUAL: residual_grade(mark.registration),
        SIMILARITY: float(mark.similarity or 0.0),
        SIM_PAPER: float(mark.sim_paper or 0.0),
    }
    others, failed = _grade_by_others(cell, _cell_at(task.master))
    return Grades(task.key, task.cluster, own | others, failed)


def residual_grade(registration: Registration) -> float:
    """1 less the mean of the upper quartiles of the residuals, both ways, in rms radii."""
    import numpy as np

    ways = registration.forward, registration.backward
    return 1.0 - float(np.mean([np.percentile(way, 75) for way in ways]))


def _grade_by_others(cell: Cell, reference: Cell) -> tuple[dict[str, float], tuple[str, ...]]:
    from rumu.errors import RumuError
    from rumu_lab.baselines.methods import METHODS

    grades, failed = {}, []
    for name, method in METHODS.items():
        try:
            grades[name] = method(cell, reference).raw
        except RumuError:
            grades[name] = 0.0
            failed.append(name)
    return grades, tuple(failed)


@functools.lru_cache(maxsize=4)
def _cell_at(master: Path) -> Cell:
    from rumu_lab.baselines.cell import cell_of

    return cell_of(master_at(master).surface)
