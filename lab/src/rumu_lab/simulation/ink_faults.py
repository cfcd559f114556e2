"""Faults of brush and ink: trembling edges, blunt ends, blots, pale ink, dry streaks.

Each function takes a glyph, the size of the fault in its unit (pixels: of a picture 512 wide), and the random
generator that makes the noise.
"""

from __future__ import annotations

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import FloatArray
from rumu_lab.simulation.glyph import ChangedGlyph, Glyph, region_of, written_forward
from rumu_lab.simulation.ink import NO_INK, brush_depth, roughness, tremble
from rumu_lab.simulation.strokes import BrushStroke

Random = np.random.Generator

_TREMOR = 26.0  # pixels of 512 from one swing of a trembling hand to the next
_ROUGH = 0.3  # of the tremor that reaches each edge on its own
_HAIRS = 7.0  # streaks that a dry brush leaves on each side of a stroke's middle


def wobble(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """Strokes of a trembling hand: they leave their way by `size` pixels (of 512, root mean square)."""
    pixels, seed = size * glyph.scale, int(rng.integers(2**31))
    shaken = tremble(glyph.depth, pixels=pixels, grain=_TREMOR * glyph.scale, seed=seed)
    core = tremble(glyph.core, pixels=pixels, grain=_TREMOR * glyph.scale, seed=seed)
    rough = roughness(glyph.mask.shape, grain=0.5 * _TREMOR * glyph.scale, seed=seed + 2)
    depth = np.maximum(shaken + _ROUGH * pixels * rough, core)
    return ChangedGlyph(
        depth,
        size,
        (),
        region_of(depth > 0),
        en=f"the strokes tremble by {size:.1f} px",
        zh=f"筆畫抖動約 {size:.1f} 像素",
    )


def blunt(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """Tapered tips widened by `size` per cent of what they lack to the full width: a felt pen at 100."""
    tips, struck = np.full(glyph.mask.shape, NO_INK, dtype=np.float32), []
    for k, stroke in enumerate(glyph.strokes):
        filled = _fill_tips(stroke, size / 100.0)
        if filled is not None:
            tips = np.maximum(tips, brush_depth(glyph.mask.shape, *filled))
            struck.append(k)
    return ChangedGlyph(
        np.maximum(glyph.depth, tips),
        size,
        tuple(struck),
        region_of((tips > 0) & ~glyph.mask),
        en=f"tips of {len(struck)} strokes are blunt: {size:.0f} % of their taper is gone",
        zh=f"{len(struck)} 筆的筆鋒禿鈍，失去 {size:.0f}% 的尖銳",
    )


def entry(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """One stroke that begins `size` per cent too wide: the brush was pressed down and only then moved on.

    The surplus falls off over the first quarter of the stroke. Raises SurfaceError when every stroke begins
    in another one.
    """
    begins = [k for k, stroke in enumerate(glyph.strokes) if _begins_free(stroke)]
    if not begins:
        raise SurfaceError("expected a stroke that begins by itself, found none")
    lengths = np.array([glyph.strokes[k].length for k in begins])
    k = begins[int(rng.choice(len(begins), p=lengths / lengths.sum()))]
    stroke = glyph.strokes[k]
    forward = written_forward(stroke)
    path, radius = (stroke.points, stroke.radius) if forward else (stroke.points[::-1], stroke.radius[::-1])
    count = max(len(path) // 4, 2)
    surplus = size / 100.0 * np.cos(np.linspace(0.0, np.pi / 2, count))
    # a tip that tapers is pressed to what the stroke has next to it
    pressed = np.maximum(radius[:count], 0.8 * float(np.median(radius[: 2 * count]))) * (1.0 + surplus)
    head = brush_depth(glyph.mask.shape, path[:count], np.where(surplus > 0.02, pressed, radius[:count]))
    zh, en = glyph.named(k)
    return ChangedGlyph(
        np.maximum(glyph.depth, head),
        size,
        (k,),
        region_of((head > 0) & ~glyph.mask) if ((head > 0) & ~glyph.mask).any() else region_of(stroke.ink),
        en=f"{en} begins {size:.0f} % too heavy",
        zh=f"{zh}起筆太重，寬了 {size:.0f}%",
    )


def blot(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """Blots at the edges of strokes that together cover `size` per cent as much as the ink."""
    count = max(1, round(size / 3.0))
    radius = float(np.sqrt(size / 100.0 * glyph.mask.sum() / (count * np.pi)))
    rough = roughness(glyph.mask.shape, grain=1.2 * radius, seed=int(rng.integers(2**31)))
    blots = np.full(glyph.mask.shape, NO_INK, dtype=np.float32)
    for _ in range(count):
        place = _open_place(np.maximum(glyph.depth, blots), radius, rng)
        drop = brush_depth(glyph.mask.shape, place[None], np.array([radius]))
        blots = np.maximum(blots, drop + 0.18 * radius * rough)
    depth = np.maximum(glyph.depth, blots)
    added = (blots > 0) & ~glyph.mask
    share = 100.0 * float(added.sum() / glyph.mask.sum())
    return ChangedGlyph(
        depth,
        share,
        (),
        region_of(added),
        en=f"{count} blot{'s' if count > 1 else ''}, {share:.0f} % as much as the ink",
        zh=f"{count} 處墨漬，為墨跡的 {share:.0f}%",
    )


def pale(glyph: Glyph, size: float, _: Random) -> ChangedGlyph:
    """Ink `size` per cent lighter all over; its shape does not change."""
    return ChangedGlyph(
        glyph.depth,
        size,
        (),
        region_of(glyph.mask),
        en=f"the ink is {size:.0f} % too pale",
        zh=f"墨色淡了 {size:.0f}%",
        density=1.0 - size / 100.0,
    )


def dry(glyph: Glyph, size: float, rng: Random) -> ChangedGlyph:
    """Streaks of bare paper along the strokes, more toward their ends, in all `size` per cent of the ink."""
    urge = np.full(glyph.mask.shape, NO_INK, dtype=np.float32)
    for stroke in glyph.strokes:
        urge = np.where(stroke.ink, np.maximum(urge, _dryness(stroke, rng)), urge)
    inside = urge[glyph.mask & (urge > NO_INK)]
    level = float(np.quantile(inside, 1.0 - min(size / 100.0 * glyph.mask.sum() / inside.size, 0.9)))
    # The urge becomes a depth whose zero is the edge of a streak, a pixel or so deep.
    depth = np.minimum(glyph.depth, (level - urge) * 4.0 * glyph.scale)
    lost = glyph.mask & (urge > level)
    share = 100.0 * float(lost.sum() / glyph.mask.sum())
    return ChangedGlyph(
        depth,
        share,
        (),
        region_of(lost),
        en=f"dry streaks take {share:.0f} % of the ink",
        zh=f"枯筆露白，佔墨跡的 {share:.0f}%",
    )


def _open_place(depth: FloatArray, radius: float, rng: Random) -> FloatArray:
    """A place where a drop of this radius touches the ink and still shows; (row, column)."""
    touching = np.argwhere(np.abs(depth + 0.75 * radius) < 1.0)
    if len(touching) == 0:
        touching = np.argwhere(depth > 0)
    tried = touching[rng.integers(len(touching), size=8)]
    offsets = np.argwhere(np.ones((5, 5))) * radius / 2.0 - radius
    around = (tried[:, None] + offsets).round().astype(int)
    rows, columns = np.clip(around, 0, np.array(depth.shape) - 1).transpose(2, 0, 1)
    bare = (depth[rows, columns] < 0).sum(axis=1)
    return np.asarray(tried[int(bare.argmax())], dtype=np.float64)


def _begins_free(stroke: BrushStroke) -> bool:
    return stroke.free[0 if written_forward(stroke) else 1]


def _fill_tips(stroke: BrushStroke, share: float) -> tuple[FloatArray, FloatArray] | None:
    """Path and radius of the brush that fills the free tips of a stroke; None when it has none."""
    full = float(np.median(stroke.radius))
    reach = min(int(3.0 * full) + 1, len(stroke.points) // 2)
    near = np.zeros(len(stroke.points), dtype=bool)
    if stroke.free[0]:
        near[:reach] = True
    if stroke.free[1]:
        near[len(near) - reach :] = True
    if not near.any():
        return None
    lacking = np.maximum(full - stroke.radius[near], 0.0)
    return stroke.points[near], stroke.radius[near] + share * lacking


def _dryness(stroke: BrushStroke, rng: Random) -> FloatArray:
    """(H, W): how readily the hairs run dry: streaks along the path, rising toward its end."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter, map_coordinates

    path = stroke.points if written_forward(stroke) else stroke.points[::-1]
    radius = stroke.radius if written_forward(stroke) else stroke.radius[::-1]
    off, index = np.ones(stroke.ink.shape, dtype=bool), np.zeros(stroke.ink.shape, dtype=int)
    row, column = np.clip(np.round(path).astype(int), 0, np.array(off.shape) - 1).T
    off[row, column], index[row, column] = False, np.arange(len(path))
    nearest = distance_transform_edt(off, return_distances=False, return_indices=True)
    at = index[tuple(nearest)]
    tangent = np.gradient(path, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    away = np.moveaxis(np.indices(off.shape), 0, -1) - path[at]
    across = (away[..., 1] * tangent[at, 0] - away[..., 0] * tangent[at, 1]) / np.maximum(radius[at], 1.0)
    hairs = gaussian_filter(rng.normal(size=(int(4 * _HAIRS), len(path) + 1)), (0.6, 0.08 * len(path)))
    hairs /= max(float(hairs.std()), 1e-9)
    where = np.stack([(np.clip(across, -1.5, 1.5) / 1.5 + 1.0) * (2 * _HAIRS - 0.5), at.astype(np.float64)])
    return np.asarray(
        map_coordinates(hairs, where, order=1, mode="nearest") + 1.2 * at / len(path), dtype=np.float32
    )
