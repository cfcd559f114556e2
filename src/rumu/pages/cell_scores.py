"""How well a printed cell of a given size fits at each place of a page."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rumu.pages.line_evidence import Evidence, LineEvidence, Map, sum_of_moved
from rumu.values import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class CellSettings:
    """How cells are looked for; lengths are shares of the pitch of the lines.

    tolerance: by which an edge may lie beside its place; beside: what it counts then. slopes: an edge may
        lean by these. samples: pieces of an edge that are looked at. covered: the part of an edge that they
        cover.
    widths, heights: sizes tried. steps: places tried along a pitch.
    least: weight of the weakest edge against the mean of the four. square: natural logarithm of height over
        width at which a cell of any other shape is taken rather.
    """

    tolerance: float = 0.02
    beside: float = 0.93
    slopes: tuple[float, ...] = (-0.105, -0.07, -0.035, 0.0, 0.035, 0.07, 0.105)
    samples: int = 17
    covered: float = 0.9
    widths: tuple[float, ...] = (0.72, 0.76, 0.8, 0.84, 0.88, 0.92, 0.96, 1.0)
    heights: tuple[float, ...] = tuple(0.72 + 0.04 * k for k in range(18))
    steps: int = 28
    least: float = 0.6
    square: float = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class EdgeMaps:
    """Evidence for the edges of a cell.

    across, down: (h, w), at every `stride` pixels: for an edge of a cell's length centred there, along x and
        y.
    """

    across: Evidence
    down: Evidence
    stride: int
    pitch: float

    def in_levels(self) -> tuple[EdgeMaps, float]:
        """The same in whole numbers of two bytes, which are compared faster, and how many levels 1 has."""
        most = max(float(self.across.max(initial=0)), float(self.down.max(initial=0)), 1e-6)
        level = 60_000 / most
        across, down = (
            np.rint(one * np.float32(level)).astype(np.uint16) for one in (self.across, self.down)
        )
        return replace(self, across=across, down=down), level


def map_edges(
    evidence: LineEvidence,
    pitch: float,
    *,
    reduction: int,
    enough: float,
    settings: CellSettings | None = None,
) -> EdgeMaps:
    """Evidence for edges of cells of this pitch."""
    settings = settings or CellSettings()
    stride = int(np.clip(round(pitch / settings.steps), 1, 8))
    turned = np.ascontiguousarray(evidence.down.T)
    across, down = (
        _edge_map(one, pitch, stride, reduction=reduction, enough=enough, settings=settings)
        for one in (evidence.across, turned)
    )
    down = down.T
    height, width = (min(a, b) for a, b in zip(across.shape, down.shape, strict=True))
    cut = slice(height), slice(width)
    return EdgeMaps(np.ascontiguousarray(across[cut]), np.ascontiguousarray(down[cut]), stride, pitch)


def _edge_map(
    response: Map, pitch: float, stride: int, *, reduction: int, enough: float, settings: CellSettings
) -> Map:
    import cv2

    count = min(settings.samples, max(5, int(pitch / reduction) | 1))
    along = (np.arange(count) - count // 2) / (count - 1) * settings.covered * pitch
    level = 65535 // count / enough  # whole numbers of two bytes are added in half the time
    response = np.rint(np.clip(response, 0, enough) * np.float32(level)).astype(np.uint16)
    best = np.zeros_like(response)
    # short edges that lean a little lie on the same pixels
    leaning = {tuple((round(slope * x), round(x / reduction)) for x in along) for slope in settings.slopes}
    for steps in leaning:
        np.maximum(best, sum_of_moved(response, steps), out=best)
    reach = 2 * int(np.ceil(settings.tolerance * pitch)) + (stride | 1)
    near, best = (
        one[stride // 2 :: stride].astype(np.float32)
        for one in (cv2.dilate(best, np.ones((reach, 1), np.uint8)), best)
    )
    found = settings.beside * near + (1 - settings.beside) * best
    size = -(-found.shape[1] * reduction // stride), found.shape[0]
    return np.asarray(cv2.resize(found, size, interpolation=cv2.INTER_LINEAR) / np.float32(level * count))


@dataclass(frozen=True, slots=True, eq=False)
class EdgePair:
    """Two opposite edges of a cell that is centred at each place, (h, w) each.

    mean: half of their mean, as it is weighed. weakest: the weaker one, likewise.
    """

    mean: Evidence
    weakest: Evidence


def opposite_edges(
    edges: EdgeMaps, size: float, *, along: Literal["x", "y"], settings: CellSettings | None = None
) -> EdgePair:
    """The left and right edges of cells of this width in pixels, or the upper and lower of this height."""
    import cv2

    settings = settings or CellSettings()
    step = round(size / 2 / edges.stride)
    values = edges.down if along == "x" else edges.across
    first, second = (sum_of_moved(values, [(0, one) if along == "x" else (one, 0)]) for one in (-step, step))
    share = (1 - settings.least) / 4
    weaker = cv2.min(first, second)
    return EdgePair(
        np.asarray(cv2.addWeighted(first, share, second, share, 0)),
        np.asarray(cv2.addWeighted(weaker, settings.least, weaker, 0, 0)),
    )


def fit_of_pairs(sides: EdgePair, ends: EdgePair) -> Evidence:
    """(h, w): how well a cell with these edges is drawn: their mean and the weakest."""
    import cv2

    weakest = cv2.min(sides.weakest, ends.weakest)
    return np.asarray(cv2.add(cv2.add(sides.mean, ends.mean), weakest))


def fit_at(edges: EdgeMaps, cells: FloatArray, *, settings: CellSettings | None = None) -> FloatArray:
    """(...,) the same at given cells, (..., 4): centre x and y, width and height in pixels."""
    settings = settings or CellSettings()
    four = edges_at(edges, cells)
    return np.asarray(settings.least * four.min(axis=-1) + (1 - settings.least) * four.mean(axis=-1))


def edges_at(edges: EdgeMaps, cells: FloatArray) -> FloatArray:
    """(..., 4) evidence for the left, right, top and bottom edge of cells (..., 4)."""
    x, y, half_width, half_height = (cells[..., k] * (0.5 if k > 1 else 1) for k in range(4))
    return np.stack(
        [
            _sampled(edges.down, x - half_width, y, edges.stride),
            _sampled(edges.down, x + half_width, y, edges.stride),
            _sampled(edges.across, x, y - half_height, edges.stride),
            _sampled(edges.across, x, y + half_height, edges.stride),
        ],
        axis=-1,
    )


def _sampled(values: Evidence, x: FloatArray, y: FloatArray, stride: int) -> FloatArray:
    column, row = _index(x, stride), _index(y, stride)
    inside = (column >= 0) & (row >= 0) & (column < values.shape[1]) & (row < values.shape[0])
    found = values[np.clip(row, 0, values.shape[0] - 1), np.clip(column, 0, values.shape[1] - 1)]
    return np.where(inside, found, 0.0)


def _index(at: FloatArray, stride: int) -> IntArray:
    return np.floor(at / stride).astype(np.int64)
