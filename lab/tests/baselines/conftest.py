"""Cells of works of the starter gallery, as they are and with a known fault."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.gallery.starter import find_work
from rumu_lab.baselines.cell import SIDE, Cell, cell_from
from rumu_lab.simulation import faults

WORKS = ("regular-shu", "regular-tian", "clerical-tian")
"""Many strokes, few, and another script."""


@lru_cache(maxsize=32)
def _ink(work: str) -> np.ndarray:
    image = Image.open(find_work(work).path).resize((SIDE, SIDE), Image.Resampling.BOX)
    return np.asarray(image) < 128


@lru_cache(maxsize=256)
def _faulted(work: str, fault: str, severity: float, seed: int) -> Cell:
    ink = _ink(work)
    return cell_from(faults.apply(ink, fault, severity=severity, seed=seed).mask if severity else ink)


@pytest.fixture(scope="session")
def cell() -> Callable[..., Cell]:
    """The cell of a work, by id, and of the same work with one fault."""

    def of(work: str, fault: str = "shift", severity: float = 0.0, seed: int = 1) -> Cell:
        return _faulted(work, fault, float(severity), seed)

    return of


@pytest.fixture(scope="session")
def moved() -> Callable[..., Cell]:
    """A work turned by `lean` degrees clockwise, scaled, and shifted by (right, down) pixels of its cell."""

    def move(
        work: str, *, lean: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)
    ) -> Cell:
        M = cv2.getRotationMatrix2D(((SIDE - 1) / 2, (SIDE - 1) / 2), -lean, scale)
        M[:, 2] += shift
        return cell_from(cv2.warpAffine(_ink(work).astype(np.float32), M, (SIDE, SIDE)) > 0.5)

    return move


@pytest.fixture(scope="session")
def ladder(cell) -> Callable[..., list[float]]:
    """Raw grades of a method at growing severities of one fault, averaged over seeds."""

    def climb(method, work: str, fault: str, severities=(0, 1, 3, 5), seeds=(1, 2, 3)) -> list[float]:
        master = cell(work)
        return [
            float(np.mean([method(cell(work, fault, s, seed), master).raw for seed in seeds]))
            for s in severities
        ]

    return climb
