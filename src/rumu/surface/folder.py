"""A surface as a folder that other programs can read, and back.

    surface.json      unit, spacing, source, quality, version, scale of height.png, which files there are, and
                      of a reconstruction how it was made, see `rumu.surface.processing`
    height.tif        float32, in the unit; height.png is 16-bit: height = value * scale + offset
    normals.tif       float32 x, y, z; normals.png is 16-bit RGB: n = value / 32767.5 - 1, y up (OpenGL);
                      normals-green-down.png, when it is asked for, the same with y down (DirectX)
    albedo.tif        float32, linear; albedo.png is 8-bit sRGB
    confidence.tif    float32; confidence.png is 8-bit
    mask.png          white where measured (photometric) or inked (relief)
    surface.glb       the mesh, textured by the albedo

Reading takes the float files, so a surface comes back as it was. They may be left out, as they are of
surfaces that are computed from ink; reading then takes the pictures.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import OutputError, SurfaceError
from rumu.image_stack import Progress
from rumu.inputs import read_json
from rumu.outputs import whole_folder
from rumu.surface.array_files import (
    ARRAYS,
    GREEN_DOWN,
    height_scale,
    read_gray_png,
    read_pictures,
    read_tiff,
    write_png,
    write_tiff,
)
from rumu.surface.mesh_files import mesh_bytes
from rumu.surface.reduction import reduce_surface
from rumu.values import FloatArray, Surface

MARKER = "surface.json"
FLOATS = tuple(f"{name}.tif" for name in ARRAYS)
"""The files of 32-bit floats."""
PICTURES = (*(f"{name}.png" for name in ARRAYS), "mask.png")
"""The files to look at."""
MESH = "surface.glb"
FILES = (*FLOATS, *PICTURES, MESH)
"""All files of a surface besides the marker."""
ON_REQUEST = (f"{GREEN_DOWN}.png",)
"""Files that are written only when they are asked for by name."""
_KIND = "rumu surface"


@dataclass(frozen=True, slots=True)
class Processing:
    """How a surface was made.

    settings: of the command, by the names of its options. inputs: the SHA-256 of each file that was read,
    by its path. result: that of each array. version: of rumu. made: when, in UTC. made_by: who, None where
    nobody said. lamps: "from", what told them, and "directions", of each photograph by its name.
    photographs: what each says of itself (EXIF, IPTC), by its name; empty in records of earlier versions.
    """

    settings: Mapping[str, Any]
    inputs: Mapping[str, str]
    result: Mapping[str, str]
    version: str
    made: str
    made_by: str | None = None
    lamps: Mapping[str, Any] = field(default_factory=dict)
    photographs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def write_surface(
    surface: Surface,
    folder: str | Path,
    *,
    files: Collection[str] = FILES,
    extra: Mapping[str, str | bytes] | None = None,
    processing: Processing | None = None,
    shown: Surface | None = None,
    progress: Progress | None = None,
) -> None:
    """Write a surface as a folder; it appears whole or not at all.

    folder: new, empty, or an earlier surface, which is replaced. files: which of FILES and ON_REQUEST; the
    mask is always written. extra: more files of the folder, text or bytes by name, such as a report.
    processing: how the surface was made, for surface.json. shown: the surface as `reduce_surface` makes it,
    for the mesh, where it was needed before.
    Raises OutputError when the folder cannot be written or holds other files, SurfaceError when there is
    nothing to make a mesh of, a file is none of a surface, or an extra name is not a plain new name.
    """
    known = (*FILES, *ON_REQUEST)
    unknown = sorted(set(files) - set(known))
    if unknown:
        raise SurfaceError(f"expected files among {', '.join(known)}, got {', '.join(unknown)}")
    for name in extra or {}:
        if Path(name).name != name or name in (MARKER, *known):
            raise SurfaceError(f"expected a plain file name that is not of the surface's own, got {name!r}")
    glb = {MESH: mesh_bytes(shown or reduce_surface(surface))} if MESH in files else {}
    arrays = [name for name in known if name in {*files, "mask.png"} and name != MESH]
    with whole_folder(folder, marker=MARKER) as new:
        try:
            for name, content in {**glb, **(extra or {})}.items():
                (new / name).write_bytes(content.encode() if isinstance(content, str) else content)
            _write_arrays(surface, new, arrays, progress)
            metadata = _metadata(surface, [*arrays, *glb])
            if processing is not None:
                metadata["processing"] = asdict(processing)
            text = json.dumps(metadata, indent=2, ensure_ascii=False) + "\n"
            (new / MARKER).write_text(text, encoding="utf-8")
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from error


def _write_arrays(surface: Surface, folder: Path, names: list[str], progress: Progress | None) -> None:
    """Write some files one after the other; each is packed by several threads."""
    for done, name in enumerate(names, start=1):
        if name in FLOATS:
            write_tiff(folder / name, getattr(surface, Path(name).stem))
        else:
            write_png(folder / name, surface, Path(name).stem)
        if progress is not None:
            progress("Writing files", done, len(names))


def _metadata(surface: Surface, files: list[str]) -> dict[str, Any]:
    """What surface.json says."""
    scale, offset = height_scale(surface)
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
        "height_png": {"scale": scale, "offset": offset},
        "files": files,
    }


def read_surface(folder: str | Path) -> Surface:
    """Read a folder that `write_surface` wrote.

    Raises SurfaceError naming the file that is missing or damaged.
    """
    folder = Path(folder)
    metadata = read_metadata(folder)
    exact = _with_floats(metadata)
    arrays = {name: read_tiff(folder / f"{name}.tif") for name in ARRAYS if name in exact}
    arrays |= read_pictures(folder, metadata, frozenset(ARRAYS) - exact)
    shape = arrays["height"].shape
    wanted = {"normals": [(*shape, 3)], "albedo": [shape, (*shape, 3)], "confidence": [shape]}
    for name, shapes in wanted.items():
        if arrays[name].shape not in shapes:
            raise SurfaceError(f"{folder / name}.tif: expected shape {shapes[0]}, got {arrays[name].shape}")
    return surface_of(arrays, read_mask(folder / "mask.png", shape), metadata, folder=folder)


def surface_of(
    arrays: Mapping[str, FloatArray],
    mask: npt.NDArray[np.bool_],
    metadata: Mapping[str, Any],
    *,
    folder: Path,
) -> Surface:
    """The surface of ARRAYS and a mask, with what its description says; folder: of the description."""
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


def _with_floats(metadata: Mapping[str, Any]) -> frozenset[str]:
    """The arrays that have a file of floats; earlier versions wrote all or none of them."""
    files = metadata.get("files")
    if isinstance(files, list):
        return frozenset(name for name in ARRAYS if f"{name}.tif" in files)
    return frozenset(ARRAYS if metadata.get("floats", True) else ())


def read_mask(path: Path, shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """The mask of a surface of this shape (H, W). Raises SurfaceError, naming the file, for any other."""
    mask = read_gray_png(path) > 127
    if mask.shape != shape:
        raise SurfaceError(f"{path}: expected shape {shape}, got {mask.shape}")
    return np.asarray(mask)


def read_metadata(folder: Path) -> dict[str, Any]:
    """What the description of a surface's folder says. Raises SurfaceError when there is none."""
    path = folder / MARKER
    if not path.is_file():
        raise SurfaceError(f"{path}: expected a surface folder with this file, there is none")
    metadata = read_json(path, error_type=SurfaceError)
    if not isinstance(metadata, dict) or metadata.get("kind") != _KIND:
        raise SurfaceError(f'{path}: expected "kind": "{_KIND}", got something else')
    return metadata
