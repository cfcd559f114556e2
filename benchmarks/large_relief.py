"""Time and memory of `rumu relief` on a photograph of 48 megapixels: `python benchmarks/large_relief.py`.

The photograph is made: characters of the starter gallery on a shaded page with noise, 8000 x 6000 pixels, as
a JPEG. Printed are the seconds, the peak of memory and the size of what was written, of a process of its own.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from rumu.gallery.starter import starter_works

WIDTH, HEIGHT, ROWS = 8000, 6000, 3
SECONDS, MEGABYTES = 12, 1500  # wanted at most, on two free cores
RUN = """
import sys
from rumu.cli import main
sys.argv = ["rumu", "relief", {image!r}, "-o", {out!r}]
try:
    main()
finally:
    print("peak", open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
"""


def make_page(path: Path) -> None:
    """A page of characters, darker on one side, with the noise of a camera."""
    rng = np.random.default_rng(1)
    page = np.full((HEIGHT, WIDTH), 235.0, np.float32)
    works, cell = starter_works(script="regular"), HEIGHT // ROWS
    side, margin = int(cell * 0.8), int(cell * 0.1)
    for number in range(ROWS * (WIDTH // cell)):
        row, column = divmod(number, WIDTH // cell)
        with Image.open(works[number % len(works)].path) as glyph:
            ink = np.asarray(glyph.convert("L").resize((side, side)), np.float32) / 255
        y, x = row * cell + margin, column * cell + margin
        page[y : y + side, x : x + side] *= ink * 0.85 + 0.15
    page *= np.linspace(1.0, 0.85, WIDTH, dtype=np.float32)
    colours = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    for top in range(0, HEIGHT, 500):
        strip = page[top : top + 500, :, None] * np.array([1.0, 0.97, 0.9], np.float32)
        colours[top : top + 500] = (strip + rng.normal(0, 4, strip.shape)).clip(0, 255)
    Image.fromarray(colours).save(path, quality=90)


def main() -> None:
    """Make the page, raise it, print."""
    import time

    with tempfile.TemporaryDirectory(prefix="rumu-") as folder:
        image, out = Path(folder) / "page.jpg", Path(folder) / "out"
        make_page(image)
        code = RUN.format(image=str(image), out=str(out))
        started = time.perf_counter()
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        seconds = time.perf_counter() - started
        written = sum(file.stat().st_size for file in out.iterdir()) / 1e6
        peak = int(re.findall(r"peak (\d+)", done.stdout)[-1]) / 1000
    print(done.stdout.split("\npeak")[0])
    print(f"{WIDTH} x {HEIGHT} pixels: {seconds:.1f} s (wanted: {SECONDS}), ", end="")
    print(f"{peak:.0f} MB of memory (wanted: {MEGABYTES}), {written:.0f} MB written")


if __name__ == "__main__":
    main()
