"""Images as arrays: read from files as stored, or as linear light, with every doubt raised at once."""

from __future__ import annotations

import os
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.capture.formats import MAX_PIXELS, MIN_SIDE, Samples, Stored, check_size, decode
from rumu.errors import ImageError
from rumu.values import BoolArray

__all__ = [
    "MAX_PIXELS",
    "MIN_SIDE",
    "Encoding",
    "as_image",
    "luminance",
    "read_image",
    "read_linear",
    "read_mask",
    "to_linear",
]

Image = npt.NDArray[np.float32]
Encoding = Literal["auto", "linear", "srgb"]
ENCODINGS: tuple[Encoding, ...] = get_args(Encoding)

_REC709 = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
_ROUNDING = 1e-5  # a float image may overshoot [0, 1] by the rounding of whoever wrote it


def read_image(path: str | os.PathLike[str]) -> Image:
    """An image with its values as stored: the display encoding is kept.

    PNG, JPEG, WebP, BMP, GIF (first frame), PPM, TIFF, EXR; 1, 8 and 16 bits and float. EXIF orientation is
    applied, CMYK and palettes become RGB, alpha is composited over white.
    Returns (H, W) or (H, W, 3) float32 in [0, 1], contiguous.
    Raises ImageError naming the file: missing, a folder, empty, cut short, no image, below MIN_SIDE, above
    MAX_PIXELS (refused from the header), float values that are NaN, infinite or outside [0, 1].
    """
    stored = decode(path)
    values = _unit_range(_checked(stored.values, name=path), name=path)
    return np.ascontiguousarray(_over_white(values, stored.alpha))


def read_linear(path: str | os.PathLike[str], *, encoding: Encoding = "auto") -> Image:
    """An image as linear light.

    encoding: 'auto' decodes JPEG and WebP from sRGB and takes every other format as linear; 'linear' and
        'srgb' say it outright. EXR and float TIFF are always linear.
    Returns (H, W) or (H, W, 3) float32, at least 0. Integer formats end at 1; EXR and float TIFF may exceed
    it, so that the frames of one capture can be divided by one common peak. Their negative values, which
    dark subtraction leaves, become 0.
    Raises ImageError as `read_image` does, except for float values above 1.
    """
    if encoding not in ENCODINGS:
        raise ImageError(f"encoding: expected one of {', '.join(ENCODINGS)}, got {encoding!r}")
    stored = decode(path)
    values = _linear(stored, name=path, encoding=encoding)
    return np.ascontiguousarray(_over_white(values, stored.alpha))


def read_mask(path: str | os.PathLike[str]) -> BoolArray:
    """A mask: True where the image is brighter than half and not transparent.

    Returns (H, W) bool. Raises ImageError as `read_image` does.
    """
    stored = decode(path)
    gray = luminance(_unit_range(_checked(stored.values, name=path), name=path))
    return np.asarray(gray > 0.5 if stored.alpha is None else gray * stored.alpha > 0.5)


def as_image(array: npt.NDArray[Any], *, name: object = "array") -> Image:
    """An array as an image, under the same checks as a file.

    array: (H, W), (H, W, 1), (H, W, 3), or with alpha (H, W, 2), (H, W, 4); bool, uint8, uint16, or float in
        [0, 1]. Alpha is composited over white.
    Returns (H, W) or (H, W, 3) float32 in [0, 1]. Raises ImageError, beginning with `name`.
    """
    samples = np.asarray(array)
    if samples.ndim not in (2, 3) or (samples.ndim == 3 and not 1 <= samples.shape[2] <= 4):
        raise ImageError(f"{name}: expected an image of shape (H, W) or (H, W, 3), got {samples.shape}")
    check_size(name, width=samples.shape[1], height=samples.shape[0])
    values = _unit_range(_checked(samples, name=name), name=name)
    if values.ndim == 2 or values.shape[2] == 3:
        return np.ascontiguousarray(values)
    colours = values[:, :, 0] if values.shape[2] < 3 else values[:, :, :3]
    return np.ascontiguousarray(_over_white(colours, values[:, :, -1] if values.shape[2] > 1 else None))


def to_linear(image: Image) -> Image:
    """Linear light from sRGB-encoded values in [0, 1] (IEC 61966-2-1); same shape, float32."""
    low = image <= 0.04045
    curve = ((image + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(low, image / np.float32(12.92), curve).astype(np.float32)


def luminance(image: Image) -> Image:
    """(H, W) float32: the Rec. 709 sum of a linear (H, W, 3) image; a gray image is returned as it is."""
    return image if image.ndim == 2 else np.asarray(image @ _REC709, dtype=np.float32)


def _checked(samples: Samples, *, name: object) -> Samples:
    kind, size = samples.dtype.kind, samples.dtype.itemsize
    if kind != "f" and (kind, size) not in [("b", 1), ("u", 1), ("u", 2)]:
        raise ImageError(f"{name}: expected bool, uint8, uint16 or float values, got {samples.dtype}")
    if kind == "f":
        bad = samples.size - int(np.count_nonzero(np.isfinite(samples)))
        if bad:
            raise ImageError(f"{name}: expected finite values, got {bad} that are NaN or infinite")
    return samples


def _unit_range(samples: Samples, *, name: object) -> Image:
    if samples.dtype.kind != "f":
        return _scaled(samples)
    low, high = float(samples.min()), float(samples.max())
    if low < -_ROUNDING or high > 1 + _ROUNDING:
        raise ImageError(f"{name}: expected float values in [0, 1], got values from {low:.6g} to {high:.6g}")
    return np.clip(samples, 0, 1).astype(np.float32, copy=False)


def _scaled(samples: Samples) -> Image:
    full = {"uint8": 255, "uint16": 65535}.get(samples.dtype.name, 1)
    values = samples.astype(np.float32)  # one conversion, then in place: numpy casts slowly while dividing
    values /= np.float32(full)
    return values


def _linear(stored: Stored, *, name: object, encoding: Encoding) -> Image:
    values = _checked(stored.values, name=name)
    if values.dtype.kind == "f":
        return np.maximum(values, 0).astype(np.float32, copy=False)
    if encoding == "linear" or (encoding == "auto" and not stored.display):
        return _scaled(values)
    if values.dtype == np.uint8:  # 256 powers instead of one for each pixel
        return to_linear(_scaled(np.arange(256, dtype=np.uint8)))[values]
    return to_linear(_scaled(values))


def _over_white(values: Image, alpha: Samples | None) -> Image:
    if alpha is None:
        return values
    cover = alpha if values.ndim == 2 else alpha[:, :, None]
    return np.asarray(values * cover + (1 - cover), dtype=np.float32)
