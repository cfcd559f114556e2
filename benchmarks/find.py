"""Which master is a copy of: hits and time among all masters at hand. `python benchmarks/find.py [DATA]`.

Every E3C copy, whose characters the masters contain, is sought among the regular masters alone, among 8,000,
and among all (regular, running and cursive). The copies took no part in making the description; its few
settings (grid, share of line density) were chosen from four variants with these copies in view.
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
from rumu_lab.experiments.e3c import Copy, read_copies

SETS = ("regular", "running-lantingxu", "cursive")
MANY = 8000


def hits(copies: list[Copy], index: MasterIndex) -> None:
    """Print how often the right character comes first and in the first ten, and how long one search takes."""
    ranks, seconds = [], []
    for copy in copies:
        began = time.perf_counter()
        found = find(copy.image, index, top=10)
        seconds.append(time.perf_counter() - began)
        names = [match.master.character for match in found]
        ranks.append(names.index(copy.character) if copy.character in names else 10)
    place = np.array(ranks)
    own = np.array([copy.character for copy in copies])
    worst = min((float(np.mean(place[own == c] < 10)), c) for c in np.unique(own))
    print(
        f"{len(index.masters):6d} masters: first {np.mean(place < 1):.3f}, in the first five "
        f"{np.mean(place < 5):.3f}, in the first ten {np.mean(place < 10):.3f} "
        f"(worst character {worst[1]} {worst[0]:.2f}); from file to answer "
        f"{1e3 * np.median(seconds):.0f} ms, longest {1e3 * np.max(seconds):.0f} ms"
    )


def main() -> None:
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", "../shared/data"))
    cv2.setNumThreads(2)
    places = [data / "masters" / name / "labels.csv" for name in SETS]
    began = time.perf_counter()
    index_masters(places, jobs=2)
    described = time.perf_counter() - began
    began = time.perf_counter()
    index = index_masters(places)
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
