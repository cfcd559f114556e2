"""Lines that were printed or carved before anyone wrote: grids of practice paper, column rules, borders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.surface.paper import Bools, Bytes, histogram, otsu, reduced


@dataclass(frozen=True, slots=True)
class RuleLimits:
    """When ink is a ruled line; all are shares of the shorter side, of its run, or of a band's ink.

    thickness: thickest line. skew: how far it may leave its row. cover: share of the side that it runs along;
    rim_cover: the same within `rim` of the border. beyond: what lies farther out than a line in this outer
    band is left out, unless more ink than `crossing` crosses the line.
    """

    thickness: float = 0.012
    run: float = 0.2
    skew: float = 0.012
    cover: float = 0.75
    rim: float = 0.22
    rim_cover: float = 0.75
    beyond: float = 0.45
    crossing: float = 0.04
    hair: float = 0.008
    page: float = 0.45


CARVED = RuleLimits(thickness=0.04, skew=0.025, run=0.1, cover=0.6, rim=0.16, rim_cover=0.45)
"""Rubbings: column rules are broken, and strokes are never as thin as they are."""


@dataclass(frozen=True, slots=True)
class Rule:
    """A thin straight line along an axis of the picture.

    axis: 0 runs along a row, 1 along a column. start, stop: the rows (columns) it fills.
    """

    axis: int
    start: int
    stop: int


def find_rules(mask: Bools, *, limits: RuleLimits) -> list[Rule]:
    """Lines that run along a row or column over most of the picture and are too thin for a stroke."""
    small = reduced(mask.astype(np.uint8) * 255, side=256) > 64
    found = []
    for axis, lines in ((0, small), (1, small.T)):
        scale = mask.shape[axis] / lines.shape[0]
        for start, stop in _thin_lines(lines, limits=limits):
            found.append(Rule(axis, int(start * scale), int(np.ceil(stop * scale))))
    return found


def _thin_lines(ink: Bools, *, limits: RuleLimits) -> list[tuple[int, int]]:
    """Bands of rows whose ink covers most columns and is thin: (first, last + 1) of each."""
    import cv2

    side = min(ink.shape)
    reach = max(1, round(limits.skew * side))
    thick = _opened(ink, (_odd(limits.thickness * side + 1), 1))
    near = cv2.dilate((ink & ~thick).astype(np.uint8), np.ones((2 * reach + 1, 3), np.uint8))
    line = _opened(near > 0, (1, _odd(limits.run * ink.shape[1])))
    cover = np.where(line.mean(axis=1) > 0.4, (line | thick).mean(axis=1), 0.0)  # strokes may cross the line
    place = (np.arange(len(cover)) + 0.5) / len(cover)
    thin = cover >= np.where(np.minimum(place, 1 - place) < limits.rim, limits.rim_cover, limits.cover)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], thin.astype(np.int8), [0]])))
    return [(max(0, a - 1), b + 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _opened(ink: Bools, shape: tuple[int, int]) -> Bools:
    """Morphological opening; what lies outside the picture is no ink."""
    import cv2

    kernel, border = np.ones(shape, np.uint8), cv2.BORDER_CONSTANT
    return np.asarray(
        cv2.morphologyEx(ink.astype(np.uint8), cv2.MORPH_OPEN, kernel, borderType=border, borderValue=0) > 0
    )


def _odd(length: float) -> int:
    """An odd kernel: opening with an even one shifts the picture in OpenCV."""
    return max(3, 2 * round((length - 1) / 2) + 1)


def drop_rules(mask: Bools, rules: list[Rule], *, limits: RuleLimits) -> Bools:
    """The ink without the lines, and without what lies beyond a line that nothing crosses.

    A stroke that crosses a line is thicker than it, and stays; so a printed grid goes and the writing on it
    stays. Beyond the border line of a stele or a ruled page there is no part of the character.
    """
    thickness = max(2, round(limits.thickness * min(mask.shape)))
    kept = mask.copy()
    for rule in rules:
        shape = (2 * thickness + 1, 1) if rule.axis == 0 else (1, 2 * thickness + 1)
        thick = _opened(mask, shape)
        band = (slice(rule.start, rule.stop), slice(None))
        _turned(kept, rule)[band] &= _turned(thick, rule)[band]
    for rule in rules:
        kept = _without_beyond(kept, rule, limits=limits)
    return kept


def _turned(mask: Bools, rule: Rule) -> Bools:
    return mask if rule.axis == 0 else mask.T


def _without_beyond(mask: Bools, rule: Rule, *, limits: RuleLimits) -> Bools:
    rows = _turned(mask, rule)
    middle = (rule.start + rule.stop) / 2 / rows.shape[0]
    if min(middle, 1 - middle) > limits.beyond:
        return mask
    crossing = rows[rule.start : rule.stop].any(axis=1).mean() * rows[rule.start : rule.stop].mean()
    outside = slice(0, rule.stop) if middle < 0.5 else slice(rule.start, None)
    if crossing > limits.crossing or rows[outside].sum() > 0.6 * rows.sum():
        return mask
    kept = rows.copy()
    kept[outside] = False
    return np.ascontiguousarray(kept if rule.axis == 0 else kept.T)


def close_cuts(mask: Bools, cut: Bools, *, width: int) -> Bools:
    """Give the ink back where a removed line crossed it: closed over `width` pixels, on the line alone."""
    import cv2

    if not cut.any() or not mask.any():
        return mask
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    return np.asarray(mask | ((closed > 0) & cut))


def below_pale_grid(x: Bytes, threshold: float, *, limits: RuleLimits) -> float:
    """A lower threshold where what is half dark is a printed grid; the threshold itself where it is not.

    x: (H, W) uint8, ink dark. A grid scanned in grey has no colour to be told by. It has a level of its own
    between ink and paper, and its lines are hairs that cross the whole page.
    """
    import cv2

    counts = histogram(x)[: int(threshold) + 1]
    if counts.sum() < 64:
        return threshold
    lower = otsu(np.pad(counts, (0, 256 - len(counts))))
    dark = x < lower
    near = cv2.dilate(dark.astype(np.uint8), np.ones((5, 5), np.uint8))
    between = cv2.bitwise_and(cv2.inRange(x, 0, int(np.ceil(threshold)) - 1), cv2.bitwise_not(255 * near))
    if not between.any():  # a drawing of two levels, or a clean scan
        return threshold
    pale = reduced(between, side=256) > 64
    depth = cv2.distanceTransform(np.pad(pale, 1).astype(np.uint8), cv2.DIST_L2, 3)
    hair = limits.hair * max(pale.shape) + 1  # where lines cross they are thicker, so nearly all will do
    if not (dark.any() and pale.any()) or np.percentile(depth[depth > 0], 98) > hair:
        return threshold
    _, _, stats, _ = cv2.connectedComponentsWithStats(pale.astype(np.uint8), connectivity=8)
    spans = (stats[1:, 2] > limits.page * pale.shape[1]) | (stats[1:, 3] > limits.page * pale.shape[0])
    return lower if spans.any() else threshold
