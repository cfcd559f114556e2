"""Uploaded pictures: recognised by their content, bounded before they are decoded, and normalised."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rumu.studio.errors import Unusable

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_BYTES = 10 * 2**20
MAX_PIXELS = 24_000_000
MAX_SIDE = 1600  # pixels; a mark does not gain from more
MIN_SIDE = 16
MEDIA_TYPES = {"jpg": "image/jpeg", "png": "image/png"}  # of stored pictures, by their suffix
_FORMATS = ("PNG", "JPEG")
_ENDINGS = {"PNG": "png", "JPEG": "jpg", "TIFF": "tif", "WEBP": "webp"}  # of works


@dataclass(frozen=True, slots=True)
class UprightPicture:
    """A picture as it is stored: upright, without the camera's metadata (position, time)."""

    data: bytes
    ending: str
    width: int
    height: int


def check_picture(data: bytes, *, max_bytes: int = MAX_BYTES, max_pixels: int = MAX_PIXELS) -> None:
    """Raise Unusable unless the head of `data` is that of a PNG or JPEG within bounds; decodes nothing."""
    if not data:
        raise Unusable("no_picture", zh="沒有收到圖片。", en="Expected a picture, got nothing.")
    if len(data) > max_bytes:
        raise Unusable(
            "too_large",
            zh=f"圖片太大，最多 {max_bytes // 2**20} MB。",
            en=f"The picture is too large: at most {max_bytes // 2**20} MB.",
        )
    with _open(data) as image:
        width, height = image.size
    if width * height > max_pixels:
        raise Unusable(
            "too_many_pixels",
            zh=f"圖片有 {width} × {height} 像素，最多 {max_pixels // 10**6} 百萬像素。",
            en=f"The picture has {width} x {height} pixels, "
            f"at most {max_pixels // 10**6} million are allowed.",
        )
    if min(width, height) < MIN_SIDE:
        raise Unusable(
            "too_small",
            zh=f"圖片只有 {width} × {height} 像素。",
            en=f"The picture has only {width} x {height} pixels.",
        )


def format_of(data: bytes, *, max_pixels: int = 100_000_000) -> str:
    """Return the suffix for a work's picture by its content: png, jpg, tif or webp. Raises Unusable."""
    with _open(data, formats=tuple(_ENDINGS)) as image:
        width, height = image.size
        if width * height > max_pixels:
            raise Unusable(
                "too_many_pixels",
                zh=f"圖片最多 {max_pixels // 10**6} 百萬像素。",
                en=f"A picture has at most {max_pixels // 10**6} million pixels.",
            )
        return _ENDINGS[str(image.format)]


def normalise_picture(data: bytes) -> UprightPicture:
    """Decode a whole picture, turn it upright, shrink it to MAX_SIDE and drop its metadata.

    Raises Unusable when it is no whole PNG or JPEG.
    """
    from PIL import ImageOps

    check_picture(data)
    with _open(data) as opened:
        image = opened
        jpeg = image.format == "JPEG"
        try:
            if jpeg:
                image.draft("RGB", (2 * MAX_SIDE, 2 * MAX_SIDE))
            image.load()
            image = _put_on_white(ImageOps.exif_transpose(image))
        except (OSError, ValueError, SyntaxError, MemoryError) as error:
            raise _not_a_picture() from error
    if max(image.size) > MAX_SIDE:
        image.thumbnail((MAX_SIDE, MAX_SIDE), reducing_gap=3.0)
    stream = io.BytesIO()
    if jpeg:
        image.save(stream, "JPEG", quality=92)
    else:
        image.save(stream, "PNG")
    return UprightPicture(stream.getvalue(), "jpg" if jpeg else "png", *image.size)


def _open(data: bytes, *, formats: tuple[str, ...] = _FORMATS) -> Image:
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # MAX_PIXELS is lower
            return Image.open(io.BytesIO(data), formats=formats)
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError) as error:
        raise _not_a_picture() from error


def _put_on_white(image: Image) -> Image:
    """Return an 8-bit picture, gray or RGB; what is transparent becomes white paper."""
    from PIL import Image

    if image.mode in ("I;16", "I;16B", "I"):
        import numpy as np

        values = np.asarray(image, dtype=np.float64)
        return Image.fromarray(np.clip(np.round(values / 257), 0, 255).astype(np.uint8))
    if image.mode in ("LA", "PA", "RGBA", "La", "RGBa") or "transparency" in image.info:
        picture = image.convert("RGBA")
        page = Image.new("RGBA", picture.size, (255, 255, 255, 255))
        return Image.alpha_composite(page, picture).convert("RGB")
    return image if image.mode in ("L", "RGB") else image.convert("L" if image.mode == "1" else "RGB")


def _not_a_picture() -> Unusable:
    return Unusable(
        "no_picture",
        zh="這不是完整的 PNG 或 JPEG 圖片。",
        en="Expected a whole PNG or JPEG picture, got something else.",
    )
