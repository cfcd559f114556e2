"""A camera at a finite distance: slopes of what it sees, and heights from them.

A flat sheet before such a camera is seen alike everywhere, but of a slope it sees more or less of one side by
where it stands in the photograph: what leans towards the camera is foreshortened less. With the focal length
f in pixels and (u, v) from the middle of the photograph, x right and y up, a point at distance Z along the
axis obeys

    d(log Z)/du = n_x / D,   d(log Z)/dv = n_y / D,   D = f n_z - u n_x - v n_y,

so that -f log Z has the slopes of a surface with normal (n_x, n_y, D / f), and is integrated as any other
(Tankus, Sochen and Yeshurun, "Shape-from-shading under perspective projection", 2005; Durou and Courteille,
2007).
"""

from __future__ import annotations

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import FloatArray

LEAST_FOCAL_LENGTH = 0.3
"""Of the photograph's longer side: shorter ones, a view of more than 118 degrees, are mistakes."""


def check_focal_length(focal_length: float | None, shape: tuple[int, ...]) -> None:
    """Raise SurfaceError for a focal length, in pixels, that no camera with a photograph of (H, W) has."""
    least = LEAST_FOCAL_LENGTH * max(shape[:2])
    if focal_length is not None and not least <= focal_length < np.inf:
        raise SurfaceError(
            f"expected a focal length in pixels, from {least:g} for these photographs, got {focal_length:g}"
        )


def seen_normals(normals: FloatArray, focal_length: float) -> FloatArray:
    """(H, W, 3) float32: normals whose slopes are those of -f log Z; not of unit length.

    normals: (H, W, 3), toward the camera's plane, as photometric stereo finds them. focal_length: in pixels.
    """
    h, w = normals.shape[:2]
    u = (np.arange(w, dtype=np.float32) - np.float32((w - 1) / 2)) / np.float32(focal_length)
    v = (np.float32((h - 1) / 2) - np.arange(h, dtype=np.float32)) / np.float32(focal_length)
    seen = np.array(normals, dtype=np.float32)
    seen[..., 2] -= seen[..., 0] * u + seen[..., 1] * v[:, None]
    return seen


def height_of_distance(found: FloatArray, focal_length: float) -> FloatArray:
    """(H, W) float32 height in pixels, mean about 0, from an integral of `seen_normals`.

    found: (H, W), -f log Z but for a constant. One pixel of height is one pixel of the sheet where `found` is
    0: there it stands at a distance of f pixels.
    """
    return np.asarray(-focal_length * np.expm1(-found / np.float32(focal_length)), dtype=np.float32)
