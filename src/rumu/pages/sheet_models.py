"""How a master is printed in a cell: filled, hollow or dotted, as outlines that are sharp at any size."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError
from rumu.values import BoolArray, FloatArray

DOT_STEP = 0.045  # between the middles of dots, as a share of the cell
DOT_RADIUS = 0.011
_SHORTEST = 0.02  # of an outline, across, as a share of the cell: what is smaller is a speck
_TOLERANCE = 0.0008  # by which an outline may be simplified, likewise


@dataclass(frozen=True)
class MasterShape:
    """A master's writing in its cell.

    ink: (n, n) float32, 1 on ink, 0 on paper; the whole is the cell. in_strokes: whether it is written in the
    strokes of copybooks, so that their order is its own.
    """

    ink: npt.NDArray[np.float32]
    in_strokes: bool = True

    def __post_init__(self) -> None:
        if self.ink.ndim != 2 or self.ink.shape[0] != self.ink.shape[1] or not (self.ink > 0.5).any():
            raise ImageError(f"expected a square picture with ink on it, got {self.ink.shape}")

    @cached_property
    def outlines(self) -> tuple[FloatArray, ...]:
        """Closed outlines, (k, 2) each, x and y as shares of the cell; what two enclose is paper."""
        from skimage.measure import approximate_polygon, find_contours

        found = find_contours(np.pad(self.ink, 1), 0.5)
        outlines = [(line[:, ::-1] - 0.5) / len(self.ink) for line in found]
        return tuple(
            approximate_polygon(line, _TOLERANCE)
            for line in outlines
            if float(np.ptp(line, axis=0).max()) > _SHORTEST
        )

    @cached_property
    def dots(self) -> FloatArray:
        """(k, 2): places along the middle of the strokes, evenly apart, x and y as shares of the cell."""
        from skimage.morphology import skeletonize

        rows, columns = np.nonzero(skeletonize(self._mask))
        places = (np.column_stack([columns, rows]) + 0.5) / len(self.ink)
        kept: list[FloatArray] = []
        for place in places[np.lexsort((places[:, 0], places[:, 1]))]:
            if not kept or np.hypot(*(np.array(kept) - place).T).min() >= DOT_STEP:
                kept.append(place)
        return np.array(kept)

    @property
    def _mask(self) -> BoolArray:
        return np.asarray(self.ink > 0.5)

    def filled(self, side: int) -> npt.NDArray[np.float32]:
        """(side, side): how much of each pixel the filled model covers."""
        import cv2

        size = cv2.INTER_AREA if side < len(self.ink) else cv2.INTER_LINEAR
        return np.asarray(cv2.resize(self.ink, (side, side), interpolation=size), np.float32)
