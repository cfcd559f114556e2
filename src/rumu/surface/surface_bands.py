"""A surface in a folder that is read some rows at a time: of a large one the whole takes gigabytes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from rumu.errors import SurfaceError
from rumu.surface.array_files import ARRAYS, tiff_bands
from rumu.surface.folder import MARKER, read_mask, read_metadata, read_surface, surface_of
from rumu.surface.reduction import SHOWN
from rumu.values import BoolArray, FloatArray, Surface

_ROWS = 256  # that are looked at at a time


class SurfaceBands:
    """A surface that `write_surface` wrote; an array without a file of floats is read whole.

    folder: where it lies. shape: (H, W). Raises SurfaceError, naming the file, where one is missing or
    damaged.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self._metadata = folder, read_metadata(folder)
        try:
            self.shape = (int(self._metadata["height"]), int(self._metadata["width"]))
        except (KeyError, TypeError, ValueError) as error:
            raise SurfaceError(f"{folder / MARKER}: expected width and height, found none") from error

    def rows(self, name: str) -> Iterator[FloatArray]:
        """One of ARRAYS from its top: (h, W) or (h, W, 3) float32."""
        path = self.folder / f"{name}.tif"
        if not path.is_file():  # as earlier versions wrote them
            yield getattr(read_surface(self.folder), name)
            return
        height, width = self.shape
        seen = 0
        for band in tiff_bands(path):
            if band.shape[1] != width:
                raise SurfaceError(f"{path}: expected a width of {width}, got {band.shape[1]}")
            seen += len(band)
            yield band
        if seen != height:
            raise SurfaceError(f"{path}: expected {height} rows, got {seen}")

    def check(self) -> None:
        """Read all of it once, some rows at a time.

        Raises SurfaceError where `read_surface` would.
        """
        if not all((self.folder / f"{name}.tif").is_file() for name in ARRAYS):
            read_surface(self.folder)
            return
        mask = read_mask(self.folder / "mask.png", self.shape)
        bands = [_in_steps(self.rows(name), _ROWS) for name in ARRAYS]
        for number, parts in enumerate(zip(*bands, strict=True)):
            part = mask[number * _ROWS : (number + 1) * _ROWS]
            surface_of(dict(zip(ARRAYS, parts, strict=True)), part, self._metadata, folder=self.folder)

    def height_range(self) -> tuple[float, float]:
        """The lowest and the highest value of the height."""
        ends = [(float(band.min()), float(band.max())) for band in self.rows("height")]
        return min(low for low, _ in ends), max(high for _, high in ends)

    def reduced(self, *, pixels: int = SHOWN) -> Surface:
        """The surface at about so many pixels or fewer, by means over squares of whole pixels.

        Normals keep unit length; a pixel is in the mask when half of what it shows was. The spacing grows as
        much as the pixels do.
        """
        step = int(np.ceil(np.sqrt(self.shape[0] * self.shape[1] / pixels)))
        arrays = {name: _means(lambda name=name: self.rows(name), step) for name in ARRAYS}  # type: ignore[misc]
        arrays["normals"] /= np.maximum(
            np.linalg.norm(arrays["normals"], axis=2, keepdims=True), np.float32(1e-6)
        )
        mask = read_mask(self.folder / "mask.png", self.shape)
        share = _means(lambda: iter([mask]), step)
        surface = surface_of(arrays, share >= 0.5, self._metadata, folder=self.folder)
        return replace(surface, spacing=surface.spacing * step)


def _in_steps(bands: Iterable[FloatArray | BoolArray], step: int) -> Iterator[FloatArray | BoolArray]:
    """Rows that come from the top, in parts of a whole number of `step` rows; the last holds what is left."""
    waiting: FloatArray | BoolArray | None = None
    for band in bands:
        waiting = band if waiting is None or not len(waiting) else np.concatenate([waiting, band])
        while len(waiting) >= step:
            yield waiting[:step]
            waiting = waiting[step:]
    if waiting is not None and len(waiting):
        yield waiting


def _means(bands: Callable[[], Iterator[FloatArray | BoolArray]], step: int) -> FloatArray:
    """Means over squares of `step` pixels of rows that come from the top; at the edges of what is left."""
    return np.concatenate([_squares(part, step) for part in _in_steps(bands(), step * max(1, _ROWS // step))])


def _squares(rows: FloatArray | BoolArray, step: int) -> FloatArray:
    """The means of some rows; what lacks to whole squares is filled with the last row and column."""
    lacking = [(0, -side % step) for side in rows.shape[:2]] + [(0, 0)] * (rows.ndim - 2)
    filled = np.pad(rows, lacking, mode="edge") if any(more for _, more in lacking) else rows
    h, w = (side // step for side in filled.shape[:2])
    parts = filled.reshape(h, step, w, step, *rows.shape[2:])
    return np.asarray(parts.mean(axis=(1, 3), dtype=np.float32))
