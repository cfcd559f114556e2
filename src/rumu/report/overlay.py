"""Copy and master laid on each other: where the copy strays, and what it leaves out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.report.pictures import PAPER, RESIDUAL_STOPS, Picture, coloured
from rumu.values import BoolArray, FloatArray, PointSet, Registration, Surface

MASTER_INK = (228, 222, 210)
MISSING = (36, 84, 164)


@dataclass(frozen=True, slots=True)
class OverlaySettings:
    """How the overlay is drawn; distances are in rms radii of the master's ink.

    side: pixels of the picture. margin: paper around the ink, as a share of its reach.
    full: residual of the loudest colour; fixed, so that pages can be compared.
    missing: residual beyond which a point of the master counts as not covered.
    dot: radius of a point in pixels.
    """

    side: int = 720
    margin: float = 0.12
    full: float = 0.2
    missing: float = 0.12
    dot: float = 3.0


def overlay_picture(
    registration: Registration, *, master: Surface, settings: OverlaySettings | None = None
) -> Picture:
    """The master's ink pale, the copy's points coloured by their distance to it, and the master's points that
    the copy leaves uncovered as blue rings: (side, side, 3) uint8."""
    settings = settings or OverlaySettings()
    moved = _moved(registration)
    reach = max(np.abs(moved).max(), np.abs(registration.reference.xyz[:, :2]).max()) * (1 + settings.margin)
    scale = settings.side / float(reach)  # the canvas is twice the picture and spans twice the reach
    canvas = _master_ink(master.mask, registration.reference, settings, scale)
    order = np.argsort(registration.forward)
    colours = coloured(registration.forward / settings.full, stops=RESIDUAL_STOPS)
    _dots(canvas, moved[order], colours[order], scale, radius=2 * settings.dot)
    uncovered = registration.backward > settings.missing
    _rings(canvas, registration.reference.xyz[uncovered, :2], scale, radius=2.2 * settings.dot)
    import cv2

    return np.asarray(cv2.resize(canvas, (settings.side, settings.side), interpolation=cv2.INTER_AREA))


def uncovered_share(registration: Registration, *, settings: OverlaySettings | None = None) -> float:
    """Share of the master's points, in [0, 1], that no point of the copy comes near."""
    settings = settings or OverlaySettings()
    return float(np.mean(registration.backward > settings.missing))


def _moved(registration: Registration) -> FloatArray:
    """(N, 2) points of the copy in the master's frame."""
    pose = registration.T_reference_probe
    return np.asarray(registration.probe.xyz @ pose[:3, :3].T + pose[:3, 3])[:, :2]


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
    ink = cv2.warpAffine(mask.astype(np.float32), affine, (side, side), flags=cv2.INTER_LINEAR)[..., None]
    mixed = np.array(PAPER) * (1 - ink) + np.array(MASTER_INK) * ink
    return np.asarray(np.round(mixed), dtype=np.uint8)


def _pixels(xy: FloatArray, side: int, scale: float) -> npt.NDArray[np.int32]:
    at = np.stack([side / 2 + xy[:, 0] * scale, side / 2 - xy[:, 1] * scale], axis=1)
    return np.round(at * 16).astype(np.int32)  # cv2 takes 4 bits of fraction


def _dots(canvas: Picture, xy: FloatArray, colours: Picture, scale: float, *, radius: float) -> None:
    import cv2

    for at, colour in zip(_pixels(xy, canvas.shape[0], scale).tolist(), colours.tolist(), strict=True):
        cv2.circle(canvas, at, round(radius * 16), colour, -1, cv2.LINE_AA, 4)


def _rings(canvas: Picture, xy: FloatArray, scale: float, *, radius: float) -> None:
    import cv2

    for at in _pixels(xy, canvas.shape[0], scale).tolist():
        cv2.circle(canvas, at, round(radius * 16), MISSING, 2, cv2.LINE_AA, 4)
