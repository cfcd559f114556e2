"""One character or a page of many: how large the characters are, and what the ink is judged by.

Rules made for one character judge by shares of the picture: what is small beside it is a speck, what is thin
a ruled line. On a page the same shares are whole characters, so there the rules go by the characters' size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.capture.image import Bytes, bounding_box, shrink
from rumu.surface.ink_cleaning import (
    PositionSettings,
    connected_parts,
    remove_by_position,
    remove_ruled_lines,
)
from rumu.surface.paper import Polarity
from rumu.values import BoolArray


@dataclass(frozen=True, slots=True)
class PageSettings:
    """When ink is a page of characters. Parts are connected parts of the ink.

    smallest: least longer side, in pixels, of a part that can be read as one of a character. largest: most,
        as a share of the picture's longer side; frame: longer ones are borders and do not count.
    aspect, fill: least shorter over longer side, and most ink in its box, of a part with strokes; a dot of
        printed shade is filled, and a piece of a ruled line is long.
    parts: least number of parts with strokes; on grainy paper or a worn stone, where one character may fall
        into 33, `grainy_parts`.
    drawn: least share of them among the parts of that size. ink: least share of the ink in such parts.
    whole: side of a character over the side of its parts, a median that is weighted by their ink.
    """

    smallest: int = 8
    largest: float = 0.12
    frame: float = 0.4
    aspect: float = 0.2
    fill: float = 0.7
    parts: int = 28
    grainy_parts: int = 56
    drawn: float = 0.25
    ink: float = 0.6
    whole: float = 1.5


def character_size(
    mask: BoolArray, *, grainy: bool = False, settings: PageSettings | None = None
) -> float | None:
    """Side of the characters of a page in pixels; None where the ink is no page of many characters.

    mask: (H, W) bool, True on ink; ruled lines and seals are best removed before. grainy: the paper is.
    """
    if not mask.any():
        return None
    settings, parts = settings or PageSettings(), connected_parts(mask)
    sides = parts.stop - parts.start
    longer, longest = sides.max(axis=1), max(mask.shape)
    of_size = (longer >= settings.smallest) & (longer < settings.largest * longest)
    filled = parts.area / (sides[:, 0].astype(np.float64) * sides[:, 1])
    drawn = of_size & (filled < settings.fill) & (sides.min(axis=1) > settings.aspect * longer)
    fewest = settings.grainy_parts if grainy else settings.parts
    if np.count_nonzero(drawn) < max(fewest, settings.drawn * np.count_nonzero(of_size)):
        return None
    if parts.area[of_size].sum() < settings.ink * parts.area[longer < settings.frame * longest].sum():
        return None
    order = np.flatnonzero(drawn)[np.argsort(longer[drawn], kind="stable")]
    ink = np.cumsum(parts.area[order])  # the median of the ink: small print is not the size of the writing
    return settings.whole * float(longer[order][np.searchsorted(ink, ink[-1] / 2)])


def remove_solid(mask: BoolArray, *, character: float) -> BoolArray:
    """The ink of a page without what no brush fills: tables, covers and pens, as thick as a character.

    character: side of the page's characters, in pixels.
    """
    import cv2

    radius = round(character / 2)
    side = 2 * radius + 1
    border = np.pad(
        mask.astype(np.uint8), side, mode="edge"
    )  # what is cut by the border may be as thick beyond
    # An opening by a disk, by two distances: unlike cv2.MORPH_OPEN it takes no longer for a larger disk.
    core = cv2.distanceTransform(border, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) > radius
    if not core.any():
        return mask
    far = cv2.distanceTransform((~core).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    solid = cv2.dilate((far <= radius).astype(np.uint8), np.ones((5, 5), np.uint8))
    return np.asarray(mask & ~(solid[side:-side, side:-side] > 0))


def clean_page(
    mask: BoolArray, character: float, *, polarity: Polarity, settings: PositionSettings
) -> tuple[BoolArray, dict[str, int]]:
    """The ink of a page without ruled lines, specks and what no brush fills; pixels of each kind.

    What lies at the border of a page, or stands alone, is writing too. character: side of the page's
    characters, in pixels.
    """
    unruled, _ = remove_ruled_lines(mask, polarity=polarity, character=character)
    drawn = remove_solid(unruled, character=character)
    speck = settings.speck * min(1.0, character**2 / mask.size)
    settings = replace(settings, speck=speck, edge_share=0.0, neighbour_share=0.0, caption_share=0.0)
    kept, left_out = remove_by_position(drawn, settings=settings)
    left_out["edge"] += int(np.count_nonzero(unruled & ~drawn))
    left_out["grid"] = int(np.count_nonzero(mask & ~unruled))
    return kept, left_out


# --- what the ink is judged by ---------------------------------------------------------------------


def side_judged(mask: BoolArray, character: float | None, *, side: int) -> int:
    """Longer side, in pixels, of the reduced picture in which the character has this side."""
    return side if character is None else round(side * max(1.0, max(mask.shape) / character))


def measure_sharpness(
    x: Bytes, cut: BoolArray, mask: BoolArray, *, ink: float, paper: float, side: int
) -> dict[str, float]:
    """The figures 'edge', 'between' and 'coherence' of `Ink`.

    x: (H, W), ratio to the paper; ink, paper: their levels in it. cut: (H, W), red marks. side: longer side,
    in pixels, to which the picture is reduced first.
    """
    import cv2

    x, cut = shrink(x, side=side), shrink(cut.astype(np.uint8), side=side) > 0
    inked = shrink(mask.astype(np.uint8) * 255, side=side) > 127
    outline, step = (
        cv2.morphologyEx(a, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
        for a in (inked.astype(np.uint8), x)
    )
    length = max(1, int(np.count_nonzero((outline > 0) & inked)))
    depth = paper - ink
    on_edge = step[outline > 0]
    half = cv2.inRange(x, ink + 0.3 * depth, ink + 0.7 * depth) > 0
    share = np.count_nonzero(inked) / inked.size
    blocks = cv2.resize(inked.astype(np.float32), None, fx=1 / 8, fy=1 / 8, interpolation=cv2.INTER_AREA)
    return {
        "edge": float(np.median(on_edge)) / depth if len(on_edge) else 0.0,
        "between": float(np.count_nonzero(half & ~cut)) / length,
        "coherence": float(blocks.var()) / max(share * (1 - share), 1e-6),
    }


def half_width_and_extent(mask: BoolArray, character: float | None, *, side: int) -> tuple[float, float]:
    """Half-width of the thickest stroke, and the longer side of the character, in pixels.

    character: its side on a page; None for the box of all ink. side: to which the picture is reduced.
    """
    import cv2

    y0, y1, x0, x1 = bounding_box(mask)
    small = shrink(mask.astype(np.uint8) * 255, side=side) > 127
    depth = cv2.distanceTransform(np.pad(small, 1).astype(np.uint8), cv2.DIST_L2, 3)
    extent = max(y1 - y0, x1 - x0) if character is None else character
    return float(depth.max()) * mask.shape[0] / small.shape[0], float(extent)
