"""Count the cells found on pages of practice: `python benchmarks/practice_pages.py [DATA] [PAGE ...]`.

The true layout of every page stands in `tests/pages/practice_layouts.json`: a line for each row of cells, x
for a cell with writing, o for an empty one, a dot where there is none. Cells that the border of the picture
cuts in two, or that a pencil covers, are not in it. Printed for each page and for all: cells that are there
and found, cells found where there are none, and of the cells found how many are rightly called written or
empty. The pages are read as `rumu page` reads them: set straight and turned upright first.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from rumu.pages.page import PageCharacter
from rumu.pages.reading import find_characters

LAYOUTS = Path(__file__).parent.parent / "tests" / "pages" / "practice_layouts.json"


def layout_of(cells: tuple[PageCharacter, ...]) -> list[list[str]]:
    """Lines for each register of cells, written as in the file of true layouts."""
    found = []
    for register in sorted({cell.register for cell in cells}):
        here = {
            (cell.column, cell.row): "o" if cell.empty else "x" for cell in cells if cell.register == register
        }
        rows, columns = (max(place[k] for place in here) + 1 for k in (0, 1))
        found.append(["".join(here.get((r, c), ".") for c in range(columns)) for r in range(rows)])
    return found


def compare(truth: list[str], found: list[str], *, reach: int = 2) -> tuple[int, int]:
    """Cells that are there and found, and how many of them are rightly told; at the best offset."""
    best = (0, 0)
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            pairs = [
                (mark, found[r + down][c + right])
                for r, row in enumerate(truth)
                for c, mark in enumerate(row)
                if mark != "." and 0 <= r + down < len(found) and 0 <= c + right < len(found[r + down])
            ]
            there = [(a, b) for a, b in pairs if b != "."]
            best = max(best, (len(there), sum(a == b for a, b in there)))
    return best


def measure(path: Path, truth: list[list[str]]) -> tuple[int, int, int, int, float]:
    """Cells that are there, found, rightly told, found where none is; seconds of the processor."""
    began = time.process_time()
    cells = find_characters(path).cells
    seconds = time.process_time() - began
    found = layout_of(cells)
    there = sum(len(row.replace(".", "")) for register in truth for row in register)
    counts = np.array([[compare(one, other) for other in found] for one in truth]).reshape(
        len(truth), len(found), 2
    )
    pairs = linear_sum_assignment(counts[..., 0], maximize=True)
    hits, told = (int(total) for total in counts[pairs].sum(axis=0))
    return there, hits, told, len(cells) - hits, seconds


def main() -> None:
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", "../shared/data"))
    layouts = json.loads(LAYOUTS.read_text())
    pages = sys.argv[2:] or list(layouts)
    total = np.zeros(5)
    for page in pages:
        row = measure(data / "pages" / "practice" / f"{page}.jpg", layouts[page])
        total += row
        print(
            "{:8s} cells {:4d}  found {:4d}  told {:4d}  false {:3d}  {:5.2f} s".format(page, *row),
            flush=True,
        )
    there, hits, told, false, seconds = total
    print(
        f"{len(pages)} pages: {hits / there:.4f} of {there:.0f} cells found, {told / max(1, hits):.4f} "
        f"of these rightly told written or empty, {false:.0f} false ones; {seconds / len(pages):.2f} s a page"
    )


if __name__ == "__main__":
    main()
