"""A surface in a folder that is read some rows at a time: of a large one the whole takes gigabytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from rumu.errors import SurfaceError
from rumu.surface.array_files import ARRAYS, tiff_bands
from rumu.surface.folder import MARKER, read_mask, read_metadata, read_surface, surface_of
from rumu.surface.reduction import SHOWN
from rumu.values import BoolArray, FloatArray, Surface


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


def _means(bands: Callable[[], Iterator[FloatArray | BoolArray]], step: int) -> FloatArray:
    """Means over squares of `step` pixels of rows that come from the top; at the edges of what is left."""
    found: list[FloatArray] = []
    waiting: FloatArray | BoolArray | None = None
    for band in bands():
        waiting = band if waiting is None or not len(waiting) else np.concatenate([waiting, band])
        whole = len(waiting) // step * step
        if whole:
            found.append(_squares(waiting[:whole], step))
            waiting = waiting[whole:]
    if waiting is not None and len(waiting):
        found.append(_squares(waiting, step))
    return np.concatenate(found)


def _squares(rows: FloatArray | BoolArray, step: int) -> FloatArray:
    """The means of some rows; what lacks to whole squares is filled with the last row and column."""
    lacking = [(0, -side % step) for side in rows.shape[:2]] + [(0, 0)] * (rows.ndim - 2)
    filled = np.pad(rows, lacking, mode="edge") if any(more for _, more in lacking) else rows
    h, w = (side // step for side in filled.shape[:2])
    parts = filled.reshape(h, step, w, step, *rows.shape[2:])
    return np.asarray(parts.mean(axis=(1, 3), dtype=np.float32))
