"""A surface as a mesh: GLB to look at, PLY and STL to print or measure.

Right-handed, x right, y up, z toward the viewer, the sheet's centre at the origin; faces turn
counter-clockwise toward +z.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray, Surface

Format = Literal["glb", "ply", "stl"]

FORMATS: tuple[Format, ...] = get_args(Format)
_PIXEL_SHEET = 0.1  # metres: how long the longer side is shown when nothing says how large the sheet is


@dataclass(frozen=True, slots=True)
class MeshSettings:
    """exaggeration: height is multiplied by it. vertices: most of the grid; 60 000 keep a GLB under 5 MB.

    texture: longest side of the picture on a GLB, in pixels.
    """

    exaggeration: float = 1.0
    vertices: int = 60_000
    texture: int = 1024

    def __post_init__(self) -> None:
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

    Of a photometric surface only what was measured is kept; a relief is kept whole, paper and ink. A sheet
    whose scale is unknown is shown 10 cm long.
    Raises SurfaceError when no triangle is left.
    """
    settings = settings or MeshSettings()
    h, w = surface.height.shape
    kept = surface.mask if surface.source == "photometric" else np.ones((h, w), dtype=bool)
    pixel = surface.spacing / 1000.0 if surface.unit == "mm" else _PIXEL_SHEET / max(h, w)
    step = max(1, int(np.ceil(np.sqrt(h * w / settings.vertices))))
    height, present = _coarse(surface.height, kept, step)
    rows, columns = (
        np.minimum((np.arange(n) + 0.5) * step - 0.5, last)
        for n, last in zip(height.shape, (h - 1, w - 1), strict=True)
    )
    x = (columns - (w - 1) / 2) * pixel
    y = ((h - 1) / 2 - rows) * pixel
    z = height * (pixel / surface.spacing) * settings.exaggeration
    everywhere = np.stack([*np.meshgrid(x, y), z], axis=-1).reshape(-1, 3)
    uv = np.stack(np.meshgrid((columns + 0.5) / w, 1.0 - (rows + 0.5) / h), axis=-1).reshape(-1, 2)
    faces = _faces(present)
    if len(faces) == 0:
        raise SurfaceError(
            f"expected a surface with room for a triangle, got {int(kept.sum())} pixels of {h} x {w}"
        )
    used, renamed = np.unique(faces, return_inverse=True)
    return Grid(everywhere[used], renamed.reshape(-1, 3), uv[used])


def mesh_bytes(surface: Surface, *, kind: Format = "glb", settings: MeshSettings | None = None) -> bytes:
    """The mesh as a file: "glb" (textured by the albedo in sRGB), "ply" (coloured vertices) or "stl".

    All are in metres but STL, which has no unit and is in millimetres as printers expect.
    Raises SurfaceError for another kind or an empty mesh.
    """
    import trimesh

    if kind not in FORMATS:
        raise SurfaceError(f"expected a mesh format among {', '.join(FORMATS)}, got {kind!r}")
    settings = settings or MeshSettings()
    grid = mesh_grid(surface, settings=settings)
    scale = 1000.0 if kind == "stl" else 1.0
    mesh = trimesh.Trimesh(grid.vertices * scale, grid.faces, process=False)
    if kind == "glb":
        mesh.visual = _texture(surface, grid, settings)
        data = trimesh.Scene(mesh).export(file_type="glb")
    else:
        if kind == "ply":
            mesh.visual.vertex_colors = _colours(surface, grid)
        data = mesh.export(file_type=kind)
    return data if isinstance(data, bytes) else str(data).encode()


def albedo_srgb(albedo: FloatArray) -> npt.NDArray[np.uint8]:
    """(H, W, 3) uint8, sRGB, from linear albedo (H, W) or (H, W, 3) in [0, 1]."""
    linear = np.clip(albedo if albedo.ndim == 3 else np.repeat(albedo[..., None], 3, axis=2), 0.0, 1.0)
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.asarray(np.round(curved * 255)).astype(np.uint8)


def _coarse(height: FloatArray, kept: BoolArray, step: int) -> tuple[FloatArray, BoolArray]:
    """Mean height of the kept pixels of each step x step block, and the blocks that are half kept."""
    h, w = height.shape
    spare = [(0, -h % step), (0, -w % step)]
    shape = ((h + spare[0][1]) // step, step, (w + spare[1][1]) // step, step)
    weight = np.pad(kept.astype(np.float64), spare).reshape(shape).sum(axis=(1, 3))
    total = np.pad(np.where(kept, height, 0.0).astype(np.float64), spare).reshape(shape).sum(axis=(1, 3))
    size = np.pad(np.ones((h, w)), spare).reshape(shape).sum(axis=(1, 3))
    return total / np.maximum(weight, 1.0), weight >= 0.5 * size


def _faces(present: BoolArray) -> npt.NDArray[np.int64]:
    """Two triangles for each square of four kept points; y runs up, so rows run down."""
    index = np.arange(present.size).reshape(present.shape)
    whole = present[:-1, :-1] & present[:-1, 1:] & present[1:, :-1] & present[1:, 1:]
    top_left, top_right = index[:-1, :-1][whole], index[:-1, 1:][whole]
    low_left, low_right = index[1:, :-1][whole], index[1:, 1:][whole]
    one = np.stack([top_left, low_left, low_right], axis=1)
    two = np.stack([top_left, low_right, top_right], axis=1)
    return np.concatenate([one, two]).astype(np.int64)


def _texture(surface: Surface, grid: Grid, settings: MeshSettings) -> Any:
    from PIL import Image
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    picture = Image.fromarray(albedo_srgb(surface.albedo))
    picture.thumbnail((settings.texture, settings.texture))
    packed = io.BytesIO()
    picture.save(packed, format="JPEG", quality=88)
    packed.seek(0)
    material = PBRMaterial(baseColorTexture=Image.open(packed), metallicFactor=0.0, roughnessFactor=1.0)
    return TextureVisuals(uv=grid.uv, material=material)


def _colours(surface: Surface, grid: Grid) -> npt.NDArray[np.uint8]:
    h, w = surface.height.shape
    rows = np.clip(((1.0 - grid.uv[:, 1]) * h).astype(int), 0, h - 1)
    columns = np.clip((grid.uv[:, 0] * w).astype(int), 0, w - 1)
    return np.asarray(albedo_srgb(surface.albedo)[rows, columns])
