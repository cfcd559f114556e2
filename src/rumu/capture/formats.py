"""One decoder per file format: a file becomes its stored samples, with nothing rescaled.

The kind of a file is read from its first bytes, never from its name. Its size and the memory that it will
take are counted from the header, before a single pixel is decoded. Pillow reads everything of 8 bits and
notices truncated files; what has more is read in `deep_formats`. Colours come out as sRGB, whatever profile a
file has.
"""

from __future__ import annotations

import io
import math
import os
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from rumu.capture import deep_formats as deep
from rumu.capture.colours import ProfileWarning, cmyk_to_rgb, is_for_screen, profile_of, to_srgb
from rumu.capture.cut_jpeg import complete_jpeg, fill_missing_end
from rumu.capture.decoded_size import FULL_SIZE, Header, Reduction, check_header, too_many_pixels
from rumu.capture.stored import Stored, reduce_stored, split_alpha, turn_upright, valid_orientation
from rumu.errors import ImageError, RumuError
from rumu.inputs import is_kernel_file, path_of

Encoding = Literal["auto", "linear", "srgb"]
ENCODINGS: tuple[Encoding, ...] = get_args(Encoding)

_PILLOW_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "PPM")  # JPEG opens MPO, too
DISPLAY_FORMATS = ("JPEG", "MPO", "WEBP", "AVIF", "HEIF")
"""Those that are always written for a screen: display-encoded."""
_FORMATS = "PNG, JPEG, WebP, HEIC, AVIF, BMP, GIF, PPM, TIFF or EXR"
_EXPECTED = f"expected an image ({_FORMATS})"
_EXPECTED_ZH = f"需要圖片檔（{_FORMATS.replace(' or ', ', ').replace(', ', '、')}）"
RAW_SUFFIXES = (".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".orf", ".rw2", ".pef")
"""Of the raw files of cameras, which are not read."""
_TIFF_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_EXR_MAGIC = b"v/1\x01"
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_JPEG_MAGIC = b"\xff\xd8\xff"
_READ_MAGIC = (_PNG_MAGIC, _JPEG_MAGIC, b"RIFF", b"GIF8", *_TIFF_MAGIC, _EXR_MAGIC)
_OTHER_KINDS = {
    b"%PDF": "a PDF",
    b"8BPS": "a Photoshop file",
    b"PK\x03\x04": "a zip file",
    b"\0\0\0\x0cjP  ": "a JPEG 2000 picture",
    b"\0\0\0\x0cJXL ": "a JPEG XL picture",
    b"\xff\x0a": "a JPEG XL picture",
    b"<svg": "an SVG drawing",
    b"<?xml": "an XML file",
}
_HEIF_BRANDS = frozenset(
    {b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"hevm", b"hevs", b"mif1", b"msf1"}
)
_AVIF_BRANDS = frozenset({b"avif", b"avis"})
_SAMPLE_BYTES = {"I": 4, "F": 4}  # by Pillow's mode; 'I;16' and its kin have 2, the others 1
_DECODER_BYTES = {"WEBP": 8, "AVIF": 8, "HEIF": 8}  # of a pixel, that decoders need besides
_PIXELS_AT_A_TIME = 4_000_000  # handed over by Pillow
_PICTURE = "the path of a picture, or a numpy array of shape (H, W) or (H, W, 3)"
_MAX_SCANS = 100  # of a progressive JPEG; each goes over the whole picture, and cameras write ten
_SCAN_OF_JPEG = b"\xff\xda"

Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class _Wish:
    """What is wanted of a picture: how far it is reduced, and whether it becomes floats."""

    reduction: Reduction
    floats: bool

    def check(self, header: Header, path: Path) -> None:
        """Raise ImageError when that takes more than it may."""
        check_header(header, path, reduction=self.reduction, floats=self.floats)


Reading = tuple[Stored, int, bytes | None]
"""Samples as they lie in the file, its orientation (EXIF) and its colour profile (ICC)."""


def decode(
    path: str | os.PathLike[str],
    *,
    upright: bool = True,
    encoding: Encoding = "srgb",
    reduction: Reduction = FULL_SIZE,
    floats: bool = True,
) -> Stored:
    """The stored samples of an image file, turned as its orientation says unless `upright` is False.

    encoding: by which samples are taken as colours for a screen, which a colour profile then brings to sRGB:
        'srgb' all, 'auto' those of formats that are always written for a screen and those whose profile says
        that they are, 'linear' none.
    reduction: a large picture is reduced by area averaging, and a JPEG already while it is decoded.
    floats: whether memory for a float image is counted, too.
    Raises ImageError, naming the file, when it is missing, a folder, empty, cut short, no image, a camera's
    raw file, smaller than MIN_SIDE, larger than MAX_PIXELS or than RUMU_MAX_DECODED_MB once decoded; and when
    `path` is no path.
    """
    path = path_of(path, error_type=ImageError, expected=_PICTURE)

    def read(head: bytes) -> Stored:
        stored, orientation, profile = _read(path, head, _Wish(reduction, floats))
        if not all(stored.whole):
            stored = replace(stored, whole=stored.values.shape[1::-1])
        stored = replace(stored, orientation=valid_orientation(orientation))
        if encoding == "auto" and stored.values.dtype.kind == "u" and is_for_screen(profile):
            stored = replace(stored, display=True)
        if encoding == "srgb" or (encoding == "auto" and stored.display):
            stored = replace(stored, values=to_srgb(stored.values, profile, name=path))
        stored = reduce_stored(stored, reduction)
        return turn_upright(stored) if upright else stored

    return _without_surprises(path, read)


def read_header(path: str | os.PathLike[str]) -> Header:
    """What the header of an image file says; nothing is decoded, and the size is not judged.

    Raises ImageError, naming the file, when it has no header of an image.
    """
    path = Path(path)
    return _without_surprises(path, lambda head: _header(path, head))


def _without_surprises(path: Path, read: Callable[[bytes], Answer]) -> Answer:
    """What `read` makes of a file, given its first bytes; whatever goes wrong with it is an ImageError."""
    head = _first_bytes(path)
    try:
        with warnings.catch_warnings():
            # Pillow warns of sizes and odd metadata: the size is judged here, metadata is not the picture.
            warnings.simplefilter("ignore")
            warnings.simplefilter("default", ProfileWarning)
            return read(head)
    except RumuError:
        raise
    except Exception as error:  # decoders raise nearly anything on broken files
        raise _as_image_error(path, head, error) from error


# --- which file it is ------------------------------------------------------------------------------


def _first_bytes(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise ImageError(
                "expected an image file, found a folder", name=path, zh="需要圖片檔，這是資料夾。"
            )
        if path.exists() and (not path.is_file() or is_kernel_file(path)):  # which may have no end
            raise ImageError(
                "expected an image file, found a device or a pipe",
                name=path,
                zh="需要圖片檔，這是裝置或管道。",
            )
        with path.open("rb") as file:
            head = file.read(64)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise ImageError(
            f"{_EXPECTED}, cannot open it ({reason})", name=path, zh=f"{_EXPECTED_ZH}，打不開（{reason}）。"
        ) from error
    if not head:
        raise ImageError(f"{_EXPECTED}, the file is empty", name=path, zh=f"{_EXPECTED_ZH}，這個檔案是空的。")
    if path.suffix.lower() in RAW_SUFFIXES:
        raise ImageError(
            "camera raw is not read; develop it to a linear 16-bit TIFF first",
            name=path,
            zh="不讀相機原始檔；請先轉成線性的 16 位 TIFF。",
        )
    return head


def _container_format(head: bytes) -> str | None:
    """HEIF or AVIF, by the brands of an ISO container; None for what is none or holds something else."""
    if head[4:8] != b"ftyp":
        return None
    size = min(int.from_bytes(head[:4], "big"), len(head))
    brands = [head[8:12], *(head[at : at + 4] for at in range(16, size, 4))]
    if _AVIF_BRANDS.intersection(brands):
        return "AVIF"
    return "HEIF" if _HEIF_BRANDS.intersection(brands) else None


def _pillow_formats(path: Path, head: bytes) -> tuple[str, ...]:
    """The formats that Pillow is to try. Raises ImageError where it lacks what the file needs."""
    container = _container_format(head)
    if container is None:
        return _PILLOW_FORMATS
    from PIL import features

    if container == "AVIF" and not features.check("avif"):
        raise ImageError(
            "this is an AVIF picture, which needs Pillow 11.3 or newer with AVIF; "
            "install that, or save it as a JPEG",
            name=path,
            zh="這是 AVIF 圖片，需要支援 AVIF 的 Pillow 11.3 以上；請安裝，或把圖片另存為 JPEG。",
        )
    if container == "HEIF":
        try:
            from pillow_heif import register_heif_opener
        except ImportError as error:
            raise ImageError(
                "this is an HEIC picture, which needs pillow-heif: pip install 'rumu[heif]'; or save it as a "
                "JPEG (on an iPhone: Settings, Camera, Formats, Most Compatible)",
                name=path,
                zh="這是 HEIC 圖片，需要 pillow-heif：pip install 'rumu[heif]'；或另存為 JPEG"
                "（iPhone：設定、相機、格式、最相容）。",
            ) from error
        register_heif_opener()
    return (container,)


def _is_deep_png(head: bytes) -> bool:
    return head.startswith(_PNG_MAGIC) and head[24:25] == b"\x10" and head[25] in (2, 4, 6)


def _header(path: Path, head: bytes) -> Header:
    if head.startswith(_EXR_MAGIC):
        return deep.exr_header(path)
    if head.startswith(_TIFF_MAGIC):
        return deep.tiff_header(path)
    if _is_deep_png(head):
        return deep.deep_png_header(path)
    from PIL import Image

    with Image.open(path, formats=_pillow_formats(path, head)) as image:
        return _pillow_header(image)


def _as_image_error(path: Path, head: bytes, error: Exception) -> ImageError:
    from PIL import Image, UnidentifiedImageError

    if isinstance(error, Image.DecompressionBombError):
        pixels = re.search(r"\((\d+) pixels\)", str(error))
        return too_many_pixels(path, int(pixels[1]) if pixels else 2 * Image.MAX_IMAGE_PIXELS)
    is_known = head.startswith(_READ_MAGIC) or _container_format(head)
    if isinstance(error, UnidentifiedImageError) and not is_known:
        found = next((kind for magic, kind in _OTHER_KINDS.items() if head.startswith(magic)), None)
        found = found or f"something else (it starts with {head[:12]!r})"
        return ImageError(f"{_EXPECTED}, found {found}", name=path, zh=f"{_EXPECTED_ZH}，這個檔案不是。")
    detail = f"{type(error).__name__}: {error}".splitlines()[0].replace(str(path), path.name)
    kind = {"HEIF": "HEIC ", "AVIF": "AVIF "}.get(_container_format(head) or "", "")
    return ImageError(
        f"the {kind}image is cut short or broken ({detail})",
        name=path,
        zh=f"{kind}圖片檔不完整或已損壞；請重新傳送或另存一次。",
    )


# --- decoders ----------------------------------------------------------------------------------------


def _read(path: Path, head: bytes, wish: _Wish) -> Reading:
    """The samples of a file, once its header is found to be in order."""
    is_tiff = head.startswith(_TIFF_MAGIC)
    if not (is_tiff or head.startswith(_EXR_MAGIC) or _is_deep_png(head)):
        return _read_pillow(path, formats=_pillow_formats(path, head), wish=wish)
    wish.check(_header(path, head), path)
    if is_tiff and not deep.is_deep_tiff(path):
        source, orientation = deep.upright_tiff(path)
        stored, _, profile = _read_pillow(path, formats=("TIFF",), wish=wish, source=source)
        return stored, orientation, profile
    if is_tiff:
        return deep.read_deep_tiff(path)
    return deep.read_deep_png(path) if _is_deep_png(head) else deep.read_exr(path)


def _read_pillow(
    path: Path, *, formats: tuple[str, ...], wish: _Wish, source: io.BytesIO | None = None
) -> Reading:
    from PIL import Image

    with Image.open(source or path, formats=formats) as image:
        header = _pillow_header(image)
        is_jpeg = header.format in ("JPEG", "MPO")
        if is_jpeg:
            _check_scans(path, image)
            factor = wish.reduction.factor(*image.size)
            image.draft(None, tuple(math.ceil(side * factor) for side in image.size))
            drawn = image.width * image.height / max(header.width * header.height, 1)
            header = replace(header, sample_bytes=drawn)
        wish.check(header, path)
        try:
            image.load()
        except OSError:
            if not is_jpeg:
                raise
            return _read_cut_jpeg(path)
        stored, orientation, profile = _pillow_samples(path, image)
    whole = (header.width, header.height)
    return replace(stored, display=header.format in DISPLAY_FORMATS, whole=whole), orientation, profile


def _read_cut_jpeg(path: Path) -> Reading:
    """A JPEG that lacks a few bytes at its end."""
    from PIL import Image

    readings = []
    for data in complete_jpeg(path.read_bytes()):
        with Image.open(io.BytesIO(data), formats=("JPEG",)) as image:
            image.load()
            readings.append(_pillow_samples(path, image))
    (stored, orientation, profile), (other, _, _) = readings
    values = fill_missing_end(stored.values, other.values)
    return replace(stored, values=values, display=True), orientation, profile


def _pillow_header(image: Any) -> Header:
    bands = len(image.getbands())
    overhead = _DECODER_BYTES.get(image.format, 0) * image.width * image.height
    if image.info.get("progressive"):
        overhead = 2 * bands * image.width * image.height  # its coefficients stay in memory to the end
    sample_bytes = _SAMPLE_BYTES.get(image.mode, 2 if image.mode.startswith("I;16") else 1)
    channels = 4 if image.has_transparency_data else 3 if image.mode in ("P", "PA") else bands
    return Header(
        image.format,
        image.width,
        image.height,
        channels=channels,
        sample_bytes=sample_bytes,
        overhead=overhead,
    )


def _check_scans(path: Path, image: Any) -> None:
    if image.info.get("progressive") and (scans := path.read_bytes().count(_SCAN_OF_JPEG)) > _MAX_SCANS:
        raise ImageError(
            f"expected a JPEG of at most {_MAX_SCANS} scans, got {scans}",
            name=path,
            zh=f"JPEG 最多 {_MAX_SCANS} 次掃描，這個檔案有 {scans} 次。",
        )


def _pillow_samples(path: Path, image: Any) -> Reading:
    mode: str = image.mode
    orientation, profile = image.getexif().get(deep.ORIENTATION, 1), profile_of(image)
    if mode == "CMYK":
        return Stored(cmyk_to_rgb(np.asarray(image), profile, name=path)), orientation, None
    if mode.startswith("I"):
        samples = np.asarray(image)
        low, high = int(samples.min()), int(samples.max())
        if low < 0 or high > 65535:
            raise ImageError(
                f"expected 8-bit, 16-bit or float samples, got values from {low} to {high}",
                name=path,
                zh=f"樣本應為 8 位、16 位或浮點數，這個檔案的值從 {low} 到 {high}。",
            )
        return Stored(samples.astype(np.uint16)), orientation, profile
    if mode == "F":
        return Stored(np.asarray(image, dtype=np.float32)), orientation, profile
    if mode in ("1", "L", "LA", "La"):
        wanted = "LA" if "A" in image.getbands() or mode == "La" or "transparency" in image.info else "L"
    else:
        wanted = "RGBA" if image.has_transparency_data else "RGB"
    return split_alpha(_array_of(image, wanted)), orientation, profile


def _array_of(image: Any, mode: str) -> Any:
    """The samples of a Pillow image in a mode, (H, W) or (H, W, C) uint8.

    Some rows at a time, because Pillow copies twice what it hands over.
    """
    channels = () if mode == "L" else (len(mode),)
    samples = np.empty((image.height, image.width, *channels), np.uint8)
    step = max(1, _PIXELS_AT_A_TIME // image.width)
    for top in range(0, image.height, step):
        rows = image.crop((0, top, image.width, min(top + step, image.height)))
        samples[top : top + step] = rows if rows.mode == mode else rows.convert(mode)
    return samples
