"""The ink of a page: writing apart from paper, seals, coloured print and the dark around the page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from rumu.values import BoolArray, FloatArray

Picture = npt.NDArray[np.uint8]
Polarity = Literal["dark on light", "light on dark"]


@dataclass(frozen=True, slots=True)
class PageInkSettings:
    """How ink is told from paper.

    ground: side of the window within which paper must show, as a share of the longer side of the page.
    contrast: how much darker than its paper ink must be at least, as a share of the paper's light.
    strongest: from how much on everything is ink, whatever the rest of the page looks like.
    colour: from which difference between its channels, 0-255, a pixel counts as coloured.
    coloured_writing: share of the ink that must be coloured before coloured ink counts as writing.
    rubbing: share of the page that must be dark for a rubbing, white on black.
    surroundings: side of the window whose median is the ground of a mark, as a share of the longer side.
    faint: what share of the darkness of ink a faint mark has at least.
    stroke: side of the window in which ink is as dark as its darkest, as a share of the longer side;
    half: how dark it is there at least, as a share of that; thin: and as a share of what is asked elsewhere;
    above_grain: and by how many standard deviations of the ground it is darker than it.
    """

    ground: float = 0.05
    contrast: float = 0.18
    strongest: float = 0.45
    colour: int = 60
    coloured_writing: float = 0.6
    rubbing: float = 0.55
    surroundings: float = 0.07
    faint: float = 0.25
    stroke: float = 0.008
    half: float = 0.5
    thin: float = 0.5
    above_grain: float = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class PageInk:
    """Where a page is written on.

    ink: (H, W) bool. faint: (H, W) bool, ink and whatever is nearly as dark, such as thin ruled lines.
    colour: (H, W) bool, seals and coloured print that were left out of it. polarity: how the writing
    stands against its ground.
    """

    ink: BoolArray
    faint: BoolArray
    colour: BoolArray
    polarity: Polarity


def find_page_ink(picture: Picture, *, settings: PageInkSettings | None = None) -> PageInk:
    """The writing on a page under any light, on any ground, dark on light or light on dark.

    picture: (H, W, 3) uint8 sRGB. Paper is what stays when dark marks smaller than a window are filled, so
    silk mounted on a lighter ground, a shaded page and a dark desk are each their own ground.
    """
    settings = settings or PageInkSettings()
    gray = _gray(picture)
    polarity: Polarity = "light on dark" if _is_rubbing(gray, settings) else "dark on light"
    if polarity == "light on dark":
        gray = (255 - gray).astype(np.uint8)
    darkness = _darkness(gray, settings)
    threshold = _threshold(darkness, settings)
    ink, colour = _without_colour(darkness > _asked(darkness, threshold, settings), picture, settings)
    faint = darkness > max(settings.faint * threshold, settings.contrast / 2)
    return PageInk(ink=ink, faint=faint, colour=colour, polarity=polarity)


def _gray(picture: Picture) -> Picture:
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)


def _is_rubbing(gray: Picture, settings: PageInkSettings) -> bool:
    """Whether the middle of the page is mostly dark and its marks are lighter than what is around them."""
    import cv2

    height, width = gray.shape
    middle = gray[height // 8 : height - height // 8, width // 8 : width - width // 8]
    factor = min(1.0, 700 / max(middle.shape))
    small = cv2.resize(middle, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    _, dark = cv2.threshold(small, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    if (dark > 0).mean() < settings.rubbing:
        return False
    side = max(3, round(settings.surroundings * max(small.shape))) | 1
    ground = cv2.medianBlur(small, min(side, 255))
    return float(cv2.subtract(small, ground).mean()) > float(cv2.subtract(ground, small).mean())


def _darkness(gray: Picture, settings: PageInkSettings) -> FloatArray:
    """(H, W) float32: by what share each pixel is darker than the paper around it."""
    import cv2

    height, width = gray.shape
    factor = min(1.0, 400 / max(height, width))
    small = cv2.resize(gray, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    side = max(3, round(settings.ground * max(small.shape))) | 1
    window = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    # the brighter of the area means would still hold ink: take the lightest of each small block first
    light = cv2.dilate(small, np.ones((3, 3), np.uint8))
    paper = cv2.morphologyEx(light, cv2.MORPH_CLOSE, window)
    paper = cv2.GaussianBlur(paper, (0, 0), side / 6)
    paper = cv2.resize(paper, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32)
    return np.asarray(1 - gray / np.maximum(paper, 1), dtype=np.float32)


def _threshold(darkness: FloatArray, settings: PageInkSettings) -> float:
    """The darkness that parts ink from paper best (Otsu), within what ink can be."""
    import cv2

    levels = (np.clip(darkness, 0, 1) * 255).astype(np.uint8)
    marks = levels[levels > 255 * settings.contrast / 2]
    if marks.size == 0:
        return settings.strongest
    level, _ = cv2.threshold(marks.reshape(-1, 1), 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return float(np.clip(level / 255, settings.contrast, settings.strongest))


def _asked(darkness: FloatArray, threshold: float, settings: PageInkSettings) -> FloatArray:
    """(H, W) float32: the darkness from which on there is ink: less where the darkest nearby is less.

    A thin stroke that the camera has blurred is as gray as the edge of a thick one.
    """
    import cv2

    side = max(3, round(settings.stroke * max(darkness.shape))) | 1
    darkest = cv2.dilate(darkness, np.ones((side, side), np.uint8))
    light, usual = np.percentile(darkness[::4, ::4], [10, 50])
    grain = usual + settings.above_grain * (usual - light) / 1.28  # of paper, stone or silk
    least = max(settings.contrast, settings.thin * threshold, float(grain))
    return np.asarray(np.clip(settings.half * darkest, min(least, threshold), threshold), np.float32)


def _without_colour(
    ink: BoolArray, picture: Picture, settings: PageInkSettings
) -> tuple[BoolArray, BoolArray]:
    """Ink without what is coloured, and that; all of it where the writing itself is coloured."""
    import cv2

    red, green, blue = cv2.split(picture)
    lightest, darkest = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    coloured = ink & (cv2.subtract(lightest, darkest) > settings.colour)
    if coloured.sum() > settings.coloured_writing * max(int(ink.sum()), 1):
        return ink, np.zeros_like(ink)
    return ink & ~coloured, coloured
