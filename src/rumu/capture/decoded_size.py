"""How much memory a picture takes, counted from its header before anything of it is decoded."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass

from rumu.errors import ImageError, RefusedImage, RumuError

MAX_PIXELS = 120_000_000
"""Largest image that is decoded, in pixels: above any phone's frame, below what fills a small machine."""
MIN_SIDE = 8
"""Smallest side of an image that can hold anything, in pixels."""
MEMORY_VARIABLE = "RUMU_MAX_DECODED_MB"
"""The environment variable with the most memory, in megabytes, that decoded pictures may take."""

_DEFAULT_MB = 1000
_MB = 10**6
_FLOAT = 4  # bytes of a sample as rumu computes with it


@dataclass(frozen=True, slots=True)
class Reduction:
    """How far a picture is reduced while it is read; nothing is enlarged.

    side: longest side, in pixels, that is wanted. pixels: most pixels that are wanted of a picture that has
    more than `above`.
    """

    side: float = math.inf
    pixels: float = math.inf
    above: float = 0.0

    def factor(self, width: int, height: int) -> float:
        """What a side of the reduced picture is of a side of the whole one, in (0, 1]."""
        by_pixels = math.sqrt(self.pixels / (width * height)) if width * height > self.above else 1.0
        return min(1.0, self.side / max(width, height), by_pixels)


FULL_SIZE = Reduction()


@dataclass(frozen=True, slots=True)
class Header:
    """What the header of a file says of its picture.

    format: such as 'PNG'. width, height: in pixels, as stored, before the picture is turned upright.
    channels: samples of each pixel; sample_bytes: of each of them, once decoded. slices: of a volume.
    overhead: bytes that the decoder needs besides, such as a tile.
    """

    format: str
    width: int
    height: int
    channels: int = 3
    sample_bytes: float = 1
    slices: int = 1
    overhead: int = 0

    def memory(self, reduction: Reduction = FULL_SIZE, *, floats: bool = True) -> int:
        """Bytes of the decoded samples and, where `floats` says so, of the float image made of them."""
        samples = self.width * self.height * self.slices * self.channels * self.sample_bytes
        image = self.image_memory(reduction) if floats else 0
        return math.ceil(samples) + self.overhead + image

    def image_memory(self, reduction: Reduction = FULL_SIZE) -> int:
        """Bytes of the float image alone, with its alpha."""
        factor = reduction.factor(self.width, self.height)
        return math.ceil(self.width * self.height * factor**2 * _FLOAT * min(self.channels, 4))


def check_header(
    header: Header, name: object, *, reduction: Reduction = FULL_SIZE, floats: bool = True
) -> None:
    """Raise ImageError, which begins with `name`, when this picture is too small or too large to decode.

    reduction, floats: how much of it is kept, and whether it is computed with.
    """
    check_size(name, width=header.width, height=header.height)
    if header.slices != 1:
        raise ImageError(
            f"expected a flat picture, got a volume of {header.slices} slices",
            name=name,
            zh=f"需要平面的圖片，這個檔案是 {header.slices} 層的立體資料。",
        )
    check_memory([header.memory(reduction, floats=floats)], name)


def check_size(name: object, *, width: int, height: int) -> None:
    """Raise ImageError when no image of this size is accepted; `name` stands in front of the message."""
    if width * height > MAX_PIXELS:
        raise too_many_pixels(name, width * height)
    if min(width, height) < MIN_SIDE:
        raise ImageError(
            f"too small: expected at least {MIN_SIDE} x {MIN_SIDE} pixels, got {width} x {height}",
            name=name,
            zh=f"圖片太小：至少要 {MIN_SIDE} × {MIN_SIDE} 像素，這張是 {width} × {height}。",
        )


@dataclass(frozen=True, slots=True)
class WritingSize:
    """Which pictures strokes can be seen in.

    least_side: pixels of the shorter side. longest: most times that the longer side has the shorter one; a
    long handscroll has forty.
    """

    least_side: int = 24
    longest: int = 40


def check_writing_size(width: int, height: int, *, limits: WritingSize | None = None) -> None:
    """Raise RefusedImage, with the reason 'too small', for a picture in which no stroke can be seen."""
    limits = limits or WritingSize()
    least, shorter, longer = limits.least_side, min(width, height), max(width, height)
    if shorter < least:
        raise RefusedImage(
            f"too small: expected at least {least} x {least} pixels, got {width} x {height}",
            reason="too small",
            zh=f"圖片太小：至少要 {least} × {least} 像素，這張是 {width} × {height}。",
        )
    if longer > limits.longest * shorter:
        raise RefusedImage(
            f"too narrow: expected a side of at most {limits.longest} times the other, "
            f"got {width} x {height} pixels",
            reason="too small",
            zh=f"圖片太狹長：長邊最多是短邊的 {limits.longest} 倍，這張是 {width} × {height} 像素。",
        )


def too_many_pixels(name: object, pixels: int) -> ImageError:
    """The error of a picture that says that it has this many pixels."""
    most, found = f"{MAX_PIXELS / 1e6:.0f}", f"{pixels / 1e6:.0f}"
    return ImageError(
        f"expected at most {most} megapixels, the header says {found}",
        name=name,
        zh=f"圖片最多 {most} 百萬像素，這張有 {found} 百萬像素。",
    )


def check_memory(needed: Sequence[int], name: object) -> None:
    """Raise ImageError when pictures together need more memory than RUMU_MAX_DECODED_MB allows.

    needed: bytes of each picture. name: stands in front of the message.
    """
    most, total = memory_limit(), sum(needed)
    if total <= most:
        return
    found = math.ceil(total / _MB)
    pictures, of = ("1 picture", "") if len(needed) == 1 else (f"{len(needed)} pictures", "一共")
    raise ImageError(
        f"expected at most {most // _MB} MB once decoded, {pictures} would take {found} MB; make it smaller, "
        f"or set {MEMORY_VARIABLE} to {found} where there is that much memory",
        name=name,
        zh=f"解碼後最多 {most // _MB} MB，圖片{of}要佔 {found} MB；請先縮小，"
        f"或在記憶體足夠的機器上把 {MEMORY_VARIABLE} 設為 {found}。",
    )


def memory_limit() -> int:
    """The most bytes that decoded pictures may take. Raises RumuError when the variable is no number."""
    text = os.environ.get(MEMORY_VARIABLE) or str(_DEFAULT_MB)
    if not text.strip().isdecimal() or int(text) == 0:
        raise RumuError(
            f"expected a whole number of megabytes, got {text!r}",
            name=MEMORY_VARIABLE,
            zh=f"{MEMORY_VARIABLE} 應是以 MB 計的整數，現在是 {text!r}。",
        )
    return int(text) * _MB
