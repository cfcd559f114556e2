"""The ink of one picture: found on paper, silk, printed grids and rubbings; seals and page edges left out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.image import as_image
from rumu.errors import RefusedImage
from rumu.surface.foreign import ForeignLimits, drop_foreign, redness
from rumu.surface.paper import (
    Bools,
    Bytes,
    Floats,
    Paper,
    Polarity,
    histogram,
    ink_box,
    otsu,
    ratio,
    read_paper,
    reduced,
    sheet_on_table,
    tone,
)
from rumu.surface.rules import CARVED, RuleLimits, below_pale_grid, close_cuts, drop_rules, find_rules
from rumu.surface.strays import Box, StrayLimits, drop_strays, inner_box, red_marks

GRAINY = 12.0  # contrast over the paper's spread below which the paper has a grain of its own
PAPER = 200  # grey level that stands for paper in a ratio image
FIGURE_SIDE = 512  # longer side of the picture that sharpness is judged on


@dataclass(frozen=True, slots=True, eq=False)
class Ink:
    """The ink of one picture.

    mask: (H, W) bool, True on ink.
    density: (H, W) float32 in [0, 1], how far the ink lies below the paper around it: 1 is black, 0.3 a pale
        grey; 0 off the ink. On a rubbing the same of the strokes above their ground.
    polarity: 'dark' ink on light paper, 'light' strokes on dark ground.
    paper: level of the paper (of the ground, for 'light'), as stored, in [0, 1].
    contrast: median density of the ink, in (0, 1].
    left_out: pixels that were dark enough and are no part of the writing, by kind: 'seal' (and red grid),
        'grid' (ruled lines and what lies beyond a border line), 'speck', 'edge', 'neighbour', 'caption',
        'stain'; and 'frame', the pixels of a flat frame, or of the table, around the paper.
    figures: 'noise' (contrast over the paper's own spread), 'edge' (step across the outline over the
        contrast, 1 is sharp), 'between' (half-dark pixels for each pixel of outline), 'coherence' (share of
        the ink's variance that survives averaging over 8 pixels).
    """

    mask: Bools
    density: Floats
    polarity: Polarity
    paper: float
    contrast: float
    left_out: Mapping[str, int] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class InkLimits:
    """When a picture is refused. Each limit lies outside what 4,000 crops of masters and copies reach.

    flat: range of grey levels of the reduced picture below which it shows nothing at all.
    black: paper this dark (0-255) is no paper.
    contrast: least contrast. noise: least contrast over the paper's spread. coherence: least coherence.
    edge, torn: least and largest step across the outline.
    between: most half-dark pixels for each pixel of a soft outline.
    thick: half-width over the page's side from which a soft shape may have half as many.
    hairline: half-width over the extent of the ink below which it is ruled lines.
    rim: share of the picture's border that ink may cover. pixels: least ink.
    grain: mean change of a pixel (0-255) by a median filter above which a blank page is noise;
    speckle: share of dark pixels that do the same when they hold no writing.
    only_red: share of the dark pixels that are red marks on a page with nothing else.
    """

    flat: int = 12
    black: int = 35
    contrast: float = 0.06
    noise: float = 3.6
    coherence: float = 0.09
    edge: float = 0.36
    torn: float = 1.6
    between: float = 4.0
    thick: float = 0.17
    hairline: float = 0.014
    rim: float = 0.45
    grain: float = 20.0
    speckle: float = 0.005
    only_red: float = 0.93
    pixels: int = 24
    strays: StrayLimits = field(default_factory=StrayLimits)
    foreign: ForeignLimits = field(default_factory=ForeignLimits)


@dataclass(frozen=True, slots=True, eq=False)
class _Split:
    """A page split into ink and paper. x: (H, W) uint8 ratio to the paper. cut: red marks. grain: 0-255.
    red: tells `redness`; None without colour, and on a rubbing."""

    x: Bytes
    threshold: float
    ink: float
    paper: float
    noise: float
    cut: Bools
    grain: float = 0.0
    red: Callable[[], Floats] | None = None

    @property
    def raw(self) -> Bools:
        return np.asarray(self.x < self.threshold)


def find_ink(
    image: npt.NDArray[Any],
    *,
    linear: bool = False,
    polarity: Polarity | None = None,
    limits: InkLimits | None = None,
) -> Ink:
    """Find the ink of a picture of writing.

    image: (H, W) or (H, W, 3), any dtype that `as_image` takes, values as stored (display-encoded).
    linear: True when the values are linear light, as the albedo of a Surface is.
    polarity: None to decide it from the picture.
    Raises ImageError for an array that is no image, and RefusedImage with reason 'blank' (paper and nothing
    on it, or only a seal or a grid), 'black' (nothing but dark) or 'noise' (speckle, or a picture without
    writing).
    """
    limits = limits or InkLimits()
    picture = _bytes(as_image(image), linear=linear)
    (y0, y1, x0, x1), off, small = _sheet(picture, polarity)
    view = np.ascontiguousarray(picture[y0:y1, x0:x1])
    _refuse_flat(small, limits)
    paper = read_paper(small, polarity="dark" if off is not None else polarity)
    split = _split(view, small, paper, off, limits)
    mask, left_out = _writing(split, paper.polarity, limits)
    figures = _figures(split, mask)
    _refuse_unwritten(mask, split, figures, limits)
    # The figures above are those of all that is dark: what is foreign is as blurred, or grainy, as the ink.
    mask = _own(mask, split, left_out, limits, framed=_framed(view, picture))
    left_out["frame"] = picture.shape[0] * picture.shape[1] - mask.size
    whole = np.zeros(picture.shape[:2], bool)
    whole[y0:y1, x0:x1] = mask
    density = np.zeros(picture.shape[:2], np.float32)
    density[y0:y1, x0:x1][mask] = np.maximum(1.0 - split.x[mask] / np.float32(PAPER), 1 / 255)
    level = float(np.median(paper.level)) / 255
    ground = level if paper.polarity == "dark" else 1.0 - level
    return Ink(whole, density, paper.polarity, ground, 1.0 - split.ink / PAPER, left_out, figures)


def _sheet(picture: Bytes, polarity: Polarity | None) -> tuple[Box, Bools | None, Bytes]:
    """The box of the picture that shows paper; the pixels in it that do not, if any; the box, reduced."""
    import cv2

    y0, y1, x0, x1 = inner_box(picture)
    view = picture[y0:y1, x0:x1]
    small = reduced(view)
    sheet = None if polarity == "light" else sheet_on_table(small)
    if sheet is None or not sheet.any():
        return (y0, y1, x0, x1), None, small
    full = cv2.resize(sheet.astype(np.uint8), view.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
    rows, columns = np.flatnonzero(full.any(axis=1)), np.flatnonzero(full.any(axis=0))
    top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
    box = (int(y0 + top), int(y0 + bottom), int(x0 + left), int(x0 + right))
    return box, ~full[top:bottom, left:right], reduced(view[top:bottom, left:right])


def _bytes(image: Floats, *, linear: bool) -> Bytes:
    """8 bits, display-encoded: enough for a threshold, and OpenCV is quickest on them."""
    import cv2

    encoded = cv2.sqrt(image) if linear else image
    return np.asarray(cv2.convertScaleAbs(encoded, alpha=255.0), dtype=np.uint8)


def _refuse_flat(small: Bytes, limits: InkLimits) -> None:
    gray = small if small.ndim == 2 else small.max(axis=2)
    if int(gray.max()) - int(gray.min()) < limits.flat or int(gray.max()) < limits.black:
        reason = "black" if np.median(gray) < limits.black else "blank"
        raise RefusedImage(f"expected writing, got a {reason} page", reason=reason)


def _split(view: Bytes, small: Bytes, paper: Paper, off: Bools | None, limits: InkLimits) -> _Split:
    """Ratio to the paper, smoothed as much as the paper is noisy, and the level half-way to the ink."""
    import cv2

    value = tone(view, polarity=paper.polarity)
    level = np.clip(np.rint(paper.level), 1, 255).astype(np.uint8)
    x = ratio(value, cv2.resize(level, value.shape[::-1], interpolation=cv2.INTER_LINEAR))
    if paper.polarity == "dark" and float(np.median(paper.level)) < limits.black:
        raise RefusedImage("expected ink on paper, got a black page", reason="black")
    cut, red = np.zeros(x.shape, bool), None
    if view.ndim == 3:
        colour = _colour(small, paper)
        cut = red_marks(view, paper=colour, on_dark=paper.polarity == "light")
        red = partial(redness, view, paper=colour) if paper.polarity == "dark" else None
    if off is not None:
        x[off], cut = PAPER, cut | off
    split = _levels(x, cut)
    size = next((n for least, n in ((16, 0), (9, 3), (5, 5)) if split.noise > least), 7)
    if size:
        split = _levels(np.asarray(cv2.medianBlur(x, size), dtype=np.uint8), cut)
    if split.noise > GRAINY:
        threshold = below_pale_grid(split.x, split.threshold, limits=RuleLimits())
        split = replace(split, threshold=threshold, ink=min(split.ink, _darkest(split.x, threshold)))
    grain = float(cv2.absdiff(value, cv2.medianBlur(value, 3)).mean())
    split = replace(split, grain=grain, red=red)
    return replace(split, cut=_spread_red(split, paper.polarity)) if cut.any() else split


def _levels(x: Bytes, red: Bools) -> _Split:
    """Otsu's threshold, moved half-way between the medians of the two sides; red marks are on neither."""
    counts = histogram(x, mask=~red if red.any() else None)
    if counts.sum() < 64:
        raise RefusedImage("expected writing, got only red marks", reason="blank")
    threshold = otsu(counts)
    for _ in range(3):
        dark, light = _median(counts, 0, threshold), _median(counts, threshold, 256)
        threshold = (dark + light) / 2
    off = np.abs(np.arange(256) - light)
    order = np.argsort(off)
    spread = np.cumsum(np.where(np.arange(256) >= threshold, counts, 0.0)[order])
    middle = float(off[order][np.searchsorted(spread, spread[-1] / 2)])
    return _Split(x, threshold, dark, light, (light - dark) / max(1.4826 * middle, 0.5), red)


def _median(counts: npt.NDArray[np.float64], low: float, high: float) -> float:
    """Median grey level in [low, high) of a histogram; `low` where it is empty."""
    first = int(np.ceil(low))
    part = np.cumsum(counts[first : int(np.ceil(high))])
    return float(first + np.searchsorted(part, part[-1] / 2)) if len(part) and part[-1] else low


def _darkest(x: Bytes, threshold: float) -> float:
    return _median(histogram(x), 0, threshold)


def _colour(small: Bytes, paper: Paper) -> npt.NDArray[np.float64]:
    """(3,) colour of the paper, 0-255."""
    under = ratio(tone(small, polarity=paper.polarity), paper.level)
    return np.asarray(np.median(small[under > otsu(histogram(under))], axis=0), dtype=np.float64)


def _spread_red(split: _Split, polarity: Polarity) -> Bools:
    """Red marks with their soft edges; ink that is plainly dark stays ink."""
    import cv2

    size = 3 if polarity == "dark" else 7
    near = cv2.dilate(split.cut.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    if polarity == "light":
        return np.asarray(near)
    return np.asarray(near & (split.cut | (split.x > (split.ink + split.threshold) / 2)))


def _writing(split: _Split, polarity: Polarity, limits: InkLimits) -> tuple[Bools, dict[str, int]]:
    raw = split.raw
    mask = close_cuts(raw & ~split.cut, split.cut & raw, width=2) if split.cut.any() else raw
    rules = CARVED if polarity == "light" else RuleLimits()
    unruled = drop_rules(mask, find_rules(mask, limits=rules), limits=rules)
    strays = limits.strays
    if split.noise < GRAINY:
        strays = replace(strays, speck=2 * strays.speck, speck_share=3 * strays.speck_share)
    kept, left_out = drop_strays(unruled, limits=strays)
    left_out["grid"] = int(np.count_nonzero(mask & ~unruled))
    left_out["seal"] = int(np.count_nonzero(raw & ~mask))
    return kept, left_out


def _own(mask: Bools, split: _Split, left_out: dict[str, int], limits: InkLimits, *, framed: bool) -> Bools:
    """The ink without what is foreign to the character; `left_out` is counted on."""
    density = np.subtract(1.0, split.x / np.float32(PAPER), dtype=np.float32)
    own, foreign = drop_foreign(
        mask, density, red=split.red, noise=split.noise, framed=framed, limits=limits.foreign
    )
    for kind, pixels in foreign.items():
        left_out[kind] = left_out.get(kind, 0) + pixels
    return own


def _framed(view: Bytes, picture: Bytes) -> bool:
    """Whether a frame was cut off all round; a strip along one side is cut off sharply."""
    return all(inner < outer for inner, outer in zip(view.shape[:2], picture.shape[:2], strict=True))


def _figures(split: _Split, mask: Bools) -> dict[str, float]:
    """See `Ink.figures`; on a picture of at most FIGURE_SIDE, so that a large photo is judged like a crop."""
    import cv2

    x, cut = reduced(split.x, side=FIGURE_SIDE), reduced(split.cut.astype(np.uint8), side=FIGURE_SIDE) > 0
    ink = reduced(mask.astype(np.uint8) * 255, side=FIGURE_SIDE) > 127
    outline, step = (
        cv2.morphologyEx(a, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) for a in (ink.astype(np.uint8), x)
    )
    length = max(1, int(np.count_nonzero((outline > 0) & ink)))
    depth = split.paper - split.ink
    on_edge = step[outline > 0]
    half = cv2.inRange(x, split.ink + 0.3 * depth, split.ink + 0.7 * depth) > 0
    share = np.count_nonzero(ink) / ink.size
    blocks = cv2.resize(ink.astype(np.float32), None, fx=1 / 8, fy=1 / 8, interpolation=cv2.INTER_AREA)
    return {
        "noise": float(split.noise),
        "edge": float(np.median(on_edge)) / depth if len(on_edge) else 0.0,
        "between": float(np.count_nonzero(half & ~cut)) / length,
        "coherence": float(blocks.var()) / max(share * (1 - share), 1e-6),
    }


def _refuse_unwritten(mask: Bools, split: _Split, figures: Mapping[str, float], limits: InkLimits) -> None:
    raw = np.count_nonzero(split.raw)
    if split.grain < limits.grain and np.count_nonzero(split.raw & split.cut) > limits.only_red * raw > 0:
        raise RefusedImage("expected writing, got only red marks", reason="blank")
    verdict = _verdict(mask, split, figures, limits)
    if verdict is None:
        return
    reason, seen = verdict
    speckled = split.raw.mean() > limits.speckle and np.count_nonzero(mask) < 0.5 * np.count_nonzero(
        split.raw
    )
    if reason == "blank" and (split.grain > limits.grain or (speckled and not split.cut.any())):
        reason, seen = "noise", "speckle"
    raise RefusedImage(f"expected writing, got {seen}", reason=reason)


def _verdict(
    mask: Bools, split: _Split, figures: Mapping[str, float], limits: InkLimits
) -> tuple[str, str] | None:
    """Reason and description of what the picture shows instead of writing; None when it shows writing."""
    if 1.0 - split.ink / PAPER < limits.contrast or np.count_nonzero(mask) < limits.pixels:
        return "blank", "a page with nothing on it"
    rim = np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]])
    half_width, extent = _half_width(mask)
    soft = figures["edge"] < 0.7
    thick = half_width > limits.thick * min(mask.shape)
    # Grain of the paper is half-dark too: grainy paper may have more of it.
    half_dark = figures["between"] / (limits.between * max(1.0, GRAINY / figures["noise"]))
    tests = (
        (figures["coherence"] < limits.coherence or figures["edge"] > limits.torn, "noise", "speckle"),
        (figures["noise"] < limits.noise, "noise", "a picture that does not part into ink and paper"),
        (figures["edge"] < limits.edge, "blank", "shades without the edge of a stroke"),
        (rim.mean() > limits.rim, "noise", "dark sides and no writing"),
        (half_width < limits.hairline * extent, "blank", "ruled lines only"),
        (soft and half_dark > (0.5 if thick else 1.0), "noise", "a picture without writing"),
    )
    return next(((reason, seen) for holds, reason, seen in tests if holds), None)


def _half_width(mask: Bools) -> tuple[float, float]:
    """Half-width of the thickest stroke, and the longer side of the box of all ink, in pixels."""
    import cv2

    y0, y1, x0, x1 = ink_box(mask)
    extent = max(y1 - y0, x1 - x0)
    small = reduced(mask.astype(np.uint8) * 255, side=2 * FIGURE_SIDE // 3) > 127
    depth = cv2.distanceTransform(np.pad(small, 1).astype(np.uint8), cv2.DIST_L2, 3)
    return float(depth.max()) * mask.shape[0] / small.shape[0], float(extent)
