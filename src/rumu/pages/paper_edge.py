"""The sheet of paper in a photograph: a bright part on a darker ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes
from rumu.pages.vanishing_points import VanishingSettings, view_from_above
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class PaperEdgeSettings:
    """What counts as a sheet on a darker ground.

    closed: side of the window, over the longer side of the picture, within which writing is filled. darker:
        most light of the ground, as a share of the paper's. light: least gray level that parts both, 0-255.
    least: least share of the picture that is paper. corner: how far its edge may bend, as a share of its
        length; straight: least share of it that its four corners hold.
    whole: least share of the picture of a sheet that lies on a desk with all of its corners.
    """

    closed: float = 0.017
    darker: float = 0.8
    light: int = 40
    least: float = 0.1
    corner: float = 0.03
    straight: float = 0.93
    whole: float = 0.15


def find_paper(gray: Bytes, *, settings: PaperEdgeSettings) -> FloatArray | None:
    """(n, 2) x and y of the convex outline of the sheet in a picture (h, w) uint8; None where none shows."""
    import cv2

    side = max(3, round(settings.closed * max(gray.shape))) | 1
    smooth = cv2.morphologyEx(gray, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    level, bright = cv2.threshold(smooth, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    outside = smooth[bright == 0]
    if not len(outside) or level < settings.light:
        return None
    if np.median(outside) > settings.darker * np.median(smooth[bright > 0]):
        return None
    contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    sheet = cv2.convexHull(max(contours, key=cv2.contourArea))
    if float(cv2.contourArea(sheet)) < settings.least * gray.size:
        return None
    return np.asarray(sheet.reshape(-1, 2), np.float64)


def view_by_paper(
    outline: FloatArray, shape: tuple[int, ...], *, settings: PaperEdgeSettings, vanishing: VanishingSettings
) -> FloatArray | None:
    """(3, 3) the view from above by the four straight edges of a sheet; None where it has no four.

    outline: see `find_paper`. shape: of the picture. The view is centred.
    """
    corners = _four_corners(outline, settings)
    if corners is None or _at_border(corners, shape).sum() > 1:
        return None
    corners = corners[np.argsort(np.arctan2(*(corners - corners.mean(axis=0)).T[::-1]))]
    corners = np.roll(corners, -int(np.argmin(corners.sum(axis=1))), axis=0)
    centred = np.hstack([corners - np.array(shape[1::-1]) / 2, np.ones((4, 1))])
    lines = np.cross(centred, np.roll(centred, -1, axis=0))
    right, down = np.cross(lines[0], lines[2]), np.cross(lines[1], lines[3])
    return view_from_above(right, down, max(shape), settings=vanishing)


def is_whole_sheet(outline: FloatArray, shape: tuple[int, ...], *, settings: PaperEdgeSettings) -> bool:
    """Whether an outline has four straight edges and all of its corners in the picture, on a desk."""
    import cv2

    corners = _four_corners(outline, settings)
    if corners is None or _at_border(corners, shape).any():
        return False
    return bool(cv2.contourArea(corners.astype(np.float32)) >= settings.whole * shape[0] * shape[1])


def _four_corners(outline: FloatArray, settings: PaperEdgeSettings) -> FloatArray | None:
    """(4, 2) the corners of an outline with four straight edges, in its order."""
    import cv2

    sheet = outline.astype(np.float32).reshape(-1, 1, 2)
    corners = cv2.approxPolyDP(sheet, settings.corner * cv2.arcLength(sheet, True), True)
    corners = corners.reshape(-1, 2).astype(np.float64)
    if len(corners) != 4:
        return None
    if cv2.contourArea(corners.astype(np.float32)) < settings.straight * cv2.contourArea(sheet):
        return None
    return np.asarray(corners)


def _at_border(corners: FloatArray, shape: tuple[int, ...]) -> BoolArray:
    size = np.array(shape[1::-1])
    return np.asarray(((corners < 4) | (corners > size - 5)).any(axis=1))
