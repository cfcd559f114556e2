"""A lattice made whole: smooth rows and columns through its cells, and the cells that are missing on them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from rumu.pages.cell_lattice import Lattice, Place, fit_between
from rumu.pages.cell_scores import EdgeMaps, fit_at
from rumu.pages.lattice_model import LatticeModel, fit_model
from rumu.pages.line_evidence import LineEvidence
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class FillSettings:
    """When a missing cell is taken in.

    Lengths are shares of a cell's width or height; how well a cell is drawn counts from 0, a place between
    the lines, to 1, the best cells of the page.

    strayed: a cell that lies farther beside its row and column is none of the lattice. drawn: from here on a
        cell is there. drift, sizes: how far it may lie beside the place that rows and columns say, and its
        size.
    as_drawn: of what the cells around it have, a cell that is drawn less is missing; asked only where these
        have `visible` or more: on faint print a missing line says nothing.
    alone: a cell without writing, and without a cell beside it, is there from here on.
    near, far, step: the next row or column begins here, tried in such steps. row: cells it needs, or half of
        it.
        unusual: what a step that differs from the other rows' by a whole cell costs each cell.
    written: least ink in a cell with writing, as a share of it. cut: most ink along its edges, as a share.
    marked: printed marks inside a cell that speak against it, as a share, beyond what its neighbours have.
        covered: marked more than others by this, it lies under a pen or a hand. mark: darkness of such a
            mark; pen: colour of a red pen, which is none.
    gap: step from row to row, in cells, from which on rows stand apart, so that one may be short. alike:
        least writing in the cells of a new row, as a share of what is usual.
    centred: how far writing that lies beside the middle of a cell moves a cell that is hardly drawn; hardly:
        how much such a cell counts.
    established: share of the rows that a column, and of the columns that a row, must reach.
    """

    strayed: float = 0.15
    drawn: float = 0.4
    drift: float = 0.05
    sizes: tuple[float, ...] = (0.96, 1.0, 1.04)
    as_drawn: float = 0.6
    visible: float = 0.3
    alone: float = 0.8
    near: float = 0.95
    far: float = 1.45
    step: float = 0.03
    row: int = 3
    unusual: float = 1.0
    written: float = 0.02
    cut: float = 0.12
    marked: float = 0.05
    mark: float = 0.045
    covered: float = 0.4
    pen: float = 0.4
    centred: float = 0.1
    hardly: float = 0.08
    gap: float = 1.06
    alike: float = 0.6
    established: float = 0.3
    rounds: int = 40


class Seen(NamedTuple):
    """What is seen at a place of a page: writing within, writing across its edges, the share printed on."""

    written: bool
    crossed: bool
    marked: float


class Slots:
    """What is found at places of a page: how well a cell is drawn there, writing, marks."""

    def __init__(
        self, edges: EdgeMaps, evidence: LineEvidence, lattice: Lattice, settings: FillSettings
    ) -> None:
        import cv2

        self.edges, self.settings = edges, settings
        self.ink = cv2.integral(evidence.writing.astype(np.uint8))
        rows, columns = np.indices(evidence.writing.shape, dtype=np.float32)
        self.ink_x = cv2.integral(evidence.writing * columns, sdepth=cv2.CV_64F)
        self.ink_y = cv2.integral(evidence.writing * rows, sdepth=cv2.CV_64F)
        pen = (evidence.coloured > settings.pen).astype(np.uint8)
        left_out = evidence.writing | (cv2.dilate(pen, np.ones((7, 7), np.uint8)) > 0)
        smooth = cv2.blur(np.where(left_out, np.float32(0), evidence.darkness), (5, 5))
        self.marks = cv2.integral((smooth > settings.mark).astype(np.uint8))
        cells = np.array(list(lattice.cells.values()))
        fits = np.array(list(lattice.fits.values()))
        self.level = float(np.mean(np.sort(fits)[-max(4, len(fits) // 4) :]))
        self.floor = min(0.5 * self.level, fit_between(edges, cells))
        self.usual_centre = np.zeros(2)
        self.usual_centre = (
            np.median(self._centres(cells)[self.written(cells)], axis=0)
            if self.written(cells).any()
            else self.usual_centre
        )
        self.usual_marks = float(np.median(self.marked(cells)))

    def drawn(self, cells: FloatArray) -> FloatArray:
        """(...,) how well cells (..., 4) are drawn."""
        return np.asarray((fit_at(self.edges, cells) - self.floor) / (self.level - self.floor))

    def snap(self, cells: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N, 4) the best drawn cells near cells (N, 4), and (N,) how well they are drawn."""
        settings = self.settings
        steps, sizes = np.linspace(-settings.drift, settings.drift, 5), np.array(settings.sizes)
        grid = np.stack(np.meshgrid(steps, steps, sizes, sizes, indexing="ij"), axis=-1).reshape(-1, 4)
        near = np.repeat(cells[:, None], len(grid), axis=1)
        near[..., :2] += grid[:, :2] * cells[:, None, 2:]
        near[..., 2:] *= grid[:, 2:]
        drawn = self.drawn(near) - 0.05 * np.abs(grid[:, :2]).max(axis=1) / settings.drift
        best = drawn.argmax(axis=1)
        return near[np.arange(len(cells)), best], drawn[np.arange(len(cells)), best]

    def filled_alike(self, cells: FloatArray, lattice: Lattice) -> bool:
        """Whether the writing in cells (N, 4) is as much as in the cells of a lattice."""
        known = np.array(list(lattice.cells.values()))
        usual = self._sum(self.ink, known[self.written(known)], 0.92)
        return not len(usual) or bool(
            np.median(self._sum(self.ink, cells, 0.92)) > self.settings.alike * np.median(usual)
        )

    def centred(self, cells: FloatArray) -> FloatArray:
        """(N, 4) cells moved to where their writing says they are, by a little at most."""
        off = self._centres(cells) - self.usual_centre
        moved = cells.copy()
        reach = self.settings.centred
        moved[:, :2] += np.clip(off, -reach, reach) * cells[:, 2:]
        return moved

    def _centres(self, cells: FloatArray) -> FloatArray:
        """(N, 2) from the centre of each cell to that of the writing in it, in cells."""
        total = np.maximum(1, self._sum(self.ink, cells, 1.0))
        at = np.stack(
            [self._sum(self.ink_x, cells, 1.0) / total, self._sum(self.ink_y, cells, 1.0) / total], axis=-1
        )
        return np.asarray((at - cells[:, :2]) / cells[:, 2:])

    def look(self, cells: FloatArray) -> list[Seen]:
        """What is seen at each of the cells (N, 4)."""
        facts = zip(self.written(cells), self.crossed(cells), self.marked(cells), strict=True)
        return [Seen(bool(a), bool(b), float(c)) for a, b, c in facts]

    def written(self, cells: FloatArray) -> BoolArray:
        """(...,) bool: writing stands within the cell and is not cut by its edges."""
        area, inside = cells[..., 2] * cells[..., 3], self._sum(self.ink, cells, 0.92)
        ring = self._sum(self.ink, cells, 1.08) - inside
        return np.asarray((inside > self.settings.written * area) & (ring < self.settings.cut * inside))

    def crossed(self, cells: FloatArray) -> BoolArray:
        """(...,) bool: much of the writing there lies on the edges."""
        area, inside = cells[..., 2] * cells[..., 3], self._sum(self.ink, cells, 0.92)
        ring = self._sum(self.ink, cells, 1.08) - inside
        return np.asarray((ring > self.settings.written * area) & (ring > 2 * self.settings.cut * inside))

    def marked(self, cells: FloatArray) -> FloatArray:
        """(...,) share of the cell that is printed on."""
        return np.asarray(self._sum(self.marks, cells, 0.86) / (0.86**2 * cells[..., 2] * cells[..., 3]))

    def _sum(self, integral: FloatArray, cells: FloatArray, share: float) -> FloatArray:
        height, width = integral.shape[0] - 1, integral.shape[1] - 1
        half = share * cells[..., 2:] / 2
        (x0, y0), (x1, y1) = (
            np.moveaxis(cells[..., :2] - half, -1, 0),
            np.moveaxis(cells[..., :2] + half, -1, 0),
        )
        x0, x1 = (np.clip(np.round(x), 0, width).astype(int) for x in (x0, x1))
        y0, y1 = (np.clip(np.round(y), 0, height).astype(int) for y in (y0, y1))
        total = integral[y1, x1].astype(np.float64) - integral[y0, x1] - integral[y1, x0] + integral[y0, x0]
        return np.asarray(total)


def fill_lattice(
    edges: EdgeMaps, evidence: LineEvidence, lattice: Lattice, *, settings: FillSettings | None = None
) -> tuple[Lattice, LatticeModel]:
    """The lattice without cells that lie off its rows and columns, with those that were missing on them.

    Its fits become how well each cell is drawn, about 0 to 1. No cells are left where none is seen again.
    """
    settings = settings or FillSettings()
    slots = Slots(edges, evidence, lattice, settings)
    drawn = slots.drawn(np.array(list(lattice.cells.values())))
    whole = Lattice(
        dict(lattice.cells),
        dict(zip(lattice.cells, np.clip(drawn, settings.hardly, 1.0).tolist(), strict=True)),
    )
    whole, model = without_strays(whole, settings.strayed)
    for _ in range(settings.rounds):
        before = set(whole.cells)
        _fill_inside(slots, whole, model)
        model = fit_model(whole)
        for axis in (0, 1):
            for side in (-1, 1):
                _add_line(slots, whole, model, axis, side)
        whole, model = without_strays(whole, settings.strayed)
        _drop_contradicted(slots, whole)
        if not whole.cells or set(whole.cells) == before:
            break
        model = fit_model(whole)
    return whole, model


def without_strays(lattice: Lattice, strayed: float) -> tuple[Lattice, LatticeModel]:
    """The lattice without cells that lie off its rows and columns by more than this share of a cell."""
    model = fit_model(lattice)
    places = list(lattice.cells)
    off = np.abs(np.array([lattice.cells[p][:2] - model.cell(p)[:2] for p in places]) / model.size).max(
        axis=1
    )
    kept = [place for place, far in zip(places, off, strict=True) if far <= strayed]
    if not kept or len(kept) == len(places):
        return lattice, model
    chosen = Lattice({p: lattice.cells[p] for p in kept}, {p: lattice.fits[p] for p in kept})
    return chosen, fit_model(chosen)


def _around(lattice: Lattice, place: Place) -> list[float]:
    r, c = place
    near = ((r + i, c + j) for i in (-1, 0, 1) for j in (-2, -1, 0, 1, 2) if i or j)
    return [lattice.fits[one] for one in near if one in lattice.cells]


def _is_drawn(slots: Slots, lattice: Lattice, place: Place, drawn: float, seen: Seen) -> bool:
    """Whether a cell is drawn well, not much worse than those around it, and no object lies on it."""
    if seen.marked > slots.usual_marks + slots.settings.covered:
        return False
    around = _around(lattice, place)
    return drawn >= max(
        slots.settings.drawn, slots.settings.as_drawn * float(np.mean(around)) if around else 0.0
    )


def _belongs(slots: Slots, lattice: Lattice, place: Place, drawn: float, seen: Seen) -> bool:
    """Whether a place within rows and columns is a cell, though it is hardly drawn."""
    settings, (r, c) = slots.settings, place
    if seen.marked > slots.usual_marks + settings.covered:
        return False
    if all(any((r, c + k * side) in lattice.cells for k in (1, 2)) for side in (-1, 1)):
        return True
    if seen.crossed or seen.marked > slots.usual_marks + (3 if seen.written else 1) * settings.marked:
        return False
    if seen.written:
        return True
    in_row = [column for row, column in lattice.cells if row == r]
    if any(column < c for column in in_row) and any(column > c for column in in_row):
        return True
    beside, above_or_below = {(r, c - 1), (r, c + 1)}, {(r - 1, c), (r + 1, c)}
    return bool(beside & lattice.cells.keys() and above_or_below & lattice.cells.keys())


def _fill_inside(slots: Slots, lattice: Lattice, model: LatticeModel) -> None:
    missing = [(r, c) for r in model.rows for c in model.columns if (r, c) not in lattice.cells]
    if not missing:
        return
    places = np.array([model.cell(place) for place in missing])
    cells, drawn = slots.snap(places)
    seen, settings = slots.look(places), slots.settings
    by_writing = slots.centred(places)
    written = {place for place, one in zip(missing, seen, strict=True) if one.written}
    in_row, in_column = _reach(lattice.cells.keys() | written)
    for k, place in enumerate(missing):
        r, c = place
        if _is_drawn(slots, lattice, place, float(drawn[k]), seen[k]):
            lattice.add(place, cells[k], min(1.0, float(drawn[k])))
            continue
        established = in_column.get(c, 0) >= settings.established * len(model.rows) and in_row.get(
            r, 0
        ) >= settings.established * len(model.columns)
        if established and _belongs(slots, lattice, place, float(drawn[k]), seen[k]):
            lattice.add(
                place, by_writing[k] if seen[k].written else places[k], max(settings.hardly, float(drawn[k]))
            )


def _reach(places: set[Place]) -> tuple[dict[int, int], dict[int, int]]:
    """How many places each row and each column has."""
    rows: dict[int, int] = {}
    columns: dict[int, int] = {}
    for r, c in places:
        rows[r], columns[c] = rows.get(r, 0) + 1, columns.get(c, 0) + 1
    return rows, columns


def _drop_contradicted(slots: Slots, lattice: Lattice) -> None:
    places = list(lattice.cells)
    cells = np.array([lattice.cells[place] for place in places])
    drawn, seen = slots.drawn(cells), slots.look(cells)
    for k, place in enumerate(places):
        r, c = place
        alone = not seen[k].written and not {(r, c - 1), (r, c + 1)} & lattice.cells.keys()
        is_drawn = _is_drawn(slots, lattice, place, drawn[k], seen[k]) and not (
            alone and drawn[k] < slots.settings.alone
        )
        if not is_drawn and not _belongs(slots, lattice, place, drawn[k], seen[k]):
            del lattice.cells[place], lattice.fits[place]


def _add_line(slots: Slots, lattice: Lattice, model: LatticeModel, axis: int, side: int) -> None:
    """Take in the next row (axis 0) or column (axis 1) on a side, if enough of it is drawn or written in."""
    settings = slots.settings
    known = model.rows if axis == 0 else model.columns
    others = sorted(model.columns if axis == 0 else model.rows)
    edge, size = (min if side < 0 else max)(known), model.size[1 - axis]
    usual = _usual_step(known) / size
    shares = np.arange(settings.near, settings.far, settings.step)
    places = [(edge + side, o) if axis == 0 else (o, edge + side) for o in others]
    cells = np.array(
        [
            [
                model.moved_cell(
                    place,
                    row=known[edge] + side * share * size if axis == 0 else model.rows[place[0]],
                    column=model.columns[place[1]] if axis == 0 else known[edge] + side * share * size,
                )
                for place in places
            ]
            for share in shares
        ]
    )
    drawn, written = np.clip(slots.drawn(cells), 0, 1), slots.written(cells)
    value = (drawn + 0.5 * written).mean(axis=1) - settings.unusual * np.abs(shares - usual)
    best = int(np.argmax(value))
    there = (drawn[best] >= settings.drawn) | written[best]
    if np.count_nonzero(there) < min(settings.row, max(1, (len(others) + 1) // 2)):
        return
    beside = [lattice.fits[p] for p in lattice.cells if p[axis] == edge]
    expected = float(np.mean(beside)) if beside else 0.0
    faint = (
        expected < settings.visible
        or np.sort(drawn[best])[-len(beside) :].mean() >= settings.as_drawn * expected
    )
    if not faint or not (drawn[best] >= settings.drawn).any():
        if np.abs(shares[best] - usual) > settings.drift or not slots.filled_alike(
            cells[best][there], lattice
        ):
            return
        if usual < settings.gap and np.count_nonzero(there) < 0.5 * len(others):
            return
    found, fits = slots.snap(cells[best])
    by_writing = slots.centred(cells[best])
    for k in np.flatnonzero(there):
        drawn_well = drawn[best, k] >= settings.drawn
        lattice.add(
            places[k],
            found[k] if drawn_well else by_writing[k],
            max(settings.hardly, min(1.0, float(fits[k]))),
        )


def _usual_step(known: dict[int, float]) -> float:
    numbers = sorted(known)
    steps = [(known[b] - known[a]) / (b - a) for a, b in pairwise(numbers)]
    return float(np.median(steps)) if steps else 0.0
