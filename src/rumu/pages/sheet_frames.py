"""The flattened page of a sheet, its light, and the printed frames of cells that say where paper bends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from rumu.pages.sheet_layout import PAPERS, TICK, Box, SheetPage, marker_boxes
from rumu.pages.sheet_markers import EVERYWHERE, PaperMap, bend_map
from rumu.pages.sheet_print import grayness
from rumu.values import FloatArray

_BLOCK = 6.0  # millimetres of the squares in which the paper's brightness is measured
_REACH = 1.6  # millimetres beside a printed line within which it is sought
_CLEAREST = 0.10  # darkness by which a line must stand out
_USUAL = 0.04  # millimetres that a line may be off without counting less
_SOME = 5  # of the sides of cells, each so many, tell how gray they are
RED, GREEN_AND_BLUE = slice(0, 1), slice(1, 3)
"""Channels of a picture: in red only ink is dark, in the others the print is too."""
_NODES = 8  # pixels between the places that are mapped exactly


@dataclass(frozen=True)
class FlatSheet:
    """A page flattened.

    picture: (h, w, 3) uint8. scale: its pixels for each millimetre.
    """

    picture: npt.NDArray[np.uint8]
    scale: float

    @cached_property
    def red(self) -> npt.NDArray[np.uint8]:
        """(h, w): its red channel, in which the print is hardly to be seen."""
        return np.ascontiguousarray(self.picture[:, :, 0])

    @cached_property
    def paper(self) -> npt.NDArray[np.float32]:
        """(rows, columns, 3): how bright the bare paper is, in blocks."""
        import cv2

        side = round(_BLOCK * self.scale)
        height, width = (n // side for n in self.picture.shape[:2])
        blocks = self.picture[: height * side, : width * side].reshape(height, side, width, side, 3)
        levels = np.quantile(blocks, 0.8, axis=(1, 3)).astype(np.float32)
        # strokes as wide as a block are darker than the paper on both sides of them
        closed = cv2.morphologyEx(levels, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
        dark = levels < 0.8 * closed
        return np.asarray(cv2.GaussianBlur(np.where(dark, closed, levels), (3, 3), 0), np.float32)

    def red_paper(self, box: Box, side: int) -> npt.NDArray[np.float32]:
        """(side, side): how bright the bare paper is in red under each pixel of a part of the page."""
        import cv2

        block = round(_BLOCK * self.scale) / self.scale
        at = (np.arange(side) + 0.5) / side
        x = (box.left + at * box.width) / block - 0.5
        y = (box.top + at * box.height) / block - 0.5
        columns, rows = np.meshgrid(x.astype(np.float32), y.astype(np.float32))
        red = np.ascontiguousarray(self.paper[:, :, 0])
        return np.asarray(cv2.remap(red, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))

    def darkness(self, rows: slice, columns: slice, *, channels: slice) -> npt.NDArray[np.float32]:
        """(h, w): how much darker than the paper a part of the page is, in `RED` or in `GREEN_AND_BLUE`.

        The print is dark in green and blue, ink in all of them.
        """
        import cv2

        block = round(_BLOCK * self.scale)
        x, y = (
            (np.arange(at.start, at.stop, dtype=np.float32) + 0.5) / block - 0.5 for at in (columns, rows)
        )
        paper = cv2.remap(self.paper, *np.meshgrid(x, y), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        shown = self.picture[rows, columns, channels].astype(np.float32).sum(axis=2)
        return np.asarray(1.0 - shown / np.maximum(paper[:, :, channels].sum(axis=2), 1.0), np.float32)

    def cut(self, box: Box) -> npt.NDArray[np.uint8]:
        """The part of the page within a box."""
        left, top = round(box.left * self.scale), round(box.top * self.scale)
        right, bottom = (
            round((box.left + box.width) * self.scale),
            round((box.top + box.height) * self.scale),
        )
        return self.picture[top:bottom, left:right].copy()


def flatten(
    picture: npt.NDArray[np.uint8], places: PaperMap, *, scale: float, box: Box | None = None
) -> FlatSheet:
    """The page, or a box of it, as a flat picture of so many pixels for each millimetre."""
    import cv2

    box = box or Box(0.0, 0.0, *PAPERS[places.paper])
    width, height = round(box.width * scale), round(box.height * scale)
    across, down = -(-width // _NODES) + 1, -(-height // _NODES) + 1
    x, y = np.meshgrid(np.arange(across) * _NODES, np.arange(down) * _NODES)
    points = (np.column_stack([x.ravel(), y.ravel()]) + 0.5) / scale + (box.left, box.top)
    mapped = places.pixels(points).astype(np.float32).reshape(down, across, 2)
    columns, rows = np.meshgrid(
        np.arange(width, dtype=np.float32) / _NODES, np.arange(height, dtype=np.float32) / _NODES
    )
    maps = cv2.remap(mapped, columns, rows, cv2.INTER_LINEAR)
    # black beyond the photograph: nothing is read there
    flat = cv2.remap(picture, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
    return FlatSheet(np.asarray(flat, np.uint8), scale)


def refine_by_frames(flat: FlatSheet, page: SheetPage, places: PaperMap) -> PaperMap:
    """The map once more, by the printed sides of the cells too, which show the bend between the markers."""
    upright: list[tuple[FloatArray, FloatArray]] = []
    level: list[tuple[FloatArray, FloatArray]] = []
    for start, end, vertical in _sides(page):
        off = _find_line(flat, start, end, vertical=vertical)
        if off is not None:
            middle = (np.array(start) + np.array(end)) / 2
            seen = middle + ((off, 0.0) if vertical else (0.0, off))
            (upright if vertical else level).append((middle, seen))
    if min(len(upright), len(level)) < 6:
        return places
    boxes = np.array([box.corners.mean(axis=0) for box in marker_boxes(page.paper).values()])
    known = places.pixels(boxes)  # the markers' own places, which the first map follows
    pairs = []
    for found in (upright, level):
        on_paper = np.concatenate([boxes, np.array([middle for middle, _ in found])])
        in_picture = np.concatenate([known, places.pixels(np.array([seen for _, seen in found]))])
        pairs.append((on_paper, in_picture))
    flat_map = PaperMap(places.homography, np.zeros(0), np.zeros(0), page.paper)
    return bend_map(flat_map, along_x=pairs[0], along_y=pairs[1], degrees=EVERYWHERE, usual=_USUAL)


def _sides(page: SheetPage) -> Iterator[tuple[tuple[float, float], tuple[float, float], bool]]:
    """Pieces of the printed sides of cells, each once: from, to, and whether it is upright."""
    seen = set()
    for cell in page.cells:
        (left, top), _, (right, bottom), _ = cell.box.corners.tolist()
        if page.grid == "none":
            shares = (
                (0.3 / cell.box.width, TICK / cell.box.width),
                (1 - TICK / cell.box.width, 1 - 0.3 / cell.box.width),
            )
        else:
            shares = ((0.08, 0.46), (0.54, 0.92))
        for low, high in shares:
            for x in (left, right):
                piece = ((x, top + low * (bottom - top)), (x, top + high * (bottom - top)), True)
                key = tuple(round(value, 3) for point in piece[:2] for value in point)
                if key not in seen:
                    seen.add(key)
                    yield piece
            for y in (top, bottom):
                piece = ((left + low * (right - left), y), (left + high * (right - left), y), False)
                key = tuple(round(value, 3) for point in piece[:2] for value in point)
                if key not in seen:
                    seen.add(key)
                    yield piece


def _find_line(
    flat: FlatSheet, start: tuple[float, float], end: tuple[float, float], *, vertical: bool
) -> float | None:
    """Millimetres by which a printed line lies right of or below its place; None where it is not plain."""
    scale = flat.scale
    profile, middle = _profile(flat, GREEN_AND_BLUE, start, end, vertical=vertical)
    if not len(profile):
        return None
    profile = profile - np.quantile(profile, 0.3)
    peak = int(np.argmax(profile))
    if profile[peak] < _CLEAREST:
        return None
    near = slice(max(peak - 3, 0), peak + 4)
    weight = np.maximum(profile[near] - 0.25 * profile[peak], 0.0)
    place = float((weight * np.arange(near.start, near.start + len(weight))).sum() / weight.sum())
    return (place - middle) / scale


def _profile(
    flat: FlatSheet,
    channels: slice,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    vertical: bool,
) -> tuple[npt.NDArray[np.float32], float]:
    """Darkness across a line, the usual one along it, and where the line should be in it.

    Empty where it would leave the page.
    """
    scale = flat.scale
    height, width = flat.picture.shape[:2] if vertical else flat.picture.shape[1::-1]
    (across, first), (_, last) = (start, end) if vertical else (start[::-1], end[::-1])
    middle = across * scale - 0.5
    low, high = int(np.floor(middle - _REACH * scale)), int(np.ceil(middle + _REACH * scale)) + 1
    top, bottom = int(np.ceil(first * scale)), int(np.floor(last * scale))
    if low < 0 or top < 0 or high > width or bottom > height or bottom - top < 4:
        return np.zeros(0, np.float32), 0.0
    along, beside = slice(top, bottom), slice(low, high)
    rows, columns = (along, beside) if vertical else (beside, along)
    dark = flat.darkness(rows, columns, channels=channels)
    return np.median(dark, axis=0 if vertical else 1), middle - low


def frame_grayness(flat: FlatSheet, page: SheetPage) -> float:
    """How gray the frames of the cells were printed, see `grayness`; of a page that was flattened by them."""
    depths: tuple[list[float], list[float]] = ([], [])
    for start, end, vertical in list(_sides(page))[::_SOME]:
        for depth, channels in zip(depths, (RED, GREEN_AND_BLUE), strict=True):
            profile, middle = _profile(flat, channels, start, end, vertical=vertical)
            if len(profile):
                near = slice(max(round(middle) - 1, 0), round(middle) + 2)
                depth.append(float(profile[near].max() - np.quantile(profile, 0.3)))
    if not depths[0]:
        return 0.0
    return grayness(*(float(np.median(depth)) for depth in depths))
