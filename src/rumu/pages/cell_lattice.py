"""Printed cells that belong together, each with its place in rows and columns: grown from cell to cell."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rumu.pages.cell_scores import CellSettings, EdgeMaps, fit_at, fit_of_pairs, opposite_edges
from rumu.pages.line_evidence import Evidence
from rumu.values import BoolArray, FloatArray

Place = tuple[int, int]
"""Row and column in a lattice."""
CellSize = tuple[float, float, float]
"""How well cells of a size fit, their width and height in pixels."""


@dataclass(frozen=True, slots=True)
class GrowthSettings:
    """How cells are joined; lengths are shares of a cell's width or height.

    seed, joined: least fit of a first cell and of one that joins: 0 is that of places between the lines, 1
        that of the best cells on the page.
    best: how many cells count as the best. near, far: the next cell begins here. aside: by how much it may
        lie beside the row or column. drift: by how much it may lie beside where its neighbours say.
    sizes: by which it may differ from its neighbour; largest: from the usual size of the page, either way.
        strayed: what a whole `drift` costs, as a share of the fit.
    apart: what a gap of a whole cell costs, likewise. overlap: share of a cell that others may cover.
    """

    seed: float = 0.4
    joined: float = 0.25
    best: int = 12
    near: float = 0.95
    far: float = 1.45
    aside: float = 0.12
    drift: float = 0.10
    sizes: tuple[float, ...] = (0.94, 0.97, 1.0, 1.03, 1.06)
    largest: float = 1.2
    strayed: float = 0.2
    apart: float = 0.5
    overlap: float = 0.15


@dataclass(slots=True)
class Lattice:
    """Cells (4,), centre x and y, width and height in pixels, and their fit, by row and column."""

    cells: dict[Place, FloatArray] = field(default_factory=dict)
    fits: dict[Place, float] = field(default_factory=dict)

    def add(self, place: Place, cell: FloatArray, fit: float) -> None:
        """Take a cell in."""
        self.cells[place], self.fits[place] = cell, fit


def best_sizes(edges: EdgeMaps, *, settings: CellSettings | None = None) -> list[CellSize]:
    """Mean fit of the best cells, width and height in pixels, best first, of the sizes tried."""
    return [
        (fits[0], width, height) for fits, width, height in fits_of_sizes(edges, (40,), settings=settings)
    ]


def fits_of_sizes(
    edges: EdgeMaps, counts: Sequence[int], *, settings: CellSettings | None = None
) -> list[tuple[tuple[float, ...], float, float]]:
    """The same with the mean fit of the best so many cells, for each of the counts; the first orders them."""
    settings = settings or CellSettings()
    edges, level = edges.in_levels()
    sides = [opposite_edges(edges, width * edges.pitch, along="x") for width in settings.widths]
    found = []
    for height in settings.heights:
        ends = opposite_edges(edges, height * edges.pitch, along="y")
        for width, side in zip(settings.widths, sides, strict=True):
            fits = fit_of_pairs(side, ends)
            squareness = 1 - (np.log(height / width) / settings.square) ** 2
            means = tuple(squareness * one / level for one in _means_of_peaks(fits, edges, counts))
            found.append((means, width * edges.pitch, height * edges.pitch))
    return sorted(found, reverse=True)


def smallest_fitting(sizes: list[CellSize], *, alike: float) -> CellSize:
    """The smallest of the `best_sizes` whose fit is at least this share of the best.

    Where cells stand apart, what reaches from the left side of one to that of the next fits as well as one.
    """
    return min((one for one in sizes if one[0] >= alike * sizes[0][0]), key=lambda one: one[1] * one[2])


def _means_of_peaks(fits: Evidence, edges: EdgeMaps, counts: Sequence[int]) -> list[float]:
    apart = max(3, round(0.6 * edges.pitch / edges.stride))
    rows = fits[: fits.shape[0] // apart * apart, : fits.shape[1] // apart * apart]
    if not rows.size:
        return [0.0] * len(counts)
    belts = rows.reshape(rows.shape[0] // apart, apart, -1).max(axis=1)
    blocks = belts.reshape(len(belts), -1, apart).max(axis=2).ravel()
    highest = np.sort(blocks)[::-1]
    return [float(highest[:count].mean()) for count in counts]


def grow_lattices(
    edges: EdgeMaps,
    size: tuple[float, float],
    *,
    strengths: EdgeMaps | None = None,
    settings: GrowthSettings | None = None,
) -> list[Lattice]:
    """The lattices of cells of about this width and height in pixels, those of most cells first.

    strengths: edges whose evidence is not capped: it begins where the edges are darkest, not on guides.
    """
    settings = settings or GrowthSettings()
    seeds, level = _seeds(edges, size, strengths or edges, settings)
    if not seeds:
        return []
    best = np.array([cell for cell, _ in seeds[: 4 * settings.best]])
    floor = min(0.5 * level, fit_between(edges, best))
    taken = np.zeros(edges.across.shape, bool)
    lattices = []
    for cell, fit in seeds:
        if fit < floor + settings.seed * (level - floor):
            continue
        if not _is_free(taken, cell, edges, settings):
            continue
        lattices.append(
            _grow(
                edges,
                cell,
                fit=fit,
                taken=taken,
                least=floor + settings.joined * (level - floor),
                size=size,
                settings=settings,
            )
        )
    return sorted(lattices, key=lambda one: -sum(one.fits.values()))


def fit_between(edges: EdgeMaps, cells: FloatArray, *, share: float = 0.25) -> float:
    """The usual fit of cells (N, 4) moved by this share of their size, so that they lie between the lines."""
    ways = ((share, 0), (-share, 0), (0, share), (0, -share))
    moved = [cells + np.array([x, y, 0, 0]) * cells[:, [2, 3, 2, 3]] for x, y in ways]
    return float(np.median([fit_at(edges, one) for one in moved]))


def _seeds(
    edges: EdgeMaps, size: tuple[float, float], strengths: EdgeMaps, settings: GrowthSettings
) -> tuple[list[tuple[FloatArray, float]], float]:
    import cv2

    width, height = size
    best, chosen = None, None
    sizes = [(width * a, height * b) for a in settings.sizes for b in settings.sizes]
    sides = [opposite_edges(strengths, width * a, along="x") for a in settings.sizes]
    ends = [opposite_edges(strengths, height * a, along="y") for a in settings.sizes]
    for k in range(len(sizes)):
        side, end = divmod(k, len(settings.sizes))
        fits = fit_of_pairs(sides[side], ends[end])
        if best is None or chosen is None:
            best, chosen = fits, np.zeros(fits.shape, np.intp)
            continue
        better = fits > best
        best[better], chosen[better] = fits[better], k
    assert best is not None and chosen is not None
    apart = max(3, round(0.5 * min(size) / edges.stride)) | 1
    peaks = (best == cv2.dilate(best, np.ones((apart, apart), np.uint8))) & (best > 0)
    rows, columns = np.nonzero(peaks)
    order = np.argsort(-best[rows, columns], kind="stable")
    cells = np.array(
        [
            [(x + 0.5) * edges.stride, (y + 0.5) * edges.stride, *sizes[chosen[y, x]]]
            for y, x in zip(rows[order], columns[order], strict=True)
        ]
    ).reshape(-1, 4)
    fits = fit_at(edges, cells)
    level = float(np.mean(np.sort(fits)[-settings.best :])) if len(fits) else 0.0
    return list(zip(cells, fits.tolist(), strict=True)), level


def _grow(
    edges: EdgeMaps,
    cell: FloatArray,
    *,
    fit: float,
    taken: BoolArray,
    least: float,
    size: tuple[float, float],
    settings: GrowthSettings,
) -> Lattice:
    """Take in neighbours, the best first, as long as they are drawn well enough."""
    lattice, count = Lattice(), 0
    waiting: list[tuple[float, int, Place, FloatArray]] = []
    heapq.heappush(waiting, (-fit, count, (0, 0), cell))
    while waiting:
        value, _, place, cell = heapq.heappop(waiting)  # the best first
        if place in lattice.cells or not _is_free(taken, cell, edges, settings):
            continue
        lattice.add(place, cell, -value)
        taken[_inside(cell, edges, shrunk=0.9)] = True
        for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            beside = place[0] + step[0], place[1] + step[1]
            if beside in lattice.cells:
                continue
            found, found_fit = _next_cell(edges, lattice, place, step, settings)
            unusual = np.abs(np.log(found[2:] / size)).max() > np.log(settings.largest)
            if found_fit >= least and not unusual:
                count += 1
                heapq.heappush(waiting, (-found_fit, count, beside, found))
    return lattice


def _next_cell(
    edges: EdgeMaps, lattice: Lattice, place: Place, step: Place, settings: GrowthSettings
) -> tuple[FloatArray, float]:
    """The best cell beside one, and its fit less what it strays from where its neighbours say."""
    cell = lattice.cells[place]
    x, y, width, height = cell
    along = np.array([width, height])
    expected = _expected_move(lattice, place, step)
    axis = 0 if step[1] else 1
    if expected is None:
        reach = (settings.far - settings.near) / 2
        centre: FloatArray = np.zeros(2)
        centre[axis] = (step[1] + step[0]) * (settings.near + reach) * along[axis]
        reaches = np.full(2, settings.aside)
        reaches[axis] = reach
    else:
        centre, reaches = expected, np.full(2, settings.drift)
    counts = [max(5, int(2 * r * a / edges.stride)) for r, a in zip(reaches, along, strict=True)]
    xs, ys = (
        c + np.linspace(-r, r, n) * a for c, r, n, a in zip(centre, reaches, counts, along, strict=True)
    )
    sizes = np.array(settings.sizes)
    grid = np.stack(np.meshgrid(x + xs, y + ys, width * sizes, height * sizes, indexing="ij"), axis=-1)
    fits = fit_at(edges, grid)
    if expected is None:
        apart = np.abs(grid[..., axis] - (x, y)[axis]) / along[axis] - 1
        fits = fits * (1 - settings.apart * np.maximum(0, apart))
    else:
        strayed = (np.abs(grid[..., :2] - np.array([x, y]) - centre) / (settings.drift * along)).max(axis=-1)
        fits = fits * (1 - settings.strayed * strayed**2)
    best = np.unravel_index(int(np.argmax(fits)), fits.shape)
    return grid[best], float(fits[best])


def _expected_move(lattice: Lattice, place: Place, step: Place) -> FloatArray | None:
    """From a cell to the next, as beside it: the same step in the rows or columns next to it, or back."""
    across = (step[1], step[0])
    for k in (1, -1, 2, -2):
        start = place[0] + k * across[0], place[1] + k * across[1]
        stop = start[0] + step[0], start[1] + step[1]
        if start in lattice.cells and stop in lattice.cells:
            return np.asarray(lattice.cells[stop][:2] - lattice.cells[start][:2])
    return None


def _is_free(taken: BoolArray, cell: FloatArray, edges: EdgeMaps, settings: GrowthSettings) -> bool:
    part = taken[_inside(cell, edges, shrunk=0.9)]
    return bool(part.size and part.mean() <= settings.overlap)


def _inside(cell: FloatArray, edges: EdgeMaps, *, shrunk: float) -> tuple[slice, slice]:
    x, y, width, height = cell
    first = np.array([y - shrunk * height / 2, x - shrunk * width / 2]) / edges.stride
    last = np.array([y + shrunk * height / 2, x + shrunk * width / 2]) / edges.stride
    (top, left), (bottom, right) = np.maximum(0, np.round(first)).astype(int), np.round(last).astype(int)
    return slice(top, max(top, bottom)), slice(left, max(left, right))
