"""Faults of single strokes: pushed, turned, shortened, thin, thick, left out, too many.

Each function takes a glyph, the size of the fault in its unit (pixels: of a picture 512 wide), and the random
generator that chooses the stroke.
"""

from __future__ import annotations

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation.glyph import ChangedGlyph, Glyph, region_of
from rumu_lab.simulation.ink import NO_INK, brush_depth, close_clefts, depth_of, move
from rumu_lab.simulation.strokes import BrushStroke

Random = np.random.Generator

_ASTRAY = np.radians(50.0)  # from straight aside; a push along itself would hide in the stroke
_SEAM = 1.0  # clefts up to so many brush radii are closed where a moved stroke met another


def shift(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke pushed `size` pixels (of 512) more aside than along itself, otherwise unchanged."""
    k = choose_stroke(glyph, rng)
    down, right = glyph.strokes[k].points[-1] - glyph.strokes[k].points[0]
    aside = np.arctan2(right, -down) + np.pi * rng.integers(2)
    turn = aside + rng.uniform(-1.0, 1.0) * _ASTRAY
    down, right = step = size * np.array([np.sin(turn), np.cos(turn)])
    depth, region = displace(glyph, k, matrix=np.eye(2), shift=step * glyph.scale)
    zh, en = glyph.named(k)
    return ChangedGlyph(
        depth,
        size,
        (k,),
        region,
        en=f"{en} is pushed {size:.1f} px: {abs(right):.1f} px {'right' if right > 0 else 'left'}, "
        f"{abs(down):.1f} px {'down' if down > 0 else 'up'}",
        zh=f"{zh}偏移 {size:.1f} 像素：向{'右' if right > 0 else '左'} {abs(right):.1f}，"
        f"向{'下' if down > 0 else '上'} {abs(down):.1f}",
    )


def angle(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke turned `size` degrees about its own middle; positive is clockwise."""
    return _turn(glyph, choose_stroke(glyph, rng), size * rng.choice((-1.0, 1.0)))


def horizontal(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One lying stroke turned `size` degrees about its own middle; positive is clockwise.

    Raises SurfaceError when no stroke lies within 30 degrees of level.
    """
    chords = [stroke.points[-1] - stroke.points[0] for stroke in glyph.strokes]
    lying = [k for k, (down, right) in enumerate(chords) if abs(down) < np.tan(np.radians(30)) * abs(right)]
    if not lying:
        raise SurfaceError("expected a horizontal stroke to turn, found none")
    lengths = np.array([glyph.strokes[k].length for k in lying])
    k = lying[int(rng.choice(len(lying), p=lengths / lengths.sum()))]
    return _turn(glyph, k, size * rng.choice((-1.0, 1.0)))


def _turn(glyph: Glyph, k: int, degrees: float) -> ChangedGlyph:
    size = abs(degrees)
    depth, region = displace(glyph, k, matrix=clockwise(degrees), shift=np.zeros(2))
    zh, en = glyph.named(k)
    way = ("clockwise", "順時針") if degrees > 0 else ("counter-clockwise", "逆時針")
    return ChangedGlyph(
        depth,
        degrees,
        (k,),
        region,
        en=f"{en} is turned {size:.1f} degrees {way[0]}",
        zh=f"{zh}{way[1]}轉了 {size:.1f} 度",
    )


def short(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke `size` per cent shorter along its chord; an end that joins another stroke stays there."""
    k = choose_stroke(glyph, rng)
    stroke = glyph.strokes[k]
    chord = stroke.points[-1] - stroke.points[0]
    along = chord / max(float(np.linalg.norm(chord)), 1e-9)
    fixed = stroke.points.mean(axis=0)
    if stroke.free[0] != stroke.free[1]:
        fixed = stroke.points[0] if stroke.free[1] else stroke.points[-1]
    shrink = np.eye(2) - size / 100.0 * np.outer(along, along)
    depth, region = displace(glyph, k, matrix=shrink, shift=np.zeros(2), centre=fixed)
    zh, en = glyph.named(k)
    return ChangedGlyph(
        depth, size, (k,), region, en=f"{en} is {size:.0f} % too short", zh=f"{zh}短了 {size:.0f}%"
    )


def thin(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke that loses `size` pixels (of 512) at each edge; a third of its width always stays."""
    k = choose_stroke(glyph, rng)
    stroke = glyph.strokes[k]
    core = brush_depth(glyph.mask.shape, stroke.points, 0.35 * stroke.radius)
    thinner = np.maximum(depth_of(stroke.ink) - size * glyph.scale, core)
    # Where it crosses others their ink stays, so the thinner stroke is laid over the rest.
    depth = np.maximum(depth_of(glyph.without(k)), thinner)
    zh, en = glyph.named(k)
    return ChangedGlyph(
        depth,
        size,
        (k,),
        region_of(stroke.ink),
        en=f"{en} is {size:.1f} px too thin at each edge",
        zh=f"{zh}太細，每邊少 {size:.1f} 像素",
    )


def thick(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke that gains `size` pixels (of 512) at each edge."""
    k = choose_stroke(glyph, rng)
    grown = depth_of(glyph.strokes[k].ink) + size * glyph.scale
    zh, en = glyph.named(k)
    return ChangedGlyph(
        np.maximum(glyph.depth, grown),
        size,
        (k,),
        region_of(grown > 0),
        en=f"{en} is {size:.1f} px too thick at each edge",
        zh=f"{zh}太粗，每邊多 {size:.1f} 像素",
    )


def missing(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """`size` per cent of the strokes left out, at least one, and at least one always stays.

    Raises SurfaceError when there is one stroke alone.
    """
    count = len(glyph.strokes)
    if count < 2:
        raise SurfaceError("expected two strokes or more to leave one out, found one stroke")
    gone = max(1, round(size / 100.0 * count))
    order = rng.permutation(count)
    left_out = tuple(int(k) for k in order[: min(gone, count - 1)])
    rest = glyph.without(*left_out)
    lost = glyph.mask & ~rest
    names = [glyph.named(k) for k in left_out]
    return ChangedGlyph(
        depth_of(rest),
        100.0 * len(left_out) / count,
        left_out,
        region_of(lost),
        en=f"{len(names)} of {count} strokes left out: {'; '.join(en for _, en in names)}",
        zh=f"{count} 筆漏寫 {len(names)} 筆：{'；'.join(zh for zh, _ in names)}",
    )


def extra(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """`size` strokes too many (at least one): shorter copies of its own strokes, where there is room."""
    depth, added = glyph.depth, np.full(glyph.mask.shape, NO_INK)
    count = max(1, round(size))
    for _ in range(count):
        one = _extra_stroke(glyph, depth, rng)
        added, depth = np.maximum(added, one), np.maximum(depth, one)
    plural = "strokes" if count > 1 else "stroke"
    return ChangedGlyph(
        depth,
        float(count),
        (),
        region_of(added > 0),
        en=f"{count} {plural} too many",
        zh=f"多寫了 {count} 筆",
    )


def choose_stroke(glyph: Glyph, rng: Random) -> int:
    """A stroke, the longer the likelier: a fault in a speck is no fault that a person would see."""
    lengths = np.array([stroke.length for stroke in glyph.strokes])
    return int(rng.choice(len(lengths), p=lengths / lengths.sum()))


def clockwise(degrees: float) -> FloatArray:
    """(2, 2) matrix on (row, column) that turns clockwise as seen; rows grow downward."""
    turn = np.radians(degrees)
    return np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])


def displace(
    glyph: Glyph, k: int, *, matrix: FloatArray, shift: FloatArray, centre: FloatArray | None = None
) -> tuple[FloatArray, tuple[float, float, float, float]]:
    """Depth of the glyph with stroke `k` transformed, its joints closed again; and where it now lies."""
    stroke = glyph.strokes[k]
    pivot = stroke.points.mean(axis=0) if centre is None else centre
    rest = glyph.without(k)
    gone = move(depth_of(stroke.ink), matrix=matrix, centre=pivot, shift=shift)
    depth = np.maximum(depth_of(rest), gone)
    seam = _seam(stroke, glyph.mask & rest, matrix=matrix, pivot=pivot, shift=shift)
    gap = _SEAM * float(np.median(stroke.radius))
    return close_clefts(depth, gap=gap, near=seam), region_of(gone > 0)


def _seam(
    stroke: BrushStroke, rest: BoolArray, *, matrix: FloatArray, pivot: FloatArray, shift: FloatArray
) -> BoolArray:
    """Where the stroke met others, widened by the brush and by how far the joint itself has moved."""
    from scipy.ndimage import distance_transform_edt

    met = stroke.ink & rest
    if not met.any():
        return np.zeros_like(met)
    middle = np.argwhere(met).mean(axis=0)
    travelled = float(np.linalg.norm((matrix - np.eye(2)) @ (middle - pivot) + shift))
    reach = float(np.median(stroke.radius)) + travelled
    return np.asarray(distance_transform_edt(~met) <= reach)


def _extra_stroke(glyph: Glyph, depth: FloatArray, rng: Random) -> FloatArray:
    """A short stroke like the beginning of some other, at the best of a few random places: near, but free."""
    rows, columns = np.nonzero(glyph.mask)
    low = np.array([rows.min(), columns.min()], dtype=np.float64)
    high = np.array([rows.max(), columns.max()], dtype=np.float64)
    diagonal = float(np.linalg.norm(high - low))
    stroke = glyph.strokes[choose_stroke(glyph, rng)]
    wide = min(float(np.median(stroke.radius)), 0.04 * diagonal)
    count = int(max(0.2 * diagonal, 4.0 * wide))
    path = stroke.points[:count]
    taper = np.linspace(1.0, 0.4, len(path))  # it is lifted off at its end
    own = brush_depth(glyph.mask.shape, path, np.minimum(stroke.radius[: len(path)], 1.1 * wide) * taper)
    middle, best, least = path.mean(axis=0), own, np.inf
    for _ in range(12):
        turn = clockwise(rng.uniform(-40.0, 40.0))
        one = move(own, matrix=turn, centre=middle, shift=rng.uniform(low, high) - middle)
        overlap = float(((one > 0) & (depth > -0.7 * wide)).sum())
        cut_off = max(float((own > 0).sum()) - float((one > 0).sum()), 0.0)
        if overlap + cut_off < least:
            best, least = one, overlap + cut_off
    return best
