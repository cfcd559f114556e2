"""A surface as a folder that other programs can read, and back.

    surface.json      unit, spacing, source, quality, version, scale of height.png
    height.tif        float32, in the unit; height.png is 16-bit: height = value * scale + offset
    normals.tif       float32 x, y, z; normals.png is 16-bit RGB: n = value / 32767.5 - 1, y up (OpenGL)
    albedo.tif        float32, linear; albedo.png is 8-bit sRGB
    confidence.tif    float32; confidence.png is 8-bit
    mask.png          white where measured (photometric) or inked (relief)
    surface.glb       the mesh, textured by the albedo

Reading takes the float files, so a surface comes back as it was. They may be left out, as they are of
surfaces that are computed from ink; reading then takes the pictures.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.image import to_linear
from rumu.errors import OutputError, SurfaceError
from rumu.inputs import read_json
from rumu.outputs import whole_folder
from rumu.surface.mesh import albedo_srgb, mesh_bytes
from rumu.values import FloatArray, Surface

MARKER = "surface.json"
_KIND = "rumu surface"
_ARRAYS = ("height", "normals", "albedo", "confidence")
_FILES = {MARKER, "surface.glb", "mask.png"} | {
    f"{name}{end}" for name in _ARRAYS for end in (".tif", ".png")
}


def write_surface(
    surface: Surface,
    folder: str | Path,
    *,
    floats: bool = True,
    extra: Mapping[str, str | bytes] | None = None,
) -> None:
    """Write a surface as a folder; it appears whole or not at all.

    folder: new, empty, or an earlier surface, which is replaced. floats: whether the float TIFFs are written.
    extra: more files of the folder, text or bytes by name, such as a report.
    Raises OutputError when the folder cannot be written or holds other files, SurfaceError when there is
    nothing to make a mesh of or an extra name is not a plain new name.
    """
    for name in extra or {}:
        if Path(name).name != name or name in _FILES:
            raise SurfaceError(f"expected a plain file name that is not of the surface's own, got {name!r}")
    glb = mesh_bytes(surface)
    with whole_folder(folder, marker=MARKER) as new:
        try:
            _write_files(surface, new, {"surface.glb": glb, **(extra or {})}, floats=floats)
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from error


def _write_files(surface: Surface, folder: Path, files: Mapping[str, str | bytes], *, floats: bool) -> None:
    import tifffile

    for name in _ARRAYS if floats else ():
        array: FloatArray = getattr(surface, name)
        kind = "rgb" if array.ndim == 3 else "minisblack"
        tifffile.imwrite(folder / f"{name}.tif", array.astype(np.float32), photometric=kind)
    scale, offset = _write_pictures(surface, folder)
    for name, content in files.items():
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    h, w = surface.height.shape
    metadata = {
        "kind": _KIND,
        "version": version("rumu"),
        "source": surface.source,
        "unit": surface.unit,
        "spacing": surface.spacing,
        "width": w,
        "height": h,
        "quality": {name: float(value) for name, value in surface.quality.items()},
        "frame": "x right, y up, z to the camera; rows run downward",
        "height_png": {"scale": scale, "offset": offset},
    } | ({} if floats else {"floats": False})
    (folder / MARKER).write_text(json.dumps(metadata, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def read_surface(folder: str | Path) -> Surface:
    """Read a folder that `write_surface` wrote.

    Raises SurfaceError naming the file that is missing or damaged.
    """
    folder = Path(folder)
    metadata = _read_metadata(folder)
    if metadata.get("floats", True):
        arrays = {name: _read_tiff(folder / f"{name}.tif") for name in _ARRAYS}
    else:
        arrays = _read_pictures(folder, metadata)
    mask = _read_mask(folder / "mask.png")
    shape = arrays["height"].shape
    wanted = {"normals": [(*shape, 3)], "albedo": [shape, (*shape, 3)], "confidence": [shape]}
    for name, shapes in wanted.items():
        if arrays[name].shape not in shapes:
            raise SurfaceError(f"{folder / name}.tif: expected shape {shapes[0]}, got {arrays[name].shape}")
    if mask.shape != shape:
        raise SurfaceError(f"{folder / 'mask.png'}: expected shape {shape}, got {mask.shape}")
    try:
        return Surface(
            height=arrays["height"],
            normals_from=arrays["normals"],
            albedo_from=arrays["albedo"],
            confidence=arrays["confidence"],
            mask=mask,
            spacing=float(metadata["spacing"]),
            unit=metadata["unit"],
            source=metadata["source"],
            quality={str(name): float(value) for name, value in metadata["quality"].items()},
        )
    except KeyError as error:
        raise SurfaceError(f"{folder / MARKER}: expected an entry {error.args[0]!r}, found none") from error
    except (TypeError, ValueError, AttributeError, SurfaceError) as error:
        raise SurfaceError(f"{folder / MARKER}: does not describe a surface: {error}") from error


def _write_pictures(surface: Surface, folder: Path) -> tuple[float, float]:
    """The files to look at; returns scale and offset of height.png."""
    import cv2
    from PIL import Image

    offset = float(surface.height.min())
    scale = max(float(surface.height.max()) - offset, 1e-12) / 65535.0
    height = np.round((surface.height.astype(np.float64) - offset) / scale).clip(0, 65535).astype(np.uint16)
    Image.fromarray(height).save(folder / "height.png")
    normals = np.round((surface.normals.astype(np.float64) + 1.0) * 32767.5).clip(0, 65535).astype(np.uint16)
    # Pillow cannot write 16 bits for each of three channels; OpenCV wants them in the order B, G, R.
    done, packed = cv2.imencode(".png", np.ascontiguousarray(normals[..., ::-1]))
    if not done:
        raise SurfaceError("normals.png: expected the picture to be packed, the PNG writer refused it")
    (folder / "normals.png").write_bytes(packed.tobytes())
    Image.fromarray(albedo_srgb(surface.albedo)).save(folder / "albedo.png")
    Image.fromarray(np.round(surface.confidence * 255).astype(np.uint8)).save(folder / "confidence.png")
    Image.fromarray(surface.mask.astype(np.uint8) * 255).save(folder / "mask.png")
    return scale, offset


def _read_pictures(folder: Path, metadata: Mapping[str, Any]) -> dict[str, FloatArray]:
    """What `_write_pictures` wrote, as floats again."""
    try:
        scale, offset = (float(metadata["height_png"][name]) for name in ("scale", "offset"))
    except (KeyError, TypeError, ValueError) as error:
        raise SurfaceError(f"{folder / MARKER}: expected the scale and offset of height.png") from error
    normals = (
        _read_png(folder / "normals.png", kind="uint16", channels=3)[..., ::-1] / np.float32(32767.5) - 1
    )
    lengths = np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), np.float32(1e-6))
    albedo = _read_png(folder / "albedo.png", kind="uint8", channels=3)[..., ::-1]
    if (albedo == albedo[..., :1]).all():  # of a gray picture
        albedo = albedo[..., 0]
    table = to_linear(np.arange(256, dtype=np.float32) / np.float32(255))
    height = _read_png(folder / "height.png", kind="uint16", channels=1)
    confidence = _read_png(folder / "confidence.png", kind="uint8", channels=1)
    return {
        "height": (height * scale + offset).astype(np.float32),
        "normals": np.asarray(normals / lengths, dtype=np.float32),
        "albedo": table[albedo],
        "confidence": confidence / np.float32(255),
    }


def _read_png(path: Path, *, kind: str, channels: int) -> npt.NDArray[Any]:
    """(H, W) or (H, W, 3) B G R. Raises SurfaceError unless the samples are as they are expected."""
    import cv2

    if not path.is_file():
        raise SurfaceError(f"{path}: expected a file of the surface, there is none")
    samples = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if samples is None or samples.dtype.name != kind or samples[0, 0].size != channels:
        raise SurfaceError(f"{path}: expected a PNG of {kind} with {channels} channels, it is none")
    return np.asarray(samples)


def _read_tiff(path: Path) -> FloatArray:
    import tifffile

    if not path.is_file():
        raise SurfaceError(f"{path}: expected a file of the surface, there is none")
    try:
        array = np.asarray(tifffile.imread(path))
    except Exception as error:  # a damaged TIFF fails in as many ways as it has fields
        raise SurfaceError(f"{path}: expected a float32 TIFF, it cannot be read ({error})") from error
    if array.dtype != np.float32 or not np.isfinite(array).all():
        raise SurfaceError(f"{path}: expected finite float32 values, got {array.dtype} or NaN")
    return array


def _read_mask(path: Path) -> npt.NDArray[np.bool_]:
    from PIL import Image

    if not path.is_file():
        raise SurfaceError(f"{path}: expected a file of the surface, there is none")
    try:
        with Image.open(path) as picture:
            return np.asarray(picture.convert("L")) > 127
    except (OSError, SyntaxError, ValueError) as error:
        raise SurfaceError(f"{path}: expected a PNG, it cannot be read ({error})") from error


def _read_metadata(folder: Path) -> dict[str, Any]:
    path = folder / MARKER
    if not path.is_file():
        raise SurfaceError(f"{path}: expected a surface folder with this file, there is none")
    metadata = read_json(path, error_type=SurfaceError)
    if not isinstance(metadata, dict) or metadata.get("kind") != _KIND:
        raise SurfaceError(f'{path}: expected "kind": "{_KIND}", got something else')
    return metadata
