"""What is as dark as ink and is not the writing: ruled lines, specks, edges, seals, stains, neighbours.

Ruled lines are recognised by their shape. All else is judged by connected parts of the ink: where they lie,
how large they are, and how pale and how red they are beside the rest of the ink. So a picture of one level
of ink whose parts lie close together stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.capture.image import bounding_box, shrink
from rumu.surface.paper import Polarity
from rumu.values import BoolArray, FloatArray

Labels = npt.NDArray[np.int32]


# --- ruled lines -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RuledLineSettings:
    """When ink is a line that was printed or carved; lengths are shares of the shorter side.

    thickness: of the thickest line; of_character: the same over the side of a page's characters. run:
        shortest piece, of the side it runs along. skew: how far a line may leave its row. cover: share of the
        side that it runs along; margin_cover: the same within `margin` of the border.
    border: what lies farther out than a line in this outer band is left out, unless more ink than
        `crossing`, as a share of the line, crosses it, or the band holds more than `most_beyond` of all ink.
    """

    thickness: float = 0.012
    of_character: float = 0.06
    run: float = 0.2
    skew: float = 0.012
    cover: float = 0.75
    margin: float = 0.22
    margin_cover: float = 0.75
    border: float = 0.45
    crossing: float = 0.04
    most_beyond: float = 0.6


PRINTED = RuledLineSettings()
CARVED = RuledLineSettings(thickness=0.04, skew=0.025, run=0.1, cover=0.6, margin=0.16, margin_cover=0.45)
"""Rubbings: column rules are broken, and strokes are never as thin as they are."""


Lines = tuple[tuple[int, slice], ...]  # the axis that each lies across, 0 along the rows, and its band there


def remove_ruled_lines(
    mask: BoolArray, *, polarity: Polarity, character: float | None = None
) -> tuple[BoolArray, Lines]:
    """The ink without straight lines along its rows and columns, and these lines.

    A stroke that crosses a line is thicker than it and stays, so the writing on a printed grid stays.
    character: side of the characters of a page, in pixels; strokes of small ones are thin, too.
    """
    settings = CARVED if polarity == "light" else PRINTED
    small = shrink(mask.astype(np.uint8) * 255, side=256) > 64
    thickest = settings.thickness * min(mask.shape)
    thickness = max(2, round(min(thickest, settings.of_character * (character or np.inf))))
    rest, found = mask.copy(), []
    for axis, lines, across, kept in ((0, small, mask, rest), (1, small.T, mask.T, rest.T)):
        scale = across.shape[0] / lines.shape[0]
        thick = _open(across, (2 * thickness + 1, 1))
        for start, stop in _thin_lines(lines, settings):
            band = slice(int(start * scale), int(np.ceil(stop * scale)))
            kept[band] &= thick[band]
            found.append((axis, band))
    return rest, tuple(found)


def remove_beyond_lines(mask: BoolArray, lines: Lines, *, polarity: Polarity) -> BoolArray:
    """The ink without what lies beyond a border line: there is no part of the one character inside it."""
    settings, rest = CARVED if polarity == "light" else PRINTED, mask.copy()
    for axis, band in lines:
        _clear_beyond(rest.T if axis else rest, band, settings)
    return rest


def _thin_lines(ink: BoolArray, settings: RuledLineSettings) -> list[tuple[int, int]]:
    """Bands of rows whose ink covers most columns and is thin: (first, last + 1) of each."""
    import cv2

    side = min(ink.shape)
    reach = max(1, round(settings.skew * side))
    thick = _open(ink, (_odd(settings.thickness * side + 1), 1))
    near = cv2.dilate((ink & ~thick).astype(np.uint8), np.ones((2 * reach + 1, 3), np.uint8))
    line = _open(near > 0, (1, _odd(settings.run * ink.shape[1])))
    cover = np.where(line.mean(axis=1) > 0.4, (line | thick).mean(axis=1), 0.0)  # strokes may cross the line
    at = (np.arange(len(cover)) + 0.5) / len(cover)
    in_margin = np.minimum(at, 1 - at) < settings.margin
    thin = cover >= np.where(in_margin, settings.margin_cover, settings.cover)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], thin.astype(np.int8), [0]])))
    return [(max(0, a - 1), b + 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _open(ink: BoolArray, shape: tuple[int, int]) -> BoolArray:
    """Morphological opening; what lies outside the picture is no ink."""
    import cv2

    kernel, border = np.ones(shape, np.uint8), cv2.BORDER_CONSTANT
    return np.asarray(
        cv2.morphologyEx(ink.astype(np.uint8), cv2.MORPH_OPEN, kernel, borderType=border, borderValue=0) > 0
    )


def _odd(length: float) -> int:
    """An odd kernel: opening with an even one shifts the picture in OpenCV."""
    return max(3, 2 * round((length - 1) / 2) + 1)


def _clear_beyond(rows: BoolArray, band: slice, settings: RuledLineSettings) -> None:
    """Clear what lies beyond a line in the given rows, if it is a border that nothing crosses."""
    middle = (band.start + band.stop) / 2 / rows.shape[0]
    if min(middle, 1 - middle) > settings.border:
        return
    crossing = rows[band].any(axis=1).mean() * rows[band].mean()
    outside = slice(0, band.stop) if middle < 0.5 else slice(band.start, None)
    if crossing <= settings.crossing and rows[outside].sum() <= settings.most_beyond * rows.sum():
        rows[outside] = False


def close_cuts(mask: BoolArray, cut: BoolArray, *, width: int) -> BoolArray:
    """Give the ink back where a removed line crossed it: closed over `width` pixels, on the line alone."""
    import cv2

    if not cut.any() or not mask.any():
        return mask
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    return np.asarray(mask | ((closed > 0) & cut))


# --- connected parts -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class InkParts:
    """The connected parts of a mask, N of them.

    mask: (H, W). box: of all ink. labels: (h, w) within the box, 0 on paper, else the part's number from 1.
    start, stop: (N, 2) int, first and last + 1 (column, row) of each part. area: (N,) pixels.
    """

    mask: BoolArray
    box: tuple[slice, slice]
    labels: Labels
    start: Labels
    stop: Labels
    area: npt.NDArray[np.int64]

    @property
    def reach(self) -> tuple[FloatArray, FloatArray]:
        """(N, 4) each: nearest and farthest reach from left, top, right and bottom, as shares of the side."""
        size = np.array(self.mask.shape[::-1])
        start, stop = self.start / size, self.stop / size
        return np.hstack([start, 1 - stop]), np.hstack([stop, 1 - start])

    def means(self, values: FloatArray) -> FloatArray:
        """(N,) mean over each part of values (H, W)."""
        ink = self.mask[self.box]
        sums = np.bincount(self.labels[ink] - 1, weights=values[self.box][ink], minlength=len(self.area))
        return np.asarray(sums / self.area)

    def gaps(self, others: BoolArray) -> FloatArray:
        """(N,) pixels from each part to the nearest of the others, given by (N,) bool."""
        import cv2

        rest = np.concatenate([[False], others])[self.labels]
        distance = cv2.distanceTransform((~rest).astype(np.uint8), cv2.DIST_L2, 3)
        nearest = np.full(len(others), np.inf)
        ink = self.mask[self.box]
        np.minimum.at(nearest, self.labels[ink] - 1, distance[ink])
        return nearest

    def only(self, kept: BoolArray) -> BoolArray:
        """(H, W) bool: the mask of the kept parts, given by (N,) bool."""
        if kept.all():
            return self.mask
        clean = np.zeros_like(self.mask)
        clean[self.box] = np.concatenate([[False], kept])[self.labels]
        return clean


def connected_parts(mask: BoolArray) -> InkParts:
    """Label the 8-connected parts of a mask that holds ink."""
    import cv2

    y0, y1, x0, x1 = bounding_box(mask)
    box = (slice(y0, y1), slice(x0, x1))  # labelling costs by the pixel; this algorithm is the quickest
    _, labels, stats, _ = cv2.connectedComponentsWithStatsWithAlgorithm(
        mask[box].astype(np.uint8), 8, cv2.CV_32S, cv2.CCL_GRANA
    )
    start = stats[1:, :2] + np.array([x0, y0], np.int32)
    return InkParts(mask, box, labels, start, start + stats[1:, 2:4], stats[1:, 4].astype(np.int64))


# --- by size and position --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PositionSettings:
    """When size and position say that a part is not of the character; lengths are shares of the side.

    speck: largest speck, in pixels of a 256 x 256 picture; speck_share: the same as a share of the ink, for
        small characters.
    edge_band, edge_share: a part that touches the border, lies wholly in this outer band, and is below this
        share of the ink is an edge of the page. edge_contact: so is a larger one there that runs along the
        border for this long.
    neighbour_share, neighbour_band: a larger part that touches the border, within this band, and that stands
        clear of the rest by `gap`, is the ink of a neighbouring character.
    caption_share, caption_band: a small part in this outer band that stands clear is a printed caption.
    """

    speck: float = 30.0
    speck_share: float = 0.01
    edge_band: float = 0.12
    edge_share: float = 0.05
    edge_contact: float = 0.35
    neighbour_share: float = 0.25
    neighbour_band: float = 0.30
    gap: float = 0.03
    caption_share: float = 0.03
    caption_band: float = 0.10


def remove_by_position(
    mask: BoolArray, *, settings: PositionSettings | None = None
) -> tuple[BoolArray, dict[str, int]]:
    """The ink without specks, edges of the page, neighbours' ink and captions; pixels of each kind."""
    removed = {"speck": 0, "edge": 0, "neighbour": 0, "caption": 0}
    if not mask.any():
        return mask, removed
    settings, parts = settings or PositionSettings(), connected_parts(mask)
    largest = settings.speck * (mask.size / 65536.0), settings.speck_share * float(parts.area.sum())
    kept = parts.area > min(*largest, parts.area.max() - 1)
    removed["speck"] = int(parts.area[~kept].sum())
    for kind, test in (("edge", _edges), ("neighbour", _neighbours), ("caption", _captions)):
        chosen = kept & test(parts, kept, settings)
        removed[kind] = int(parts.area[chosen].sum())
        kept = kept & ~chosen
    return parts.only(kept), removed


def _edges(parts: InkParts, kept: BoolArray, settings: PositionSettings) -> BoolArray:
    """Parts at the border: small ones, and long ones that run along it."""
    in_band = _touching(parts, settings.edge_band)
    small = in_band.any(axis=1) & (parts.area < settings.edge_share * parts.area[kept].sum())
    along = np.tile(((parts.stop - parts.start) / parts.mask.shape[::-1])[:, ::-1], 2)
    long = (in_band & (along >= settings.edge_contact)).any(axis=1)
    others = parts.area[kept & ~(small | long)].sum()
    return np.asarray(small | (long & (others > 0)))


def _neighbours(parts: InkParts, kept: BoolArray, settings: PositionSettings) -> BoolArray:
    near = _touching(parts, settings.neighbour_band).any(axis=1)
    candidate = kept & near & (parts.area < settings.neighbour_share * parts.area[kept].sum())
    return np.asarray(candidate & (_gap_to_rest(parts, candidate, kept) > settings.gap))


def _captions(parts: InkParts, kept: BoolArray, settings: PositionSettings) -> BoolArray:
    in_band = (parts.reach[1] <= settings.caption_band).any(axis=1)
    candidate = kept & in_band & (parts.area < settings.caption_share * parts.area[kept].sum())
    return np.asarray(candidate & (_gap_to_rest(parts, candidate, kept) > settings.gap))


def _touching(parts: InkParts, band: float) -> BoolArray:
    """(N, 4) bool: reaches the left, top, right, bottom border, within a pixel, and stays in this band."""
    near, far = parts.reach
    return np.asarray((near <= np.tile(1.01 / np.array(parts.mask.shape[::-1]), 2)) & (far <= band))


def _gap_to_rest(parts: InkParts, candidate: BoolArray, kept: BoolArray) -> FloatArray:
    """(N,) gap between the box of each candidate and the box of all other ink, as a share of the side."""
    rest = kept & ~candidate
    if not rest.any():
        return np.zeros(len(rest))
    first, last = parts.start[rest].min(axis=0), parts.stop[rest].max(axis=0)
    gaps = np.maximum(first - parts.stop, parts.start - last) / parts.mask.shape[::-1]
    return np.asarray(gaps.max(axis=1))


# --- by colour and density -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ColourSettings:
    """When colour, density or a blank band say that a part is not of the character.

    Lengths are shares of the picture's side along them.

    redder, hue: what is redder than the ink by this share of the paper, and by this for each unit of its
        density, is left of a seal. Remains of seals have 0.30 or more for a unit, brown strokes up to 0.22.
    pale, stain_share, stain_gap: a part paler than this share of the ink's density, below this share of all
        ink, and this far from the darker parts is a stain. Only asked where the contrast over the paper's
        spread is below `grainy`: on clean paper such a part is a dot from a dry brush.
    side_gap, side_band, side_share: parts that reach in over one side, no farther than this band, with
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
    grainy: float = 9.0
    side_gap: float = 0.08
    side_band: float = 0.30
    side_share: float = 0.45
    opposite: float = 0.03
    soft_edge: float = 0.07


def remove_by_colour(
    mask: BoolArray,
    density: FloatArray,
    *,
    redness: Callable[[], FloatArray] | None,
    noise: float,
    framed: bool,
    settings: ColourSettings | None = None,
) -> tuple[BoolArray, dict[str, int]]:
    """The ink without remains of seals, stains, and neighbours' strokes; pixels of each kind.

    mask: (H, W). density: (H, W), see `Ink`. redness: measures `redness`, (H, W), if it is needed; None
        without colour. noise: contrast over the paper's spread. framed: the paper lies in a frame.
    Something is always kept.
    """
    settings, removed = settings or ColourSettings(), {"seal": 0, "stain": 0, "neighbour": 0}
    if not mask.any():
        return mask, removed
    parts = connected_parts(mask)
    if len(parts.area) < 2:
        return mask, removed
    kept, tests = np.ones(len(parts.area), bool), {}
    if redness is not None:
        tests["seal"] = _seals(parts, density, redness(), settings)
    if noise < settings.grainy:
        tests["stain"] = _stains(parts, density, settings)
    for kind, chosen in tests.items():
        if (kept & ~chosen).any():
            removed[kind] = int(parts.area[kept & chosen].sum())
            kept &= ~chosen
    beside = _beside(parts, kept, settings, near=settings.soft_edge if framed else 0.0)
    removed["neighbour"] = int(parts.area[beside].sum())
    return parts.only(kept & ~beside), removed


def _seals(parts: InkParts, density: FloatArray, red: FloatArray, settings: ColourSettings) -> BoolArray:
    excess = parts.means(red) - float(np.median(red[parts.mask]))
    return np.asarray((excess > settings.redder) & (excess > settings.hue * parts.means(density)))


def _stains(parts: InkParts, density: FloatArray, settings: ColourSettings) -> BoolArray:
    dark = float(np.percentile(density[parts.mask], 75))
    pale = parts.means(density) < settings.pale * dark
    pale &= parts.area < settings.stain_share * parts.area.sum()
    if not pale.any() or pale.all():
        return np.zeros(len(pale), bool)
    return np.asarray(pale & (parts.gaps(~pale) > settings.stain_gap * max(parts.mask.shape)))


def _beside(parts: InkParts, kept: BoolArray, settings: ColourSettings, *, near: float) -> BoolArray:
    """Parts that reach in over a side of the picture together, as far as the widest blank band."""
    chosen = np.zeros(len(kept), bool)
    for axis, length in enumerate(parts.mask.shape[::-1]):
        start, stop = parts.start[:, axis], parts.stop[:, axis]
        for low, high in ((start, stop), (length - stop, length - start)):
            rest = kept & ~chosen
            run = _first_run(low / length, high / length, rest, settings, near=max(near, 1.01 / length))
            if parts.area[run].sum() < settings.side_share * parts.area[kept].sum():
                chosen |= run
    return chosen


def _first_run(
    low: FloatArray, high: FloatArray, kept: BoolArray, settings: ColourSettings, *, near: float
) -> BoolArray:
    """Of the kept parts, (N,) from `low` to `high`, those before the widest blank band; or none."""
    order = np.flatnonzero(kept)[np.argsort(low[kept])]
    run, gaps = np.zeros(len(low), bool), low[order][1:] - np.maximum.accumulate(high[order])[:-1]
    if not len(gaps) or low[order[0]] > near or gaps.max() < settings.side_gap:
        return run
    first = order[: int(np.argmax(gaps)) + 1]
    spare = 1.0 - high[order].max() - low[order[0]]
    if high[first].max() <= settings.side_band and spare > settings.opposite:
        run[first] = True
    return run
