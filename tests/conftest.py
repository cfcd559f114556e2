"""Works of the starter gallery, copies with known faults, and registrations made of both."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.gallery.starter import find_work
from rumu.pipeline import PreparedMaster, measure
from rumu.registration.icp import register_points
from rumu.registration.points import Sampling, sample_points
from rumu.surface.inflation import inflate
from rumu.values import Registration, Surface
from rumu_lab.simulation import faults


@lru_cache(maxsize=32)
def _darkness(work: str) -> np.ndarray:
    return 1.0 - np.asarray(Image.open(find_work(work).path), np.float32) / 255.0


@pytest.fixture(scope="session")
def mask() -> Callable[[str], np.ndarray]:
    """(512, 512) bool ink of a work of the starter gallery, by id."""
    return lambda work: _darkness(work) > 0.5


@pytest.fixture(scope="session")
def moved() -> Callable[..., np.ndarray]:
    """Ink of a work turned `lean` degrees clockwise, scaled, shifted by (x right, y up) pixels."""

    def move(
        work: str, *, lean: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)
    ) -> np.ndarray:
        ink = _darkness(work)
        h, w = ink.shape
        M = cv2.getRotationMatrix2D(((w - 1) / 2, (h - 1) / 2), -lean, scale)
        M[:, 2] += shift[0], -shift[1]
        return cv2.warpAffine(ink, M, (w, h), flags=cv2.INTER_LINEAR) > 0.5

    return move


@pytest.fixture(scope="session")
def surface() -> Callable[[np.ndarray], Surface]:
    """The inflated surface of an ink mask."""

    def of(ink: np.ndarray) -> Surface:
        return Surface(
            height=inflate(ink),
            normals_from=np.broadcast_to(np.array([0, 0, 1], np.float32), (*ink.shape, 3)),
            albedo_from=np.where(ink, 0.1, 0.9).astype(np.float32),
            mask=ink,
            confidence=np.ones(ink.shape, np.float32),
            spacing=1.0,
            unit="px",
            source="inflation",
        )

    return of


@pytest.fixture(scope="session")
def laid(surface) -> Callable[..., Registration]:
    """The registration of one ink mask on another.

    of_copy: another count for the copy, so that the points of the same ink do not coincide.
    """

    def lay(copy: np.ndarray, master: np.ndarray, *, count: int = 900, of_copy: int = 0) -> Registration:
        probe, reference = (
            sample_points(surface(ink), settings=Sampling(count=n))
            for ink, n in ((copy, of_copy or count), (master, count))
        )
        return register_points(probe, reference)

    return lay


@pytest.fixture(scope="session")
def measured(surface):
    """The measurement of one ink mask against another, as a mark is made of it; written: the character."""
    return lambda copy, master, written=None: measure(surface(copy), PreparedMaster(surface(master), written))


@pytest.fixture(scope="session")
def fault(mask) -> Callable[..., faults.Faulted]:
    """A work with one known fault."""
    return lambda work, name, severity, seed=1: faults.apply(mask(work), name, severity=severity, seed=seed)
