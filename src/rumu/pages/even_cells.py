"""Whether cells that were found are printed ones: equally large, with lines equally dark all along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.line_evidence import LineEvidence
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class EvenLineSettings:
    """Where the darkness of lines is looked at.

    reach: a line lies so near its place, and beside: the paper so far from that, in pixels of the reduced
        picture. along: the middle part of a side that is looked at. stretches: of it, `samples` places each.
    ruled: usual darkness from which the sides that run one way are ruled lines. seen: of the others, this
        share must then be darker than `trace` of their mean, for cells. clear: share of the sides that run
        one way or the other, of cells that are clearly drawn.
    """

    reach: int = 2
    beside: int = 6
    along: float = 0.84
    stretches: int = 10
    samples: int = 3
    ruled: float = 0.05
    seen: float = 0.35
    trace: float = 0.25
    clear: float = 0.5


def uneven_sizes(quads: FloatArray, places: FloatArray, *, drifting: bool) -> tuple[float, float]:
    """Median shares by which the widths and the heights of cells differ, the less uneven of both first.

    quads: (N, 4, 2) corners from the top left clockwise. places: (N, 2) rows and columns. drifting: they may
    change from one side of the page to the other.
    """
    ones = np.ones((len(quads), 1))
    terms = np.hstack([ones, places, places[:, :1] * places[:, 1:]]) if drifting else ones
    uneven = []
    for corner in (1, 3):
        length = np.linalg.norm(quads[:, corner] - quads[:, 0], axis=1)
        rest = length - terms @ np.linalg.lstsq(terms, length, rcond=None)[0]
        uneven.append(float(np.median(np.abs(rest)) / np.median(length)))
    return min(uneven), max(uneven)


def evenness_of_lines(
    evidence: LineEvidence, quads: FloatArray, *, settings: EvenLineSettings | None = None
) -> float:
    """How dark the lightest stretch of cells' sides is over their mean; along rows or columns, the better.

    About 1 where lines are printed: they run on from corner to corner. Near 0 where patches of paper show
    corners, characters and their edges. quads: (N, 4, 2) in pixels of the reduced picture.
    """
    settings = settings or EvenLineSettings()
    sides = [_darkness_along(evidence, quads[:, k], quads[:, (k + 1) % 4], settings) for k in range(4)]
    found = []
    for one, other in ((sides[0], sides[2]), (sides[1], sides[3])):
        darkness = np.vstack([one, other]).reshape(-1, settings.stretches, settings.samples)
        seen = np.isfinite(darkness)
        stretches = np.where(seen, darkness, 0).sum(axis=(0, 2)) / np.maximum(1, seen.sum(axis=(0, 2)))
        found.append(float(stretches.min() / stretches.mean()) if stretches.mean() > 0 else 0.0)
    return max(found)


def has_sides_both_ways(
    evidence: LineEvidence, quads: FloatArray, *, clear: bool, settings: EvenLineSettings | None = None
) -> bool:
    """Whether lines run both ways around cells, where no writing lies on them.

    Of a page whose columns are ruled, rows of characters that stand level look like the other two sides.
    clear: whether the cells are clearly drawn. quads: (N, 4, 2) in pixels of the reduced picture.
    """
    settings = settings or EvenLineSettings()
    usual, mean, share = [], [], []
    for k in (0, 1):
        sides = np.vstack(
            [_darkness_along(evidence, quads[:, i], quads[:, (i + 1) % 4], settings) for i in (k, k + 2)]
        )
        sides = sides[np.isfinite(sides).any(axis=1)]
        if not len(sides):
            return True
        usual.append(float(np.nanmedian(sides)))
        mean.append(float(np.nanmean(sides)))
        share.append(float((np.nanmedian(sides, axis=1) > settings.trace * mean[-1]).mean()))
    ruled = int(np.argmax(usual))
    other = 1 - ruled
    if usual[ruled] > settings.ruled and (mean[other] <= 0 or share[other] < settings.seen):
        return False
    return not clear or max(share) >= settings.clear


def _darkness_along(
    evidence: LineEvidence, first: FloatArray, last: FloatArray, settings: EvenLineSettings
) -> FloatArray:
    """(N, samples of all stretches): how much darker a line is than both of its sides, NaN under writing."""
    count = settings.stretches * settings.samples
    along = (0.5 + settings.along * np.linspace(-0.5, 0.5, count))[None, :, None]
    points = first[:, None] * (1 - along) + last[:, None] * along
    way = (last - first) / np.linalg.norm(last - first, axis=1)[:, None]
    across = np.stack([-way[:, 1], way[:, 0]], axis=1)[:, None]
    height, width = evidence.darkness.shape

    def at(places: FloatArray) -> FloatArray:
        x, y = np.rint(places[..., 0]).astype(int), np.rint(places[..., 1]).astype(int)
        inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        x, y = x.clip(0, width - 1), y.clip(0, height - 1)
        return np.where(inside & ~evidence.writing[y, x], evidence.darkness[y, x], np.nan)

    def darkest(off: int) -> FloatArray:
        near = [at(points + (off + step) * across) for step in range(-settings.reach, settings.reach + 1)]
        return np.asarray(np.fmax.reduce(near))

    return np.asarray(darkest(0) - np.fmax(darkest(-settings.beside), darkest(settings.beside)))
