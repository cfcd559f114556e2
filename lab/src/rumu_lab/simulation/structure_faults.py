"""Faults of the whole character: weight, lean, place, size, proportion, spacing.

Each function takes a glyph, the size of the fault in its unit (pixels: of a picture 512 wide), and the random
generator that chooses the side.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rumu.values import FloatArray
from rumu_lab.simulation.glyph import ChangedGlyph, Glyph, region_of
from rumu_lab.simulation.ink import close_clefts, depth_of, move
from rumu_lab.simulation.severity import OFF_CENTRE_DOWN
from rumu_lab.simulation.stroke_faults import clockwise

Random = np.random.Generator


def thin(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """Every stroke loses `size` pixels (of 512) at each edge; a third of its width always stays."""
    depth = np.maximum(glyph.depth - size * glyph.scale, glyph.core)
    return _whole(
        depth,
        size,
        en=f"every stroke is {size:.1f} px too thin at each edge",
        zh=f"所有筆畫太細，每邊少 {size:.1f} 像素",
    )


def thick(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """Every stroke gains `size` pixels (of 512) at each edge."""
    return _whole(
        glyph.depth + size * glyph.scale,
        size,
        en=f"every stroke is {size:.1f} px too thick at each edge",
        zh=f"所有筆畫太粗，每邊多 {size:.1f} 像素",
    )


def lean(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """The character turned `size` degrees about the centroid of its ink; positive is clockwise."""
    degrees = size * rng.choice((-1.0, 1.0))
    depth = move(glyph.depth, matrix=clockwise(degrees), centre=_centroid(glyph), shift=np.zeros(2))
    way = ("clockwise", "右") if degrees > 0 else ("counter-clockwise", "左")
    return _whole(
        depth,
        degrees,
        en=f"the character leans {size:.1f} degrees {way[0]}",
        zh=f"整個字向{way[1]}傾斜 {size:.1f} 度",
    )


def off_centre(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """The character pushed `size` pixels (of 512) to a side and 8/11 of that up or down."""
    right, down = size * rng.choice((-1.0, 1.0), 2) * (1.0, OFF_CENTRE_DOWN)
    depth = move(
        glyph.depth, matrix=np.eye(2), centre=np.zeros(2), shift=np.array([down, right]) * glyph.scale
    )
    return _whole(
        depth,
        float(np.hypot(right, down)),
        en=f"the character sits {abs(right):.1f} px too far {'right' if right > 0 else 'left'} "
        f"and {abs(down):.1f} px too {'low' if down > 0 else 'high'}",
        zh=f"整個字偏{'右' if right > 0 else '左'} {abs(right):.1f} 像素、"
        f"偏{'下' if down > 0 else '上'} {abs(down):.1f} 像素",
    )


def small(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """The character `size` per cent smaller about the centroid of its ink, its strokes with it."""
    depth = move(
        glyph.depth, matrix=np.eye(2) * (1.0 - size / 100.0), centre=_centroid(glyph), shift=np.zeros(2)
    )
    return _whole(depth, size, en=f"the character is {size:.0f} % too small", zh=f"整個字小了 {size:.0f}%")


def narrow(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """The character `size` per cent narrower about the centroid of its ink, its height as it was."""
    depth = move(
        glyph.depth, matrix=np.diag([1.0, 1.0 - size / 100.0]), centre=_centroid(glyph), shift=np.zeros(2)
    )
    return _whole(depth, size, en=f"the character is {size:.0f} % too narrow", zh=f"整個字窄了 {size:.0f}%")


def squeeze(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """The left part widened by `size` per cent of the character's width, the right narrowed by as much.

    They part at the column with the least ink in the middle two fifths of the character.
    """
    from scipy.ndimage import map_coordinates

    columns = np.flatnonzero(glyph.mask.any(axis=0))
    left, right = float(columns[0]), float(columns[-1])
    width = max(right - left, 1.0)
    parting = _parting(glyph, left, width)
    # A quarter of the right part always stays, or its strokes would melt into one.
    pushed = min(size / 100.0 * width, 0.75 * (right - parting))
    x = np.arange(glyph.mask.shape[1], dtype=np.float64)
    source = np.interp(
        x, [-1e6, left, parting + pushed, right, 1e6], [left - 1e6, left, parting, right, right + 1e6]
    )
    source = np.where(x < left, x, np.where(x > right, x, source))
    rows = np.arange(glyph.mask.shape[0], dtype=np.float64)
    depth = map_coordinates(glyph.depth, np.meshgrid(rows, source, indexing="ij"), order=1, mode="nearest")
    return _whole(
        np.asarray(depth, dtype=np.float32),
        100.0 * pushed / width,
        en=f"the left part is wider by {100 * pushed / width:.0f} % of the character and squeezes the right",
        zh=f"左部寬了全字的 {100 * pushed / width:.0f}%，擠窄了右部",
    )


def uneven(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """Every stroke pushed its own way by about `size` pixels (of 512): the spaces come out uneven."""
    pixels = size * glyph.scale
    turns = rng.uniform(0.0, 2.0 * np.pi, len(glyph.strokes))
    lengths = pixels * rng.uniform(0.5, 1.5, len(glyph.strokes))
    depth = depth_of(glyph.without(*range(len(glyph.strokes))))
    steps = lengths[:, None] * np.column_stack([np.sin(turns), np.cos(turns)])
    long = np.array([stroke.length for stroke in glyph.strokes])
    apart = np.hypot(*(steps - np.average(steps, axis=0, weights=long)).T).max() / glyph.scale
    for stroke, step in zip(glyph.strokes, steps, strict=True):
        own = move(depth_of(stroke.ink), matrix=np.eye(2), centre=np.zeros(2), shift=step)
        depth = np.maximum(depth, own)
    # Strokes that touched go on touching, unless they were pushed far apart.
    met = np.sum([stroke.ink for stroke in glyph.strokes], axis=0) > 1
    brush = min(float(np.median(stroke.radius)) for stroke in glyph.strokes)
    depth = close_clefts(depth, gap=min(1.5 * pixels, 0.7 * brush), near=depth_of(met) > -pixels)
    change = _whole(
        depth,
        size,
        en=f"every stroke is pushed its own way by about {size:.1f} px",
        zh=f"各筆各自偏移約 {size:.1f} 像素，間距不勻",
    )
    return replace(change, apart=float(apart))


def _whole(depth: FloatArray, size: float, *, en: str, zh: str) -> ChangedGlyph:
    return ChangedGlyph(depth, size, (), region_of(depth > 0), en=en, zh=zh)


def _centroid(glyph: Glyph) -> FloatArray:
    return np.asarray(np.argwhere(glyph.mask).mean(axis=0))


def _parting(glyph: Glyph, left: float, width: float) -> float:
    ink = glyph.mask.sum(axis=0)
    low, high = int(left + 0.3 * width), int(left + 0.7 * width) + 1
    emptiest = np.flatnonzero(ink[low:high] == ink[low:high].min())
    return float(low + np.median(emptiest))
