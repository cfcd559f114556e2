"""The ink of one picture: found on paper, silk, printed grids and rubbings; seals and page edges left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import check_writing_size
from rumu.capture.image import Box, Bytes, as_image, bounding_box, box_inside_frame, shrink
from rumu.errors import RefusedImage
from rumu.surface.colour import coloured_as_gray, find_red_marks, is_seal, redness
from rumu.surface.grid import remove_grid
from rumu.surface.ink_cleaning import (
    ColourSettings,
    PositionSettings,
    close_cuts,
    remove_beyond_lines,
    remove_by_colour,
    remove_by_position,
    remove_ruled_lines,
)
from rumu.surface.pages import (
    character_size,
    clean_page,
    measure_sharpness,
    side_judged,
)
from rumu.surface.paper import (
    PAPER_GRAY,
    REDUCED_SIDE,
    Paper,
    Polarity,
    divide_by_paper,
    fit_paper,
    histogram,
    level_of,
    otsu_threshold,
    threshold_below_grid,
    tone,
)
from rumu.surface.sheet import find_sheet, has_bays
from rumu.surface.writing import (
    InkLevels,
    WritingLimits,
    refuse_cut_by_shadow,
    refuse_flat,
    refuse_small,
    refuse_unwritten,
)
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Ink:
    """The ink of one picture.

    mask: (H, W) bool, True on ink.
    density: (H, W) float32 in [0, 1], how far the ink lies below the paper around it: 1 is black, 0.3 a pale
        gray; 0 off the ink. On a rubbing the same of the strokes above their ground.
    polarity: 'dark' ink on light paper, 'light' strokes on dark ground.
    paper: level of the paper (of the ground, for 'light'), as stored, in [0, 1].
    contrast: median density of the ink, in (0, 1].
    left_out: pixels that were dark enough and are no part of the writing, by kind: 'seal' (and red grid),
        'grid' (ruled lines and what lies beyond a border line), 'speck', 'edge', 'neighbour', 'caption',
        'stain'; and 'frame', the pixels of a flat frame, or of the table, around the paper.
    figures: 'noise' (contrast over the paper's own spread), 'edge' (step across the outline over the
        contrast, 1 is sharp), 'between' (half-dark pixels for each pixel of outline), 'coherence' (share of
        the ink's variance that survives averaging over 8 pixels), 'light' (see `Paper.light`); of a page of
        many characters also 'character' (their side in pixels).
    """

    mask: BoolArray
    density: FloatArray
    polarity: Polarity
    paper: float
    contrast: float
    left_out: Mapping[str, int] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class InkMaskSettings:
    """How ink is separated from paper.

    clean: contrast over the paper's spread from which the paper has no grain of its own. Above it specks are
        sought up to `clean_speck` times the size and `clean_speck_share` times the share of the ink.
    smoothing: (contrast over spread, side of a median filter in pixels) from clean paper on; the first whose
        contrast is reached is used. noisiest: the filter's side where none is.
    fewest_pixels: least number that is not red, for a page to have ink on it.
    red_edge, red_edge_on_dark: side, in pixels, of the neighbourhood that belongs to a red mark.
    cut_width: pixels over which ink is closed where a red mark crossed it.
    grid: whether a printed grid may be on the page. Looking for one takes half of the time.
    """

    clean: float = 12.0
    clean_speck: float = 2.0
    clean_speck_share: float = 3.0
    smoothing: tuple[tuple[float, int], ...] = ((16.0, 0), (9.0, 3), (5.0, 5))
    noisiest: int = 7
    fewest_pixels: int = 64
    red_edge: int = 3
    red_edge_on_dark: int = 7
    cut_width: int = 2
    grid: bool = True
    position: PositionSettings = field(default_factory=PositionSettings)
    colour: ColourSettings = field(default_factory=ColourSettings)
    writing: WritingLimits = field(default_factory=WritingLimits)


def find_ink(
    image: npt.NDArray[Any],
    *,
    linear: bool = False,
    polarity: Polarity | None = None,
    settings: InkMaskSettings | None = None,
) -> Ink:
    """Find the ink of a picture of writing.

    image: (H, W) or (H, W, 3), any dtype that `as_image` takes, values as stored (display-encoded).
    linear: True when the values are linear light, as the albedo of a Surface is.
    polarity: None to decide it from the picture.
    Raises ImageError for an array that is no image, and RefusedImage with reason 'blank' (paper and nothing
    on it, or only a seal or a grid), 'black' (nothing but dark), 'noise' (speckle, or a picture without
    writing), 'too thin' (written with a pen), 'too small' (a picture of few pixels) or 'uneven light'.
    """
    import cv2

    settings = settings or InkMaskSettings()
    checked = as_image(image)
    check_writing_size(checked.shape[1], checked.shape[0])
    # 8 bits, display-encoded: enough for a threshold, and OpenCV is quickest on them
    picture = np.asarray(cv2.convertScaleAbs(cv2.sqrt(checked) if linear else checked, alpha=255.0), np.uint8)
    try:
        return _find_ink(picture, polarity, settings)
    except RefusedImage as refusal:
        found = None
        if refusal.reason == "blank" and picture.ndim == 3 and polarity != "light":
            found = _find_coloured_ink(picture, settings)
        if found is not None:
            return found
        refuse_small(picture.shape, settings.writing)
        raise


def _find_coloured_ink(picture: Bytes, settings: InkMaskSettings) -> Ink | None:
    """The ink of a page on which nothing is black; None where there is none, or only a seal.

    Raises RefusedImage where what is coloured is written with a pen.
    """
    try:
        found = _find_ink(coloured_as_gray(picture), "dark", settings)
    except RefusedImage as refusal:
        if refusal.reason in ("too thin", "uneven light"):
            raise
        return None
    return None if is_seal(found.mask) else found


def _find_ink(picture: Bytes, polarity: Polarity | None, settings: InkMaskSettings) -> Ink:
    """The ink of a picture (H, W) or (H, W, 3) uint8."""
    (y0, y1, x0, x1), off_sheet, small = _find_paper(picture, polarity)
    view = np.ascontiguousarray(picture[y0:y1, x0:x1])
    refuse_flat(small, settings.writing)
    paper = fit_paper(small, polarity="dark" if off_sheet is not None else polarity)
    page = _separate(view, small, paper, off_sheet, settings)
    mask, left_out, character = _clean(page, paper.polarity, settings)
    side = side_judged(mask, character, side=settings.writing.side)
    figures = measure_sharpness(page.x, page.cut, mask, ink=page.ink, paper=page.paper, side=side)
    figures |= {"noise": page.noise, "light": page.light} | (
        {} if character is None else {"character": character}
    )
    refuse_unwritten(mask, page, figures, limits=settings.writing, clean=settings.clean)
    if off_sheet is not None:
        refuse_cut_by_shadow(mask, off_sheet, settings.writing)
    # The figures above are those of all that is dark: a seal or a neighbour is as blurred, or grainy, as ink.
    density = np.subtract(1.0, page.x / np.float32(PAPER_GRAY), dtype=np.float32)
    # a frame was cut off all round; a strip along one side is cut off sharply
    framed = all(inner < outer for inner, outer in zip(view.shape[:2], picture.shape[:2], strict=True))
    colour = (
        replace(settings.colour, side_share=0.0) if character is not None else settings.colour
    )  # no column is a neighbour
    mask, removed = remove_by_colour(
        mask, density, redness=page.redness, noise=page.noise, framed=framed, settings=colour
    )
    for kind, pixels in removed.items():
        left_out[kind] = left_out.get(kind, 0) + pixels
    left_out["frame"] = picture.shape[0] * picture.shape[1] - mask.size
    whole = np.zeros(picture.shape[:2], bool)
    whole[y0:y1, x0:x1] = mask
    inked = np.zeros(picture.shape[:2], np.float32)
    inked[y0:y1, x0:x1][mask] = np.maximum(density[mask], 1 / 255)
    level = float(np.median(paper.level)) / 255
    ground = level if paper.polarity == "dark" else 1.0 - level
    return Ink(whole, inked, paper.polarity, ground, page.contrast, left_out, figures)


def _find_paper(picture: Bytes, polarity: Polarity | None) -> tuple[Box, BoolArray | None, Bytes]:
    """The box of the picture that shows paper; the pixels in it that do not, if any; the box, reduced."""
    import cv2

    y0, y1, x0, x1 = box_inside_frame(picture)
    view = picture[y0:y1, x0:x1]
    small = shrink(view, side=REDUCED_SIDE)
    sheet = None if polarity == "light" else find_sheet(small)
    if sheet is None or not sheet.any():
        return (y0, y1, x0, x1), None, small
    full = cv2.resize(sheet.astype(np.uint8), view.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
    top, bottom, left, right = bounding_box(full)
    reduced = shrink(view[top:bottom, left:right], side=REDUCED_SIDE)
    return (y0 + top, y0 + bottom, x0 + left, x0 + right), ~full[top:bottom, left:right], reduced


def _separate(
    view: Bytes, small: Bytes, paper: Paper, off_sheet: BoolArray | None, settings: InkMaskSettings
) -> InkLevels:
    """Ratio to the paper, smoothed as much as the paper is noisy, and the level half-way to the ink."""
    import cv2

    value = tone(view, polarity=paper.polarity)
    x = divide_by_paper(value, level_of(view, paper))
    if paper.polarity == "dark" and float(np.median(paper.level)) < settings.writing.black:
        raise RefusedImage("expected ink on paper, got a black page", reason="black")
    cut, red = np.zeros(x.shape, bool), None
    if view.ndim == 3:
        under = divide_by_paper(tone(small, polarity=paper.polarity), paper.level)
        colour = np.median(small[under > otsu_threshold(histogram(under))], axis=0).astype(np.float64)
        cut = find_red_marks(view, paper=colour, polarity=paper.polarity)
        red = partial(redness, view, paper=colour) if paper.polarity == "dark" else None
    if off_sheet is not None:
        x[off_sheet], cut = PAPER_GRAY, cut | off_sheet
    grid = 0
    if paper.polarity == "dark" and settings.grid:
        x, grid = remove_grid(x)
    page = _find_levels(x, cut, settings)
    size = next((side for least, side in settings.smoothing if page.noise > least), settings.noisiest)
    if size:
        page = _find_levels(np.asarray(cv2.medianBlur(x, size), dtype=np.uint8), cut, settings)
    if page.noise > settings.clean:
        threshold = threshold_below_grid(page.x, page.threshold)
        darkest = _median(histogram(page.x), 0, threshold)
        page = replace(page, threshold=threshold, ink=min(page.ink, darkest))
    light = 0.0 if off_sheet is not None and has_bays(off_sheet) else paper.light
    grain = float(cv2.absdiff(value, cv2.medianBlur(value, 3)).mean())
    page = replace(page, grain=grain, redness=red, grid=grid, light=light)
    return replace(page, cut=_widen_cut(page, paper.polarity, settings)) if cut.any() else page


def _find_levels(x: Bytes, cut: BoolArray, settings: InkMaskSettings) -> InkLevels:
    """Otsu's threshold, moved half-way between the medians of the two sides; red marks are on neither."""
    counts = histogram(x, mask=~cut if cut.any() else None)
    if counts.sum() < settings.fewest_pixels:
        raise RefusedImage("expected writing, got only red marks", reason="blank")
    threshold = otsu_threshold(counts)
    for _ in range(3):
        dark, light = _median(counts, 0, threshold), _median(counts, threshold, 256)
        threshold = (dark + light) / 2
    off = np.abs(np.arange(256) - light)
    order = np.argsort(off)
    spread = np.cumsum(np.where(np.arange(256) >= threshold, counts, 0.0)[order])
    middle = float(off[order][np.searchsorted(spread, spread[-1] / 2)])
    return InkLevels(x, threshold, dark, light, (light - dark) / max(1.4826 * middle, 0.5), cut)


def _median(counts: FloatArray, low: float, high: float) -> float:
    """Median gray level in [low, high) of a histogram; `low` where it is empty."""
    first = int(np.ceil(low))
    part = np.cumsum(counts[first : int(np.ceil(high))])
    return float(first + np.searchsorted(part, part[-1] / 2)) if len(part) and part[-1] else low


def _widen_cut(page: InkLevels, polarity: Polarity, settings: InkMaskSettings) -> BoolArray:
    """Red marks with their soft edges; ink that is plainly dark stays ink."""
    import cv2

    size = settings.red_edge if polarity == "dark" else settings.red_edge_on_dark
    near = cv2.dilate(page.cut.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    if polarity == "light":
        return np.asarray(near)
    return np.asarray(near & (page.cut | (page.x > (page.ink + page.threshold) / 2)))


def _clean(
    page: InkLevels, polarity: Polarity, settings: InkMaskSettings
) -> tuple[BoolArray, dict[str, int], float | None]:
    """The ink without red marks, ruled lines and what its position gives away; pixels of each kind.

    Last the side of the characters, in pixels, where there are many: see `character_size`.
    """
    dark, position = page.dark, settings.position
    mask = dark
    if page.cut.any():
        mask = close_cuts(dark & ~page.cut, page.cut & dark, width=settings.cut_width)
    if page.noise < settings.clean:
        position = replace(
            position,
            speck=settings.clean_speck * position.speck,
            speck_share=settings.clean_speck_share * position.speck_share,
        )
    unruled, lines = remove_ruled_lines(mask, polarity=polarity)
    character = None
    if page.noise >= settings.writing.noise:
        character = character_size(unruled, grainy=page.noise < settings.clean)
    if character is None:
        unruled = remove_beyond_lines(unruled, lines, polarity=polarity)
        kept, left_out = remove_by_position(unruled, settings=position)
        left_out["grid"] = int(np.count_nonzero(mask & ~unruled))
    else:
        kept, left_out = clean_page(mask, character, polarity=polarity, settings=position)
    left_out["grid"] = left_out.get("grid", 0) + page.grid
    left_out["seal"] = int(np.count_nonzero(dark & ~mask))
    return kept, left_out, character
