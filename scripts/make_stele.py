#!/usr/bin/env python3
"""Carve the starter gallery's stele and photograph it, all by simulation: src/rumu/gallery/starter_stele/.

    .venv/bin/python scripts/make_stele.py FONT

FONT: ma-shan-zheng-chinese-simplified-400-normal.woff2 of the npm package @fontsource/ma-shan-zheng
(Ma Shan Zheng, OFL-1.1). Nothing of the font but the drawing of four characters goes into the photographs.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery.fonts import Face
from rumu.outputs import whole_folder
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation.lamps import Sensor, photographs

ROOT = Path(__file__).resolve().parents[1]
STELE = ROOT / "src" / "rumu" / "gallery" / "starter_stele"
COLUMNS = ("入木", "三分")  # from right to left
LAMPS = tuple(
    (tilt, slant)
    for slant, first in ((42.0, 0.0), (64.0, 36.0))
    for tilt in first + np.arange(0.0, 360.0, 72.0)
)
SPACING = 0.35  # mm for each pixel


@dataclass(frozen=True, slots=True)
class Stone:
    """A slab and how it was carved; lengths in pixels.

    side: of a character's square; glyph: of its drawing, which has a margin of its own. margin: around all.
    depth: of the deepest groove; wall: its steepness, degrees. waves: height of the slab's unevenness.
    grain: of its roughness. chips: how many pits there are for each megapixel.
    quality: of the JPEG photographs.
    """

    side: int = 310
    glyph: int = 400
    margin: int = 52
    depth: float = 13.0
    wall: float = 52.0
    waves: float = 1.3
    grain: float = 0.22
    chips: int = 700
    quality: int = 86
    seed: int = 5


def carved(stone: Stone, face: Face) -> tuple[FloatArray, FloatArray]:
    """Height (H, W) in pixels and linear albedo (H, W, 3) of the slab."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    rng = np.random.default_rng(stone.seed)
    writing = inscription(stone, face)
    size = writing.shape
    rough = fractal(size, rng=rng)
    # Stone breaks along the edge of a groove, so the outline is moved by a noise of its own.
    edge = gaussian_filter(writing.astype(float), 1.2) + 0.16 * fractal(size, rng=rng, coarsest=9.0)
    inside = distance_transform_edt(edge > 0.5)
    wall = inside * np.tan(np.radians(stone.wall))
    groove = stone.depth * np.tanh(wall / stone.depth)  # steep at its edge, round at its bottom
    pits = np.zeros(size)
    count = round(stone.chips * writing.size / 1e6)
    pits[rng.integers(0, size[0], count), rng.integers(0, size[1], count)] = rng.gamma(1.2, 5.0, count)
    height = stone.waves * rough - gaussian_filter(groove, 0.8) - gaussian_filter(pits, 1.6)
    height += stone.grain * gaussian_filter(rng.normal(0.0, 1.0, size), 0.9)
    tone = 0.40 + 0.045 * fractal(size, rng=rng) - 0.05 * np.minimum(groove / stone.depth, 1.0)
    colour = np.array([1.0, 0.955, 0.875])
    return height, np.clip(tone[..., None] * colour, 0.05, 0.9)


def inscription(stone: Stone, face: Face) -> BoolArray:
    """The characters in columns from right to left, (H, W)."""
    rows, columns = max(map(len, COLUMNS)), len(COLUMNS)
    size = (2 * stone.margin + rows * stone.side, 2 * stone.margin + columns * stone.side)
    mask = np.zeros(size, bool)
    for column, characters in enumerate(COLUMNS):
        for row, character in enumerate(characters):
            glyph = face.picture(character).resize((stone.glyph, stone.glyph), Image.Resampling.LANCZOS)
            before = (stone.glyph - stone.side) // 2
            top = stone.margin + row * stone.side - before
            left = size[1] - stone.margin - (column + 1) * stone.side - before
            mask[top : top + stone.glyph, left : left + stone.glyph] |= np.asarray(glyph) < 128
    return mask


def fractal(size: tuple[int, int], *, rng: np.random.Generator, coarsest: float = 120.0) -> FloatArray:
    """Noise of all sizes up to `coarsest` pixels, the coarse the stronger; (H, W), standard deviation 1."""
    from scipy.ndimage import gaussian_filter

    total, scale = np.zeros(size), coarsest
    while scale >= 1.5:
        layer = gaussian_filter(rng.normal(0.0, 1.0, size), scale)
        total += layer / layer.std() * np.sqrt(scale)
        scale /= 2.0
    return np.asarray(total / total.std())


def _save(image: FloatArray, path: Path, *, quality: int) -> None:
    Image.fromarray(np.rint(255 * image).astype(np.uint8)).save(path, quality=quality, subsampling=0)


def main(arguments: list[str] | None = None) -> int:
    """Write the capture, or say in one line what is missing and write nothing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("font", type=Path)
    parser.add_argument("--output", type=Path, default=STELE)
    options = parser.parse_args(arguments)
    stone = Stone()
    try:
        height, albedo = carved(stone, Face(options.font))
        tilts, slants = zip(*LAMPS, strict=True)
        images, lights = photographs(
            height,
            albedo,
            tilts=tilts,
            slant=slants,
            strengths=[1.5] * len(LAMPS),
            ambient=0.01,
            sensor=Sensor(noise=0.004, encoding="srgb", seed=stone.seed),
        )
        with whole_folder(options.output, marker="capture.json") as folder:
            mean = images.mean(axis=0)
            _save(mean / mean.max(), folder / "mean.jpg", quality=stone.quality)
            lines = [str(len(images))]
            for number, (image, light) in enumerate(zip(images, lights, strict=True), start=1):
                name = f"{number:03d}.jpg"
                _save(image, folder / name, quality=stone.quality)
                lines.append(f"{name} " + " ".join(f"{part:.6f}" for part in light))
            (folder / "lights.lp").write_text("\n".join(lines) + "\n", encoding="utf-8")
            (folder / "capture.json").write_text(
                json.dumps({"encoding": "srgb", "spacing_mm": SPACING}) + "\n", encoding="utf-8"
            )
    except GalleryError as error:
        print(f"make_stele: {error}", file=sys.stderr)
        return 1
    print(f"{len(images)} photographs of {height.shape[1]} x {height.shape[0]} pixels in {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
