"""A surface drawn as a mesh seen from an angle: orthographic, quads painted from back to front."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rumu.report.pictures import PAPER, Picture, shrink_to_fit, srgb
from rumu.values import BoolArray, FloatArray, Surface


@dataclass(frozen=True, slots=True)
class MeshView:
    """From where the mesh is seen.

    azimuth: degrees the sheet is turned about z. elevation: degrees of the eye above the sheet.
    cells: quads along the longer side. width: pixels of the picture.
    relief: share of the longer side to which a flatter surface is raised; a steeper one stays as it is.
    margin: paper kept around the ink of a computed relief, as a share of the picture's longer side.
    """

    azimuth: float = -17.0
    elevation: float = 47.0
    cells: int = 84
    width: int = 640
    relief: float = 0.1
    margin: float = 0.07


# Drawn at twice the size and shrunk: the hair lines of the mesh then stay even.
_OVERSAMPLING = 2
_LAMP = np.array([-0.5, 0.45, 0.74])


def mesh_picture(surface: Surface, *, view: MeshView | None = None) -> tuple[Picture, float]:
    """The picture (rows, view.width, 3) on paper colour, and the factor by which the height was raised."""
    view = view or MeshView()
    surface = _crop_to_mask(surface, margin=view.margin)
    height, drawn = _sample_height(surface, view)
    xyz, exaggeration = _vertices(height, drawn, view)
    screen, depth = _project(xyz, view)
    quads = drawn[:-1, :-1] & drawn[:-1, 1:] & drawn[1:, :-1] & drawn[1:, 1:]
    if not quads.any():  # none of which all four corners are drawn
        quads = np.ones_like(quads)
    return _paint_quads(screen, depth, _colours(surface, xyz), quads, view), exaggeration


def _crop_to_mask(surface: Surface, *, margin: float) -> Surface:
    """The part that holds the ink or the object; what lies around it only makes it small."""
    if not surface.mask.any():
        return surface
    keep = round(margin * max(surface.mask.shape)) if surface.source != "photometric" else 0
    spans = []
    for axis in (1, 0):
        held = np.flatnonzero(surface.mask.any(axis=axis))
        spans.append(slice(max(held[0] - keep, 0), max(held[-1] + keep, held[0] + 1) + 1))
    rows, columns = spans
    return replace(
        surface,
        height=surface.height[rows, columns],
        normals_from=surface.normals[rows, columns],
        albedo_from=surface.albedo[rows, columns],
        mask=surface.mask[rows, columns],
        confidence=surface.confidence[rows, columns],
    )


def _sample_height(surface: Surface, view: MeshView) -> tuple[FloatArray, BoolArray]:
    """Height at the vertices, in units of the longer side, and which of them are drawn.

    Means over pixels: a nearest sample would drop strokes thinner than a cell. A photometric surface is drawn
    where it was measured, and its means are taken there; paper around ink is drawn as well.
    """
    height = (surface.height / (surface.spacing * max(surface.height.shape))).astype(np.float32)
    if surface.source != "photometric" or surface.mask.all():
        height = shrink_to_fit(height, side=view.cells + 1)
        return height, np.ones(height.shape, dtype=bool)
    weight = shrink_to_fit(surface.mask.astype(np.float32), side=view.cells + 1)
    total = shrink_to_fit(height * surface.mask, side=view.cells + 1)
    drawn = weight > 0.5
    return np.where(drawn, total / np.maximum(weight, 0.5), 0.0), drawn


def _vertices(height: FloatArray, drawn: BoolArray, view: MeshView) -> tuple[FloatArray, float]:
    """(rows, columns, 3) vertices in units of the longer side, centred, and the exaggeration."""
    rows, columns = height.shape
    held = height[drawn] if drawn.any() else height
    z = height - np.median(held)
    low, high = np.percentile(held, (0.5, 99.5))
    span = float(max(high - low, np.ptp(held) * 0.5))
    exaggeration = max(1.0, view.relief / span) if span > 1e-6 else 1.0
    step = 1.0 / max(max(rows, columns) - 1, 1)
    x = (np.arange(columns) - (columns - 1) / 2) * step
    y = ((rows - 1) / 2 - np.arange(rows)) * step
    xx, yy = np.meshgrid(x, y)
    return np.stack([xx, yy, z * exaggeration], axis=-1), exaggeration


def _colours(surface: Surface, xyz: FloatArray) -> FloatArray:
    """(rows - 1, columns - 1, 3) colour of each quad: paper and ink (or albedo), shaded by the drawn form."""
    rows, columns = xyz.shape[:2]
    across = xyz[:-1, 1:] - xyz[1:, :-1]
    along = xyz[1:, 1:] - xyz[:-1, :-1]
    normal = np.cross(along, across)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    lamp = _LAMP / np.linalg.norm(_LAMP)
    light = 0.42 + 0.7 * np.clip(normal @ lamp, 0, 1)
    half = lamp + np.array([0.0, -0.6, 0.8])  # half way to the eye
    gloss = np.clip(normal @ (half / np.linalg.norm(half)), 0, 1) ** 24
    if surface.source == "photometric":
        base = _quad_albedo(surface, rows, columns)
    else:
        ink = _mean_over_quads(surface.mask.astype(np.float32), rows, columns)[..., None]
        base = np.array(PAPER) * (1 - ink) * 0.98 + np.array((112, 132, 140)) * ink
    return np.asarray(np.clip(base * light[..., None] + 38 * gloss[..., None], 0, 255))


def _quad_albedo(surface: Surface, rows: int, columns: int) -> FloatArray:
    coded = srgb(surface.albedo / max(float(np.percentile(surface.albedo, 99)), 1e-6)).astype(np.float32)
    if coded.ndim == 2:
        coded = np.repeat(coded[..., None], 3, axis=2)
    quads = _mean_over_quads(coded, rows, columns)
    # A mesh of black albedo would hide its own form: lift it toward clay.
    return np.asarray(0.55 * quads + 0.45 * np.array((196, 186, 170)))


def _mean_over_quads(array: npt.NDArray[np.float32], rows: int, columns: int) -> FloatArray:
    import cv2

    return np.asarray(cv2.resize(array, (columns - 1, rows - 1), interpolation=cv2.INTER_AREA))


def _project(xyz: FloatArray, view: MeshView) -> tuple[FloatArray, FloatArray]:
    """Screen positions (rows, columns, 2) with y down, and depth away from the eye (rows, columns)."""
    turn, lift = np.radians(view.azimuth), np.radians(view.elevation)
    x = xyz[..., 0] * np.cos(turn) - xyz[..., 1] * np.sin(turn)
    y = xyz[..., 0] * np.sin(turn) + xyz[..., 1] * np.cos(turn)
    up = y * np.sin(lift) + xyz[..., 2] * np.cos(lift)
    return np.stack([x, -up], axis=-1), y * np.cos(lift) - xyz[..., 2] * np.sin(lift)


def _paint_quads(
    screen: FloatArray, depth: FloatArray, colours: FloatArray, drawn: BoolArray, view: MeshView
) -> Picture:
    """The quads that are `drawn`, far ones first."""
    import cv2

    corners = np.stack([screen[:-1, :-1], screen[:-1, 1:], screen[1:, 1:], screen[1:, :-1]], axis=2)[drawn]
    low, high = corners.reshape(-1, 2).min(axis=0), corners.reshape(-1, 2).max(axis=0)
    width = view.width * _OVERSAMPLING
    scale, margin = 0.94 * width / (high[0] - low[0]), 0.03 * width
    canvas = np.full((int((high[1] - low[1]) * scale + 2 * margin), width, 3), PAPER, dtype=np.uint8)
    quads = np.round((corners - low) * scale + margin).astype(np.int32)[:, :, None, :]
    middle = (depth[:-1, :-1] + depth[1:, 1:] + depth[:-1, 1:] + depth[1:, :-1])[drawn]
    fills = colours[drawn]
    lines = fills * 0.72
    for index in np.argsort(-middle):
        cv2.fillConvexPoly(canvas, quads[index], fills[index].tolist())
        cv2.polylines(canvas, [quads[index]], True, lines[index].tolist(), 1, cv2.LINE_AA)
    return np.asarray(shrink_to_fit(canvas, side=max(canvas.shape[:2]) // _OVERSAMPLING))
