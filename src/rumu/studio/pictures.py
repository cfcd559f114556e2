"""A picture that somebody sent: known by what it holds, not by its name, and bounded before it is decoded."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rumu.studio.errors import Unusable

if TYPE_CHECKING:
    from PIL.Image import Image

MOST_BYTES = 10 * 2**20
MOST_PIXELS = 24_000_000
KEPT_SIDE = 1600  # pixels; a mark does not gain from more, a disk does lose
LEAST_SIDE = 16
_FORMATS = ("PNG", "JPEG")
_ENDINGS = {"PNG": "png", "JPEG": "jpg", "TIFF": "tif", "WEBP": "webp"}  # of works


@dataclass(frozen=True, slots=True)
class Kept:
    """A picture as it is kept: turned upright, without what a camera wrote about place and time."""

    data: bytes
    ending: str
    width: int
    height: int


def looked_at(data: bytes, *, most_bytes: int = MOST_BYTES, most_pixels: int = MOST_PIXELS) -> None:
    """Raise Unusable unless the head of `data` is that of a PNG or JPEG within bounds; decodes nothing."""
    if not data:
        raise Unusable("no_picture", zh="沒有收到圖片。", en="Expected a picture, got nothing.")
    if len(data) > most_bytes:
        raise Unusable(
            "too_large",
            zh=f"圖片太大，最多 {most_bytes // 2**20} MB。",
            en=f"The picture is too large: at most {most_bytes // 2**20} MB.",
        )
    with _opened(data) as image:
        width, height = image.size
    if width * height > most_pixels:
        raise Unusable(
            "too_many_pixels",
            zh=f"圖片有 {width} × {height} 像素，最多 {most_pixels // 10**6} 百萬像素。",
            en=f"The picture has {width} x {height} pixels, at most {most_pixels // 10**6} million will do.",
        )
    if min(width, height) < LEAST_SIDE:
        raise Unusable(
            "too_small",
            zh=f"圖片只有 {width} × {height} 像素。",
            en=f"The picture has only {width} x {height} pixels.",
        )


def format_of(data: bytes, *, most_pixels: int = 100_000_000) -> str:
    """The ending that a picture of a work should have, by what it holds: png, jpg, tif or webp. Raises
    Unusable."""
    with _opened(data, formats=tuple(_ENDINGS)) as image:
        width, height = image.size
        if width * height > most_pixels:
            raise Unusable(
                "too_many_pixels",
                zh=f"圖片最多 {most_pixels // 10**6} 百萬像素。",
                en=f"A picture has at most {most_pixels // 10**6} million pixels.",
            )
        return _ENDINGS[str(image.format)]


def kept(data: bytes) -> Kept:
    """Decode a picture whole, turn it upright, shrink it to KEPT_SIDE, leave its metadata behind.

    Raises Unusable for what is no whole PNG or JPEG.
    """
    from PIL import ImageOps

    looked_at(data)
    with _opened(data) as opened:
        image = opened
        jpeg = image.format == "JPEG"
        try:
            if jpeg:
                image.draft("RGB", (2 * KEPT_SIDE, 2 * KEPT_SIDE))
            image.load()
            image = _on_white(ImageOps.exif_transpose(image))
        except (OSError, ValueError, SyntaxError, MemoryError) as error:
            raise _no_picture() from error
    if max(image.size) > KEPT_SIDE:
        image.thumbnail((KEPT_SIDE, KEPT_SIDE), reducing_gap=3.0)
    stream = io.BytesIO()
    if jpeg:
        image.save(stream, "JPEG", quality=92)
    else:
        image.save(stream, "PNG")
    return Kept(stream.getvalue(), "jpg" if jpeg else "png", *image.size)


def media_type(ending: str) -> str:
    """Of a kept picture."""
    return {"jpg": "image/jpeg", "png": "image/png"}[ending]


def _opened(data: bytes, *, formats: tuple[str, ...] = _FORMATS) -> Image:
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # our own bound is lower
            return Image.open(io.BytesIO(data), formats=formats)
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError) as error:
        raise _no_picture() from error


def _on_white(image: Image) -> Image:
    """8 bits, gray or RGB: palettes and CMYK become RGB, what is clear becomes paper."""
    from PIL import Image

    if image.mode in ("I;16", "I;16B", "I"):
        import numpy as np

        values = np.asarray(image, dtype=np.float64)
        return Image.fromarray(np.clip(np.round(values / 257), 0, 255).astype(np.uint8))
    if image.mode in ("LA", "PA", "RGBA", "La", "RGBa") or "transparency" in image.info:
        clear = image.convert("RGBA")
        page = Image.new("RGBA", clear.size, (255, 255, 255, 255))
        return Image.alpha_composite(page, clear).convert("RGB")
    return image if image.mode in ("L", "RGB") else image.convert("L" if image.mode == "1" else "RGB")


def _no_picture() -> Unusable:
    return Unusable(
        "no_picture",
        zh="這不是完整的 PNG 或 JPEG 圖片。",
        en="Expected a whole PNG or JPEG picture, got something else.",
    )
