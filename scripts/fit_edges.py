"""Make the basis in which edges of ink are described: `python scripts/fit_edges.py [DATA]`.

Writes src/rumu/assessment/edges.npz from 250 characters of the stele works in DATA/masters/regular. No copy
and no mark is read, so whatever is judged on marks has not been seen here.
"""

from __future__ import annotations

import csv
import os
import sys
from pathlib import Path

import numpy as np

import rumu
from rumu.assessment.edges import COMPONENTS, edge_patches
from rumu.registration.points import canvas_of, ink_mask

ROOT = Path(__file__).parents[1]
CHARACTERS, PATCHES = 250, 40


def basis(patches: np.ndarray) -> dict[str, np.ndarray]:
    """Mean, principal components and their spreads of (N, D) patches."""
    mean = patches.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(patches - mean, rowvar=False))
    components = vectors[:, ::-1][:, :COMPONENTS]
    components *= np.sign(components.sum(axis=0))  # a sign of its own, the same on every machine
    return {"mean": mean, "components": components, "spread": np.sqrt(values[::-1][:COMPONENTS])}


def fitted(data: Path) -> dict[str, np.ndarray]:
    """The basis as it is stored."""
    folder = data / "masters" / "regular"
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as stream:
        names = sorted(row["file"] for row in csv.DictReader(stream))
    rng = np.random.default_rng(0)
    taken = []
    for name in rng.choice(names, CHARACTERS, replace=False):
        found = edge_patches(canvas_of(ink_mask(rumu.relief(folder / name))).ink)
        taken.append(found[rng.choice(len(found), PATCHES)])
    return {name: array.astype(np.float32) for name, array in basis(np.concatenate(taken)).items()}


if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", ROOT / "../shared/data"))
    np.savez(ROOT / "src/rumu/assessment/edges.npz", **fitted(data))
