"""The mean description of regular script: `python scripts/describe_mean.py [DATA]`.

Writes src/rumu/registration/mean_description.npy, which `likeness` takes away: the mean of `describe` over
the 6,590 characters of the regular masters, 1,024 numbers, of no single character.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np

from rumu.gallery.masters import read_masters
from rumu.outputs import whole_file
from rumu.pipeline import surface_of
from rumu.registration.descriptor import describe
from rumu.registration.points import sample_points

HOME = Path(__file__).parents[1]

if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", HOME / "../shared/data"))
    masters = read_masters(data / "masters" / "regular")
    total = sum(describe(sample_points(surface_of(master.path))).astype(float) for master in masters)
    target = HOME / "src/rumu/registration/mean_description.npy"
    with whole_file(target) as part, part.open("wb") as stream:
        np.save(stream, (total / len(masters)).astype(np.float16))
    print(f"mean of {len(masters)} characters")
