"""Pictures that are no copy of a master and might pass for one: what a mark must not be fooled by.

    impostor(mask, "outline", seed=1) -> (H, W) or (H, W, 3) uint8

They are made, like every fault here, of a glyph's ink and say nothing about what people would mark.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import SurfaceError
from rumu.values import BoolArray
from rumu_lab.simulation.glyph import Glyph
from rumu_lab.simulation.ink import brush_depth, coverage, depth_of

Picture = npt.NDArray[np.uint8]

PAPER, INK = 245, 20
"""Grey levels of paper and ink."""


def picture_of(ink: npt.NDArray[Any]) -> Picture:
    """A scan of ink, (H, W) bool or in [0, 1], on paper: (H, W) uint8."""
    return np.rint(PAPER - (PAPER - INK) * ink.astype(np.float32)).astype(np.uint8)


def impostor(mask: BoolArray, kind: str, *, seed: int = 0) -> Picture:
    """One impostor of the glyph with this ink mask (H, W) bool; the seed chooses strokes, blobs and noise.

    Raises SurfaceError for an unknown kind or an empty mask.
    """
    if kind not in IMPOSTORS:
        raise SurfaceError(f"expected an impostor among {', '.join(IMPOSTORS)}, got {kind!r}")
    glyph, rng = Glyph(np.asarray(mask)), np.random.default_rng([seed, IMPOSTORS.index(kind)])
    if kind in _DRAWN:
        return _DRAWN[kind](glyph, rng)
    if kind in ("mirrored", "upside_down", "outline"):
        return _from_ink(glyph, kind, rng)
    return _paper_or_noise(glyph.mask.shape, kind, rng)


def _paper_or_noise(shape: tuple[int, ...], kind: str, rng: np.random.Generator) -> Picture:
    """No writing at all: paper with its faint grain, black paper, or noise."""
    if kind == "blank":
        return np.rint(rng.normal(PAPER, 2.0, shape)).clip(0, 255).astype(np.uint8)
    if kind == "black":
        return np.full(shape, INK // 4, np.uint8)
    return rng.integers(0, 256, shape if kind == "gray_noise" else (*shape, 3), dtype=np.uint8)


def _from_ink(glyph: Glyph, kind: str, rng: np.random.Generator) -> Picture:
    """The ink mirrored, upside down, or a line of 2 to 8 pixels (of 512) along the edge of every stroke."""
    if kind == "outline":
        wide = glyph.scale * float(rng.uniform(2.0, 8.0))
        return picture_of(coverage(wide / 2 - np.abs(glyph.depth)))
    ink = coverage(glyph.depth)[:, ::-1]
    return picture_of(ink if kind == "mirrored" else ink[::-1])


def _filled_square(glyph: Glyph, rng: np.random.Generator) -> Picture:
    page = np.zeros(glyph.mask.shape)
    height, width = glyph.mask.shape
    page[height // 5 : height - height // 5, width // 5 : width - width // 5] = 1.0
    return picture_of(page)


def _one_stroke(glyph: Glyph, rng: np.random.Generator) -> Picture:
    """One stroke of several; a ring that is most of the character is not one that leaves the rest out."""
    inks = [stroke.ink for stroke in glyph.strokes]
    some = [ink for ink in inks if 2 * np.count_nonzero(ink) < np.count_nonzero(glyph.mask)] or inks
    return picture_of(coverage(depth_of(some[int(rng.integers(len(some)))])))


def _blobs(glyph: Glyph, rng: np.random.Generator) -> Picture:
    """As much ink as the glyph has, in round blots."""
    depth = np.full(glyph.mask.shape, -1e4, np.float32)
    side = float(max(glyph.mask.shape))
    y, x = np.indices(glyph.mask.shape)
    while np.count_nonzero(depth > 0) < glyph.mask.sum():
        row, column = rng.uniform(0.12, 0.88, 2) * glyph.mask.shape
        radius = side * rng.uniform(0.025, 0.07)
        depth = np.maximum(depth, radius - np.hypot(y - row, x - column)).astype(np.float32)
    return picture_of(coverage(depth))


def _scribble(glyph: Glyph, rng: np.random.Generator) -> Picture:
    """One line without a plan that runs on until there is as much ink as the glyph has."""
    height, width = glyph.mask.shape
    radius = max(float(np.median(glyph.strokes[0].radius)), 1.0)
    at, heading, bend = np.array([height, width]) / 2.0, float(rng.uniform(0, 2 * np.pi)), 0.0
    path = []
    steps = int(glyph.mask.sum() / (2 * radius) / 0.8)
    for _ in range(max(steps, 50)):
        bend = 0.97 * bend + 0.012 * float(rng.normal())
        heading += bend
        step = at + 0.8 * np.array([np.sin(heading), np.cos(heading)])
        if (np.abs(step / (height, width) - 0.5) > 0.4).any():
            heading += 0.2
            step = np.clip(step, (0.1 * height, 0.1 * width), (0.9 * height, 0.9 * width))
        at = step
        path.append(at)
    line = np.array(path)
    return picture_of(coverage(brush_depth(glyph.mask.shape, line, np.full(len(line), radius))))


IMPOSTORS: tuple[str, ...] = (
    *("blank", "black", "filled_square", "one_stroke", "mirrored", "upside_down", "outline"),
    *("blobs", "scribble", "gray_noise", "coloured_noise"),
)
_DRAWN: Mapping[str, Callable[[Glyph, np.random.Generator], Picture]] = {
    "filled_square": _filled_square,
    "one_stroke": _one_stroke,
    "blobs": _blobs,
    "scribble": _scribble,
}
