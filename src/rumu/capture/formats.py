"""One decoder per file format: a file becomes its stored samples, with nothing rescaled.

The kind of a file is read from its first bytes, never from its name. The size is checked in the header,
before a single pixel is decoded. Pillow reads everything of 8 bits and notices truncated files; it reads
16-bit colour PNG as 8 bits, so those go to OpenCV; deep TIFF goes to tifffile, EXR to OpenEXR.
"""

from __future__ import annotations

import io
import logging
import os
import re
import struct
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError

Samples = npt.NDArray[Any]

MAX_PIXELS = 120_000_000
"""Largest image that is decoded, in pixels: above any phone's frame, below what fills a small machine."""
MIN_SIDE = 8
"""Smallest side of an image that can hold anything, in pixels."""

_PILLOW_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "PPM", "TIFF")
_DISPLAY_FORMATS = ("JPEG", "MPO", "WEBP")  # always written for a screen, so display-encoded
_EXPECTED = "expected an image (PNG, JPEG, WebP, BMP, GIF, PPM, TIFF or EXR)"
_RAW_SUFFIXES = (".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".orf", ".rw2", ".pef")
_ORIENTATION_TAG = 0x0112
_TIFF_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_EXR_MAGIC = b"v/1\x01"
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_PILLOW_MAGIC = (_PNG_MAGIC, b"\xff\xd8\xff", b"RIFF")

# What tifffile finds odd is in our error or does not matter; without this it prints to stderr.
logging.getLogger("tifffile").addHandler(logging.NullHandler())


@dataclass(frozen=True, slots=True, eq=False)
class Stored:
    """The samples of a file.

    values: (H, W) or (H, W, 3), uint8, uint16 or float32, R G B.
    alpha: (H, W) float32 in [0, 1], straight (colours are not multiplied by it); None when opaque.
    display: True when the format is always display-encoded (JPEG, WebP).
    orientation: how the samples are still to be turned, as EXIF numbers it; 1 when they are upright.
    """

    values: Samples
    alpha: Samples | None = None
    display: bool = False
    orientation: int = 1


def decode(path: str | os.PathLike[str], *, upright: bool = True) -> Stored:
    """The stored samples of an image file, turned as its orientation says unless `upright` is False.

    Raises ImageError, naming the file, when it is missing, a folder, empty, cut short, no image, a camera's
    raw file, smaller than MIN_SIDE or larger than MAX_PIXELS.
    """
    path = Path(path)
    head = _first_bytes(path)
    try:
        with warnings.catch_warnings():
            # Pillow warns of sizes and odd metadata: the size is judged here, metadata is not the picture.
            warnings.simplefilter("ignore")
            stored = _decoder(head)(path)
            return _turn_upright(stored) if upright else stored
    except ImageError:
        raise
    except Exception as error:  # decoders raise nearly anything on broken files
        raise _as_image_error(path, head, error) from error


def _first_bytes(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise ImageError(f"{path}: expected an image file, found a folder")
        if path.exists() and not path.is_file():  # reading a pipe would wait for ever
            raise ImageError(f"{path}: expected an image file, found a device or a pipe")
        with path.open("rb") as file:
            head = file.read(32)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise ImageError(f"{path}: {_EXPECTED}, cannot open it ({reason})") from error
    if not head:
        raise ImageError(f"{path}: {_EXPECTED}, the file is empty")
    if path.suffix.lower() in _RAW_SUFFIXES:
        raise ImageError(f"{path}: camera raw is not read; develop it to a linear 16-bit TIFF first")
    return head


def _decoder(head: bytes) -> Callable[[Path], Stored]:
    if head.startswith(_EXR_MAGIC):
        return _read_exr
    if head.startswith(_TIFF_MAGIC):
        return _read_tiff
    is_deep_colour = head.startswith(_PNG_MAGIC) and head[24:25] == b"\x10" and head[25] in (2, 4, 6)
    return _read_deep_png if is_deep_colour else _read_pillow


def _as_image_error(path: Path, head: bytes, error: Exception) -> ImageError:
    from PIL import Image, UnidentifiedImageError

    if isinstance(error, Image.DecompressionBombError):
        pixels = re.search(r"\((\d+) pixels\)", str(error))
        return _too_large(path, int(pixels[1]) if pixels else 2 * MAX_PIXELS)
    if isinstance(error, UnidentifiedImageError) and not head.startswith(_PILLOW_MAGIC):
        return ImageError(f"{path}: {_EXPECTED}, found something else (it starts with {head[:12]!r})")
    detail = f"{type(error).__name__}: {error}".splitlines()[0].replace(str(path), path.name)
    return ImageError(f"{path}: the image is cut short or broken ({detail})")


def _too_large(path: Path, pixels: int) -> ImageError:
    return ImageError(
        f"{path}: expected at most {MAX_PIXELS / 1e6:.0f} megapixels, the header says {pixels / 1e6:.0f}"
    )


def check_size(name: object, *, width: int, height: int) -> None:
    """Raise ImageError when no image of this size is accepted; `name` stands in front of the message."""
    if width * height > MAX_PIXELS:
        raise _too_large(Path(str(name)), width * height)
    if min(width, height) < MIN_SIDE:
        raise ImageError(f"{name}: expected at least {MIN_SIDE} x {MIN_SIDE} pixels, got {width} x {height}")


# --- Pillow: everything of 8 bits ------------------------------------------------------------------


def _read_pillow(path: Path, *, source: io.BytesIO | None = None) -> Stored:
    from PIL import Image

    with Image.open(source or path, formats=_PILLOW_FORMATS) as image:
        check_size(path, width=image.width, height=image.height)
        display = image.format in _DISPLAY_FORMATS
        image.load()
        orientation = image.getexif().get(_ORIENTATION_TAG, 1)
        samples = _pillow_samples(path, image)
    return replace(_split_alpha(samples), display=display, orientation=_valid(orientation))


def _pillow_samples(path: Path, image: Any) -> Samples:
    mode: str = image.mode
    if mode.startswith("I"):
        samples = np.asarray(image)
        low, high = int(samples.min()), int(samples.max())
        if low < 0 or high > 65535:
            raise ImageError(
                f"{path}: expected 8-bit, 16-bit or float samples, got values from {low} to {high}"
            )
        return samples.astype(np.uint16)
    if mode == "F":
        return np.asarray(image, dtype=np.float32)
    if mode in ("1", "L", "LA", "La"):
        wanted = "LA" if "A" in image.getbands() or mode == "La" or "transparency" in image.info else "L"
    else:
        wanted = "RGBA" if image.has_transparency_data else "RGB"
    return np.asarray(image if mode == wanted else image.convert(wanted))


# --- PNG of 16 bits in colour or with alpha --------------------------------------------------------


def _read_deep_png(path: Path) -> Stored:
    from PIL import Image

    with Image.open(path, formats=("PNG",)) as image:
        check_size(path, width=image.width, height=image.height)
        orientation = image.getexif().get(_ORIENTATION_TAG, 1)
    with Image.open(path, formats=("PNG",)) as image:
        image.verify()  # checksums; OpenCV would return what it got of a file cut short
    return replace(_split_alpha(_read_opencv(path)), orientation=_valid(orientation))


def _read_opencv(path: Path) -> Samples:
    import cv2

    samples = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if samples is None:
        raise ValueError("it cannot be decoded")
    if samples.ndim == 3 and samples.shape[2] >= 3:
        samples = samples[:, :, [2, 1, 0, 3][: samples.shape[2]]]  # B G R (A) to R G B (A)
    return np.asarray(samples)


# --- TIFF ------------------------------------------------------------------------------------------


def _read_tiff(path: Path) -> Stored:
    import tifffile

    with tifffile.TiffFile(path) as tiff:
        page = tiff.pages[0]
        check_size(path, width=page.imagewidth, height=page.imagelength)
        bits = page.bitspersample if isinstance(page.bitspersample, int) else max(page.bitspersample)
        tag = page.tags.get(_ORIENTATION_TAG)
        orientation = int(tag.value) if tag else 1
        if bits <= 8:
            stored = _read_pillow(path, source=_without_orientation(path, tiff))
            return replace(stored, orientation=_valid(orientation))
        if page.dtype is None or page.dtype.name not in ("uint16", "float16", "float32", "float64"):
            raise ImageError(f"{path}: expected 8-bit, 16-bit or float samples, got {bits}-bit {page.dtype}")
        stored = _tiff_colours(path, page, _tiff_samples(path, page))
    return replace(stored, orientation=_valid(orientation))


def _without_orientation(path: Path, tiff: Any) -> io.BytesIO | None:
    """The file with its orientation set to upright, or None when it is: Pillow 13 turns a TIFF twice."""
    tag = tiff.pages[0].tags.get(_ORIENTATION_TAG)
    if tag is None or tag.value == 1:
        return None
    data = bytearray(path.read_bytes())
    struct.pack_into(f"{tiff.byteorder}H", data, tag.valueoffset, 1)
    return io.BytesIO(data)


def _tiff_samples(path: Path, page: Any) -> Samples:
    ends = [a + b for a, b in zip(page.dataoffsets, page.databytecounts, strict=True)]
    if max(ends, default=0) > path.stat().st_size:
        raise ValueError("its samples lie beyond its end")
    try:
        samples = page.asarray()
    except (ValueError, KeyError) as error:
        if "imagecodecs" not in str(error):
            raise
        samples = _read_opencv(path)  # LZW and PackBits need a 26 MB wheel in tifffile; OpenCV has them
    samples = np.asarray(samples)
    if samples.ndim == 3 and samples.shape[-1] != page.samplesperpixel:
        samples = np.moveaxis(samples, 0, -1)  # planes stored one after the other
    return samples.astype(np.float32) if samples.dtype.kind == "f" else samples


def _tiff_colours(path: Path, page: Any, samples: Samples) -> Stored:
    kind = getattr(page.photometric, "name", str(page.photometric))
    colours = {"MINISBLACK": 1, "MINISWHITE": 1, "RGB": 3, "SEPARATED": 4}.get(kind)
    if colours is None:
        raise ImageError(f"{path}: expected a gray, RGB or CMYK TIFF, got {kind}")
    channels = samples if samples.ndim == 3 else samples[:, :, None]
    inks, extra = channels[:, :, :colours], channels[:, :, colours:]
    if kind == "MINISWHITE":
        inks = _full_scale(inks) - inks
    if kind == "SEPARATED":
        cmyk = inks.astype(np.float32) / np.float32(_full_scale(inks))
        inks = (1 - cmyk[:, :, :3]) * (1 - cmyk[:, :, 3:])
    meanings = [int(m) for m in page.extrasamples]
    if extra.shape[2] and meanings and meanings[0] in (1, 2):  # 1 premultiplied, 2 straight
        joined = np.concatenate([inks, extra[:, :, :1]], axis=2)
        return _split_alpha(joined, premultiplied=meanings[0] == 1)
    return _split_alpha(inks)


# --- EXR -------------------------------------------------------------------------------------------


def _read_exr(path: Path) -> Stored:
    import OpenEXR

    with OpenEXR.File(str(path), header_only=True) as file:
        low, high = file.header()["dataWindow"]
    check_size(path, width=int(high[0] - low[0]) + 1, height=int(high[1] - low[1]) + 1)
    with OpenEXR.File(str(path)) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    for name in ("RGBA", "RGB", "Y"):
        if name in channels:
            samples = np.asarray(channels[name], dtype=np.float32)
            return _split_alpha(samples, premultiplied=True)
    raise ImageError(f"{path}: expected EXR channels R, G, B or Y, found {', '.join(sorted(channels))}")


# --- alpha and orientation --------------------------------------------------------------------------------


def _full_scale(samples: Samples) -> Any:
    return samples.dtype.type(np.iinfo(samples.dtype).max if samples.dtype.kind == "u" else 1)


def _split_alpha(samples: Samples, *, premultiplied: bool = False) -> Stored:
    """(H, W), or (H, W, C) of 1 gray, 2 gray + alpha, 3 colour, 4 colour + alpha."""
    if samples.ndim == 2:
        return Stored(samples)
    count = samples.shape[2]
    values = samples[:, :, 0] if count < 3 else samples[:, :, :3]
    if count in (1, 3):
        return Stored(values)
    alpha = samples[:, :, -1].astype(np.float32) / np.float32(_full_scale(samples))
    if np.all(alpha == 1):
        return Stored(values)
    if premultiplied:
        scale = _full_scale(samples)
        cover = np.where(alpha > 0, alpha, 1) if count == 2 else np.where(alpha > 0, alpha, 1)[:, :, None]
        values = (values.astype(np.float32) / np.float32(scale) / cover).astype(np.float32)
    return Stored(values, alpha)


def _valid(orientation: object) -> int:
    """An EXIF orientation, 1 to 8; anything else is a broken tag and leaves the picture as it is."""
    return orientation if isinstance(orientation, int) and 1 <= orientation <= 8 else 1


def _turn_upright(stored: Stored) -> Stored:
    alpha = None if stored.alpha is None else turn(stored.alpha, stored.orientation)
    return replace(stored, values=turn(stored.values, stored.orientation), alpha=alpha, orientation=1)


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
