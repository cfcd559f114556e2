#!/usr/bin/env python3
"""Write what the front end's arithmetic must give, as rumu gives it: frontend/tests/vectors/viewer.json.

The viewer shades, decodes, colours and cuts by itself. These vectors hold it to `rumu.relight` and to other
libraries (matplotlib for colours, scipy for sampling). Run by tests/frontend/test_vectors.py.

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
    """Write them all."""
    rng = np.random.default_rng(20261122)
    surface = bump(SIDE, rng)
    vectors = {
        "srgb": encoding(),
        "normals": decoding(surface),
        "relight": relighting(surface),
        "three": mixing(surface),
        "colours": colouring(),
        "contours": contouring(rng),
        "section": sampling(rng),
    }
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(vectors))


def bump(side: int, rng: np.random.Generator) -> Surface:
    """A raised dome on a plane, coloured at random: x right, y up, rows downward."""
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


def encoding() -> dict[str, Any]:
    """Linear values and the sRGB codes, 0 to 65535, that the package writes for them."""
    linear = np.linspace(0.0, 1.0, 101, dtype=np.float32)
    return {"linear": linear.tolist(), "codes": srgb(linear[None], bits=16)[0].tolist()}


def decoding(surface: Surface) -> dict[str, Any]:
    """Normals, and their bytes as the service sends them."""
    from rumu.gallery.renderers import normals_8

    packed = normals_8(surface, SIDE).reshape(-1, 3)
    return {"bytes": packed.tolist(), "normals": surface.normals.reshape(-1, 3).tolist()}


def relighting(surface: Surface) -> dict[str, Any]:
    """One surface under several lamps."""
    lit = [rumu.relight(surface, tilt=tilt, slant=slant) for tilt, slant in LAMPS]
    return {
        "side": SIDE,
        "albedo": surface.albedo.reshape(-1, 3).tolist(),
        "normals": surface.normals.reshape(-1, 3).tolist(),
        "lamps": LAMPS,
        "lit": [image.reshape(-1, 3).tolist() for image in lit],
    }


def mixing(surface: Surface, slant: float = 40.0) -> dict[str, Any]:
    """Three photographs, and others mixed from them."""
    a, b, c = (rumu.relight(surface, tilt=tilt, slant=slant)[..., 1] for tilt in (0.0, 90.0, 180.0))
    asked = [(tilt, new) for tilt, new in LAMPS if new > 0]
    mixed = [relight_three(a, b, c, slant=slant, tilt=tilt, new_slant=new) for tilt, new in asked]
    flat = {name: image.ravel().tolist() for name, image in zip("abc", (a, b, c), strict=True)}
    return {"slant": slant, "lamps": asked, "mixed": [image.ravel().tolist() for image in mixed]} | flat


def colouring() -> dict[str, Any]:
    """Viridis, as matplotlib's table of 256 colours has it."""
    from matplotlib import colormaps

    table = np.asarray(colormaps["viridis"](np.arange(256)))[:, :3]
    return {"at": np.linspace(0, 1, 256).tolist(), "rgb": table.tolist()}


def contouring(rng: np.random.Generator) -> dict[str, Any]:
    """Ranges with the multiples of a round step inside them, and how far heights stand from a line."""
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
    """Of the steps 1, 2, 5 times a power of ten, the one that stands nearest to range / count on the page:
    below 1.5 one, below 3.5 two, below 7.5 five, else ten."""
    rough = (high - low) / count
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * (1, 2, 5, 10)[int(np.searchsorted([1.5, 3.5, 7.5], rough / power, side="right"))]
    counted = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1)
    return [float(value) for value in counted * step]


def sampling(rng: np.random.Generator) -> dict[str, Any]:
    """Heights and a line over them, in fractions; what scipy samples along it, and how far along."""
    from scipy.ndimage import map_coordinates

    rows, columns, spacing = 12, 20, 0.25
    heights = rng.normal(size=(rows, columns)).astype(np.float32)
    x0, y0, x1, y1 = line = (0.02, 0.9, 0.97, 0.08)
    t = np.linspace(0, 1, 33)
    u, v = x0 + (x1 - x0) * t, y0 + (y1 - y0) * t
    where: npt.NDArray[np.float64] = np.stack([v * rows - 0.5, u * columns - 0.5])
    sampled = map_coordinates(heights.astype(np.float64), where, order=1, mode="nearest")
    whole = float(np.hypot((x1 - x0) * columns, (y1 - y0) * rows) * spacing)
    return {
        "heights": heights.ravel().tolist(),
        "size": [columns, rows],
        "spacing": spacing,
        "line": line,
        "distance": (t * whole).tolist(),
        "sampled": sampled.tolist(),
    }


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
