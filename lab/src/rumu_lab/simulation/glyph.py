"""A glyph as a fault finds it: its ink, its strokes, and words for where a stroke lies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation.ink import brush_depth, depth_of
from rumu_lab.simulation.strokes import BrushStroke, separate

Region = tuple[float, float, float, float]

_REAL_STROKE = 0.025  # of all ink; what is less is a speck that a fault could not be seen in
_DOT = 6.5  # a stroke shorter than so many of its own radii is a dot

_ROWS = (("上", "upper"), ("中", "middle"), ("下", "lower"))
_COLUMNS = (("左", "left"), ("中", "middle"), ("右", "right"))


@dataclass(frozen=True)
class Glyph:
    """An ink mask (H, W) bool with what is computed from it when first asked for."""

    mask: BoolArray

    def __post_init__(self) -> None:
        if self.mask.ndim != 2 or self.mask.dtype != np.bool_:
            raise SurfaceError(f"expected an (H, W) bool mask, got {self.mask.dtype} {self.mask.shape}")
        if not self.mask.any():
            raise SurfaceError("expected a mask that holds ink, got an empty one")

    @property
    def scale(self) -> float:
        """Pixels of this picture for one pixel of a picture 512 wide."""
        return float(max(self.mask.shape)) / 512.0

    @cached_property
    def depth(self) -> FloatArray:
        """(H, W) float32, signed distance to the edge of the ink."""
        return depth_of(self.mask)

    @cached_property
    def strokes(self) -> tuple[BrushStroke, ...]:
        """Strokes large enough to be seen, longest first; a speck belongs to the stroke that it touches."""
        ink = int(self.mask.sum())
        real = [s for s in self._all_strokes if s.ink.sum() >= _REAL_STROKE * ink] or [self._all_strokes[0]]
        own = [s.ink.copy() for s in real]
        for speck in (s for s in self._all_strokes if s not in real):
            reach = _grow(speck.ink)
            touching = [int((reach & s.ink).sum()) for s in real]
            if max(touching) > 0:
                own[int(np.argmax(touching))] |= speck.ink
        return tuple(replace(stroke, ink=mask) for stroke, mask in zip(real, own, strict=True))

    @cached_property
    def _all_strokes(self) -> tuple[BrushStroke, ...]:
        return separate(self.mask)

    @cached_property
    def core(self) -> FloatArray:
        """Depth of a thin line along every stroke: what no thinning may take away."""
        thin = [brush_depth(self.mask.shape, s.points, 0.35 * s.radius) for s in self._all_strokes]
        return np.asarray(np.max(thin, axis=0), dtype=np.float32)

    def without(self, *strokes: int) -> BoolArray:
        """The ink that is left when these strokes are taken out; what other strokes cover as well stays."""
        gone = np.logical_or.reduce([self.strokes[k].ink for k in strokes])
        stays = [s.ink for k, s in enumerate(self.strokes) if k not in strokes]
        kept = np.logical_or.reduce([np.zeros_like(gone), *stays])
        return np.asarray(self.mask & ~(gone & ~kept))

    def named(self, stroke: int) -> tuple[str, str]:
        """Chinese and English words for a stroke: its direction and its place in the character."""
        s = self.strokes[stroke]
        zh, en = _direction(s)
        place_zh, place_en = self._place(s)
        return f"{place_zh}的{zh}", f"the {en} at the {place_en}"

    def _place(self, stroke: BrushStroke) -> tuple[str, str]:
        x0, y0, x1, y1 = region_of(self.mask)
        height, width = self.mask.shape
        row, column = stroke.points.mean(axis=0) / (height, width)
        across = min(int(3 * (column - x0) / max(x1 - x0, 1e-9)), 2)
        down = min(int(3 * (row - y0) / max(y1 - y0, 1e-9)), 2)
        if (down, across) == (1, 1):
            return "中央", "centre"
        zh = (_COLUMNS[across][0] if across != 1 else "") + (_ROWS[down][0] if down != 1 else "")
        en = " ".join(w for w in (_ROWS[down][1] * (down != 1), _COLUMNS[across][1] * (across != 1)) if w)
        return zh + ("方" if len(zh) == 1 else ""), {"upper": "top", "lower": "bottom"}.get(en, en)


@dataclass(frozen=True, slots=True, eq=False)
class ChangedGlyph:
    """What a fault did to a glyph.

    depth: (H, W) float32, the ink after the fault. size: of the fault, in the unit of its kind.
    strokes: numbers of those that have the fault. region: where. en, zh: what was done.
    density: darkness of the ink, one number for all of it; None is 1. apart: where strokes were pushed each
    its own way, how far the one that was pushed farthest stands from where all were on average; pixels of a
    picture 512 wide.
    """

    depth: FloatArray
    size: float
    strokes: tuple[int, ...]
    region: Region
    en: str
    zh: str
    density: float | None = None
    apart: float = 0.0


def region_of(mask: BoolArray) -> Region:
    """(x0, y0, x1, y1) of a mask in fractions of the picture, origin top left; all of it when empty."""
    if not mask.any():
        return (0.0, 0.0, 1.0, 1.0)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    height, width = mask.shape
    return (
        float(columns[0] / width),
        float(rows[0] / height),
        float((columns[-1] + 1) / width),
        float((rows[-1] + 1) / height),
    )


def _grow(mask: BoolArray) -> BoolArray:
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(mask, iterations=2))


def written_forward(stroke: BrushStroke) -> bool:
    """Whether the path runs as a brush would: downward, or to the right when it lies flat."""
    row, column = stroke.points[-1] - stroke.points[0]
    return bool(row + 0.6 * column >= 0)


def _direction(stroke: BrushStroke) -> tuple[str, str]:
    chord = stroke.points[-1] - stroke.points[0]
    straight = float(np.linalg.norm(chord))
    if stroke.length < _DOT * float(np.median(stroke.radius)):
        return "點", "dot"
    if stroke.length > 1.3 * straight:
        return "曲筆", "curved stroke"
    angle = np.degrees(np.arctan2(-chord[0], chord[1])) % 180.0
    if angle < 25.0 or angle > 155.0:
        return "橫", "horizontal stroke"
    if 70.0 < angle < 110.0:
        return "豎", "vertical stroke"
    return ("撇", "left-falling stroke") if angle < 90.0 else ("捺", "right-falling stroke")
