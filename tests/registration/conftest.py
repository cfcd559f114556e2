"""Surfaces made from outlines, so that registration is tested without the room that finds ink."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from hypothesis import settings
from PIL import Image

from rumu.gallery.starter import find_work
from rumu.surface.inflation import inflate
from rumu.values import Surface

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

FLAT = np.array([0.0, 0.0, 1.0], np.float32)


def _surface(mask: np.ndarray, *, height: np.ndarray | None = None, source: str = "inflation") -> Surface:
    h = inflate(mask) if height is None else height.astype(np.float32)
    return Surface(
        height=h,
        normals_from=np.broadcast_to(FLAT, (*mask.shape, 3)),
        albedo_from=np.where(mask, 0.1, 0.9).astype(np.float32),
        mask=mask,
        confidence=np.ones(mask.shape, np.float32),
        spacing=1.0,
        unit="px",
        source=source,
    )


@pytest.fixture(scope="session")
def surface() -> Callable[..., Surface]:
    """A surface from an ink mask (H, W) bool; inflated unless a height is given."""
    return _surface


@pytest.fixture(scope="session")
def glyph() -> Callable[[str], np.ndarray]:
    """(512, 512) float32 darkness of a work of the starter gallery, by id."""
    return lambda work: 1.0 - np.asarray(Image.open(find_work(work).path), np.float32) / 255.0


@pytest.fixture(scope="session")
def moved() -> Callable[..., np.ndarray]:
    """The mask of a darkness, turned `lean` degrees clockwise, scaled, shifted by (x right, y up) pixels."""

    def move(
        ink: np.ndarray, *, lean: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)
    ) -> np.ndarray:
        h, w = ink.shape
        M = cv2.getRotationMatrix2D(((w - 1) / 2, (h - 1) / 2), -lean, scale)
        M[:, 2] += shift[0], -shift[1]
        return cv2.warpAffine(ink, M, (w, h), flags=cv2.INTER_LINEAR) > 0.5

    return move
