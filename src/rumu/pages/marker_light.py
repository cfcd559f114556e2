"""What the printed markers of a photograph tell of it: how far black stands out, and how sharp it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.pages.sheet_markers import SIDE
from rumu.values import FloatArray

PER_MODULE = 8
"""Pixels of a module in what is cut out of a marker."""


@dataclass(frozen=True, slots=True)
class MarkerLight:
    """Medians over the markers of a photograph.

    contrast: gray levels between their black and the white beside it. blur: standard deviation, in pixels of
    the photograph, by which their edges are smeared. side: of a marker, in pixels.
    """

    contrast: float
    blur: float
    side: float


def measure_markers(gray: npt.NDArray[np.uint8], markers: Sequence[tuple[int, FloatArray]]) -> MarkerLight:
    """Contrast and blur of a photograph (H, W). markers: one or more, with their corners (4, 2)."""
    spreads, contrasts = [], []
    for _, corners in markers:
        patch = cut_marker(gray, corners)
        white, black = float(np.quantile(patch, 0.95)), float(np.quantile(patch, 0.05))
        contrasts.append(white - black)
        spreads.append(_smear(patch, max(white - black, 1.0)))
    side = float(np.median([np.hypot(*(c - np.roll(c, 1, axis=0)).T).mean() for _, c in markers]))
    return MarkerLight(float(np.median(contrasts)), float(np.median(spreads)) * side / SIDE, side)


def cut_marker(picture: npt.NDArray[np.uint8], corners: FloatArray) -> npt.NDArray[np.float32]:
    """A marker and a module of paper around it, upright, of one channel (H, W) of a photograph."""
    import cv2

    side = (SIDE + 2) * PER_MODULE
    inner, outer = PER_MODULE - 0.5, side - PER_MODULE - 0.5
    square = np.array([[inner, inner], [outer, inner], [outer, outer], [inner, outer]], np.float32)
    matrix = cv2.getPerspectiveTransform(corners.astype(np.float32), square)
    return np.asarray(cv2.warpPerspective(picture, matrix, (side, side), flags=cv2.INTER_LINEAR), np.float32)


def _smear(patch: npt.NDArray[np.float32], contrast: float) -> float:
    """Standard deviation, in modules, of the blur: from how steep the outer edges of the marker are."""
    k, n = PER_MODULE, len(patch)
    steepest = []
    for view in (patch, patch[::-1], patch.T, patch.T[::-1]):
        profile = view[: 2 * k, 2 * k : n - 2 * k].mean(axis=1)
        steepest.append(float(np.abs(np.diff(profile)).max()))
    return contrast / (math.sqrt(2 * math.pi) * max(float(np.median(steepest)), 1e-3)) / k
