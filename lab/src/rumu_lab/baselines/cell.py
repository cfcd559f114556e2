"""What every method is given: the ink of a copy, and of its master, in the square cell it was written in.

All methods get the same two values, so that none wins by a better reading of the picture. The frame of the
cell is kept: a copy that stands off centre, or is too small, is so in its cell as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from rumu.errors import RegistrationError
from rumu.registration.points import ink_mask
from rumu.values import BoolArray, FloatArray, Surface

SIDE = 256
"""Side of the cell, in pixels."""
LEAST_INK = 20
"""Fewest pixels of ink in a cell that can be compared."""


@dataclass(frozen=True, eq=False)
class Cell:
    """The ink of one character in its square cell; compared and hashed as the object it is.

    ink: (SIDE, SIDE) bool. density: (SIDE, SIDE) float32 in [0, 1], how far the ink lies below its paper,
    with soft edges; 0 on paper. Raises RegistrationError for other shapes and for less than LEAST_INK.
    """

    ink: BoolArray
    density: FloatArray

    def __post_init__(self) -> None:
        for name, array, kind in (("ink", self.ink, "bool"), ("density", self.density, "float32")):
            if array.shape != (SIDE, SIDE) or array.dtype != np.dtype(kind):
                raise RegistrationError(
                    f"expected {name} of ({SIDE}, {SIDE}) {kind}, got {array.shape} {array.dtype}"
                )
        if not (np.isfinite(self.density).all() and self.density.min() >= 0 and self.density.max() <= 1):
            raise RegistrationError("expected a density in [0, 1], got values beyond")
        if (pixels := int(np.count_nonzero(self.ink))) < LEAST_INK:
            raise RegistrationError(
                f"expected a cell with at least {LEAST_INK} pixels of ink, got {pixels or 'an empty one'}"
            )

    @cached_property
    def even(self) -> BoolArray:
        """(SIDE, SIDE) bool: the ink with the streaks and specks of a dry brush evened out (median of 5 x 5).

        Lines of 2 pixels would go with them: writing that is mostly such is left as it is.
        """
        import cv2

        even = cv2.medianBlur(self.ink.astype(np.uint8), 5) > 0
        return np.asarray(even if 2 * np.count_nonzero(even) > np.count_nonzero(self.ink) else self.ink)

    @cached_property
    def depth(self) -> FloatArray:
        """(SIDE, SIDE) float32, distance in pixels to the edge of the even ink, 0 off it."""
        import cv2

        padded = np.pad(self.even, 1).astype(np.uint8)
        depth = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
        # OpenCV measures to the centre of the nearest paper pixel; the edge lies half a pixel before it.
        return np.asarray(np.maximum(depth - np.float32(0.5), np.float32(0.0)))

    @cached_property
    def skeleton(self) -> BoolArray:
        """(SIDE, SIDE) bool, lines one pixel wide in the even ink (Zhang-Suen thinning), not pruned."""
        from skimage.morphology import skeletonize

        return np.asarray(skeletonize(self.even), dtype=bool)

    @cached_property
    def width(self) -> float:
        """Stroke width in pixels, at least 1: twice the median depth along the skeleton."""
        along = self.depth[self.skeleton]
        return max(1.0, 2.0 * float(np.median(along)))


@dataclass(frozen=True)
class Raw:
    """What a method says of a copy, before any calibration.

    raw: in [0, 1], 1 for a perfect copy. features: named numbers it rests on, finite, each explained in the
    module of the method. Raises RegistrationError for anything else.
    """

    raw: float
    features: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 0.0 <= self.raw <= 1.0:
            raise RegistrationError(f"expected a raw grade in [0, 1], got {self.raw}")
        bad = {name: value for name, value in self.features.items() if not np.isfinite(value)}
        if bad:
            raise RegistrationError(f"expected finite features, got {bad}")


def cell_of(surface: Surface) -> Cell:
    """The cell of a surface: its whole picture, made square by paper at the shorter sides, and resized.

    Raises RegistrationError where there is too little ink, RefusedImage where a measured surface shows none.
    """
    ink = ink_mask(surface)
    return cell_from(ink, density=_density(surface, ink))


def cell_from(ink: BoolArray, *, density: FloatArray | None = None) -> Cell:
    """The cell of an ink mask (H, W) bool; density (H, W) in [0, 1], by default black ink."""
    if ink.ndim != 2 or ink.dtype != np.bool_ or (density is not None and density.shape != ink.shape):
        came = None if density is None else density.shape
        raise RegistrationError(
            f"expected an (H, W) bool mask and its density, got {ink.dtype} {ink.shape}, {came}"
        )
    if not ink.any():
        raise RegistrationError("expected a cell with ink, got an empty one")
    soft = _square(ink.astype(np.float32))
    dark = soft if density is None else _square(density.astype(np.float32))
    # Hairlines of a large picture pale when it shrinks; half of the darkest keeps them.
    return Cell(soft > 0.5 * min(float(soft.max()), 1.0), np.clip(dark, 0.0, 1.0))


def _density(surface: Surface, ink: BoolArray) -> FloatArray:
    """(H, W) float32: how far the picture lies from its paper near the ink, 1 black on white; 0 elsewhere.

    On a rubbing (light strokes) the same above the dark ground. Taken from the albedo, display-encoded, as
    people see it. A surface whose albedo does not show its ink at all counts as black ink.
    """
    import cv2

    light = surface.albedo if surface.albedo.ndim == 2 else surface.albedo.mean(axis=2)
    tone = np.power(np.clip(light, 0.0, 1.0), np.float32(1 / 2.2))
    near = cv2.dilate(ink.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    if near.all():
        return ink.astype(np.float32)
    paper = float(np.median(tone[~near]))
    step = float(np.median(tone[ink])) - paper
    depth = (paper - tone) / max(paper, 1e-6) if step < 0 else (tone - paper) / max(1.0 - paper, 1e-6)
    if abs(step) < 0.02:
        return ink.astype(np.float32)
    return np.where(near, np.clip(depth, 0.0, 1.0), 0.0).astype(np.float32)


def _square(image: FloatArray) -> FloatArray:
    """(H, W) float32 -> (SIDE, SIDE) float32: padded with 0 to a square and smoothly resized."""
    import cv2

    rows, columns = image.shape
    longer = max(rows, columns)
    top, left = (longer - rows) // 2, (longer - columns) // 2
    square = np.pad(image, ((top, longer - rows - top), (left, longer - columns - left)))
    method = cv2.INTER_AREA if longer > SIDE else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(square, (SIDE, SIDE), interpolation=method), dtype=np.float32)
