"""What lies beside the lattices that were found: room for further cells, and the evidence for their lines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rumu.pages.cell_lattice import Lattice
from rumu.pages.line_evidence import LineEvidence, PrintedLineSettings
from rumu.values import FloatArray

_CELL = 12  # pixels of a cell where room for more of them is looked for


def has_room_beside(lattices: list[Lattice], shape: tuple[int, ...], *, count: int, smaller: float) -> bool:
    """Whether so many cells have room around the boxes of lattices in a picture of this shape.

    smaller: the factor by which they may be smaller than those of the first lattice.
    """
    import cv2

    cells = np.array(list(lattices[0].cells.values()))
    width, height = np.median(cells[:, 2:], axis=0) / smaller
    free = np.full(shape, 255, np.uint8)
    for x0, y0, x1, y1 in map(_box_around, lattices):
        free[y0:y1, x0:x1] = 0
    scale = min(1.0, _CELL / min(width, height))
    free = cv2.resize(free, None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
    sides = [max(1, int(scale * side)) for side in (width, height)]
    room = cv2.morphologyEx(
        free, cv2.MORPH_OPEN, np.ones(sides[::-1], np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    return bool(np.count_nonzero(room) >= count * sides[0] * sides[1])


def evidence_beside(
    evidence: LineEvidence, lattices: list[Lattice], lines: PrintedLineSettings
) -> LineEvidence:
    """The evidence for lines without that in the boxes around lattices."""
    across, down, step = evidence.across.copy(), evidence.down.copy(), lines.reduction
    for x0, y0, x1, y1 in map(_box_around, lattices):
        across[y0:y1, x0 // step : x1 // step] = 0
        down[y0 // step : y1 // step, x0:x1] = 0
    return replace(evidence, across=across, down=down, frames=_outside(evidence.frames, lattices))


def _outside(frames: FloatArray, lattices: list[Lattice]) -> FloatArray:
    """Those of the frames (N, 4) that lie in none of the boxes around lattices."""
    x, y = frames[:, :2].T
    outside = np.ones(len(frames), bool)
    for x0, y0, x1, y1 in map(_box_around, lattices):
        outside &= (x < x0) | (x > x1) | (y < y0) | (y > y1)
    return frames[outside]


def _box_around(lattice: Lattice) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the cells of a lattice and half a cell around them."""
    cells = np.array(list(lattice.cells.values()))
    low, high = cells[:, :2] - cells[:, 2:], cells[:, :2] + cells[:, 2:]
    (x0, y0), (x1, y1) = low.min(axis=0).clip(0).astype(int), high.max(axis=0).clip(0).astype(int)
    return x0, y0, x1, y1
