"""Place and size taken out: the probe moved and scaled until its ink stands as the reference's does.

Pictures of copies are seldom cropped as their masters are. A method that compares pixel by pixel would mark
the crop; so the simple ones look at the copy placed, and report what was taken out without charging it.
"""

from __future__ import annotations

import math

import numpy as np

from rumu.errors import RegistrationError
from rumu.values import BoolArray, FloatArray
from rumu_lab.baselines.cell import LEAST_INK, SIDE, Cell


def frame(ink: BoolArray) -> tuple[FloatArray, float]:
    """Centroid (x, y) of the ink, in pixels, and its rms distance from there, at least one pixel."""
    rows, columns = np.nonzero(ink)
    return np.array([columns.mean(), rows.mean()]), max(float(np.hypot(columns.std(), rows.std())), 1.0)


def align(probe: Cell, reference: Cell) -> Cell:
    """The probe with the centroid and rms radius of the reference; aspect and lean are kept.

    What would stand beyond the cell is lost. Raises RegistrationError where nearly all of it would.
    """
    import cv2

    (there, far), (here, near) = frame(reference.ink), frame(probe.ink)
    scale = far / near
    M = np.array([[scale, 0.0, there[0] - scale * here[0]], [0.0, scale, there[1] - scale * here[1]]])

    def move(image: FloatArray) -> FloatArray:
        if scale < 1:  # smooth before shrinking, or edges alias
            image = cv2.GaussianBlur(image, (0, 0), 0.4 / scale)
        return np.asarray(cv2.warpAffine(image, M, (SIDE, SIDE)), dtype=np.float32)

    ink = move(probe.ink.astype(np.float32)) > 0.5
    if np.count_nonzero(ink) < LEAST_INK:
        raise RegistrationError(f"expected ink that can be placed in a cell, got a scale of {scale:.3g}")
    return Cell(ink, np.clip(move(probe.density), 0.0, 1.0))


def placement(probe: Cell, reference: Cell) -> dict[str, float]:
    """What `align` takes out.

    'log_size': ln of the probe's radius over the reference's; 'right' and 'up',
    how far its centroid stands from the reference's, in cells.
    """
    (there, far), (here, near) = frame(reference.ink), frame(probe.ink)
    right, down = (here - there) / SIDE
    return {"log_size": math.log(near / far), "right": float(right), "up": float(-down)}
