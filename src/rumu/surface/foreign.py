"""Dark parts that no stroke of this character made: remains of seals, stains, a neighbour's strokes.

What is asked of a part is how pale and how red it is against the rest of the ink of the same picture, and
where it stands; so a picture of one level of ink whose parts stand together stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.surface.paper import Bools, Bytes, Floats, ink_box

Doubles = npt.NDArray[np.float64]
Stats = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class ForeignLimits:
    """When a part of the ink is another's. Lengths are shares of the picture's side along them.

    redder, hue: what is redder than the ink by this share of the paper, and by this for each unit of its
        density, is left of a seal. Remains of seals have 0.30 or more for a unit, brown strokes up to 0.22.
    pale, stain_share, stain_gap: a part paler than this share of the ink's density, below this share of all
        ink, and this far from the darker parts is a stain. Only asked where the contrast over the paper's
        spread is below `grain`: on clean paper such a part is a dot from a dry brush.
    beside_gap, beside_band, beside_share: parts that reach in over one side, no farther than this band, with
        less than this share of the ink, beyond a blank band that is the widest and at least this wide.
    opposite: how much farther than they the rest must stay from the other side: a character cropped to its
        ink reaches both.
    soft_edge: how far from the side they may end where the paper lies in a frame, whose edge is soft.
    """

    redder: float = 0.07
    hue: float = 0.26
    pale: float = 0.72
    stain_share: float = 0.08
    stain_gap: float = 0.05
    grain: float = 9.0
    beside_gap: float = 0.08
    beside_band: float = 0.30
    beside_share: float = 0.45
    opposite: float = 0.03
    soft_edge: float = 0.07


def redness(view: Bytes, *, paper: Doubles) -> Floats:
    """(H, W) float32: how much redder than green and blue, as a share of the paper.

    view: (H, W, 3) uint8. paper: (3,) colour of the paper, 0-255, which is divided out.
    """
    import cv2

    gains = np.maximum(paper.max(), 1.0) / np.maximum(paper, 1.0)
    table = np.clip(np.arange(256)[:, None] * gains, 0, 255).astype(np.float32)
    r, g, b = cv2.split(cv2.LUT(view, table[:, None, :]))
    return np.asarray((r - cv2.max(g, b)) / max(float(paper.max()), 1.0), dtype=np.float32)


def drop_foreign(
    mask: Bools,
    density: Floats,
    *,
    red: Callable[[], Floats] | None,
    noise: float,
    framed: bool,
    limits: ForeignLimits | None = None,
) -> tuple[Bools, dict[str, int]]:
    """The ink without remains of seals, stains, and neighbours' strokes; pixels of each kind.

    mask: (H, W). density: (H, W), see `Ink`. red: tells `redness`, (H, W), where it is asked for; None
        without colour. noise: contrast over the paper's spread. framed: the paper lies in a frame.
    Something is always kept.
    """
    import cv2

    limits, left_out = limits or ForeignLimits(), {"seal": 0, "stain": 0, "neighbour": 0}
    if not mask.any():
        return mask, left_out
    y0, y1, x0, x1 = ink_box(mask)
    box = (slice(y0, y1), slice(x0, x1))
    count, labels, stats, _ = cv2.connectedComponentsWithStatsWithAlgorithm(
        mask[box].astype(np.uint8), 8, cv2.CV_32S, cv2.CCL_GRANA
    )
    if count <= 2:  # the paper and one part
        return mask, left_out
    stats[:, :2] += (x0, y0)
    area, kept = stats[1:, cv2.CC_STAT_AREA].astype(np.int64), np.ones(count - 1, bool)
    parts = _Parts(labels, mask[box], area)
    tests = {}
    if red is not None:
        tests["seal"] = _seals(parts, density[box], red()[box], limits)
    if noise < limits.grain:
        tests["stain"] = _stains(parts, density[box], limits, side=max(mask.shape))
    for kind, stray in tests.items():
        if (kept & ~stray).any():
            left_out[kind] += int(area[kept & stray].sum())
            kept &= ~stray
    beside = _beside(stats[1:], mask.shape, kept, limits, near=limits.soft_edge if framed else 0.0)
    left_out["neighbour"] = int(area[beside].sum())
    kept &= ~beside
    if kept.all():
        return mask, left_out
    clean = np.zeros_like(mask)
    clean[box] = np.concatenate([[False], kept])[labels]
    return clean, left_out


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """labels: (h, w), 0 on paper. ink: (h, w). area: (N,) pixels."""

    labels: npt.NDArray[np.int32]
    ink: Bools
    area: npt.NDArray[np.int64]

    def means(self, values: Floats) -> Doubles:
        """(N,) mean of (h, w) over each part."""
        sums = np.bincount(self.labels[self.ink] - 1, weights=values[self.ink], minlength=len(self.area))
        return np.asarray(sums / self.area)

    def gaps(self, firm: Bools) -> Doubles:
        """(N,) pixels from each part to the nearest of the firm ones, (N,)."""
        import cv2

        rest = np.concatenate([[False], firm])[self.labels]
        distance = cv2.distanceTransform((~rest).astype(np.uint8), cv2.DIST_L2, 3)
        nearest = np.full(len(firm), np.inf)
        np.minimum.at(nearest, self.labels[self.ink] - 1, distance[self.ink])
        return nearest


def _seals(parts: _Parts, density: Floats, red: Floats, limits: ForeignLimits) -> Bools:
    excess = parts.means(red) - float(np.median(red[parts.ink]))
    return np.asarray((excess > limits.redder) & (excess > limits.hue * parts.means(density)))


def _stains(parts: _Parts, density: Floats, limits: ForeignLimits, *, side: int) -> Bools:
    dark = float(np.percentile(density[parts.ink], 75))
    pale = (parts.means(density) < limits.pale * dark) & (parts.area < limits.stain_share * parts.area.sum())
    if not pale.any() or pale.all():
        return np.zeros(len(pale), bool)
    return np.asarray(pale & (parts.gaps(~pale) > limits.stain_gap * side))


def _beside(
    stats: Stats, shape: tuple[int, ...], kept: Bools, limits: ForeignLimits, *, near: float
) -> Bools:
    """Parts that reach in over a side of the picture together, as far as the widest blank band."""
    found = np.zeros(len(stats), bool)
    for axis, length in ((0, shape[1]), (1, shape[0])):
        start, stop = stats[:, axis], stats[:, axis] + stats[:, 2 + axis]
        for low, high in ((start, stop), (length - stop, length - start)):
            rest = kept & ~found
            run = _first_run(low / length, high / length, rest, limits, near=max(near, 1.01 / length))
            if stats[run, 4].sum() < limits.beside_share * stats[kept, 4].sum():
                found |= run
    return found


def _first_run(low: Doubles, high: Doubles, kept: Bools, limits: ForeignLimits, *, near: float) -> Bools:
    """Of the kept parts, (N,) from `low` to `high`, those before the widest blank band; or none."""
    order = np.flatnonzero(kept)[np.argsort(low[kept])]
    run, gaps = np.zeros(len(low), bool), low[order][1:] - np.maximum.accumulate(high[order])[:-1]
    if not len(gaps) or low[order[0]] > near or gaps.max() < limits.beside_gap:
        return run
    first = order[: int(np.argmax(gaps)) + 1]
    spare = 1.0 - high[order].max() - low[order[0]]
    if high[first].max() <= limits.beside_band and spare > limits.opposite:
        run[first] = True
    return run
