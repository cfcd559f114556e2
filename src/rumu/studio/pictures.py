"""Uploaded pictures: recognised by their content, bounded before they are decoded, and normalised."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rumu.errors import ImageError, RefusedImage
from rumu.gallery.assets import decode_picture, picture_file
from rumu.studio.errors import Unusable

if TYPE_CHECKING:
    from rumu.capture.decoded_size import Header

MAX_BYTES = 10 * 2**20
MAX_PIXELS = 24_000_000
MAX_SIDE = 1600  # pixels; a mark does not gain from more
MEDIA_TYPES = {"jpg": "image/jpeg", "png": "image/png"}  # of stored pictures, by their suffix
_ENDINGS = {
    "JPEG": "jpg", "MPO": "jpg", "PNG": "png", "TIFF": "tif", "WEBP": "webp", "HEIF": "heic", "AVIF": "avif",
    "BMP": "bmp", "GIF": "gif", "PPM": "ppm", "EXR": "exr",
}  # fmt: skip
_PHOTOGRAPHS = ("JPEG", "MPO", "WEBP", "HEIF", "AVIF")  # are stored as JPEG, the others as PNG


@dataclass(frozen=True, slots=True)
class UprightPicture:
    """A picture as it is stored: upright, without the camera's metadata (position, time)."""

    data: bytes
    ending: str
    width: int
    height: int


def check_picture(data: bytes, *, max_bytes: int = MAX_BYTES, max_pixels: int = MAX_PIXELS) -> str:
    """The format of a picture by its head, such as 'JPEG'; nothing is decoded.

    Raises Unusable for what is no picture, and for one that is too large, too small or too narrow.
    """
    if not data:
        raise Unusable("no_picture", zh="沒有收到圖片。", en="Expected a picture, got nothing.")
    if len(data) > max_bytes:
        raise Unusable(
            "too_large",
            zh=f"圖片太大，最多 {max_bytes // 2**20} MB。",
            en=f"The picture is too large: at most {max_bytes // 2**20} MB.",
        )
    header = _head_of(data)
    width, height = header.width, header.height
    if width * height > max_pixels:
        raise Unusable(
            "too_many_pixels",
            zh=f"圖片有 {width} × {height} 像素，最多 {max_pixels // 10**6} 百萬像素。",
            en=f"The picture has {width} x {height} pixels, "
            f"at most {max_pixels // 10**6} million are allowed.",
        )
    return header.format


def _head_of(data: bytes) -> Header:
    """What a picture says of itself. Raises Unusable where that is not enough or too much to be read."""
    from rumu.capture.decoded_size import Reduction, check_header, check_writing_size
    from rumu.capture.formats import read_header

    with _unusable(), picture_file(data) as path:
        header = read_header(path)
        check_writing_size(header.width, header.height)
        check_header(header, path, reduction=Reduction(side=MAX_SIDE))
        return header


def format_of(data: bytes, *, max_pixels: int = 100_000_000) -> str:
    """Return the suffix for a work's picture by its content: png, jpg, tif, ... Raises Unusable."""
    return _ENDINGS[check_picture(data, max_bytes=len(data), max_pixels=max_pixels)]


def normalise_picture(data: bytes) -> UprightPicture:
    """Decode a whole picture, turn it upright, shrink it to MAX_SIDE and drop its metadata.

    Colours become sRGB, what is transparent white. Raises Unusable when it is no whole picture.
    """
    is_photograph = check_picture(data) in _PHOTOGRAPHS
    with _unusable():
        image = decode_picture(data, longest=MAX_SIDE)
    stream = io.BytesIO()
    if is_photograph:
        image.save(stream, "JPEG", quality=92)
    else:
        image.save(stream, "PNG")
    return UprightPicture(stream.getvalue(), "jpg" if is_photograph else "png", *image.size)


@contextmanager
def _unusable() -> Iterator[None]:
    """Raise what is wrong with a picture as Unusable, without the name of the temporary file."""
    try:
        yield
    except RefusedImage as error:
        raise Unusable(error.reason.replace(" ", "_"), zh=error.zh, en=_sentence(error.en)) from error
    except ImageError as error:
        raise Unusable("no_picture", zh=error.zh, en=_sentence(error.en)) from error


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."
