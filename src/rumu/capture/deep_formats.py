"""Decoders of more than 8 bits: PNG and TIFF of 16 bits, TIFF and EXR of floats."""

from __future__ import annotations

import io
import logging
import lzma
import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from rumu.capture.colours import cmyk_to_rgb, profile_of
from rumu.capture.decoded_size import Header
from rumu.capture.stored import Samples, Stored, full_scale, split_alpha
from rumu.errors import ImageError

ORIENTATION = 0x0112
"""The EXIF and TIFF tag of the orientation."""

_ICC_TAG = 34675
_DEFLATE, _LZMA = (8, 32946), (34925,)
_UNPACKED = (1, *_DEFLATE, *_LZMA)  # by tifffile; the rest by OpenCV, which never unpacks more than a strip
_SEPARATED = 5  # the photometric interpretation of inks
_REDUCED, _MASK = 1, 4  # bits of a TIFF's NewSubfileType
_PAGES = 16  # of a TIFF, that are looked at for its picture
_EXR_SAMPLE_BYTES = {0: 4, 1: 2, 2: 4}  # uint32, half, float
_EXR_MULTIPART = 0x1000
_NO_DEEP_ZH = "不讀帶有深度樣本的 EXR。"

# What tifffile finds odd is in our error or does not matter; without this it prints to stderr.
logging.getLogger("tifffile").addHandler(logging.NullHandler())


# --- PNG of 16 bits in colour or with alpha --------------------------------------------------------


def deep_png_header(path: Path) -> Header:
    """The header of a PNG of 16 bits."""
    from PIL import Image

    with Image.open(path, formats=("PNG",)) as image:
        return Header("PNG", image.width, image.height, channels=4, sample_bytes=2)


def read_deep_png(path: Path) -> tuple[Stored, int, bytes | None]:
    """The samples of a PNG of 16 bits, its orientation and its colour profile."""
    from PIL import Image

    with Image.open(path, formats=("PNG",)) as image:
        orientation, profile = image.getexif().get(ORIENTATION, 1), profile_of(image)
    with Image.open(path, formats=("PNG",)) as image:
        image.verify()  # checksums; OpenCV would return what it got of a file cut short
    return split_alpha(_read_opencv(path)), orientation, profile


def _read_opencv(path: Path) -> Samples:
    return _decode_opencv(np.fromfile(path, np.uint8))


def _decode_opencv(data: Samples) -> Samples:
    import cv2

    samples = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    if samples is None:
        raise ValueError("it cannot be decoded")
    if samples.ndim == 3 and samples.shape[2] >= 3:  # B G R (A) to R G B (A), without a copy of all
        samples[:, :, 0], samples[:, :, 2] = samples[:, :, 2], samples[:, :, 0].copy()
    return np.asarray(samples)


# --- TIFF ------------------------------------------------------------------------------------------


def tiff_header(path: Path) -> Header:
    """The header of a TIFF's picture."""
    import tifffile

    with tifffile.TiffFile(path) as tiff:
        return _page_header(_main_page(tiff))


def is_deep_tiff(path: Path) -> bool:
    """Whether the samples of a TIFF have more than 8 bits."""
    import tifffile

    with tifffile.TiffFile(path) as tiff:
        return _bits(_main_page(tiff)) > 8


def _main_page(tiff: Any) -> Any:
    """The first picture of a TIFF, but not a preview where a whole one follows, or lies within it."""
    first = tiff.pages[0]
    if not _is_aside(first):
        return first
    others = [*tiff.pages[1:_PAGES], *(first.pages or ())[:_PAGES]]
    return next((page for page in others if not _is_aside(page)), first)


def _is_aside(page: Any) -> bool:
    """Whether a page is a preview of another, or its mask, by its own word."""
    return bool(int(getattr(page, "subfiletype", 0)) & (_REDUCED | _MASK))


def _begun_at(path: Path, page: Any) -> bytearray | None:
    """The file, of which a page is the first; None where it is that already."""
    tiff = page.parent
    if page.offset == tiff.pages[0].offset:
        return None
    data = bytearray(path.read_bytes())
    place, form = (8, "Q") if tiff.is_bigtiff else (4, "I")
    struct.pack_into(f"{tiff.byteorder}{form}", data, place, page.offset)
    return data


def _page_header(page: Any) -> Header:
    """What a page says of itself. Its tiles may be larger than itself, and each is decoded whole."""
    sample_bytes = -(-_bits(page) // 8)
    tile = 0
    if page.is_tiled:
        tile = page.tilewidth * page.tilelength * page.tiledepth * page.samplesperpixel * sample_bytes
    return Header(
        "TIFF",
        int(page.imagewidth),  # a broken file may have several where one is meant
        int(page.imagelength),
        channels=int(page.samplesperpixel),
        sample_bytes=sample_bytes,
        slices=int(page.imagedepth),
        overhead=2 * tile,
    )


def _bits(page: Any) -> int:
    return page.bitspersample if isinstance(page.bitspersample, int) else max(page.bitspersample)


def read_deep_tiff(path: Path) -> tuple[Stored, int, bytes | None]:
    """The samples of a TIFF's picture, its orientation and its colour profile."""
    import tifffile

    with tifffile.TiffFile(path) as tiff:
        page = _main_page(tiff)
        if page.dtype is None or page.dtype.name not in ("uint16", "float16", "float32", "float64"):
            raise ImageError(
                f"expected 8-bit, 16-bit or float samples, got {_bits(page)}-bit {page.dtype}",
                name=path,
                zh=f"樣本應為 8 位、16 位或浮點數，這個檔案是 {_bits(page)} 位。",
            )
        orientation, icc = page.tags.get(ORIENTATION), page.tags.get(_ICC_TAG)
        profile = bytes(icc.value) if icc and isinstance(icc.value, bytes) else None
        stored = _tiff_colours(path, page, _tiff_samples(path, page), profile)
        is_cmyk = int(page.photometric) == _SEPARATED
        return stored, int(orientation.value) if orientation else 1, None if is_cmyk else profile


def upright_tiff(path: Path) -> tuple[io.BytesIO | None, int]:
    """The file with its orientation set to upright, and that orientation: Pillow 13 turns a TIFF twice.

    Its picture is the first of it. None instead of the file when it is so already.
    """
    import tifffile

    with tifffile.TiffFile(path) as tiff:
        page = _main_page(tiff)
        tag, data = page.tags.get(ORIENTATION), _begun_at(path, page)
        if tag is None or tag.value == 1:
            return (None if data is None else io.BytesIO(data)), 1
        data = bytearray(path.read_bytes()) if data is None else data
        struct.pack_into(f"{tiff.byteorder}H", data, tag.valueoffset, 1)
    return io.BytesIO(data), int(tag.value)


def _tiff_samples(path: Path, page: Any) -> Samples:
    ends = [a + b for a, b in zip(page.dataoffsets, page.databytecounts, strict=True)]
    if max(ends, default=0) > path.stat().st_size:
        raise ValueError("its samples lie beyond its end")
    try:
        _check_inflated_sizes(page)
        samples = np.asarray(page.asarray() if page.compression in _UNPACKED else _read_page(path, page))
    except (ValueError, KeyError) as error:
        if "imagecodecs" not in str(error):
            raise
        samples = _read_page(path, page)  # what needs a 26 MB wheel in tifffile
    if samples.ndim == 3 and samples.shape[-1] != page.samplesperpixel:
        samples = np.moveaxis(samples, 0, -1)  # planes stored one after the other
    return samples.astype(np.float32) if samples.dtype.kind == "f" else samples


def _read_page(path: Path, page: Any) -> Samples:
    data = _begun_at(path, page)
    return _read_opencv(path) if data is None else _decode_opencv(np.frombuffer(data, np.uint8))


def _check_inflated_sizes(page: Any) -> None:
    """Raise ValueError when a strip or tile unpacks to more than its size; tifffile would unpack it all."""
    if page.compression not in (*_DEFLATE, *_LZMA):
        return
    most = math.prod(page.chunks) * page.dtype.itemsize
    for start, size in zip(page.dataoffsets, page.databytecounts, strict=True):
        page.parent.filehandle.seek(start)
        packed = page.parent.filehandle.read(size)
        unpacker: Any = zlib.decompressobj() if page.compression in _DEFLATE else lzma.LZMADecompressor()
        if len(unpacker.decompress(packed, most + 1)) > most:
            raise ValueError("its strips hold more than the picture")


def _tiff_colours(path: Path, page: Any, samples: Samples, profile: bytes | None) -> Stored:
    kind = getattr(page.photometric, "name", str(page.photometric))
    colours = {"MINISBLACK": 1, "MINISWHITE": 1, "RGB": 3, "SEPARATED": 4}.get(kind)
    if colours is None:
        raise ImageError(
            f"expected a gray, RGB or CMYK TIFF, got {kind}",
            name=path,
            zh=f"TIFF 應為灰階、RGB 或 CMYK，這個檔案是 {kind}。",
        )
    channels = samples if samples.ndim == 3 else samples[:, :, None]
    inks, extra = channels[:, :, :colours], channels[:, :, colours:]
    if kind == "MINISWHITE":
        inks = full_scale(inks) - inks
    if kind == "SEPARATED":
        inks = cmyk_to_rgb(inks, profile, name=path)
    meanings = [int(m) for m in page.extrasamples]
    if extra.shape[2] and meanings and meanings[0] in (1, 2):  # 1 premultiplied, 2 straight
        joined = np.concatenate([inks, extra[:, :, :1]], axis=2)
        return split_alpha(joined, premultiplied=meanings[0] == 1)
    return split_alpha(inks)


# --- EXR -------------------------------------------------------------------------------------------


def exr_header(path: Path) -> Header:
    """The header of an EXR; its memory counts every channel of every part, since all are decoded."""
    with path.open("rb") as file:
        parts = list(_exr_parts(file.read(2**20), path))
    if not parts:
        raise ValueError("its header is cut short")
    (width, height), _ = parts[0]
    total = sum(max(columns, 0) * max(rows, 0) * channels for (columns, rows), channels in parts)
    pixels = max(width * height, 1)
    return Header("EXR", width, height, channels=4, sample_bytes=4, overhead=math.ceil(total - 16 * pixels))


def _exr_parts(data: bytes, path: Path) -> Iterator[tuple[tuple[int, int], float]]:
    """Width and height of each part, and the bytes of one pixel of all its channels."""
    (version,) = struct.unpack_from("<I", data, 4)
    at = 8
    while data[at : at + 1] not in (b"", b"\0"):
        attributes: dict[str, bytes] = {}
        while data[at : at + 1] != b"\0":
            name_end = data.index(b"\0", at)
            kind_end = data.index(b"\0", name_end + 1)
            (size,) = struct.unpack_from("<I", data, kind_end + 1)
            start = kind_end + 5
            attributes[data[at:name_end].decode("latin-1")] = data[start : start + size]
            at = start + size
        at += 1
        if b"deep" in attributes.get("type", b""):
            raise ImageError(
                "expected one value for each pixel, got an EXR with deep samples", name=path, zh=_NO_DEEP_ZH
            )
        left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"][:16])
        yield (right - left + 1, bottom - top + 1), _exr_pixel_bytes(attributes["channels"])
        if not version & _EXR_MULTIPART:
            return


def _exr_pixel_bytes(channels: bytes) -> float:
    total, at = 0.0, 0
    while channels[at : at + 1] not in (b"", b"\0"):
        at = channels.index(b"\0", at) + 1
        kind, _, across, down = struct.unpack_from("<iIii", channels, at)
        total += _EXR_SAMPLE_BYTES[kind] / (max(across, 1) * max(down, 1))
        at += 16
    return total


def read_exr(path: Path) -> tuple[Stored, int, None]:
    """The samples of an EXR, which is always upright and linear."""
    import OpenEXR

    with OpenEXR.File(str(path)) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    for name in ("RGBA", "RGB", "Y"):
        if name in channels:
            samples = np.asarray(channels[name], dtype=np.float32)
            return split_alpha(samples, premultiplied=True), 1, None
    found = ", ".join(sorted(channels))
    raise ImageError(
        f"expected EXR channels R, G, B or Y, found {found}",
        name=path,
        zh=f"EXR 應有 R、G、B 或 Y 通道，這個檔案有 {found}。",
    )
