"""A surface as a folder that other programs can read, and back.

    surface.json      unit, spacing, source, quality, version, scale of height.png
    height.tif        float32, in the unit; height.png is 16-bit: height = value * scale + offset
    normals.tif       float32 x, y, z; normals.png is 16-bit RGB: n = value / 32767.5 - 1, y up (OpenGL)
    albedo.tif        float32, linear; albedo.png is 8-bit sRGB
    confidence.tif    float32; confidence.png is 8-bit
    mask.png          white where measured (photometric) or inked (relief)
    surface.glb       the mesh, textured by the albedo

Reading takes the float files, so a surface comes back as it was.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import OutputError, SurfaceError
from rumu.outputs import whole_folder
from rumu.surface.mesh import albedo_srgb, mesh_bytes
from rumu.values import FloatArray, Surface

MARKER = "surface.json"
_KIND = "rumu surface"
_ARRAYS = ("height", "normals", "albedo", "confidence")


def write_surface(
    surface: Surface, folder: str | Path, *, extra: Mapping[str, str | bytes] | None = None
) -> None:
    """Write a surface as a folder; it appears whole or not at all.

    folder: new, empty, or an earlier surface, which is replaced. extra: more files of the folder, text or
    bytes by name, such as a report.
    Raises OutputError when the place cannot be written or holds other things, SurfaceError when there is
    nothing to make a mesh of or an extra name is not a plain new name.
    """
    for name in extra or {}:
        if Path(name).name != name or name in _names():
            raise SurfaceError(f"expected a plain file name that is not of the surface's own, got {name!r}")
    glb = mesh_bytes(surface)
    with whole_folder(folder, marker=MARKER) as part:
        try:
            _write_pieces(surface, part, {"surface.glb": glb, **(extra or {})})
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from error


def _write_pieces(surface: Surface, place: Path, files: Mapping[str, str | bytes]) -> None:
    for name in _ARRAYS:
        _write_tiff(place / f"{name}.tif", getattr(surface, name))
    scale, offset = _write_pictures(surface, place)
    for name, content in files.items():
        (place / name).write_bytes(content.encode() if isinstance(content, str) else content)
    facts = _facts(surface) | {"height_png": {"scale": scale, "offset": offset}}
    (place / MARKER).write_text(json.dumps(facts, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def read_surface(folder: str | Path) -> Surface:
    """Read a folder that `write_surface` wrote.

    Raises SurfaceError naming the file that is missing or damaged.
    """
    place = Path(folder)
    facts = _read_facts(place)
    arrays = {name: _read_tiff(place / f"{name}.tif") for name in _ARRAYS}
    mask = _read_mask(place / "mask.png")
    shape = arrays["height"].shape
    wanted = {"normals": [(*shape, 3)], "albedo": [shape, (*shape, 3)], "confidence": [shape]}
    for name, shapes in wanted.items():
        if arrays[name].shape not in shapes:
            raise SurfaceError(f"{place / name}.tif: expected shape {shapes[0]}, got {arrays[name].shape}")
    if mask.shape != shape:
        raise SurfaceError(f"{place / 'mask.png'}: expected shape {shape}, got {mask.shape}")
    try:
        return Surface(
            height=arrays["height"],
            normals_from=arrays["normals"],
            albedo_from=arrays["albedo"],
            confidence=arrays["confidence"],
            mask=mask,
            spacing=float(facts["spacing"]),
            unit=facts["unit"],
            source=facts["source"],
            quality={str(name): float(value) for name, value in facts["quality"].items()},
        )
    except KeyError as error:
        raise SurfaceError(f"{place / MARKER}: expected an entry {error.args[0]!r}, found none") from error
    except (TypeError, ValueError, AttributeError, SurfaceError) as error:
        raise SurfaceError(f"{place / MARKER}: does not describe a surface: {error}") from error


def _names() -> set[str]:
    pictures = {f"{name}.png" for name in (*_ARRAYS, "mask")}
    return {f"{name}.tif" for name in _ARRAYS} | pictures | {MARKER, "surface.glb"}


def _facts(surface: Surface) -> dict[str, Any]:
    h, w = surface.height.shape
    return {
        "kind": _KIND,
        "version": version("rumu"),
        "source": surface.source,
        "unit": surface.unit,
        "spacing": surface.spacing,
        "width": w,
        "height": h,
        "quality": {name: float(value) for name, value in surface.quality.items()},
        "frame": "x right, y up, z to the camera; rows run downward",
    }


def _write_pictures(surface: Surface, place: Path) -> tuple[float, float]:
    """The files to look at; returns scale and offset of height.png."""
    import cv2
    from PIL import Image

    offset = float(surface.height.min())
    scale = max(float(surface.height.max()) - offset, 1e-12) / 65535.0
    height = np.round((surface.height.astype(np.float64) - offset) / scale).clip(0, 65535).astype(np.uint16)
    Image.fromarray(height).save(place / "height.png")
    normals = np.round((surface.normals.astype(np.float64) + 1.0) * 32767.5).clip(0, 65535).astype(np.uint16)
    # Pillow cannot write 16 bits for each of three channels; OpenCV wants them in the order B, G, R.
    done, packed = cv2.imencode(".png", np.ascontiguousarray(normals[..., ::-1]))
    if not done:
        raise SurfaceError("normals.png: expected the picture to be packed, the PNG writer refused it")
    (place / "normals.png").write_bytes(packed.tobytes())
    Image.fromarray(albedo_srgb(surface.albedo)).save(place / "albedo.png")
    Image.fromarray(np.round(surface.confidence * 255).astype(np.uint8)).save(place / "confidence.png")
    Image.fromarray(surface.mask.astype(np.uint8) * 255).save(place / "mask.png")
    return scale, offset


def _write_tiff(path: Path, array: FloatArray) -> None:
    import tifffile

    colour = array.ndim == 3
    tifffile.imwrite(path, array.astype(np.float32), photometric="rgb" if colour else "minisblack")


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


def _read_facts(place: Path) -> dict[str, Any]:
    path = place / MARKER
    if not path.is_file():
        raise SurfaceError(f"{path}: expected a surface folder with this file, there is none")
    try:
        facts = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SurfaceError(f"{path}: expected JSON, it cannot be read ({error})") from error
    if not isinstance(facts, dict) or facts.get("kind") != _KIND:
        raise SurfaceError(f'{path}: expected "kind": "{_KIND}", got something else')
    return facts
