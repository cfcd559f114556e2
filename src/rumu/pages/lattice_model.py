"""Smooth rows and columns through the cells of a lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.cell_lattice import Lattice, Place
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class LatticeModel:
    """Where each row and each column lies, in pixels, how all of them bend, and the usual size of a cell."""

    rows: dict[int, float]
    columns: dict[int, float]
    bend_rows: FloatArray
    bend_columns: FloatArray
    size: FloatArray
    middle: FloatArray

    def cell(self, place: Place) -> FloatArray:
        """(4,) centre x and y, width and height of the cell at a place within the rows and columns."""
        return self.moved_cell(place, row=self.rows[place[0]], column=self.columns[place[1]])

    def moved_cell(self, place: tuple[float, float], *, row: float, column: float) -> FloatArray:
        """(4,) the same where its row and column lie elsewhere than the model says."""
        r, c = (np.array(place) - self.middle) / 10
        x = column + bends(r, c)[: len(self.bend_columns)] @ self.bend_columns
        y = row + bends(c, r)[: len(self.bend_rows)] @ self.bend_rows
        return np.array([x, y, *self.size])

    def directions(self, place: Place) -> tuple[FloatArray, FloatArray]:
        """(2,) and (2,): which way the row runs at a place, and the column; unit vectors."""
        row, column = self.rows[place[0]], self.columns[place[1]]
        r, c = place
        along_row, along_column = (
            self.moved_cell(after, row=row, column=column)[:2]
            - self.moved_cell(before, row=row, column=column)[:2]
            for before, after in (((r, c - 0.5), (r, c + 0.5)), ((r - 0.5, c), (r + 0.5, c)))
        )
        right = np.array([self._step(self.columns) + along_row[0], along_row[1]])
        down = np.array([along_column[0], self._step(self.rows) + along_column[1]])
        return right / np.linalg.norm(right), down / np.linalg.norm(down)

    def _step(self, places: dict[int, float]) -> float:
        numbers = sorted(places)
        if len(numbers) < 2:
            return float(self.size.mean())
        return (places[numbers[-1]] - places[numbers[0]]) / (numbers[-1] - numbers[0])


def bends(along: float, across: float) -> FloatArray:
    """How a row or column bends: terms of the place along it, and across it."""
    return np.array([along, along * across, along**2, along**3, along**2 * across, along * across**2])


STIFF = (1.0, 2.0, 4.0, 16.0, 16.0, 16.0)  # each term of a bend: what it costs against the one before


def fit_model(lattice: Lattice) -> LatticeModel:
    """Rows and columns through the cells, each with its own place and all with the same bends.

    Cells that lie far off, and those that are drawn faintly, weigh little.
    """
    places = np.array(list(lattice.cells))
    cells = np.array(list(lattice.cells.values()))
    middle, size = np.median(places, axis=0), np.median(cells[:, 2:], axis=0)
    weights = np.sqrt(np.array(list(lattice.fits.values())))
    columns, bend_columns = fit_axis(places[:, ::-1], cells[:, 0], middle[::-1], size[0], weights)
    rows, bend_rows = fit_axis(places, cells[:, 1], middle, size[1], weights)
    return LatticeModel(rows, columns, bend_rows, bend_columns, size, middle)


def fit_axis(
    places: FloatArray, at: FloatArray, middle: FloatArray, size: float, weights: FloatArray
) -> tuple[dict[int, float], FloatArray]:
    """A place for every number in the first column of `places`, and the common bends along the second."""
    numbers, which = np.unique(places[:, 0], return_inverse=True)
    across, along = ((places - middle) / 10).T
    per_number = len(at) / len(numbers)
    terms = 0 if per_number < 1.5 else 1 if per_number < 2.5 else 3 if per_number < 4 else 6
    design = np.zeros((len(at), len(numbers) + terms))
    design[np.arange(len(at)), which] = 1
    design[:, len(numbers) :] = np.array([bends(a, b) for a, b in zip(along, across, strict=True)])[:, :terms]
    ridge = np.full(design.shape[1], 1e-6)
    ridge[len(numbers) :] = 1e-2 * np.array(STIFF)[:terms]
    found: FloatArray = np.zeros(design.shape[1])
    scale = weights.copy()
    for _ in range(6):
        weighted = design * scale[:, None] ** 2
        found = np.linalg.solve(design.T @ weighted + np.diag(ridge * np.mean(scale**2)), weighted.T @ at)
        scale = weights / np.sqrt(1 + ((at - design @ found) / (0.05 * size)) ** 2)
    every = np.arange(int(numbers[0]), int(numbers[-1]) + 1)
    between = np.interp(every, numbers, found[: len(numbers)])
    return dict(zip(every.tolist(), between.tolist(), strict=True)), found[len(numbers) :]
