"""Images as arrays: read from files as stored, or as linear light, checked at once; boxes in them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import FULL_SIZE, Reduction, check_size
from rumu.capture.formats import ENCODINGS, Encoding, decode
from rumu.capture.stored import Samples, Stored, eight_bits, over_white, turn
from rumu.errors import ImageError
from rumu.image_stack import Photograph
from rumu.values import BoolArray

Image = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]
Box = tuple[int, int, int, int]
"""Rows y0:y1 and columns x0:x1 of a picture."""

_REC709 = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
_OPAQUE = 0.999  # alpha from which nothing behind the sheet shines through
_ROUNDING = 1e-5  # a float image may overshoot [0, 1] by the rounding of the program that wrote it


def read_image(path: str | os.PathLike[str], *, reduction: Reduction = FULL_SIZE) -> Image:
    """An image with its values as stored: the display encoding is kept.

    PNG, JPEG, WebP, HEIC (with pillow-heif), AVIF, BMP, GIF (first frame), PPM, TIFF, EXR; 1, 8 and 16 bits
    and float. EXIF orientation is applied, colours with a profile (ICC) become sRGB, CMYK and palettes become
    RGB, alpha is composited over white. A large picture is reduced as `reduction` says.
    Returns (H, W) or (H, W, 3) float32 in [0, 1], contiguous.
    Raises ImageError naming the file: missing, a folder, empty, cut short, no image, below MIN_SIDE, above
    MAX_PIXELS or RUMU_MAX_DECODED_MB (refused from the header), float values that are NaN, infinite or
    outside [0, 1].
    """
    return image_of(decode(path, reduction=reduction), name=path)


def read_colours(path: str | os.PathLike[str], *, reduction: Reduction = FULL_SIZE) -> Bytes:
    """A picture in colour with its values as stored, upright, over white: (H, W, 3) uint8, contiguous.

    Formats, `reduction` and errors: as of `read_image`.
    """
    return colours_of(decode(path, reduction=reduction, floats=False), name=path)


def colours_of(stored: Stored, *, name: object) -> Bytes:
    """Decoded samples as `read_colours` returns them. Raises ImageError for float values outside [0, 1]."""
    values = stored.values if stored.values.dtype.kind == "u" else _unit_range(stored.values, name=name)
    samples = eight_bits(over_white(values, stored.alpha))
    return np.ascontiguousarray(np.dstack([samples] * 3) if samples.ndim == 2 else samples)


def image_of(stored: Stored, *, name: object) -> Image:
    """Decoded samples as `read_image` returns them. Raises ImageError for float values outside [0, 1]."""
    values = _unit_range(stored.values, name=name)
    return np.ascontiguousarray(over_white(values, stored.alpha))


def read_linear(path: str | os.PathLike[str], *, encoding: Encoding = "auto") -> Image:
    """An image as linear light, upright.

    encoding: 'auto' decodes JPEG, WebP, HEIC and AVIF from sRGB, and what has a colour profile by it, and
        takes every other file as linear; 'linear' and 'srgb' say it outright. EXR and float TIFF are always
        linear. A colour profile counts where the samples are taken as display-encoded.
    Returns (H, W) or (H, W, 3) float32, at least 0. Integer formats end at 1; EXR and float TIFF may exceed
    it, so that the frames of one capture can be divided by one common peak. Their negative values, which
    dark subtraction leaves, become 0.
    Raises ImageError as `read_image` does, except for float values above 1.
    """
    image, orientation = read_frame(path, encoding=encoding)
    return np.ascontiguousarray(turn(image, orientation))


def read_frame(path: str | os.PathLike[str], *, encoding: Encoding = "auto") -> tuple[Image, int]:
    """An image as linear light as the camera stored it, and the EXIF orientation that would turn it.

    encoding, the values and errors: as of `read_linear`.
    """
    photograph, orientation = read_photograph(path, encoding=encoding)
    return photograph.light(), orientation


def read_photograph(path: str | os.PathLike[str], *, encoding: Encoding = "auto") -> tuple[Photograph, int]:
    """An image in its own bits with the curve that makes linear light of them, and its EXIF orientation.

    encoding and errors: as of `read_linear`. What has alpha or floats is linear light of 32 bits.
    """
    if encoding not in ENCODINGS:
        raise ImageError(f"encoding: expected one of {', '.join(ENCODINGS)}, got {encoding!r}")
    stored = decode(path, upright=False, encoding=encoding, floats=False)
    values = _check_values(stored.values, name=path)
    curve = None
    if values.dtype.kind == "f":
        values = np.maximum(values, 0).astype(np.float32, copy=False)
    elif encoding == "srgb" or (encoding == "auto" and stored.display):
        curve = to_linear(_scale(np.arange(np.iinfo(values.dtype).max + 1, dtype=values.dtype)))
    if stored.alpha is not None:
        height, width = values.shape[:2]
        linear = Photograph(values, curve).range(0, height * width).reshape(values.shape)
        opaque = stored.alpha >= _OPAQUE
        return Photograph(over_white(linear, stored.alpha), opaque=opaque), stored.orientation
    return Photograph(values, curve), stored.orientation


def read_mask(path: str | os.PathLike[str], *, upright: bool = True) -> BoolArray:
    """A mask: True where the image is brighter than half and not transparent.

    upright: whether it is turned as its EXIF orientation says. Returns (H, W) bool. Raises ImageError as
    `read_image` does.
    """
    stored = decode(path, upright=upright)
    gray = luminance(_unit_range(stored.values, name=path))
    return np.asarray(gray > 0.5 if stored.alpha is None else gray * stored.alpha > 0.5)


def as_image(array: npt.NDArray[Any], *, name: object = "array") -> Image:
    """An array as an image, under the same checks as a file.

    array: (H, W), (H, W, 1), (H, W, 3), or with alpha (H, W, 2), (H, W, 4); bool, uint8, uint16, or float in
        [0, 1]. Alpha is composited over white.
    Returns (H, W) or (H, W, 3) float32 in [0, 1]. Raises ImageError, beginning with `name`.
    """
    samples = np.asarray(array)
    if samples.ndim not in (2, 3) or (samples.ndim == 3 and not 1 <= samples.shape[2] <= 4):
        raise ImageError(f"expected an image of shape (H, W) or (H, W, 3), got {samples.shape}", name=name)
    check_size(name, width=samples.shape[1], height=samples.shape[0])
    values = _unit_range(samples, name=name)
    if values.ndim == 2 or values.shape[2] == 3:
        return np.ascontiguousarray(values)
    colours = values[:, :, 0] if values.shape[2] < 3 else values[:, :, :3]
    return np.ascontiguousarray(over_white(colours, values[:, :, -1] if values.shape[2] > 1 else None))


def to_linear(image: Image) -> Image:
    """Linear light from sRGB-encoded values in [0, 1] (IEC 61966-2-1); same shape, float32."""
    low = image <= 0.04045
    curve = ((image + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(low, image / np.float32(12.92), curve).astype(np.float32)


def luminance(image: Image) -> Image:
    """(H, W) float32: the Rec. 709 sum of a linear (H, W, 3) image; a gray image is returned as it is."""
    return image if image.ndim == 2 else np.asarray(image @ _REC709, dtype=np.float32)


def _check_values(samples: Samples, *, name: object) -> Samples:
    kind, size = samples.dtype.kind, samples.dtype.itemsize
    if kind != "f" and (kind, size) not in [("b", 1), ("u", 1), ("u", 2)]:
        raise ImageError(f"expected bool, uint8, uint16 or float values, got {samples.dtype}", name=name)
    if kind == "f":
        bad = samples.size - int(np.count_nonzero(np.isfinite(samples)))
        if bad:
            raise ImageError(
                f"expected finite values, got {bad} that are NaN or infinite",
                name=name,
                zh=f"有 {bad} 個值不是有限的數。",
            )
    return samples


def _unit_range(samples: Samples, *, name: object) -> Image:
    _check_values(samples, name=name)
    if samples.dtype.kind != "f":
        return _scale(samples)
    low, high = float(samples.min()), float(samples.max())
    if low < -_ROUNDING or high > 1 + _ROUNDING:
        raise ImageError(
            f"expected float values in [0, 1], got values from {low:.6g} to {high:.6g}",
            name=name,
            zh=f"浮點值應在 0 到 1 之間，這個檔案從 {low:.6g} 到 {high:.6g}。",
        )
    return np.clip(samples, 0, 1).astype(np.float32, copy=False)


def _scale(samples: Samples) -> Image:
    full = {"uint8": 255, "uint16": 65535}.get(samples.dtype.name, 1)
    values = samples.astype(np.float32)  # one conversion, then in place: numpy casts slowly while dividing
    values /= np.float32(full)
    return values


def shrink(picture: Bytes, *, side: int) -> Bytes:
    """A picture (H, W) or (H, W, 3) uint8 by area averaging, longer side at most `side` pixels."""
    import cv2

    longest = max(picture.shape[:2])
    if longest <= side:
        return picture
    height, width = (max(1, round(n * side / longest)) for n in picture.shape[:2])
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


# --- boxes -----------------------------------------------------------------------------------------


def bounding_box(mask: BoolArray) -> Box:
    """The tightest box that holds all that is True in a mask (H, W); something must be."""
    import cv2

    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    return y, y + height, x, x + width


@dataclass(frozen=True, slots=True)
class FrameSettings:
    """When the outside of a picture is a flat frame or strip; shares of its pixels unless said.

    flat: gray levels that JPEG leaves of a constant colour. ring: of the outermost pixels, that must be flat
        for a frame. active_row: of a row, that must differ from the frame for it to count; inner_row: of what
        rows usually have, that the rows inside the frame have at least.
    least_side: fewest rows and columns inside. least_area: of what is inside. corners: of each corner inside,
        that must differ from the frame. blank: of the blocks inside, that may be as flat as it.
    colour_step: gray levels by which the usual colour inside may differ from the frame's.
    strip_depth: deepest strip, of the side. strip_flat: gray levels that are flat in it. strip_row: of its
        first row, that must be flat; picture_row: of a row of the picture, that may be; after_row: the same
        of the three rows after it.
    """

    flat: int = 2
    ring: float = 0.98
    active_row: float = 0.02
    inner_row: float = 0.5
    least_side: int = 8
    least_area: float = 0.08
    corners: float = 0.3
    blank: float = 0.02
    colour_step: float = 60.0
    strip_depth: float = 0.15
    strip_flat: int = 12
    strip_row: float = 0.85
    picture_row: float = 0.25
    after_row: float = 0.1


def box_inside_frame(view: Bytes, *, settings: FrameSettings | None = None) -> Box:
    """The picture within a flat frame around it, or within flat strips along its sides; all of it if none.

    view: (H, W) or (H, W, 3) uint8.
    """
    settings = settings or FrameSettings()
    height, width = view.shape[:2]
    colours = view.reshape(height, width, -1)
    ring = np.concatenate([colours[0], colours[-1], colours[:, 0], colours[:, -1]])
    frame = np.median(ring, axis=0)
    if (np.abs(ring - frame).max(axis=1) <= 2 * settings.flat).mean() > settings.ring:
        return _within_frame(colours, frame, settings)
    turned = colours.transpose(1, 0, 2)
    top, bottom, left, right = (
        _strip_depth(rows, settings) for rows in (colours, colours[::-1], turned, turned[::-1])
    )
    return top, height - bottom, left, width - right


def _within_frame(colours: Bytes, frame: npt.NDArray[Any], settings: FrameSettings) -> Box:
    """The rectangle of paper inside a frame of one constant colour, as museums' crops are padded.

    Blank digital paper is flat too. There what lies inside is ink: it leaves flat paper between its strokes
    and no texture in the corners of its box. So all four corners must be busy, and no block may be flat.
    """
    import cv2

    whole = (0, colours.shape[0], 0, colours.shape[1])
    active = np.zeros(colours.shape[:2], np.uint8)
    for k in range(colours.shape[2]):
        difference = cv2.absdiff(colours[:, :, k], float(frame[k]))  # type: ignore[call-overload]
        active |= difference.astype(np.uint8) > settings.flat
    spans = []
    for axis in (1, 0):
        sums = cv2.reduce(active, axis, cv2.REDUCE_SUM, dtype=cv2.CV_32S)
        share = sums.ravel() / active.shape[axis]
        busy = share[share > settings.active_row]
        span = np.flatnonzero(share > (settings.inner_row * np.median(busy) if len(busy) else 1.0))
        if len(span) < settings.least_side:
            return whole
        spans.append((int(span[0]), int(span[-1]) + 1))
    (y0, y1), (x0, x1) = spans
    if (y0, y1, x0, x1) == whole:
        return whole
    part = active[y0:y1, x0:x1]
    k = max(4, min(part.shape) // 16)
    corners = [part[:k, :k], part[:k, -k:], part[-k:, :k], part[-k:, -k:]]
    busy_corners = min(float(c.mean()) for c in corners) >= settings.corners
    if part.size < settings.least_area * active.size or not busy_corners:
        return whole
    inside = np.median(colours[y0:y1, x0:x1].reshape(-1, colours.shape[2]), axis=0)
    flat_blocks = (cv2.blur(part.astype(np.float32), (9, 9)) < 0.01).mean()
    if np.abs(inside - frame).max() > settings.colour_step or flat_blocks > settings.blank:
        return whole
    return y0, y1, x0, x1


def _strip_depth(rows: Bytes, settings: FrameSettings) -> int:
    """Rows to cut from the top, such as the white band of a watermark; 0 where there is no strip."""
    depth = max(3, int(settings.strip_depth * rows.shape[0]))
    band = rows[: depth + 4].astype(np.int16)
    colour = np.median(band[0], axis=0)
    flat = (np.abs(band - colour).max(axis=2) <= settings.strip_flat).mean(axis=1)
    inside = np.flatnonzero(flat < settings.picture_row)
    if flat[0] < settings.strip_row or len(inside) == 0 or inside[0] < 2 or inside[0] >= depth:
        return 0
    if flat[inside[0] + 1 : inside[0] + 4].max(initial=0.0) > settings.after_row:
        return 0
    return int(inside[0]) + 1
