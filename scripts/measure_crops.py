#!/usr/bin/env python3
"""Measure the studio's first crop on real copies: in how many it cuts ink, and the size error that it gives.

The crop is found by the front end (frontend/src/studio/firstCrop.ts), so this script writes the pictures
for its test (frontend/tests/vectors/crops.*) and runs that test, which prints the figures.

    .venv/bin/python scripts/measure_crops.py [DATA]

DATA: the folder of real data, by default RUMU_DATA or ../shared/data.
"""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).parents[1]
FRONTEND = ROOT / "frontend"
TARGET = FRONTEND / "tests" / "vectors"
COPY_SIDE = 512  # pixels: as in frontend/src/studio/photoInk.ts
PHOTOGRAPHS = ("pages/phone", "pages/practice", "../cases/copies")


def write(data: Path, target: Path = TARGET) -> None:
    """Write the cells of E3C as bits, and photographs as small RGB copies, with a table of contents."""
    cells, photographs, blocks = [], [], []
    for path in sorted((data / "e3c" / "copies").glob("*.png")):
        with Image.open(path) as image:
            ink = np.asarray(image.convert("L")) < 128
        cells.append({"name": path.name, "height": ink.shape[0], "width": ink.shape[1]})
        blocks.append(np.packbits(ink, axis=None).tobytes())
    for folder in PHOTOGRAPHS:
        for path in sorted((data / folder).glob("*.jp*g")):
            with Image.open(path) as image:
                small = image.convert("RGB")
            small.thumbnail((COPY_SIDE, COPY_SIDE), Image.Resampling.BICUBIC)
            photographs.append({"name": path.name, "height": small.height, "width": small.width})
            blocks.append(small.tobytes())
    target.mkdir(parents=True, exist_ok=True)
    (target / "crops.json").write_text(json.dumps({"cells": cells, "photographs": photographs}))
    (target / "crops.bin.gz").write_bytes(gzip.compress(b"".join(blocks), compresslevel=1))


if __name__ == "__main__":
    home = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", ROOT / ".." / "shared" / "data")
    write(Path(home).resolve())
    test = ["npx", "vitest", "run", "tests/studio/crops.test.ts"]
    everything = os.environ | {"ALL_CELLS": "1"}
    sys.exit(subprocess.run(test, cwd=FRONTEND, env=everything, check=False).returncode)
