"""What ran straight on a page before it bent: columns of writing, ruled lines, the sides of printed cells."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rumu.pages.bend import PageCurves
from rumu.pages.columns import Ridge
from rumu.pages.free_page import FreePage, WrittenColumn
from rumu.pages.grids import PageGrid
from rumu.pages.page_layout import PartingLine, parting_lines
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class CurveSettings:
    """Which curves tell how a page bends.

    length: sizes of a character that a column has at least. points: how many are taken along each curve.
    ends: share of the columns whose ends lie on one smooth line, or ends say nothing; level: how far, in
    sizes of a character, they may lie from it. fewest: columns whose ends say something, and cells in a line.
    reach: how far from its curve the pixels of a ruled line are looked for. traced: share of the places along
    it at which it must be seen.
    """

    length: float = 5.0
    points: int = 24
    ends: float = 0.6
    level: float = 0.3
    fewest: int = 5
    reach: float = 0.35
    traced: float = 0.6


def curves_of_page(page: FreePage, *, settings: CurveSettings | None = None) -> PageCurves:
    """The curves of a page without a grid, in pixels of the picture it was found in."""
    settings = settings or CurveSettings()
    long = [one for one in page.columns if one.column.length > settings.length * page.size]
    if not long:
        return PageCurves((), (), page.size)
    top, bottom = min(one.column.extent[0] for one in long), max(one.column.extent[1] for one in long)
    sides = [float(one.column.ridge.at((top + bottom) / 2)) for one in long]
    left, right = min(sides) - page.size, max(sides) + page.size
    upright = [_along(one.column.ridge, *one.column.extent, settings)[:, ::-1] for one in long]
    written = (len(long), 0)
    upright += [one[:, ::-1] for one in _ruled(page.lines.T, page.size, (top, bottom), settings)]
    level = _ruled(page.lines, page.size, (left, right), settings)
    for register in sorted({one.register for one in long}):
        own = [one for one in long if one.register == register]
        level += [curve for end in (0, 1) for curve in _ends(own, end, page.size, settings)]
    if page.direction == "horizontal":
        upright, level, written = (
            [one[:, ::-1] for one in level],
            [one[:, ::-1] for one in upright],
            written[::-1],
        )
    return PageCurves(tuple(upright), tuple(level), page.size, written)


def curves_of_grid(grid: PageGrid, *, settings: CurveSettings | None = None) -> PageCurves:
    """The sides of rows and columns of printed cells."""
    settings = settings or CurveSettings()
    lines: dict[tuple[str, int, int, int], list[FloatArray]] = defaultdict(list)
    for cell in grid.cells:
        corners = np.asarray(cell.polygon[:4])
        lines["level", cell.register, cell.column, 0].append(corners[[0, 1]])
        lines["level", cell.register, cell.column, 1].append(corners[[3, 2]])
        lines["upright", cell.register, cell.row, 0].append(corners[[0, 3]])
        lines["upright", cell.register, cell.row, 1].append(corners[[1, 2]])
    long = {name: np.concatenate(own) for name, own in lines.items() if len(own) >= settings.fewest}
    sides = [np.ptp(cell.polygon, axis=0).mean() for cell in grid.cells]
    return PageCurves(
        tuple(points for name, points in long.items() if name[0] == "upright"),
        tuple(points for name, points in long.items() if name[0] == "level"),
        float(np.median(sides)),
    )


def _ruled(
    lines: BoolArray, size: float, extent: tuple[float, float], settings: CurveSettings
) -> list[FloatArray]:
    """Ruled lines that run from left to right, each followed from place to place."""
    lines = np.ascontiguousarray(lines)
    traced = [
        _traced(line, lines, size, extent, settings)
        for line in parting_lines(lines, size=size, extent=extent)
    ]
    return [one for one in traced if len(one) > settings.traced * settings.points]


def _traced(
    line: PartingLine, lines: BoolArray, size: float, extent: tuple[float, float], settings: CurveSettings
) -> FloatArray:
    """(n, 2): places along a line, and where the middle of its pixels lies there, where it has any."""
    edges = np.linspace(*extent, settings.points + 1)
    found = []
    for begin, end in pairwise(np.clip(edges, 0, lines.shape[1] - 1).astype(int)):
        if begin >= end:
            continue
        along = (begin + end - 1) / 2
        at, reach = float(line.at(along)), settings.reach * size
        low, high = max(0, int(at - reach)), max(0, int(at + reach) + 1)
        rows = np.nonzero(lines[low:high, begin:end])[0]
        if len(rows):
            found.append((along, low + float(np.median(rows))))
    return np.array(found).reshape(-1, 2)


def _along(line: Ridge, begin: float, end: float, settings: CurveSettings) -> FloatArray:
    """(points, 2): places along a line, and where it lies there."""
    along = np.linspace(begin, end, settings.points)
    return np.column_stack([along, line.at(along)])


def _ends(columns: list[WrittenColumn], end: int, size: float, settings: CurveSettings) -> list[FloatArray]:
    """The first or last rows of columns that began or ended at one level, as a curve; none where few did."""
    if len(columns) < settings.fewest:
        return []
    y = np.array([float(one.column.extent[end]) for one in columns])
    x = np.array([float(one.column.ridge.at(row)) for one, row in zip(columns, y, strict=True)])
    weights = np.ones(len(y))
    for _ in range(12):
        off = y - np.polyval(np.polyfit(x, y, 2, w=np.sqrt(weights)), x)
        weights = 1 / (1 + (off / (settings.level * size)) ** 2)
    on = np.abs(off) < settings.level * size
    if on.sum() < max(settings.fewest, settings.ends * len(y)):
        return []
    return [np.column_stack([x[on], y[on]])]
