"""The sheet of paper in a photograph: a bright part on a darker ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes
from rumu.pages.vanishing_points import VanishingSettings, view_from_above
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class PaperEdgeSettings:
    """What counts as a sheet on a darker ground.

    closed: side of the window, over the longer side of the picture, within which writing is filled. darker:
        most light of the ground, as a share of the paper's. light: least gray level that parts both, 0-255.
    least: least share of the picture that is paper. corner: how far its edge may bend, as a share of its
        length; straight: least share of it that its four corners hold.
    whole: least share of the picture of a sheet that lies on a desk with all of its corners.
    near, far: distances on both sides of an edge, over the longer side of the picture; step: share of the
        difference in light between the far places that lies between the near ones, at an edge of paper: a
        shadow fades. piece: share of an outline over which both are averaged. faded: longest run of its
        outline that is no such edge, as a share of it.
    """

    closed: float = 0.017
    darker: float = 0.8
    light: int = 40
    least: float = 0.1
    corner: float = 0.03
    straight: float = 0.93
    whole: float = 0.15
    near: float = 0.005
    far: float = 0.02
    step: float = 0.5
    piece: float = 0.03
    faded: float = 0.12


def find_paper(gray: Bytes, *, settings: PaperEdgeSettings) -> FloatArray | None:
    """(n, 2) x and y of the convex outline of the sheet in a picture (h, w) uint8; None where none shows.

    Of a sheet that lies half in a shadow the dark half may be nearer to the desk than to the light one: where
    the bright part fades out, what is darker is parted once more.
    """
    import cv2

    side = max(3, round(settings.closed * max(gray.shape))) | 1
    smooth = np.asarray(cv2.morphologyEx(gray, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8)), np.uint8)
    level = 256.0
    for _ in range(2):
        darker = smooth[smooth < level].reshape(-1, 1)
        if not len(darker):
            return None
        level, _ = cv2.threshold(darker, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
        bright = (smooth > level).view(np.uint8)
        outside = smooth[bright == 0]
        if not len(outside) or level < settings.light:
            return None
        if np.median(outside) > settings.darker * np.median(smooth[bright > 0]):
            return None
        contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        edge = max(contours, key=cv2.contourArea)
        if _longest_faded(smooth, bright, edge.reshape(-1, 2), settings) <= settings.faded:
            sheet = cv2.convexHull(edge)
            enough = float(cv2.contourArea(sheet)) >= settings.least * gray.size
            return np.asarray(sheet.reshape(-1, 2), np.float64) if enough else None
    return None


def _longest_faded(smooth: Bytes, bright: Bytes, edge: IntArray, settings: PaperEdgeSettings) -> float:
    """The longest run of a closed edge (n, 2) of a bright part across which light falls by and by, over n.

    Where it runs along the border of the picture nothing is seen of it.
    """
    import cv2
    from scipy.ndimage import uniform_filter1d

    longer = max(smooth.shape)
    near, far = settings.near * longer, settings.far * longer
    soft = cv2.GaussianBlur(bright.astype(np.float32), (0, 0), near)
    inward = np.stack(
        [cv2.Sobel(soft, cv2.CV_32F, *way)[edge[:, 1], edge[:, 0]] for way in ((1, 0), (0, 1))], axis=1
    )
    inward /= np.maximum(np.hypot(*inward.T), 1e-6)[:, None]
    size = np.array(smooth.shape[1::-1])
    inside = ((edge >= far + 1) & (edge < size - far - 1)).all(axis=1)

    def light(off: float) -> FloatArray:
        x, y = np.clip(np.rint(edge + off * inward).astype(int), 0, size - 1).T
        return np.asarray(smooth[y, x], np.float64)

    count = max(1, round(settings.piece * len(edge)))
    step, whole = (
        uniform_filter1d(np.where(inside, light(off) - light(-off), 0.0), count, mode="wrap")
        for off in (near, far)
    )
    faded = inside & (step <= settings.step * np.maximum(whole, 1.0))
    ends = np.flatnonzero(~np.concatenate([[False], faded, faded, [False]]))  # a run may cross the start
    return min(float(np.diff(ends).max() - 1) / len(edge), 1.0)


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
