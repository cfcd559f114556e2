"""How fast strokes are inflated, beside solvers of libraries: `python benchmarks/inflation.py`.

All solve the same equations on the same ink to the same residual, in one process on one thread, from the mask
to the height; the direct solver is exact. Inks are E3C copies (in RUMU_DATA, default: ../shared/data beside
the checkout) and starter works. Seconds are the best of three for each ink, summed; a ratio of 2 is twice as
slow as `rumu.surface.inflation`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np
import pyamg
from scipy import sparse
from scipy.sparse.linalg import cg, spsolve

from rumu.capture.image import bounding_box, read_image
from rumu.gallery.starter import starter_works
from rumu.surface.inflation import InflationSettings, finest_grid, inflate
from rumu.surface.ink import find_ink

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data")).resolve()
COPIES, WORKS = 12, 12
SETTINGS = InflationSettings()


def equations(ink: np.ndarray) -> tuple[sparse.csr_array, np.ndarray]:
    """The equations of `inflate` over the pixels of a mask: matrix and right side."""
    grid = finest_grid(ink, SETTINGS.damping)
    at = np.flatnonzero(grid.ink)
    number = np.full(grid.ink.size, -1, np.int32)
    number[at] = np.arange(len(at), dtype=np.int32)
    rows, columns = [np.arange(len(at), dtype=np.int32)], [np.arange(len(at), dtype=np.int32)]
    values = [grid.diagonal.ravel()[at].astype(float)]
    for links, step in ((grid.east, 1), (grid.south, grid.ink.shape[1])):
        first = np.flatnonzero(links)
        a, b = number[first], number[first + step]
        rows += [a, b]
        columns += [b, a]
        values += [np.full(2 * len(first), -1.0)]
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    matrix = sparse.csr_array(sparse.coo_array(entries, shape=(len(at), len(at))))
    return matrix, grid.right.ravel()[at].astype(float)


def direct(matrix: sparse.csr_array, right: np.ndarray) -> np.ndarray:
    return np.asarray(spsolve(matrix, right))


def conjugate_gradients(matrix: sparse.csr_array, right: np.ndarray) -> np.ndarray:
    return np.asarray(cg(matrix, right, rtol=SETTINGS.tolerance)[0])


def classical_multigrid(matrix: sparse.csr_array, right: np.ndarray) -> np.ndarray:
    solver = pyamg.ruge_stuben_solver(sparse.csr_matrix(matrix))
    return np.asarray(solver.solve(right, tol=SETTINGS.tolerance, accel="cg"))


def smoothed_aggregation(matrix: sparse.csr_array, right: np.ndarray) -> np.ndarray:
    solver = pyamg.smoothed_aggregation_solver(sparse.csr_matrix(matrix))
    return np.asarray(solver.solve(right, tol=SETTINGS.tolerance, accel="cg"))


SOLVERS: dict[str, Callable[[sparse.csr_array, np.ndarray], np.ndarray]] = {
    "scipy.sparse.linalg.spsolve": direct,
    "scipy.sparse.linalg.cg": conjugate_gradients,
    "pyamg, Ruge-Stuben, with cg": classical_multigrid,
    "pyamg, smoothed aggregation, with cg": smoothed_aggregation,
}


def inflate_by(solver: Callable[[sparse.csr_array, np.ndarray], np.ndarray], mask: np.ndarray) -> np.ndarray:
    """The height of the ink, as `inflate` gives it, by another solver of the same equations."""
    y0, y1, x0, x1 = bounding_box(mask)
    matrix, right = equations(mask[y0:y1, x0:x1])
    height = np.zeros(mask.shape, np.float32)
    height[y0:y1, x0:x1][mask[y0:y1, x0:x1]] = np.sqrt(2.0 * np.maximum(solver(matrix, right), 0.0))
    return height


def inks() -> list[np.ndarray]:
    """Masks of E3C copies and of starter works."""
    copies = sorted((DATA / "e3c" / "copies").rglob("*.png"))
    works = [work.path for work in starter_works()]
    files = copies[:: max(1, len(copies) // COPIES)][:COPIES] + works[:WORKS]
    return [find_ink(read_image(file)).mask for file in files]


def best_of(job: Callable[[], object], *, times: int = 3) -> float:
    """Seconds of the quickest run."""
    seconds = []
    for _ in range(times):
        start = perf_counter()
        job()
        seconds.append(perf_counter() - start)
    return min(seconds)


def main() -> None:
    cv2.setNumThreads(1)
    masks = inks()
    sizes = [int(mask.sum()) for mask in masks]
    print(f"{len(masks)} inks of {min(sizes)} to {max(sizes)} pixels, {np.median(sizes):.0f} as a rule")
    exact = [inflate_by(direct, mask) for mask in masks]
    methods: dict[str, Callable[[np.ndarray], np.ndarray]] = {"rumu.surface.inflation": inflate}
    methods |= {name: lambda m, solver=solver: inflate_by(solver, m) for name, solver in SOLVERS.items()}
    print(f"{'':<40}{'seconds':>9}{'ratio':>8}{'error, % of the top':>21}")
    ours = 0.0
    for name, method in methods.items():
        seconds = sum(best_of(lambda mask=mask, method=method: method(mask)) for mask in masks)
        ours = ours or seconds
        errors = [np.abs(method(m) - e).max() / e.max() for m, e in zip(masks, exact, strict=True)]
        print(f"{name:<40}{seconds:9.3f}{seconds / ours:8.1f}{100 * np.mean(errors):21.2f}")


if __name__ == "__main__":
    main()
