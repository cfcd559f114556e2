"""Cells that stand apart on all sides: each frame is seen by itself, and says where its cell lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.cell_lattice import Lattice, Place
from rumu.pages.cell_scores import EdgeMaps, fit_at
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class FramedCellSettings:
    """Which frames are neighbours; lengths are shares of a frame.

    farthest: from the middle of a frame to that of the next at most. aside: by how much it may lie beside the
    row or column. on: so near to a frame a cell is that of the frame.
    """

    farthest: float = 2.0
    aside: float = 0.3
    on: float = 0.3


def join_frames(
    frames: FloatArray, edges: EdgeMaps, *, settings: FramedCellSettings | None = None
) -> list[Lattice]:
    """The lattices that frames (N, 4) make up, those of most cells first."""
    settings = settings or FramedCellSettings()
    size = np.median(frames[:, 2:], axis=0)
    fits = fit_at(edges, frames)
    free, lattices = set(range(len(frames))), []
    while free:
        first = min(free)
        free.discard(first)
        places: dict[Place, int] = {(0, 0): first}
        waiting: list[Place] = [(0, 0)]
        while waiting:
            place = waiting.pop()
            for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                beside = place[0] + step[0], place[1] + step[1]
                found = _next_frame(frames, places[place], step, size, settings)
                if beside not in places and found in free:
                    free.discard(found)
                    places[beside] = found
                    waiting.append(beside)
        lattices.append(
            Lattice(
                {place: frames[k] for place, k in places.items()},
                {place: float(fits[k]) for place, k in places.items()},
            )
        )
    return sorted(lattices, key=lambda one: -len(one.cells))


def corners_on_frames(
    quads: FloatArray, frames: FloatArray, *, settings: FramedCellSettings | None = None
) -> FloatArray:
    """Cells (N, 4, 2), those that are seen as frames with the corners of these."""
    settings = settings or FramedCellSettings()
    if not len(frames):
        return quads
    placed = quads.copy()
    for k, centre in enumerate(quads.mean(axis=1)):
        off = np.abs(frames[:, :2] - centre) / frames[:, 2:]
        nearest = int(off.max(axis=1).argmin())
        if off[nearest].max() < settings.on:
            x, y, width, height = frames[nearest]
            half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (width / 2, height / 2)
            placed[k] = half + np.array([x, y])
    return placed


def _next_frame(
    frames: FloatArray, start: int, step: Place, size: FloatArray, settings: FramedCellSettings
) -> int | None:
    """The nearest frame in a direction, row and column, from another."""
    off = (frames[:, :2] - frames[start, :2]) / size
    along, across = (off[:, 0], off[:, 1]) if step[1] else (off[:, 1], off[:, 0])
    along = along * (step[0] + step[1])
    there = (along > 0.5) & (along <= settings.farthest) & (np.abs(across) <= settings.aside)
    return int(np.where(there, along, np.inf).argmin()) if there.any() else None
