#!/usr/bin/env python3
"""Write reference values for the front end's arithmetic: frontend/tests/vectors/viewer.json.

The viewer computes shading, normals, colours and cross-sections itself. Its tests compare them with these
values, which come from rumu and from other libraries (matplotlib for colours, scipy for sampling).
tests/frontend/test_vectors.py runs this script.

    .venv/bin/python scripts/write_vectors.py [FILE]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import rumu
from rumu.report.pictures import srgb
from rumu.surface.relight import relight_three
from rumu.values import Surface

TARGET = Path(__file__).parents[1] / "frontend" / "tests" / "vectors" / "viewer.json"
LAMPS = [(135.0, 45.0), (0.0, 0.0), (90.0, 30.0), (200.0, 75.0), (315.5, 88.0), (359.0, 12.5)]
SIDE = 24


def main(target: Path = TARGET) -> None:
    """Write all reference values to a file."""
    rng = np.random.default_rng(20261122)
    surface = dome(SIDE, rng)
    vectors = {
        "srgb": srgb_codes(),
        "normals": packed_normals(surface),
        "relight": relit_images(surface),
        "three": three_lamp_mixtures(surface),
        "colours": height_colours(),
        "contours": contour_levels(rng),
        "section": section_samples(rng),
    }
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(vectors))


def dome(side: int, rng: np.random.Generator) -> Surface:
    """Return a dome on a plane with random colours; x right, y up, rows downward."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(1, -1, side))
    radius = np.hypot(x, y)
    height = np.where(radius < 0.7, 0.5 * np.cos(np.pi * radius / 1.4) ** 2, 0.0) * side / 2
    rows, columns = np.gradient(height)
    normals = np.stack([-columns, rows, np.ones_like(height)], axis=-1)  # dz/dy = -dz/drow
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return Surface(
        height=height.astype(np.float32),
        normals_from=normals.astype(np.float32),
        albedo_from=rng.uniform(0.05, 1.0, (side, side, 3)).astype(np.float32),
        mask=np.ones((side, side), dtype=np.bool_),
        confidence=np.ones((side, side), dtype=np.float32),
        spacing=1.0,
        unit="px",
        source="photometric",
    )


def srgb_codes() -> dict[str, Any]:
    """Return linear values and the 16-bit sRGB codes that the package writes for them."""
    linear = np.linspace(0.0, 1.0, 101, dtype=np.float32)
    return {"linear": linear.tolist(), "codes": srgb(linear[None], bits=16)[0].tolist()}


def packed_normals(surface: Surface) -> dict[str, Any]:
    """Return normals and the bytes in which the service sends them."""
    from rumu.gallery.renderers import normals_8

    packed = normals_8(surface, SIDE).reshape(-1, 3)
    return {"bytes": packed.tolist(), "normals": surface.normals.reshape(-1, 3).tolist()}


def relit_images(surface: Surface) -> dict[str, Any]:
    """Return a surface under several lamps."""
    lit = [rumu.relight(surface, tilt=tilt, slant=slant) for tilt, slant in LAMPS]
    return {
        "side": SIDE,
        "albedo": surface.albedo.reshape(-1, 3).tolist(),
        "normals": surface.normals.reshape(-1, 3).tolist(),
        "lamps": LAMPS,
        "lit": [image.reshape(-1, 3).tolist() for image in lit],
    }


def three_lamp_mixtures(surface: Surface, slant: float = 40.0) -> dict[str, Any]:
    """Return three photographs, and images under other lamps mixed from them."""
    a, b, c = (rumu.relight(surface, tilt=tilt, slant=slant)[..., 1] for tilt in (0.0, 90.0, 180.0))
    lamps = [(tilt, new) for tilt, new in LAMPS if new > 0]
    mixed = [relight_three(a, b, c, slant=slant, tilt=tilt, new_slant=new) for tilt, new in lamps]
    flat = {name: image.ravel().tolist() for name, image in zip("abc", (a, b, c), strict=True)}
    return {"slant": slant, "lamps": lamps, "mixed": [image.ravel().tolist() for image in mixed]} | flat


def height_colours() -> dict[str, Any]:
    """Return matplotlib's 256 colours of viridis."""
    from matplotlib import colormaps

    table = np.asarray(colormaps["viridis"](np.arange(256)))[:, :3]
    return {"at": np.linspace(0, 1, 256).tolist(), "rgb": table.tolist()}


def contour_levels(rng: np.random.Generator) -> dict[str, Any]:
    """Return ranges, the multiples of a round step in them, and distances of heights from contour lines."""
    ranges = [(0.0, 22.3, 14), (-1.2, 0.9, 5), (0.003, 0.0171, 4), (120.0, 4800.0, 6)]
    heights = rng.uniform(-3, 3, 60)
    interval = 0.25
    nearest = np.abs(heights[:, None] - np.arange(-20, 21) * interval).min(axis=1) / interval
    return {
        "ranges": [[low, high, count, _multiples(low, high, count)] for low, high, count in ranges],
        "heights": heights.tolist(),
        "interval": interval,
        "distance": nearest.tolist(),
    }


def _multiples(low: float, high: float, count: int) -> list[float]:
    """Return the multiples of a round step within [low, high].

    The step is about (high - low) / count, rounded to 1, 2, 5 or 10 times a power of ten: below 1.5 to one,
    below 3.5 to two, below 7.5 to five, else to ten.
    """
    rough = (high - low) / count
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * (1, 2, 5, 10)[int(np.searchsorted([1.5, 3.5, 7.5], rough / power, side="right"))]
    factors = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1)
    return [float(value) for value in factors * step]


def section_samples(rng: np.random.Generator) -> dict[str, Any]:
    """Return heights, a line over them in fractions, and what scipy samples along it, with the distances."""
    from scipy.ndimage import map_coordinates

    rows, columns, spacing = 12, 20, 0.25
    heights = rng.normal(size=(rows, columns)).astype(np.float32)
    x0, y0, x1, y1 = line = (0.02, 0.9, 0.97, 0.08)
    t = np.linspace(0, 1, 33)
    u, v = x0 + (x1 - x0) * t, y0 + (y1 - y0) * t
    positions: npt.NDArray[np.float64] = np.stack([v * rows - 0.5, u * columns - 0.5])
    sampled = map_coordinates(heights.astype(np.float64), positions, order=1, mode="nearest")
    length = float(np.hypot((x1 - x0) * columns, (y1 - y0) * rows) * spacing)
    return {
        "heights": heights.ravel().tolist(),
        "size": [columns, rows],
        "spacing": spacing,
        "line": line,
        "distance": (t * length).tolist(),
        "sampled": sampled.tolist(),
    }


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
