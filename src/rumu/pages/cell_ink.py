"""The writing in printed cells: without the grid, its guides and marks in red, and which cells hold none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.pages.line_evidence import Map, Picture, paper_level
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class CellInkSettings:
    """What counts as writing in a cell; lengths are shares of its side, darkness is 0 on paper and 1 black.

    side: pixels of a cell when cells are compared. printed: the share of cells that a guide is seen in, at
        least, where all cells have it; few: with fewer cells nothing is known of the guides.
    coloured: a mark is red where its red is darker than the rest by less than this share.
    faintest: of writing; of_darkest: least darkness of a stroke, as a share of the cell's darkest parts;
        of_page: and of what is usual on the page.
    dark_guide: a guide that is darker than this is bridged like a grid line, whose width is `line`; across:
        ink on both sides of a line goes on over it up to this width.
    margin: this much along the edges is not looked at; border: a part that stays this close to an edge is a
        line, or a neighbour's stroke. extent: least length of a written part. area: least area.
    """

    side: int = 64
    printed: float = 0.3
    few: int = 6
    coloured: float = 0.6
    faintest: float = 0.13
    of_darkest: float = 0.4
    of_page: float = 0.22
    dark_guide: float = 0.4
    line: float = 0.04
    across: float = 0.1
    margin: float = 0.05
    border: float = 0.16
    extent: float = 0.12
    area: float = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class CellInk:
    """ink: (H, W) bool, the writing. empty: (N,) bool, cells that hold none."""

    ink: BoolArray
    empty: BoolArray


def find_cell_ink(picture: Picture, quads: FloatArray, *, settings: CellInkSettings | None = None) -> CellInk:
    """The writing of a picture (H, W, 3) in cells (N, 4, 2), corners from the top left clockwise."""
    settings = settings or CellInkSettings()
    dark = ink_darkness(picture, quads, settings)
    patches = cut_cells(dark, quads, side=settings.side)
    printed = printed_pattern(patches, settings)
    rest = patches - printed
    darkest = np.sort(rest.reshape(len(rest), -1), axis=1)[:, -max(4, rest[0].size // 100)]
    usual = float(np.percentile(darkest, 75))
    least = np.maximum(settings.faintest, np.maximum(settings.of_darkest * darkest, settings.of_page * usual))
    empty = np.array([not _is_written(one > t, settings) for one, t in zip(rest, least, strict=True)])
    ink = _ink_of_page(dark, quads, printed=printed, least=least, empty=empty, settings=settings)
    return CellInk(ink, empty)


def ink_darkness(picture: Picture, quads: FloatArray, settings: CellInkSettings) -> Map:
    """(H, W) darkness in the channel in which the printed lines are faintest; nothing where a mark is red."""
    import cv2

    height, width = picture.shape[:2]
    paper = np.stack([paper_level(np.ascontiguousarray(picture[..., k])) for k in range(3)], axis=-1)
    dark = np.clip((paper - picture) / paper, 0, 1)
    red, green, blue = dark[..., 0], dark[..., 1], dark[..., 2]
    lines = np.zeros((height, width), np.uint8)
    cv2.polylines(lines, list(np.round(quads).astype(np.int32)), True, 1, 2)
    on_lines = [float(channel[lines > 0].mean()) if lines.any() else 0.0 for channel in (red, green, blue)]
    best = int(np.argmin(on_lines))
    chosen = dark[..., best] if on_lines[best] < 0.8 * max(on_lines) else red
    other = np.maximum(green, blue)
    is_red = (red < settings.coloured * other) & (other > settings.faintest)
    return np.asarray(np.where(is_red, np.minimum(red, chosen), chosen))


def cut_cells(values: Map, quads: FloatArray, *, side: int) -> Map:
    """(N, side, side): each cell as a square."""
    import cv2

    square = np.array([[0, 0], [side, 0], [side, side], [0, side]], np.float32)
    longest = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2).max(initial=1.0)
    scale = min(1.0, 1.6 * side / longest)
    if scale < 1:
        values = cv2.resize(values, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    cut = [
        cv2.warpPerspective(
            values, cv2.getPerspectiveTransform((scale * q).astype(np.float32), square), (side, side)
        )
        for q in quads
    ]
    return np.asarray(np.stack(cut)) if cut else np.zeros((0, side, side), np.float32)


def printed_pattern(patches: Map, settings: CellInkSettings) -> Map:
    """(side, side): how dark the guides are that are printed in every cell; 0 where that is not known."""
    import cv2

    if len(patches) < settings.few:
        return np.zeros(patches.shape[1:], np.float32)
    widened = np.stack([cv2.dilate(one, np.ones((3, 3), np.uint8)) for one in patches])
    found = np.percentile(widened, 100 * settings.printed, axis=0).astype(np.float32)
    return np.asarray(cv2.dilate(found, np.ones((3, 3), np.uint8)))


def _is_written(ink: BoolArray, settings: CellInkSettings) -> bool:
    """Whether a cell (side, side) holds a part of the size of a stroke, off its edges."""
    import cv2

    side = ink.shape[0]
    margin, border = round(settings.margin * side), settings.border * side
    closed = cv2.morphologyEx(
        ink.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    )  # dry, halftone
    inner = np.ascontiguousarray(closed[margin : side - margin, margin : side - margin])
    _, _, stats, _ = cv2.connectedComponentsWithStats(inner, connectivity=8)
    for left, top, width, height, area in stats[1:]:
        x, y = left + margin, top + margin
        near = x + width <= border or y + height <= border or x >= side - border or y >= side - border
        if not near and max(width, height) >= settings.extent * side and area >= settings.area * side**2:
            return True
    return False


def _ink_of_page(
    dark: Map,
    quads: FloatArray,
    *,
    printed: Map,
    least: FloatArray,
    empty: BoolArray,
    settings: CellInkSettings,
) -> BoolArray:
    """(H, W): darker than what is printed there by what its cell asks; no lines but where strokes cross."""
    import cv2

    asked, hidden = _asked_darkness(
        dark.shape, quads, printed=printed, least=least, empty=empty, settings=settings
    )
    side = float(np.median(np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2))) if len(quads) else 0.0
    outlines = list(np.round(quads).astype(np.int32))
    lines, inside = np.zeros(dark.shape, np.uint8), np.zeros(dark.shape, np.uint8)
    cv2.polylines(lines, outlines, True, 1, max(3, round(settings.line * side)))
    cv2.fillPoly(inside, outlines, 1)
    ink = dark > asked
    dark_enough = dark > np.median(least)
    if np.count_nonzero(dark_enough & (lines > 0)) > 0.3 * np.count_nonzero(lines):
        hidden |= lines > 0
    bare = ink & ~hidden
    reach = max(3, round(settings.across * side)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    bare |= _thicker_than_lines(dark_enough, lines > 0, outlines)
    closed = cv2.morphologyEx(bare.astype(np.uint8), cv2.MORPH_CLOSE, kernel) > 0
    return _connected_to(bare | (closed & hidden & (dark > settings.faintest)), inside > 0)


def _thicker_than_lines(
    dark: BoolArray, lines: BoolArray, outlines: list[npt.NDArray[np.int32]]
) -> BoolArray:
    """What is dark and thicker than the printed lines, guides among them: strokes, wherever they run."""
    import cv2

    if not outlines:
        return np.zeros_like(dark)
    thin = np.zeros(dark.shape, np.uint8)
    cv2.polylines(thin, outlines, True, 1, 1)
    width = round(int(np.count_nonzero(dark & lines)) / max(1, int(np.count_nonzero(thin))))
    kernel = np.ones((width + 2, width + 2), np.uint8)
    return np.asarray(cv2.morphologyEx(dark.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0)


def _asked_darkness(
    shape: tuple[int, ...],
    quads: FloatArray,
    *,
    printed: Map,
    least: FloatArray,
    empty: BoolArray,
    settings: CellInkSettings,
) -> tuple[Map, BoolArray]:
    """(H, W) the darkness from which on there is ink; and where a guide is too dark for ink to be told."""
    import cv2

    asked = np.full(shape, np.float32(np.median(least) if len(least) else 1.0))
    hidden = np.zeros(shape, bool)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32) * settings.side
    for quad, threshold, bare in zip(quads, least, empty, strict=True):
        first = np.maximum(0, np.floor(quad.min(axis=0))).astype(int)
        last = np.minimum(np.ceil(quad.max(axis=0)) + 1, shape[1::-1]).astype(int)
        if (last <= first).any():
            continue
        matrix = cv2.getPerspectiveTransform(square, (quad - first).astype(np.float32))
        size = int(last[0] - first[0]), int(last[1] - first[1])
        there = cv2.warpPerspective(np.ones_like(printed), matrix, size, flags=cv2.INTER_NEAREST) > 0
        guide = cv2.warpPerspective(printed, matrix, size)
        part = slice(first[1], last[1]), slice(first[0], last[0])
        asked[part][there] = (guide + (1.0 if bare else threshold))[there]
        hidden[part] |= there & (guide > settings.dark_guide)
    return asked, hidden


def _connected_to(ink: BoolArray, inside: BoolArray) -> BoolArray:
    import cv2

    _, labels = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    kept = np.zeros(int(labels.max()) + 1, bool)
    kept[np.unique(labels[inside & ink])] = True
    kept[0] = False
    return np.asarray(kept[labels])
