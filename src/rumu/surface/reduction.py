"""A large surface made smaller, for what shows it and does not measure on it: reports, meshes, thumbnails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rumu.values import BoolArray, FloatArray, Surface

SHOWN = 8_000_000
"""Most pixels of a surface that is drawn as a picture of a report or as a mesh: more would not be seen."""


def reduce_surface(surface: Surface, *, pixels: int = SHOWN) -> Surface:
    """The surface with at most so many pixels, by means over pixels; itself when it has no more.

    The spacing grows as much as the pixels do: also where the unit is 'px', which stays a pixel of the
    photographs. Normals keep unit length; a pixel is in the mask when half of what it shows was.
    """
    height, width = surface.height.shape
    factor = np.sqrt(height * width / pixels)
    if factor <= 1:
        return surface
    size = max(2, round(width / factor)), max(2, round(height / factor))

    def mean(array: FloatArray | BoolArray) -> FloatArray:
        import cv2

        samples = array.astype(np.float32, copy=False)
        return np.asarray(cv2.resize(samples, size, interpolation=cv2.INTER_AREA))

    normals = mean(surface.normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.float32(1e-6))
    return replace(
        surface,
        height=mean(surface.height),
        normals_from=normals,
        albedo_from=np.clip(mean(surface.albedo), 0, 1),
        mask=mean(surface.mask) >= 0.5,
        confidence=np.clip(mean(surface.confidence), 0, 1),
        spacing=surface.spacing * width / size[0],
    )
