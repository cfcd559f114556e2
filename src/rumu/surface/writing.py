"""A page parted into ink and paper, and what is refused because it shows no writing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes, bounding_box
from rumu.errors import RefusedImage
from rumu.surface.pages import half_width_and_extent, side_judged
from rumu.surface.paper import PAPER_GRAY
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class WritingLimits:
    """When a picture shows no writing. Each limit lies outside what 4,000 crops of masters and copies reach.

    gray_range: gray levels of the reduced picture below which it shows nothing at all.
    black: paper this dark (0-255) is no paper.
    contrast: least contrast. noise: least contrast over the paper's spread. coherence: least coherence.
    blurred, torn: least and largest step across the outline.
    half_dark: most half-dark pixels for each pixel of a soft outline; soft: step below which it is soft.
    thick: half-width over the page's side from which a soft shape may have half as many.
    hairline: half-width over the extent of the ink, of a page over its characters' side, below which it is
        ruled lines, or a pen's. ruled: share of it that lies in straight runs along rows or columns, of this
        length over the side, from which it is ruled lines; ruled_run: that length. brush: what a stroke of
        the brush usually measures, over the same extent.
    border: share of the picture's border that ink may cover. pixels: least ink.
    grain: mean change of a pixel (0-255) by a median filter above which a blank page is noise.
    speckle: share of dark pixels that makes it noise, too, when less than `written` of them are writing.
    only_red: share of the dark pixels that are red marks on a page with nothing else.
    side: longer side, in pixels, of the picture that sharpness is judged on, so that a large photo is judged
        like a crop; of a page, the side of one character.
    light: of the darkest part of the paper, as a share of the brightest, below which it is the light that
        hides the writing. cut: ink along the edge of a dark part, over the side, that says that writing goes
        on in it. small_side: side, in pixels, below which it is the picture's size that hides it.
    """

    gray_range: int = 12
    black: int = 35
    contrast: float = 0.06
    noise: float = 3.6
    coherence: float = 0.09
    blurred: float = 0.36
    torn: float = 1.6
    half_dark: float = 4.0
    soft: float = 0.7
    thick: float = 0.17
    hairline: float = 0.014
    border: float = 0.45
    pixels: int = 24
    grain: float = 20.0
    speckle: float = 0.005
    written: float = 0.5
    only_red: float = 0.93
    side: int = 512
    brush: float = 0.08
    ruled: float = 0.5
    ruled_run: float = 0.3
    light: float = 0.4
    cut: float = 0.02
    small_side: int = 40


@dataclass(frozen=True, slots=True, eq=False)
class InkLevels:
    """A page separated into ink and paper.

    x: (H, W) uint8, ratio to the paper. threshold, ink, paper: gray levels of it, the last two medians.
    noise: contrast over the paper's spread. cut: (H, W), red marks and what lies off the sheet.
    grain: 0-255. redness: measures `redness`; None without colour, and on a rubbing. grid: pixels of a
        printed grid that was taken off. light: see `Paper.light`; 0 where what is dark
        beside the sheet runs into it.
    """

    x: Bytes
    threshold: float
    ink: float
    paper: float
    noise: float
    cut: BoolArray
    grain: float = 0.0
    redness: Callable[[], FloatArray] | None = None
    grid: int = 0
    light: float = 1.0

    @property
    def dark(self) -> BoolArray:
        """(H, W) bool: all that is darker than the threshold."""
        return np.asarray(self.x < self.threshold)

    @property
    def contrast(self) -> float:
        """Median density of the ink."""
        return 1.0 - self.ink / PAPER_GRAY


def refuse_flat(small: Bytes, limits: WritingLimits) -> None:
    """Raise RefusedImage where a reduced picture shows nothing at all."""
    gray = small if small.ndim == 2 else small.max(axis=2)
    if int(gray.max()) - int(gray.min()) < limits.gray_range or int(gray.max()) < limits.black:
        reason = "black" if np.median(gray) < limits.black else "blank"
        raise RefusedImage(f"expected writing, got a {reason} page", reason=reason)


def refuse_small(shape: tuple[int, ...], limits: WritingLimits) -> None:
    """Raise RefusedImage where a picture (H, W, ...) has too few pixels to show strokes."""
    height, width = shape[:2]
    if min(height, width) >= limits.small_side:
        return
    least = 2 * limits.small_side
    raise RefusedImage(
        f"expected a picture that shows strokes, {least} x {least} pixels or more, got {width} x {height}",
        reason="too small",
        zh=f"圖片只有 {width} × {height} 像素，看不清筆畫；至少要 {least} × {least} 像素。",
    )


def refuse_cut_by_shadow(mask: BoolArray, dark: BoolArray, limits: WritingLimits) -> None:
    """Raise RefusedImage where ink (H, W) runs into a part of the picture (H, W) that is too dark."""
    import cv2

    beside = cv2.dilate(dark.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    if np.count_nonzero(mask & beside) > 2 * limits.cut * max(mask.shape):
        raise RefusedImage(_UNEVEN[0], reason="uneven light", zh=_UNEVEN[1])


_UNEVEN = (
    "expected a page in even light, got one with a part too dark to see the writing in it; "
    "photograph it without a shadow",
    "光線不勻，有一部分太暗，看不到那裏的筆畫；請避開陰影、在均勻的光線下再拍。",
)


def refuse_unwritten(
    mask: BoolArray, page: InkLevels, figures: Mapping[str, float], *, limits: WritingLimits, clean: float
) -> None:
    """Raise RefusedImage where what is dark is no writing.

    mask: (H, W), the ink that is left of it. figures: see `Ink`. clean: contrast over the paper's spread from
    which the paper has no grain of its own.
    """
    dark = page.dark
    count = np.count_nonzero(dark)
    if page.grain < limits.grain and np.count_nonzero(dark & page.cut) > limits.only_red * count > 0:
        raise RefusedImage("expected writing, got only red marks", reason="blank")
    verdict = _what_else(mask, page, figures, limits, clean)
    if verdict is None:
        return
    reason, seen = verdict
    if page.light < limits.light and (reason == "noise" or page.light == 0.0):
        raise RefusedImage(_UNEVEN[0], reason="uneven light", zh=_UNEVEN[1])
    if reason == "too thin":
        raise _thin_refusal(mask, figures, limits)
    speckled = dark.mean() > limits.speckle and np.count_nonzero(mask) < limits.written * count
    if reason == "blank" and (
        page.grain > limits.grain or (speckled and not page.cut.any() and not page.grid)
    ):
        reason, seen = "noise", "speckle"
    raise RefusedImage(f"expected writing, got {seen}", reason=reason)


def _what_else(
    mask: BoolArray, page: InkLevels, figures: Mapping[str, float], limits: WritingLimits, clean: float
) -> tuple[str, str] | None:
    """Reason and description of what the picture shows instead of writing; None when it shows writing."""
    if page.contrast < limits.contrast or np.count_nonzero(mask) < limits.pixels:
        return "blank", "a page with nothing on it"
    rim = np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]])
    character = figures.get("character")
    side = 2 * side_judged(mask, character, side=limits.side) // 3
    half_width, extent = half_width_and_extent(mask, character, side=side)
    thin = half_width < limits.hairline * extent
    soft = figures["edge"] < limits.soft
    thick = half_width > limits.thick * min(mask.shape)
    # Grain of the paper is half-dark too: grainy paper may have more of it.
    half_dark = figures["between"] / (limits.half_dark * max(1.0, clean / figures["noise"]))
    tests = (
        (figures["coherence"] < limits.coherence or figures["edge"] > limits.torn, "noise", "speckle"),
        (figures["noise"] < limits.noise, "noise", "a picture that does not part into ink and paper"),
        (figures["edge"] < limits.blurred, "blank", "shades without the edge of a stroke"),
        (rim.mean() > limits.border, "noise", "dark sides and no writing"),
        (thin and _is_ruled(mask, limits), "blank", "ruled lines only"),
        (thin, "too thin", "lines of a pen"),
        (soft and half_dark > (0.5 if thick else 1.0), "noise", "a picture without writing"),
    )
    return next(((reason, seen) for holds, reason, seen in tests if holds), None)


def _is_ruled(mask: BoolArray, limits: WritingLimits) -> bool:
    """Whether most of the ink lies in straight runs along the rows or the columns."""
    import cv2

    wide, high = (max(3, round(limits.ruled_run * n)) for n in mask.shape[::-1])
    ink = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3), np.uint8))
    runs = np.zeros(mask.shape, bool)
    for shape in ((1, wide), (high, 1)):
        runs |= cv2.morphologyEx(ink, cv2.MORPH_OPEN, np.ones(shape, np.uint8)) > 0
    return bool(np.count_nonzero(mask & runs) > limits.ruled * np.count_nonzero(mask))


def _thin_refusal(mask: BoolArray, figures: Mapping[str, float], limits: WritingLimits) -> RefusedImage:
    """What is said of lines that are too thin for a brush: their width, and what a brush leaves at least."""
    import cv2

    y0, y1, x0, x1 = bounding_box(mask)
    extent = figures.get("character") or max(y1 - y0, x1 - x0)
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)
    width = max(4 * (float(depth[depth > 0].mean()) - 0.5), 1.0)  # depth across a line is a triangle
    brush = limits.brush * extent
    return RefusedImage(
        f"expected strokes of a brush, about {brush:.0f} pixels wide in writing of this size, got lines of "
        f"about {width:.0f}; what a hard pen or a pencil wrote cannot be marked: write it with a brush",
        reason="too thin",
        zh=f"線條太細，不是毛筆的筆畫：這樣大的字，筆畫約寬 {brush:.0f} 像素，這裏約寬 {width:.0f}。"
        "硬筆和鉛筆寫的字不能評分，請用毛筆書寫。",
    )
