"""Copy and master on one sheet: the copy's ink brought into the master's frame by the registration.

The frame of everything that speaks of strokes: (x, y) in rms radii of the master's ink, origin at its
centroid, x right and y DOWN as on the page. A sheet is a picture of that frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.registration.points import ink_mask
from rumu.values import BoolArray, FloatArray, PointSet, Registration, Surface

SIDE = 256
"""Pixels of a sheet's side."""
RADIUS = 48.0
"""Pixels of a sheet for one rms radius of the master's ink."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Ink in the common frame.

    ink: (SIDE, SIDE) bool. to_picture: (2, 3), takes (x, y) of the frame to fractions of the picture the ink
        came from, origin top left. share: pixels of a sheet for one of that picture; below 1 it was shrunk.
    """

    ink: BoolArray
    to_picture: FloatArray
    share: float


def pixels(points: FloatArray) -> FloatArray:
    """(n, 2) of the frame -> (n, 2) (column, row) of a sheet."""
    return np.asarray(points * RADIUS + (SIDE - 1) / 2)


def frame(points: FloatArray) -> FloatArray:
    """(n, 2) (column, row) of a sheet -> (n, 2) of the frame."""
    return np.asarray((points - (SIDE - 1) / 2) / RADIUS)


def copy_sheet(copy: Surface, registration: Registration) -> Sheet:
    """The copy's ink as it lies on the master when lean, place and size are taken out."""
    T = registration.T_reference_probe
    return _sheet(ink_mask(copy), registration.probe, T[:2, :2], T[:2, 3])


def master_sheet(master: Surface, reference: PointSet) -> Sheet:
    """The master's ink in its own frame."""
    return _sheet(ink_mask(master), reference, np.eye(2), np.zeros(2))


def _sheet(mask: BoolArray, points: PointSet, R: FloatArray, t: FloatArray) -> Sheet:
    import cv2

    back = _to_picture(points, R, t)
    h, w = mask.shape
    to_pixel = np.array([[w, 0.0], [0.0, h]]) @ back  # continuous, pixel centres at a half
    per_sheet_pixel = to_pixel[:, :2] / RADIUS
    offset = to_pixel[:, 2] - 0.5 - per_sheet_pixel @ np.full(2, (SIDE - 1) / 2)
    shrunk = float(np.sqrt(abs(np.linalg.det(per_sheet_pixel))))
    image = mask.view(np.uint8) * np.uint8(255)
    if shrunk > 1.0:  # smooth before shrinking, or edges alias
        image = cv2.GaussianBlur(image, (0, 0), 0.4 * shrunk)
    M = np.column_stack([per_sheet_pixel, offset])
    flat = cv2.warpAffine(image, M, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    return Sheet(np.asarray(flat > 127), back, 1.0 / shrunk)


def _to_picture(points: PointSet, R: FloatArray, t: FloatArray) -> FloatArray:
    """(2, 3): (x, y down) of the frame -> fractions of the picture, origin top left."""
    flip = np.diag([1.0, -1.0])
    # frame -> y up -> before the pose -> fractions of the longer side from the middle -> fractions
    linear = points.radius * R.T @ flip
    constant = -points.radius * R.T @ t + points.centre
    cell = np.array(points.cell)
    linear, constant = (flip @ linear) / cell[:, None], 0.5 + flip @ constant / cell
    return np.column_stack([linear, constant])
