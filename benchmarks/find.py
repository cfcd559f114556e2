"""Time the search for the master of a copy and count its hits: `python benchmarks/find.py [DATA]`.

Each E3C copy whose character the masters contain is searched for among the regular masters, among 8,000, and
among all (regular, running and cursive). The description was made without the copies; only its few settings
(grid, share of line density) were chosen from four variants by their results on these copies.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import cv2
import numpy as np

import rumu
from rumu.gallery.search import MasterIndex, find, index_masters
from rumu_lab.experiments.marked_copies import Copy, read_copies

SETS = ("regular", "running-lantingxu", "cursive")
MANY = 8000


def hits(copies: list[Copy], index: MasterIndex) -> None:
    """Print how often the right character is first and among the first ten, and the time of a search."""
    ranks, seconds = [], []
    for copy in copies:
        began = time.perf_counter()
        results = find(copy.image, index, top=10)
        seconds.append(time.perf_counter() - began)
        names = [result.master.character for result in results]
        ranks.append(names.index(copy.character) if copy.character in names else 10)
    rank = np.array(ranks)
    character = np.array([copy.character for copy in copies])
    worst = min((float(np.mean(rank[character == c] < 10)), c) for c in np.unique(character))
    print(
        f"{len(index.masters):6d} masters: first {np.mean(rank < 1):.3f}, in the first five "
        f"{np.mean(rank < 5):.3f}, in the first ten {np.mean(rank < 10):.3f} "
        f"(worst character {worst[1]} {worst[0]:.2f}); from file to answer "
        f"{1e3 * np.median(seconds):.0f} ms, longest {1e3 * np.max(seconds):.0f} ms"
    )


def main() -> None:
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", "../shared/data"))
    cv2.setNumThreads(2)
    paths = [data / "masters" / name / "labels.csv" for name in SETS]
    began = time.perf_counter()
    index_masters(paths, jobs=2)
    described = time.perf_counter() - began
    began = time.perf_counter()
    index = index_masters(paths)
    print(
        f"rumu {rumu.__version__}; described in {described:.0f} s, read again in "
        f"{time.perf_counter() - began:.2f} s, {len(index.left_out)} without writing left out"
    )
    copies = read_copies(data)
    known = {master.character for master in index.masters}
    copies = [copy for copy in copies if copy.character in known]
    print(f"{len(copies)} copies whose character the masters contain")
    regular = sum("regular" in master.path.parts for master in index.masters)
    for count in (regular, MANY, len(index.masters)):
        hits(copies, MasterIndex(index.masters[:count], index.vectors[:count]))


if __name__ == "__main__":
    main()
