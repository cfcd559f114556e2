"""Normals of ink at the sharpness of a large picture, whose surface was computed from a reduced one.

The reduced surface says where there is ink: it was cleaned of seals, grids and specks. The large picture
says where the outline runs. Each block is inflated with so much of its surroundings that the seams cannot
be seen, so memory grows with the block and not with the picture.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.surface.inflation import inflate
from rumu.surface.paper import Polarity, tone
from rumu.surface.relief import half_width, normals_of
from rumu.values import BoolArray, FloatArray, Surface

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class FineSettings:
    """How normals are made block by block.

    block: side of a block, in pixels. margin: pixels around it for each pixel of the thickest stroke's
        half-width; the inflation of a stroke depends on what is so far along it by a thousandth. widest:
        most pixels of the margin; where strokes are thicker, the normals are made of a picture of half the
        size, or a quarter...
    near: standard deviation, in pixels of the reduced surface, of the neighbourhood that says how dark ink
        and paper are. reach: pixels of the reduced surface beyond its ink that may be ink.
    smooth: standard deviation of the smoothing of the large picture, in pixels of the reduced surface.
    soften: of that of the height, in pixels of the picture, so that a low lamp does not show the steps of
        the outline from pixel to pixel.
    """

    block: int = 1024
    margin: float = 4.0
    widest: int = 384
    near: float = 6.0
    reach: int = 2
    smooth: float = 0.3
    soften: float = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class FineInk:
    """What blocks are made from.

    dark: (H, W) uint8, tone in which ink is dark. threshold: (h, w) float32, the level half-way between ink
    and paper. typical: median half-width, in pixels of `dark`. allowed: (h, w) uint8, 255 where there may
    be ink. paper: (h, w) float32 level. margin: pixels around a block. density: whether height follows the
    density.
    """

    dark: Bytes
    threshold: FloatArray
    allowed: Bytes
    paper: FloatArray
    typical: float
    margin: int
    density: bool


def prepare_ink(picture: Bytes, surface: Surface, *, settings: FineSettings | None = None) -> FineInk:
    """What the normals of a picture are made from.

    picture: (H, W) or (H, W, 3) uint8, sRGB. surface: of the same picture reduced, computed from its ink.
    """
    import cv2

    settings = settings or FineSettings()
    polarity = _polarity(picture, surface.mask)
    dark = np.empty(picture.shape[:2], np.uint8)
    for top in range(0, len(dark), settings.block):
        dark[top : top + settings.block] = tone(
            np.ascontiguousarray(picture[top : top + settings.block]), polarity=polarity
        )
    dark, scale = _reduce_for(dark, surface.mask, settings)
    mask = surface.mask.astype(np.uint8)
    small = cv2.resize(dark, mask.shape[::-1], interpolation=cv2.INTER_AREA).astype(np.float32)
    wide = cv2.dilate(mask, np.ones((2 * settings.reach + 1,) * 2, np.uint8))
    ink = _mean_near(small, mask.astype(np.float32), settings.near)
    paper = _mean_near(small, 1.0 - wide.astype(np.float32), settings.near)
    return FineInk(
        dark=cv2.GaussianBlur(dark, (0, 0), max(settings.smooth * scale, 0.5)) if scale > 1 else dark,
        threshold=(ink + paper) / 2,
        allowed=wide * np.uint8(255),
        paper=paper,
        typical=half_width(surface.mask) * scale,
        margin=_margin(surface.mask, scale, settings),
        density=surface.source == "density",
    )


def fine_normals(ink: FineInk, *, settings: FineSettings | None = None) -> Iterator[Bytes]:
    """Normals, (rows, W, 3) uint8, n = value / 127.5 - 1, y up, from the top of the picture to its end."""
    settings = settings or FineSettings()
    height, width = ink.dark.shape
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for top in range(0, height, settings.block):
            yield _band(ink, slice(top, min(top + settings.block, height)), width, pool, settings)


def _band(ink: FineInk, rows: slice, width: int, pool: Executor, settings: FineSettings) -> Bytes:
    band = np.full((rows.stop - rows.start, width, 3), (128, 128, 255), np.uint8)

    def fill(left: int) -> None:
        columns = slice(left, min(left + settings.block, width))
        part = _block(ink, rows, columns, settings)
        if part is not None:
            band[:, columns] = part

    list(pool.map(fill, range(0, width, settings.block)))
    return band


def eight_bit_normals(normals: FloatArray) -> Bytes:
    """Unit normals as uint8: n = value / 127.5 - 1."""
    levels = np.multiply(normals, np.float32(127.5))
    levels += np.float32(128)  # half a level more, which the cast cuts off
    return np.asarray(np.minimum(levels, np.float32(255), out=levels).astype(np.uint8))


def _block(ink: FineInk, rows: slice, columns: slice, settings: FineSettings) -> Bytes | None:
    """The normals of a block; None where it has no ink."""
    import cv2

    y0, x0 = max(rows.start - ink.margin, 0), max(columns.start - ink.margin, 0)
    around = (slice(y0, rows.stop + ink.margin), slice(x0, columns.stop + ink.margin))
    dark = ink.dark[around]
    mask = _mask_of(ink, dark, (y0, x0))
    if not mask.any():
        return None
    if ink.density:
        paper = np.maximum(_enlarge(ink, ink.paper, dark.shape, (y0, x0)), 1)
        height = np.where(mask, np.clip(1 - dark / paper, 0, 1) * ink.typical, 0).astype(np.float32)
    else:
        height = inflate(mask)
    height = cv2.GaussianBlur(height, (0, 0), settings.soften)
    inner = normals_of(height)[rows.start - y0 : rows.stop - y0, columns.start - x0 : columns.stop - x0]
    return eight_bit_normals(inner)


def _mask_of(ink: FineInk, dark: Bytes, corner: tuple[int, int]) -> BoolArray:
    """Where a block is ink. corner: its first row and column in the picture."""
    allowed = _enlarge(ink, ink.allowed, dark.shape, corner)
    if not allowed.any():
        return np.zeros(dark.shape, bool)
    return np.asarray((dark < _enlarge(ink, ink.threshold, dark.shape, corner)) & (allowed > 127))


def _enlarge(
    ink: FineInk, values: npt.NDArray[Any], shape: tuple[int, ...], corner: tuple[int, int]
) -> npt.NDArray[Any]:
    """A map of the reduced surface over a block of the picture, bilinear."""
    import cv2

    (h, w), (height, width) = values.shape, ink.dark.shape
    fy, fx = h / height, w / width
    top, left = int(corner[0] * fy), int(corner[1] * fx)
    part = values[max(top - 2, 0) : int((corner[0] + shape[0]) * fy) + 3]
    part = np.ascontiguousarray(part[:, max(left - 2, 0) : int((corner[1] + shape[1]) * fx) + 3])
    first = (corner[0] + 0.5) * fy - 0.5 - max(top - 2, 0), (corner[1] + 0.5) * fx - 0.5 - max(left - 2, 0)
    warp = np.array([[fx, 0, first[1]], [0, fy, first[0]]], np.float64)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(part, warp, shape[1::-1], flags=flags, borderMode=cv2.BORDER_REPLICATE))


def _polarity(picture: Bytes, mask: BoolArray) -> Polarity:
    """Whether the ink of a picture is darker than the rest of it."""
    import cv2

    small = cv2.resize(picture, mask.shape[::-1], interpolation=cv2.INTER_AREA)
    gray = small if small.ndim == 2 else cv2.cvtColor(small, cv2.COLOR_RGB2GRAY)
    inked = mask.any() and not mask.all() and float(gray[mask].mean()) > float(gray[~mask].mean())
    return "light" if inked else "dark"


def _reduce_for(dark: Bytes, mask: BoolArray, settings: FineSettings) -> tuple[Bytes, float]:
    """The picture halved until its strokes are thin enough, and its pixels for one of the surface."""
    import cv2

    scale = max(dark.shape) / max(mask.shape)
    while scale > 1 and settings.margin * _thickest(mask) * scale > settings.widest:
        size = (-(-dark.shape[1] // 2), -(-dark.shape[0] // 2))
        dark, scale = cv2.resize(dark, size, interpolation=cv2.INTER_AREA), scale / 2
    return dark, scale


def _margin(mask: BoolArray, scale: float, settings: FineSettings) -> int:
    return min(settings.widest, round(settings.margin * _thickest(mask) * scale) + 8)


def _thickest(mask: BoolArray) -> float:
    """Half-width of the thickest stroke, in pixels of the surface."""
    import cv2

    padded = np.pad(mask.astype(np.uint8), 1)
    return float(cv2.distanceTransform(padded, cv2.DIST_L2, 3).max())


def _mean_near(values: FloatArray, weight: FloatArray, reach: float) -> FloatArray:
    """Weighted mean of the neighbourhood of each pixel; the mean of all where there is none."""
    import cv2

    whole = float((values * weight).sum()) / max(float(weight.sum()), 1e-6)
    least = np.float32(1e-3)
    total = cv2.GaussianBlur(values * weight, (0, 0), reach) + least * np.float32(whole)
    return np.asarray(total / (cv2.GaussianBlur(weight, (0, 0), reach) + least))
