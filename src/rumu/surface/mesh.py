"""A surface as a mesh: an open sheet of triangles, or a closed solid on a flat base.

Right-handed, x right, y up, z toward the viewer, the sheet's centre at the origin; faces turn
counter-clockwise toward +z. `mesh_files` writes both as files.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.capture.stored import to_srgb
from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray, Surface

MIN_LENGTH, MAX_LENGTH = 0.1, 10_000.0  # width and base of a printed solid, in millimetres
_PIXEL_SHEET = 0.1  # metres: how long the longer side is shown when nothing says how large the sheet is


@dataclass(frozen=True, slots=True)
class MeshSettings:
    """exaggeration: height is multiplied by it. vertices: most of the grid; 60 000 keep a GLB under 5 MB.

    texture: longest side of the pictures on the sheet, in pixels. width, base: of an STL, in millimetres:
    from its left to its right side (None: as large as the sheet), and the thickness below its lowest point.
    soften: standard deviation, in points of the grid, of the smoothing of a relief, which takes away the
    steps of an outline from pixel to pixel; what was measured is left as it is.
    """

    exaggeration: float = 1.0
    vertices: int = 60_000
    texture: int = 1024
    width: float | None = None
    base: float = 2.0
    soften: float = 0.7

    def __post_init__(self) -> None:
        for name, length in (("width", self.width), ("base", self.base)):
            if length is not None and not MIN_LENGTH <= length <= MAX_LENGTH:
                raise SurfaceError(
                    f"expected a {name} from {MIN_LENGTH:g} to {MAX_LENGTH:g} mm, got {length}"
                )
        if not (np.isfinite(self.exaggeration) and self.vertices >= 4 and self.texture >= 1):
            raise SurfaceError(
                "expected a finite exaggeration, at least 4 vertices and a texture of at least 1 pixel, "
                f"got {self.exaggeration}, {self.vertices} and {self.texture}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """vertices: (V, 3) float64, metres. faces: (F, 3), counter-clockwise from +z. uv: (V, 2) in [0, 1]."""

    vertices: FloatArray
    faces: npt.NDArray[np.int64]
    uv: FloatArray


def mesh_grid(surface: Surface, *, settings: MeshSettings | None = None) -> Grid:
    """The surface as a grid of triangles, coarse enough for the settings.

    Of a photometric surface only what was measured is kept, and counted; a relief is kept whole, paper and
    ink. A sheet whose scale is unknown is shown 10 cm long.
    Raises SurfaceError when no triangle is left.
    """
    settings = settings or MeshSettings()
    h, w = surface.height.shape
    kept = int(np.count_nonzero(surface.mask)) if surface.source == "photometric" else h * w
    step = max(1, int(np.ceil(np.sqrt(kept / settings.vertices))))
    while True:
        points, present, rows, columns = _points(surface, (step, step), settings)
        faces = _faces(present, points[..., 2])
        if len(faces) <= 2 * settings.vertices:
            break
        step += 1
    uv = np.stack(np.meshgrid((columns + 0.5) / w, 1.0 - (rows + 0.5) / h), axis=-1).reshape(-1, 2)
    if len(faces) == 0:
        raise _no_triangle(surface)
    used, renamed = np.unique(faces, return_inverse=True)
    return Grid(points.reshape(-1, 3)[used], renamed.reshape(-1, 3), uv[used])


def solid_mesh(
    surface: Surface, *, settings: MeshSettings | None = None
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """The surface as a closed solid on a flat base: (V, 3) vertices in millimetres, (F, 3) faces outward.

    What was not measured of a photometric surface lies as low as the lowest point that was; a sheet whose
    scale is unknown is 100 mm long unless the settings give a width. The base lies below z = 0 of the solid
    as deep as the settings say, the lowest point of the surface at 0. At most twice as many faces as
    `settings.vertices`.
    Raises SurfaceError when no triangle is left.
    """
    settings = settings or MeshSettings()
    points, present, _, _ = _points(surface, _solid_steps(surface, settings.vertices), settings)
    if min(present.shape) < 2 or not present.any():
        raise _no_triangle(surface)
    x, y, z = (points[..., k] * 1000.0 for k in range(3))
    scale = 1.0
    if settings.width is not None:
        scale = settings.width / float(np.ptp(x))
    elif surface.unit != "mm":
        scale = 1000.0 * _PIXEL_SHEET / max(float(np.ptp(x)), float(np.ptp(y)))
    low = z[present].min()
    top = np.stack([x * scale, y * scale, np.where(present, z - low, 0.0) * scale], axis=-1).reshape(-1, 3)
    index = np.arange(present.size).reshape(present.shape)
    # counter-clockwise as seen from +z, from the top left corner down
    edge = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    foot = len(top) + np.arange(len(edge))
    following, next_foot = np.roll(edge, -1), np.roll(foot, -1)
    centre = np.full(len(edge), len(top) + len(edge))
    vertices = np.concatenate([top, top[edge] * (1, 1, 0), [[0, 0, 0]]])
    vertices[len(top) :, 2] = -settings.base
    faces = [
        _faces(np.ones(present.shape, dtype=bool), top[:, 2]),
        np.stack([edge, foot, next_foot], axis=1),
        np.stack([edge, next_foot, following], axis=1),
        np.stack([centre, next_foot, foot], axis=1),
    ]
    return vertices, np.concatenate(faces).astype(np.int64)


def albedo_srgb(albedo: FloatArray) -> npt.NDArray[np.uint8]:
    """(H, W, 3) uint8, sRGB, from linear albedo (H, W) or (H, W, 3) in [0, 1]."""
    linear = np.clip(albedo if albedo.ndim == 3 else np.repeat(albedo[..., None], 3, axis=2), 0.0, 1.0)
    return np.asarray(np.round(to_srgb(linear) * 255)).astype(np.uint8)


def _points(
    surface: Surface, steps: tuple[int, int], settings: MeshSettings
) -> tuple[FloatArray, BoolArray, FloatArray, FloatArray]:
    """Points of a coarse grid, in metres; which of them are kept; rows and columns where they lie.

    steps: rows and columns of pixels for each point.
    """
    import cv2

    (h, w), height = surface.height.shape, surface.height
    kept = surface.mask if surface.source == "photometric" else np.ones((h, w), dtype=bool)
    if surface.source != "photometric" and settings.soften > 0:
        height = cv2.GaussianBlur(height, (0, 0), settings.soften * max(steps))
    pixel = surface.spacing / 1000.0 if surface.unit == "mm" else _PIXEL_SHEET / max(h, w)
    height, present = _coarse(height, kept, steps)
    rows, columns = (
        np.minimum((np.arange(n) + 0.5) * step - 0.5, last)
        for n, step, last in zip(height.shape, steps, (h - 1, w - 1), strict=True)
    )
    x = (columns - (w - 1) / 2) * pixel
    y = ((h - 1) / 2 - rows) * pixel
    z = height * (pixel / surface.spacing) * settings.exaggeration
    return np.stack([*np.meshgrid(x, y), z], axis=-1), present, rows, columns


def _solid_steps(surface: Surface, vertices: int) -> tuple[int, int]:
    """The smallest steps with which a solid has at most 2 faces for each vertex allowed."""
    h, w = surface.height.shape
    step = max(1, int(np.sqrt(h * w / vertices)))
    while True:
        rows, columns = min(step, max(1, h // 2)), min(step, max(1, w // 2))
        r, c = -(-h // rows), -(-w // columns)
        if 2 * r * c + 4 * (r + c) - 10 <= 2 * vertices or r * c <= 4:
            return rows, columns
        step += 1


def _coarse(height: FloatArray, kept: BoolArray, steps: tuple[int, int]) -> tuple[FloatArray, BoolArray]:
    """Mean height of the kept pixels of each block of `steps` pixels, and the blocks that are half kept."""
    h, w = height.shape
    down, right = steps
    spare = [(0, -h % down), (0, -w % right)]
    shape = ((h + spare[0][1]) // down, down, (w + spare[1][1]) // right, right)
    weight = np.pad(kept.astype(np.float64), spare).reshape(shape).sum(axis=(1, 3))
    total = np.pad(np.where(kept, height, 0.0).astype(np.float64), spare).reshape(shape).sum(axis=(1, 3))
    size = np.pad(np.ones((h, w)), spare).reshape(shape).sum(axis=(1, 3))
    return total / np.maximum(weight, 1.0), weight >= 0.5 * size


def _no_triangle(surface: Surface) -> SurfaceError:
    h, w = surface.height.shape
    kept = int(surface.mask.sum()) if surface.source == "photometric" else h * w
    return SurfaceError(f"expected a surface with room for a triangle, got {kept} pixels of {h} x {w}")


def _faces(present: BoolArray, height: FloatArray) -> npt.NDArray[np.int64]:
    """Two triangles for each square of four kept points; y runs up, so rows run down.

    A square is cut along the diagonal whose ends differ less in height: one that crosses the wall of a
    stroke would make a tooth of it.
    """
    index = np.arange(present.size).reshape(present.shape)
    corners = [slice(None, -1), slice(1, None)]
    whole = np.logical_and.reduce([present[rows, columns] for rows in corners for columns in corners])
    top_left, top_right, low_left, low_right = (
        index[rows, columns][whole] for rows in corners for columns in corners
    )
    z = height.ravel()
    falling = np.abs(z[top_left] - z[low_right]) <= np.abs(z[top_right] - z[low_left])
    one = np.stack([top_left, low_left, np.where(falling, low_right, top_right)], axis=1)
    two = np.stack([np.where(falling, top_left, low_left), low_right, top_right], axis=1)
    return np.concatenate([one, two]).astype(np.int64)
