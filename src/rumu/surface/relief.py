"""A surface from one image: the ink of a scan or photo, given a height.

This height is computed from the ink of one 2-D image. It is no measured relief: 'inflation' depends on the
outline of the ink alone and 'density' on how dark the ink is. Ink on flat paper has no photometric relief
either, however dark it is, because the slopes of photometric stereo do not contain the albedo; so these are
the surfaces that a sheet of paper can have. Real relief needs lamps and an object that has one.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import Reduction
from rumu.capture.formats import decode
from rumu.capture.image import as_image, bounding_box, image_of, to_linear
from rumu.errors import RefusedImage, SurfaceError
from rumu.surface.inflation import inflate
from rumu.surface.ink import Ink, find_ink
from rumu.values import BoolArray, FloatArray, Surface

WORKING_SIZE = Reduction(pixels=6_300_000, above=12_600_000)
"""How a picture in a file is reduced: not at all up to a phone's 12 megapixels, and else to half of them."""

_SAMPLES = 20_000  # pixels of ink that say how dark the darkest of it is

Method = Literal["inflation", "density"]
Mode = Literal["inhomogeneous", "homogeneous", "hybrid"]


def relief(
    image: str | os.PathLike[str] | npt.NDArray[Any] | Ink,
    *,
    method: Method = "inflation",
    mode: Mode = "inhomogeneous",
    kappa: float = 0.0,
) -> Surface:
    """Give the ink of one image a height.

    The height is a function of that image and not measured relief.

    Parameters
    ----------
    image : path, ndarray or Ink
        A file; an array (H, W) or (H, W, 3) of bool, uint8, uint16, or float in [0, 1], values as stored and
        not linear; or ink that was found before.
    method : {'inflation', 'density'}
        'inflation': a half circle across each stroke, from the outline of the ink alone. 'density': the
        density of the ink times the median half-width of its strokes.
    mode : {'inhomogeneous', 'homogeneous', 'hybrid'}
        Of the inflation. 'inhomogeneous': wide strokes are high. 'homogeneous': all strokes reach the median
        half-width. 'hybrid': the mean of both.
    kappa : float
        Pixels of height for each unit by which the ink is denser than the ink around it; inflation only.

    Returns
    -------
    Surface
        In pixels (unit 'px', spacing 1): height 0 on paper; normals of that height; albedo the image as
        linear light; mask the ink; confidence 1 on ink and 0 elsewhere; quality: 'ink_share' of the picture,
        'contrast' (median density), 'darkest' (density that 5 % of the ink exceed), 'half_width' (median,
        px), the figures of the ink, and 'reduced', by which the sides of a file's picture were divided, where
        it has more than 12.6 million pixels.

    Raises
    ------
    ImageError
        For what is no image.
    RefusedImage
        Where there is no writing; it names the file.
    SurfaceError
        For an unknown method or mode, or a kappa that is not finite.

    Notes
    -----
    Inflation is our reconstruction of what the paper cites for single images (Zhang et al. 2018).
    """
    check_choice(method, get_args(Method), "method")
    check_choice(mode, get_args(Mode), "mode")
    if not np.isfinite(kappa):
        raise SurfaceError(f"kappa: expected a finite number, got {kappa}")
    ink, albedo, reduced = _ink_and_albedo(image)
    typical = half_width(ink.mask)
    if method == "density":
        height = ink.density * np.float32(typical)
    else:
        height = _inflate_ink(ink, typical=typical, mode=mode, kappa=kappa)
    share = {"ink_share": np.count_nonzero(ink.mask) / ink.mask.size}
    return Surface(
        height=height,
        normals_from=partial(normals_of, height),
        albedo_from=albedo,
        mask=ink.mask,
        confidence=ink.mask.astype(np.float32),
        spacing=1.0,
        unit="px",
        source=method,
        quality=share
        | {"contrast": ink.contrast, "darkest": _darkest(ink), "half_width": typical}
        | dict(ink.figures)
        | ({"reduced": reduced} if reduced > 1 else {}),
    )


def _darkest(ink: Ink) -> float:
    """Density of the darkest twentieth of the ink, from some of its pixels."""
    density = ink.density[ink.mask]
    return float(np.quantile(density[:: max(len(density) // _SAMPLES, 1)], 0.95))


def check_choice(value: object, choices: tuple[str, ...], name: str) -> None:
    """Raise SurfaceError that names the choices when `value` is none of them."""
    if value not in choices:
        raise SurfaceError(f"{name}: expected one of {', '.join(choices)}, got {value!r}")


def read_with_ink(path: str | os.PathLike[str]) -> tuple[FloatArray, Ink, tuple[int, int]]:
    """The picture in a file, as stored, its ink, and the (width, height) that the file has.

    A large picture is reduced, see WORKING_SIZE, while it is read. Raises ImageError; RefusedImage names the
    file.
    """
    stored = decode(path, reduction=WORKING_SIZE)
    image, whole = image_of(stored, name=path), stored.whole
    try:
        return image, find_ink(image), whole
    except RefusedImage as error:
        raise RefusedImage(error.en, reason=error.reason, name=path, zh=error.zh) from None


def _ink_and_albedo(
    image: str | os.PathLike[str] | npt.NDArray[Any] | Ink,
) -> tuple[Ink, Callable[[], FloatArray], float]:
    """The ink, the function that makes the albedo, and the pixels of the picture for one of its surface."""
    if isinstance(image, Ink):
        return image, partial(_paint, image), 1.0
    if isinstance(image, np.ndarray):
        stored = as_image(image)
        return find_ink(stored), partial(_linearise, stored), 1.0
    stored, ink, whole = read_with_ink(image)
    return ink, partial(_linearise, stored), max(whole) / max(stored.shape[:2])


def _linearise(stored: FloatArray) -> FloatArray:
    """Linear light; 8-bit values, which most images have, take 256 powers instead of one for each pixel."""
    import cv2

    steps = cv2.convertScaleAbs(stored, alpha=255.0)
    table = to_linear(np.arange(256, dtype=np.float32) / np.float32(255.0))
    coarse = steps.astype(np.float32)
    coarse *= np.float32(1 / 255)
    if float(cv2.norm(coarse, stored, cv2.NORM_INF)) > 1e-5:
        return to_linear(stored.astype(np.float32, copy=False))
    return np.asarray(cv2.LUT(steps, table), dtype=np.float32).reshape(stored.shape)


def _paint(ink: Ink) -> FloatArray:
    """The picture that an Ink alone describes, linear: its densities on paper of one level."""
    if ink.polarity == "dark":
        return to_linear((ink.paper * (1.0 - ink.density)).astype(np.float32))
    return to_linear((ink.paper + (1.0 - ink.paper) * ink.density).astype(np.float32))


def _inflate_ink(ink: Ink, *, typical: float, mode: Mode, kappa: float) -> FloatArray:
    import cv2

    height = inflate(ink.mask)
    if mode != "inhomogeneous":
        even = height * np.float32(typical) / np.maximum(local_half_width(ink.mask), np.float32(0.5))
        height = (even if mode == "homogeneous" else (height + even) / 2).astype(np.float32)
    if kappa:
        weight, reach = ink.mask.astype(np.float32), max(2 * typical, 1.0)
        total = cv2.GaussianBlur(ink.density * weight, (0, 0), reach)
        around = total / np.maximum(cv2.GaussianBlur(weight, (0, 0), reach), np.float32(1e-6))
        detailed = height + np.float32(kappa) * (ink.density - around)
        height = np.where(ink.mask, np.maximum(detailed, np.float32(0.0)), np.float32(0.0))
    return height


# --- half-widths -----------------------------------------------------------------------------------


def half_width(mask: BoolArray) -> float:
    """Median half-width of the strokes over their medial axis, in pixels; 0 without ink."""
    if not mask.any():
        return 0.0
    y0, y1, x0, x1 = bounding_box(mask)
    depth, ridge = _medial_axis(mask[y0:y1, x0:x1])
    return float(np.median(depth[ridge])) if ridge.any() else 0.0


def local_half_width(mask: BoolArray) -> FloatArray:
    """(H, W) float32: for each ink pixel the half-width, in pixels, of the stroke it lies in; 0 off the ink.

    The distance to the edge at the nearest pixel of the medial axis.
    """
    import cv2

    depth, ridge = _medial_axis(mask)
    _, nearest = cv2.distanceTransformWithLabels(
        (~ridge).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.zeros(int(nearest.max()) + 1, np.float32)
    of_label[nearest[ridge]] = depth[ridge]
    return np.where(mask, of_label[nearest], np.float32(0.0))


def _medial_axis(mask: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Distance to the edge, and where it is a local maximum.

    Distances run to the centre of the nearest paper pixel; the edge lies half a pixel before it.
    """
    import cv2

    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    ridge = mask & (depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8)) - np.float32(0.25))
    return np.asarray(depth - np.float32(0.5)), np.asarray(ridge)


# --- normals ---------------------------------------------------------------------------------------


def normals_of(height: FloatArray) -> FloatArray:
    """(H, W, 3) float32 unit normals, x right, y up, z to the camera, of a height map (H, W) in pixels."""
    normals = np.zeros((*height.shape, 3), np.float32)
    normals[:, :, 2] = 1.0
    raised = height != height.flat[0]
    if raised.any():
        y0, y1, x0, x1 = bounding_box(raised)
        box = slice(max(0, y0 - 2), y1 + 2), slice(max(0, x0 - 2), x1 + 2)
        down, right = _differences(height[box], axis=0), _differences(height[box], axis=1)
        length = np.sqrt(right * right + down * down + np.float32(1))
        part = normals[box]
        part[..., 0], part[..., 1] = -right / length, down / length  # rows grow downward: dz/dy = -down
        part[..., 2] = 1 / length
    return normals


def _differences(height: FloatArray, *, axis: int) -> FloatArray:
    """Central differences along an axis, one-sided at the border; 0 where there is one row or column."""
    return np.gradient(height, axis=axis) if height.shape[axis] > 1 else np.zeros_like(height)
