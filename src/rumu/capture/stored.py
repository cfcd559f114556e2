"""The samples of a picture as its file stores them; turning, reducing and laying them on white."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import Reduction
from rumu.image_stack import Floats

Samples = npt.NDArray[Any]
_STRIP = 256  # rows that are computed with at a time


@dataclass(frozen=True, slots=True, eq=False)
class Stored:
    """The samples of a file.

    values: (H, W) or (H, W, 3), uint8, uint16 or float32, R G B.
    alpha: (H, W) float32 in [0, 1], straight (colours are not multiplied by it); None when opaque.
    display: True when the samples are display-encoded, as those of a format always are (JPEG, WebP, HEIC,
    AVIF), or as their colour profile says.
    orientation: how the samples are still to be turned, as EXIF numbers it; 1 when they are upright.
    whole: (width, height) of the picture before it was reduced, turned as the samples are.
    """

    values: Samples
    alpha: Samples | None = None
    display: bool = False
    orientation: int = 1
    whole: tuple[int, int] = (0, 0)


def to_srgb(light: Floats) -> Floats:
    """Linear light in [0, 1] as sRGB-encoded values (IEC 61966-2-1); same shape and type."""
    return np.asarray(np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055))


def full_scale(samples: Samples) -> Any:
    """The value of white, of the samples' own type: 255, 65535, or 1 of floats."""
    return samples.dtype.type(np.iinfo(samples.dtype).max if samples.dtype.kind == "u" else 1)


def eight_bits(samples: Samples) -> Samples:
    """Samples as uint8; floats are cut to [0, 1]."""
    if samples.dtype == np.uint8:
        return samples
    shares = np.clip(samples.astype(np.float32) / np.float32(full_scale(samples)), 0, 1)
    return np.asarray(np.round(shares * 255), dtype=np.uint8)


def split_alpha(samples: Samples, *, premultiplied: bool = False) -> Stored:
    """(H, W), or (H, W, C) of 1 gray, 2 gray + alpha, 3 colour, 4 colour + alpha."""
    if samples.ndim == 2:
        return Stored(samples)
    count = samples.shape[2]
    values = samples[:, :, 0] if count < 3 else samples[:, :, :3]
    if count in (1, 3):
        return Stored(values)
    scale = full_scale(samples)
    if np.all(samples[:, :, -1] == scale):
        return Stored(values)
    alpha = samples[:, :, -1].astype(np.float32)
    alpha /= np.float32(scale)
    if premultiplied:
        cover = np.where(alpha > 0, alpha, 1) if count == 2 else np.where(alpha > 0, alpha, 1)[:, :, None]
        values = (values.astype(np.float32) / np.float32(scale) / cover).astype(np.float32)
    return Stored(values, alpha)


def over_white(values: Samples, alpha: Samples | None) -> Samples:
    """Samples laid on white paper; of the same type, changed in place where they can be."""
    if alpha is None:
        return values
    values = values if values.flags.writeable else values.copy()
    white = np.float32(full_scale(values))
    for top in range(0, len(values), _STRIP):
        rows = slice(top, top + _STRIP)
        cover = alpha[rows] if values.ndim == 2 else alpha[rows][:, :, None]
        laid = values[rows] * cover + white * (1 - cover)
        values[rows] = np.round(laid) if values.dtype.kind == "u" else laid
    return values


def reduce_stored(stored: Stored, reduction: Reduction) -> Stored:
    """The picture by area averaging, as far as it is to be reduced; what is reduced lies on white."""
    import cv2

    width, height = stored.whole  # a JPEG has been reduced in part while it was decoded
    shrink = reduction.factor(width, height)
    size = (max(1, round(width * shrink)), max(1, round(height * shrink)))
    if size == stored.values.shape[1::-1] or shrink == 1.0:
        return stored
    values = np.ascontiguousarray(over_white(stored.values, stored.alpha))
    reduced = np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))
    return replace(stored, values=reduced, alpha=None)


def valid_orientation(orientation: object) -> int:
    """An EXIF orientation, 1 to 8; anything else is a broken tag and leaves the picture as it is."""
    return orientation if isinstance(orientation, int) and 1 <= orientation <= 8 else 1


def turn_upright(stored: Stored) -> Stored:
    """Stored samples turned as their orientation says."""
    alpha = None if stored.alpha is None else turn(stored.alpha, stored.orientation)
    whole = stored.whole[::-1] if stored.orientation >= 5 else stored.whole
    values = turn(stored.values, stored.orientation)
    return replace(stored, values=values, alpha=alpha, whole=whole, orientation=1)


def turn(samples: Samples, orientation: int) -> Samples:
    """The picture (H, W) or (H, W, C) as an EXIF orientation, 1 to 8, says it is to be shown; a view."""
    transposed = samples.swapaxes(0, 1)
    turns = {
        2: samples[:, ::-1],
        3: samples[::-1, ::-1],
        4: samples[::-1],
        5: transposed,
        6: transposed[:, ::-1],
        7: transposed[::-1, ::-1],
        8: transposed[::-1],
    }
    return turns.get(orientation, samples)
