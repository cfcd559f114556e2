"""Copy and master laid on each other: where the copy deviates, and what it leaves out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rumu.registration.icp import pose_probe
from rumu.report.pictures import PAPER, RESIDUAL_STOPS, Picture, colour_scale
from rumu.values import BoolArray, FloatArray, PointSet, Registration, Surface

MASTER_INK = (228, 222, 210)
MISSING = (36, 84, 164)


@dataclass(frozen=True, slots=True)
class OverlaySettings:
    """How the overlay is drawn; distances lie in the plane, in rms radii of the master's ink.

    side: pixels of the picture. margin: paper around the ink, as a share of its reach.
    full: distance of the loudest colour; fixed, so that pages can be compared.
    missing: distance beyond which a point of the master counts as not covered.
    """

    side: int = 720
    margin: float = 0.12
    full: float = 0.3
    missing: float = 0.12


def overlay_picture(
    registration: Registration, *, master: Surface, settings: OverlaySettings | None = None
) -> Picture:
    """Copy on master, (side, side, 3) uint8.

    The master's ink is pale, the copy's points have the colour of their distance to it, and the master's
    points that the copy does not cover are blue rings.
    """
    settings = settings or OverlaySettings()
    copy, model = plane_points(registration)
    reach = max(np.abs(copy).max(), np.abs(model).max()) * (1 + settings.margin)
    scale = settings.side / float(reach)  # the canvas is twice the picture and spans twice the reach
    canvas = _master_ink(master.mask, registration.reference, settings, scale)
    distances = _distances(copy, model)
    order = np.argsort(distances)  # the loudest on top
    colours = colour_scale(distances / settings.full, stops=RESIDUAL_STOPS)
    dot = 0.85 * scale * _pitch(copy)  # neighbours just touch: the points read as ink
    _circles(canvas, copy[order], colours[order].tolist(), scale, radius=dot, thickness=-1)
    uncovered = model[_distances(model, copy) > settings.missing]
    _circles(canvas, uncovered, [MISSING] * len(uncovered), scale, radius=dot, thickness=2)
    import cv2

    return np.asarray(cv2.resize(canvas, (settings.side, settings.side), interpolation=cv2.INTER_AREA))


def uncovered_share(registration: Registration, *, settings: OverlaySettings | None = None) -> float:
    """Share of the master's points, in [0, 1], that no point of the copy comes near."""
    settings = settings or OverlaySettings()
    copy, model = plane_points(registration)
    return float(np.mean(_distances(model, copy) > settings.missing))


def plane_points(registration: Registration) -> tuple[FloatArray, FloatArray]:
    """(N, 2) points of the copy, posed, and (M, 2) points of the master: what an eye sees.

    The registration's own residuals also hold height and stroke direction, which a flat picture cannot show.
    """
    return pose_probe(registration)[:, :2], registration.reference.xyz[:, :2]


def _distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """(N,) from each point of a to the nearest of b."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(b).query(a)[0])


def _pitch(points: FloatArray) -> float:
    """Median distance from a point to its nearest neighbour."""
    from scipy.spatial import cKDTree

    return float(np.median(cKDTree(points).query(points, k=2)[0][:, 1]))


def _master_ink(mask: BoolArray, points: PointSet, settings: OverlaySettings, scale: float) -> Picture:
    """The canvas, twice the picture's size, with the master's ink laid into the frame of its points."""
    import cv2

    rows, columns = mask.shape
    side = 2 * settings.side
    longer = max(rows, columns)
    per_pixel = scale / (points.radius * longer)
    centre = np.array([columns / 2 + points.centre[0] * longer, rows / 2 - points.centre[1] * longer])
    affine = np.array(
        [
            [per_pixel, 0, side / 2 - per_pixel * (centre[0] - 0.5)],
            [0, per_pixel, side / 2 - per_pixel * (centre[1] - 0.5)],
        ]
    )
    sheet = np.where(mask[..., None], np.array(MASTER_INK, np.uint8), np.array(PAPER, np.uint8))
    return np.asarray(cv2.warpAffine(sheet, affine, (side, side), flags=cv2.INTER_LINEAR, borderValue=PAPER))


def _circles(
    canvas: Picture, xy: FloatArray, colours: list[Any], scale: float, *, radius: float, thickness: int
) -> None:
    """Draw a circle at each point; thickness: of the line in pixels, -1 fills it."""
    import cv2

    middle = canvas.shape[0] / 2
    at = np.stack([middle + xy[:, 0] * scale, middle - xy[:, 1] * scale], axis=1)
    pixels = np.round(at * 16).astype(np.int32)  # cv2 takes 4 bits of fraction
    for centre, colour in zip(pixels.tolist(), colours, strict=True):
        cv2.circle(canvas, centre, round(radius * 16), colour, thickness, cv2.LINE_AA, 4)
