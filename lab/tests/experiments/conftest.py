"""Grades copies that nobody measured, so that what is made of them can be tested alone."""

from __future__ import annotations

import zlib
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from rumu_lab.baselines.methods import METHODS
from rumu_lab.experiments.grading import OURS, OWN, Grades, GradingTask
from rumu_lab.experiments.marked_copies import FOLDERS
from rumu_lab.experiments.run_settings import RunSettings


@pytest.fixture
def quick(tmp_path) -> RunSettings:
    """The quick subset, with a place to keep what it finds and no data."""
    return RunSettings(tmp_path / "data", tmp_path / "out", quick=True)


def _graded(task: GradingTask, quality: float, *, noise: float = 0.02) -> Grades:
    """Ours says `quality` (0 to 1); the others say it with noise of their own."""
    rng = np.random.default_rng(zlib.crc32(task.key.encode()))
    raw = {name: float(np.clip(quality + noise * rng.normal(), 0, 1)) for name in (*OWN, *METHODS)}
    return Grades(task.key, task.cluster, raw | {OURS: quality})


@pytest.fixture(scope="session")
def graded():
    """(task, quality, noise=) -> a copy of that quality, measured by every method."""
    return _graded


@pytest.fixture
def e3c_data(tmp_path) -> Path:
    """Both tables with the characters of the quick subset; the pictures are not there."""
    rng = np.random.default_rng(3)
    for folder, characters in zip(FOLDERS, ("十得", "合"), strict=True):
        rows = ["image,character,template,mean_score,n_raters,ratings"]
        for character, k in product(characters, range(8)):
            ratings = np.clip(np.round(2 + k + rng.normal(size=4)), 1, 10)
            told = " ".join(f"{r:.0f}" for r in ratings)
            rows.append(
                f"copies/{character}{k}.png,{character},templates/{character}.png,{ratings.mean()},4,{told}"
            )
        table = tmp_path / "data" / folder / "scores.csv"
        table.parent.mkdir(parents=True)
        table.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return tmp_path / "data"
