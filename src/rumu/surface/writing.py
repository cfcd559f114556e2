"""A page parted into ink and paper, and what is refused because it shows no writing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes
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
        ruled lines.
    border: share of the picture's border that ink may cover. pixels: least ink.
    grain: mean change of a pixel (0-255) by a median filter above which a blank page is noise.
    speckle: share of dark pixels that makes it noise, too, when less than `written` of them are writing.
    only_red: share of the dark pixels that are red marks on a page with nothing else.
    side: longer side, in pixels, of the picture that sharpness is judged on, so that a large photo is judged
        like a crop; of a page, the side of one character.
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


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """A page separated into ink and paper.

    x: (H, W) uint8, ratio to the paper. threshold, ink, paper: gray levels of it, the last two medians.
    noise: contrast over the paper's spread. cut: (H, W), red marks and what lies off the sheet.
    grain: 0-255. redness: measures `redness`; None without colour, and on a rubbing. grid: pixels of a
        printed grid that was taken off.
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


def refuse_unwritten(
    mask: BoolArray, page: Page, figures: Mapping[str, float], *, limits: WritingLimits, clean: float
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
    speckled = dark.mean() > limits.speckle and np.count_nonzero(mask) < limits.written * count
    if reason == "blank" and (
        page.grain > limits.grain or (speckled and not page.cut.any() and not page.grid)
    ):
        reason, seen = "noise", "speckle"
    raise RefusedImage(f"expected writing, got {seen}", reason=reason)


def _what_else(
    mask: BoolArray, page: Page, figures: Mapping[str, float], limits: WritingLimits, clean: float
) -> tuple[str, str] | None:
    """Reason and description of what the picture shows instead of writing; None when it shows writing."""
    if page.contrast < limits.contrast or np.count_nonzero(mask) < limits.pixels:
        return "blank", "a page with nothing on it"
    rim = np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]])
    character = figures.get("character")
    side = 2 * side_judged(mask, character, side=limits.side) // 3
    half_width, extent = half_width_and_extent(mask, character, side=side)
    soft = figures["edge"] < limits.soft
    thick = half_width > limits.thick * min(mask.shape)
    # Grain of the paper is half-dark too: grainy paper may have more of it.
    half_dark = figures["between"] / (limits.half_dark * max(1.0, clean / figures["noise"]))
    tests = (
        (figures["coherence"] < limits.coherence or figures["edge"] > limits.torn, "noise", "speckle"),
        (figures["noise"] < limits.noise, "noise", "a picture that does not part into ink and paper"),
        (figures["edge"] < limits.blurred, "blank", "shades without the edge of a stroke"),
        (rim.mean() > limits.border, "noise", "dark sides and no writing"),
        (half_width < limits.hairline * extent, "blank", "ruled lines only"),
        (soft and half_dark > (0.5 if thick else 1.0), "noise", "a picture without writing"),
    )
    return next(((reason, seen) for holds, reason, seen in tests if holds), None)
