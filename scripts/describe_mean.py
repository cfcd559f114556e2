"""Compute what `likeness` and `beyond_others` compare with: `python scripts/describe_mean.py [DATA]`.

Writes into src/rumu/registration, from the 6,590 characters of the regular masters: mean_description.npy, the
mean of `describe`, which `likeness` subtracts; and other_characters.npz, one description of each character
in one half of them. The half is chosen by a hash of the name, as in benchmarks/refusal.py, so that the other
half shows what this is worth on characters that it does not hold.
"""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

import numpy as np

from rumu.gallery.masters import read_masters
from rumu.outputs import whole_file
from rumu.pipeline import surface_of
from rumu.registration.descriptor import describe, to_bytes
from rumu.registration.points import sample_points

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "src/rumu/registration"


def one_of_each(characters: np.ndarray) -> np.ndarray:
    """One row of each character in the development half, drawn at random."""
    rng = np.random.default_rng(0)
    half = [c for c in np.unique(characters) if hashlib.sha256(c.encode()).digest()[0] % 2 == 0]
    return np.array([rng.choice(np.flatnonzero(characters == c)) for c in half])


if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", ROOT / "../shared/data"))
    masters = read_masters(data / "masters" / "regular")
    vectors = np.array([describe(sample_points(surface_of(master.path))) for master in masters])
    chosen = vectors[one_of_each(np.array([master.character for master in masters]))]
    with whole_file(FOLDER / "mean_description.npy") as part, part.open("wb") as stream:
        np.save(stream, vectors.mean(axis=0, dtype=float).astype(np.float16))
    with whole_file(FOLDER / "other_characters.npz") as part, part.open("wb") as stream:
        np.savez_compressed(stream, vectors=to_bytes(chosen))
    print(f"mean of {len(masters)} characters, {len(chosen)} of them kept")
