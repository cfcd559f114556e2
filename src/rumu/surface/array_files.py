"""The arrays of a surface as files: tiled TIFFs of 32-bit floats, and PNGs to look at.

Everything is converted some rows at a time, and compressed for speed: the noise of a measurement is made no
smaller by any setting.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.image import to_linear
from rumu.capture.stored import to_srgb
from rumu.errors import SurfaceError
from rumu.surface.png_files import write_png_bands
from rumu.values import FloatArray, Surface

ARRAYS = ("height", "normals", "albedo", "confidence")
"""The arrays of a surface that are written; each has a .tif and a .png."""
GREEN_DOWN = "normals-green-down"
"""Of normals whose green runs downward, as DirectX takes them."""

_TILE = 256  # pixels of a side of a tile in a TIFF
_BUFFER = 2**24  # bytes of a compressed TIFF that are read at once
_LEVELS = 65535


# --- TIFFs of floats -------------------------------------------------------------------------------


def write_tiff(path: Path, array: FloatArray) -> None:
    """Write (H, W) or (H, W, 3) as a tiled TIFF of 32-bit floats, compressed losslessly (deflate)."""
    import tifffile

    tiffed = array.astype(np.float32, copy=False)
    tifffile.imwrite(
        path,
        _packed_tiles(tiffed),
        shape=tiffed.shape,
        dtype=np.float32,
        photometric="rgb" if array.ndim == 3 else "minisblack",
        tile=(_TILE, _TILE),
        compression="zlib",
    )


def _packed_tiles(array: FloatArray) -> Iterator[bytes]:
    """The tiles of an array, row by row, each compressed; what lies beyond its edge is 0."""
    rows, columns = (range(0, side, _TILE) for side in array.shape[:2])

    def packed(corner: tuple[int, int]) -> bytes:
        top, left = corner
        part = array[top : top + _TILE, left : left + _TILE]
        if part.shape[:2] != (_TILE, _TILE):
            whole = np.zeros((_TILE, _TILE, *array.shape[2:]), np.float32)
            whole[: part.shape[0], : part.shape[1]] = part
            part = whole
        # Matches are not looked for: there are none in noise, and looking takes three times as long.
        packer = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_HUFFMAN_ONLY)
        return packer.compress(np.ascontiguousarray(part).data) + packer.flush()

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield from pool.map(packed, [(top, left) for top in rows for left in columns])


def read_tiff(path: Path) -> FloatArray:
    """The floats of a TIFF. Raises SurfaceError, naming the file, for any other one."""
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


def tiff_bands(path: Path) -> Iterator[FloatArray]:
    """The floats of a TIFF from its top, some rows at a time: (h, W) or (h, W, 3).

    Raises SurfaceError, naming the file, for any other one.
    """
    import tifffile

    if not path.is_file():
        raise SurfaceError(f"{path}: expected a file of the surface, there is none")
    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages.first
            shape = (*page.shape, 1)[:3]
            if page.dtype != np.float32 or page.ndim not in (2, 3):
                raise SurfaceError(f"{path}: expected a float32 TIFF, got {page.dtype} {page.shape}")
            step = page.tilelength if page.is_tiled else page.rowsperstrip
            band, top = np.zeros((step, *shape[1:]), np.float32), 0
            for values, at, size in page.segments(maxworkers=os.cpu_count(), buffersize=_BUFFER):
                row, column = at[2], at[3]
                if row != top:
                    yield _finite(path, band[: row - top].reshape(-1, *page.shape[1:]))
                    band, top = np.zeros_like(band), row
                if values is not None:
                    rows, columns = min(size[1], shape[0] - row), min(size[2], shape[1] - column)
                    band[:rows, column : column + columns] = values[0, :rows, :columns]
            yield _finite(path, band[: shape[0] - top].reshape(-1, *page.shape[1:]))
    except SurfaceError:
        raise
    except Exception as error:  # a damaged TIFF fails in as many ways as it has fields
        raise SurfaceError(f"{path}: expected a float32 TIFF, it cannot be read ({error})") from error


def _finite(path: Path, band: FloatArray) -> FloatArray:
    if not np.isfinite(band).all():
        raise SurfaceError(f"{path}: expected finite float32 values, got NaN")
    return band


# --- PNGs ------------------------------------------------------------------------------------------


def height_scale(surface: Surface) -> tuple[float, float]:
    """Scale and offset of height.png: height = value * scale + offset."""
    offset = float(surface.height.min())
    return max(float(surface.height.max()) - offset, 1e-12) / _LEVELS, offset


def write_png(path: Path, surface: Surface, name: str) -> None:
    """Write one of ARRAYS, GREEN_DOWN, or the mask, as a PNG to look at."""
    array = getattr(surface, "normals" if name == GREEN_DOWN else name)
    scale, offset = height_scale(surface) if name == "height" else (1.0, 0.0)
    table = _srgb_table() if name == "albedo" else None
    kind = np.uint16 if name in ("height", "normals", GREEN_DOWN) else np.uint8

    def levels(rows: slice) -> npt.NDArray[Any]:
        part = _levels(array[rows], name, scale=scale, offset=offset, table=table)
        return part.astype(kind, copy=False)

    write_png_bands(path, array.shape, kind, levels)


def _levels(
    part: npt.NDArray[Any], name: str, *, scale: float, offset: float, table: npt.NDArray[np.uint8] | None
) -> npt.NDArray[Any]:
    """Some rows of an array as the levels of its PNG."""
    if name == "mask":
        return part.astype(np.uint8) * 255
    if name == "height":
        return np.asarray(np.round((part.astype(np.float64) - offset) / scale).clip(0, _LEVELS))
    if name in ("normals", GREEN_DOWN):
        part = part * np.array([1, -1, 1], np.float32) if name == GREEN_DOWN else part
        return np.asarray(np.round((part + np.float32(1)) * np.float32(_LEVELS / 2)))
    if table is not None:
        linear = np.round(part * np.float32(_LEVELS)).clip(0, _LEVELS).astype(np.uint16)
        return np.asarray(table[linear])
    return np.asarray(np.round(part * 255))


def _srgb_table() -> npt.NDArray[np.uint8]:
    """(65536,) the sRGB level of linear light in 16 bits."""
    linear = np.arange(_LEVELS + 1) / _LEVELS
    return np.asarray(np.round(to_srgb(linear) * 255)).astype(np.uint8)


def read_pictures(folder: Path, metadata: Mapping[str, Any], names: frozenset[str]) -> dict[str, FloatArray]:
    """Those of ARRAYS that are named, as floats from the PNGs of a surface's folder."""
    read: dict[str, Callable[[], FloatArray]] = {
        "height": lambda: _read_height(folder, metadata),
        "normals": lambda: _read_normals(folder / "normals.png"),
        "albedo": lambda: _read_albedo(folder / "albedo.png"),
        "confidence": lambda: _read_png(folder / "confidence.png", "uint8", 1) / np.float32(255),
    }
    return {name: read[name]() for name in ARRAYS if name in names}


def _read_height(folder: Path, metadata: Mapping[str, Any]) -> FloatArray:
    try:
        scale, offset = (float(metadata["height_png"][name]) for name in ("scale", "offset"))
    except (KeyError, TypeError, ValueError) as error:
        raise SurfaceError(
            f"{folder / 'surface.json'}: expected the scale and offset of height.png"
        ) from error
    return (_read_png(folder / "height.png", "uint16", 1) * scale + offset).astype(np.float32)


def _read_normals(path: Path) -> FloatArray:
    normals = _read_png(path, "uint16", 3)[..., ::-1] / np.float32(_LEVELS / 2) - 1
    lengths = np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), np.float32(1e-6))
    return np.asarray(normals / lengths, dtype=np.float32)


def _read_albedo(path: Path) -> FloatArray:
    albedo = _read_png(path, "uint8", 1, 3)
    if albedo.ndim == 3:
        albedo = albedo[..., ::-1]
        if (albedo == albedo[..., :1]).all():  # of a gray picture
            albedo = albedo[..., 0]
    return np.asarray(to_linear(np.arange(256, dtype=np.float32) / np.float32(255))[albedo])


def read_gray_png(path: Path) -> npt.NDArray[Any]:
    """(H, W) uint8, such as a mask. Raises SurfaceError, naming the file, for any other."""
    samples = _read_png(path, "uint8", 1, 3)
    return samples if samples.ndim == 2 else np.asarray(samples[..., 1])


def _read_png(path: Path, kind: str, *channels: int) -> npt.NDArray[Any]:
    """(H, W) or (H, W, 3) B G R. Raises SurfaceError unless the samples are as they are expected."""
    import cv2

    if not path.is_file():
        raise SurfaceError(f"{path}: expected a file of the surface, there is none")
    data = np.fromfile(path, np.uint8)
    samples = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    if samples is None or samples.dtype.name != kind or samples[0, 0].size not in channels:
        wanted = " or ".join(str(count) for count in channels)
        raise SurfaceError(f"{path}: expected a PNG of {kind} with {wanted} channels, it is none")
    return np.asarray(samples)
