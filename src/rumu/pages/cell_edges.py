"""The edges of the cells of a lattice, to less than a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.cell_lattice import Lattice
from rumu.pages.lattice_model import LatticeModel, bends, fit_axis
from rumu.pages.line_evidence import LineEvidence, Map
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class CellEdgeSettings:
    """How edges are placed; lengths are shares of a cell's side.

    reach: how far beside its place an edge is looked for. along: the middle part of it that is looked at.
    samples: places along it. seen: least response of an edge that is seen, as a share of one that is told
        without doubt. strayed: one that lies farther beside the edges in its row or column is put with them.
    """

    reach: float = 0.09
    along: float = 0.8
    samples: int = 17
    seen: float = 0.25
    strayed: float = 0.025


def place_edges(
    evidence: LineEvidence,
    lattice: Lattice,
    model: LatticeModel,
    *,
    reduction: int,
    enough: float,
    settings: CellEdgeSettings | None = None,
) -> FloatArray:
    """(N, 4, 2) corners of the cells from the top left clockwise, in the order of the lattice."""
    settings = settings or CellEdgeSettings()
    places = np.array(list(lattice.cells))
    cells = np.array(list(lattice.cells.values()))
    ways = [model.directions(place) for place in lattice.cells]
    along_row, along_column = (np.array([way[k] for way in ways]) for k in (0, 1))
    down, across = (
        evidence.down.T,
        evidence.across,
    )  # both (position across the line, place along it / reduction)
    edges = []
    for line, axis, side in ((down, 0, -1), (down, 0, 1), (across, 1, -1), (across, 1, 1)):
        way = along_column if axis == 0 else along_row
        found, strength = _look_for_edge(
            line, cells, way=way, axis=axis, side=side, reduction=reduction, settings=settings
        )
        strength = np.minimum(strength, enough) / enough
        numbers = places[:, ::-1] if axis == 0 else places
        size = float(np.median(cells[:, 2 + axis]))
        lines, bend = fit_axis(
            numbers, found, np.median(numbers, axis=0), size, np.sqrt(np.maximum(strength, 0.02))
        )
        expected = _on_lines(numbers, lines, bend, np.median(numbers, axis=0))
        visible = strength >= settings.seen
        off = found - expected
        beside = _beside(places, off, visible, 1 - axis)
        near = np.abs(off - beside) <= settings.strayed * size
        expected = expected + beside
        edges.append(np.where(visible & near, found, expected))
    left, right, top, bottom = edges
    centre = np.stack([(left + right) / 2, (top + bottom) / 2], axis=1)
    half_row = along_row * ((right - left) / 2 / along_row[:, 0])[:, None]
    half_column = along_column * ((bottom - top) / 2 / along_column[:, 1])[:, None]
    return np.stack(
        [
            centre - half_row - half_column,
            centre + half_row - half_column,
            centre + half_row + half_column,
            centre - half_row + half_column,
        ],
        axis=1,
    )


def _beside(places: FloatArray, off: FloatArray, visible: BoolArray, axis: int) -> FloatArray:
    """(N,) by how much the same edges of the next two cells on each side, along a row or column, lie off."""
    known = {(int(r), int(c)): k for k, (r, c) in enumerate(places)}
    beside = np.zeros(len(places))
    for k, place in enumerate(places):
        near = []
        for step in (-2, -1, 1, 2):
            other = known.get((int(place[0] + step * (axis == 0)), int(place[1] + step * (axis == 1))))
            if other is not None and visible[other]:
                near.append(off[other])
        beside[k] = np.median(near) if near else 0.0
    return beside


def _look_for_edge(
    line: Map,
    cells: FloatArray,
    *,
    way: FloatArray,
    axis: int,
    side: int,
    reduction: int,
    settings: CellEdgeSettings,
) -> tuple[FloatArray, FloatArray]:
    """(N,) where an edge of each cell is in its middle, along x (axis 0) or y (1), and how strong."""
    size, other = cells[:, 2 + axis], cells[:, 3 - axis]
    middle = cells[:, axis] + side * size / 2
    reach = max(2, round(settings.reach * float(np.median(size))))
    offsets = np.arange(-reach, reach + 1)
    along = np.linspace(-settings.along / 2, settings.along / 2, settings.samples)
    step = along[None] * other[:, None]  # (N, samples), along the edge
    across = middle[:, None] + step * (way[:, axis] / way[:, 1 - axis])[:, None]
    at = np.round(across[:, None, :] + offsets[None, :, None]).astype(int)
    beside = np.floor((cells[:, 1 - axis][:, None] + step) / reduction).astype(int)[:, None, :]
    inside = (at >= 0) & (at < line.shape[0]) & (beside >= 0) & (beside < line.shape[1])
    values = line[np.clip(at, 0, line.shape[0] - 1), np.clip(beside, 0, line.shape[1] - 1)]
    profile = np.where(inside, values, 0).mean(axis=2)
    best = profile.argmax(axis=1)
    rows = np.arange(len(cells))
    around = np.clip(best[:, None] + np.arange(-2, 3)[None], 0, len(offsets) - 1)
    weights = profile[rows[:, None], around] + 1e-9
    offset = (weights * offsets[around]).sum(axis=1) / weights.sum(axis=1)
    return middle + offset + 0.5, profile[rows, best]


def _on_lines(
    numbers: FloatArray, lines: dict[int, float], bend: FloatArray, middle: FloatArray
) -> FloatArray:
    place = (numbers - middle) / 10
    terms = np.array([bends(along, across)[: len(bend)] for across, along in place]).reshape(len(numbers), -1)
    return np.array([lines[int(number)] for number in numbers[:, 0]]) + terms @ bend
