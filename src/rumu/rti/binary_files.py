"""The two binary files of the RTI trade, as RTIViewer reads them; both are little-endian.

.ptm    Malzbender and Gelb, "Polynomial Texture Map (.ptm) File Format", version 1.2 (Hewlett-Packard 2001).
        Lines of text: PTM_1.2; PTM_FORMAT_LRGB or PTM_FORMAT_RGB; width and height; six scales; six biases.
        Then bytes, rows from the bottom: of LRGB all coefficients, then all colours; of RGB the
        coefficients of red, then of green, then of blue. A coefficient is scale * (byte - bias), and 255 is
        white. JPEG_LRGB and JPEG_RGB hold a JPEG of each, see `rumu.rti.compressed_ptm`.
.rti    Cultural Heritage Imaging's universal RTI, hemispherical harmonics (type 3). Lines of text: #HSH1.2;
        3; width, height and 3 channels; terms, 2 and 1. For 4, 9 and 16 terms their order may stand, as
        RTIViewer reads it. Then float32 scales and biases, one for each term, and bytes, rows from the top:
        for each pixel the coefficients of red, green and blue. A coefficient is byte / 255 * scale + bias,
        and 1 is white.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from rumu.errors import ImageError
from rumu.inputs import read_file
from rumu.outputs import whole_file
from rumu.rti.compressed_ptm import read_jpeg_planes
from rumu.rti.image import TERMS, Bytes, RtiImage
from rumu.values import FloatArray

_NUMBER = rb"[ \t\r\n]+([-+.\deE]+)"
_PTM = re.compile(
    rb"PTM_(1\.[12])[ \t]*\r?\nPTM_FORMAT_(\w+)" + 2 * rb"[ \t\r\n]+(\d+)" + 12 * _NUMBER + rb"[ \t]*\r?\n"
)
_HSH = re.compile(rb"(?:#[^\n]*\n)+\s*(\d+)\s+(\d+)\s+(\d+)\s+(\d+)\s+(\d+)\s+(\d+)\s+(\d+)[ \t]*\r?\n")
_LONGEST_HEADER = 4096
_PTM_KINDS = ("LRGB", "RGB", "JPEG_LRGB", "JPEG_RGB")
_TERMS_OF_ORDER = {1: 4, 2: 9, 3: 16}
_LINES = "\r\n"  # of .rti, as the first program that wrote it; .ptm has \n


def write_ptm(image: RtiImage, path: str | Path) -> None:
    """Write a polynomial texture map as a .ptm; it appears whole or not at all.

    Raises ImageError for harmonics, and for channels of different scales; OutputError when it cannot be
    written.
    """
    if image.basis != "ptm":
        raise ImageError("expected a polynomial for a .ptm, got harmonics; write a .rti", name=path)
    scale, bias = _of_all_channels(image, path)
    height, width, channels, _ = image.coefficients.shape
    header = [
        "PTM_1.2",
        "PTM_FORMAT_LRGB" if channels == 1 else "PTM_FORMAT_RGB",
        f"{width}",
        f"{height}",
        " ".join(f"{255 * one:.9g}" for one in scale),
        " ".join(f"{one:.0f}" for one in bias),
    ]
    if not np.allclose(bias, np.round(bias), atol=1e-6):
        raise ImageError("expected biases that are whole numbers, as a .ptm holds them", name=path)
    with whole_file(path) as part, part.open("wb") as file:
        file.write(("\n".join(header) + "\n").encode("ascii"))
        for channel in range(channels):
            for row in image.coefficients[::-1, :, channel]:
                file.write(row.tobytes())
        if image.colour is not None:
            for row in image.colour[::-1]:
                file.write(row.tobytes())


def write_hsh(image: RtiImage, path: str | Path) -> None:
    """Write harmonics as a .rti; it appears whole or not at all.

    Raises ImageError for a polynomial, for a colour under one luminance, which it cannot hold, and for
    channels of different scales; OutputError when it cannot be written.
    """
    if image.basis != "hsh" or image.colour is not None:
        raise ImageError("expected harmonics of each channel for a .rti, got others", name=path)
    scale, bias = _of_all_channels(image, path)
    height, width, channels, terms = image.coefficients.shape
    header = ["#HSH1.2", "3", f"{width} {height} {channels}", f"{terms} 2 1", ""]
    with whole_file(path) as part, part.open("wb") as file:
        file.write(_LINES.join(header).encode("ascii"))
        file.write((255 * scale).astype("<f4").tobytes())
        file.write((-bias * scale).astype("<f4").tobytes())
        for row in image.coefficients:
            file.write(row.tobytes())


def read_ptm(path: str | Path) -> RtiImage:
    """A .ptm of version 1.1 or 1.2 with one luminance and a colour (LRGB), or three channels (RGB).

    Packed as JPEGs (JPEG_LRGB, JPEG_RGB) or not.

    Raises ImageError naming the file and what is wrong with it.
    """
    data = read_file(path, error_type=ImageError, expected="a .ptm file")
    header = _PTM.match(data[:_LONGEST_HEADER])
    if header is None:
        raise ImageError("expected a polynomial texture map, PTM_1.2, with its header", name=path)
    version, kind, wide, high, *numbers = (one.decode("ascii") for one in header.groups())
    if kind not in _PTM_KINDS:
        raise ImageError(
            f"expected PTM_FORMAT_{', PTM_FORMAT_'.join(_PTM_KINDS)}, got PTM_FORMAT_{kind}", name=path
        )
    width, height = int(wide), int(high)
    scale, bias = _levels(numbers, path)
    of_channels = kind.endswith("_RGB") or kind == "RGB"
    if kind.startswith("JPEG"):
        count = 18 if of_channels else 9
        planes = read_jpeg_planes(data, header.end(), count, (height, width), path)
        stored, colour = _of_planes(planes[:, ::-1], of_channels=of_channels)
    else:
        body = _body(data, header.end(), width * height * (18 if of_channels else 9), path)
        stored, colour = _of_pixels(body, (height, width), of_channels=of_channels, version=version)
    channels = stored.shape[2]
    return RtiImage("ptm", stored, np.tile(scale / 255, (channels, 1)), np.tile(bias, (channels, 1)), colour)


def _of_planes(planes: Bytes, *, of_channels: bool) -> tuple[Bytes, Bytes | None]:
    """Coefficients (H, W, C, 6) and the colour (H, W, 3) of planes, (9 or 18, H, W)."""
    channels = 3 if of_channels else 1
    sixes = planes[: 6 * channels].reshape(channels, 6, *planes.shape[1:])
    colour = None if of_channels else np.ascontiguousarray(planes[6:].transpose(1, 2, 0))
    return np.ascontiguousarray(sixes.transpose(2, 3, 0, 1)), colour


def _of_pixels(
    body: Bytes, shape: tuple[int, int], *, of_channels: bool, version: str
) -> tuple[Bytes, Bytes | None]:
    """Coefficients (H, W, C, 6) and the colour (H, W, 3) of a .ptm without JPEGs, rows from the top."""
    if of_channels:
        planes = body.reshape(3, *shape, 6)[:, ::-1]
        return np.ascontiguousarray(planes.transpose(1, 2, 0, 3)), None
    if version == "1.1":  # the colour stands behind the coefficients of each pixel
        pixels = body.reshape(*shape, 9)[::-1]
        return pixels[:, :, None, :6].copy(), pixels[:, :, 6:].copy()
    split = 6 * shape[0] * shape[1]
    first, last = body[:split].reshape(*shape, 1, 6)[::-1], body[split:].reshape(*shape, 3)[::-1]
    return first.copy(), last.copy()


def read_hsh(path: str | Path) -> RtiImage:
    """A .rti of hemispherical harmonics with 4, 9 or 16 terms for each of three channels.

    Raises ImageError naming the file and what is wrong with it.
    """
    data = read_file(path, error_type=ImageError, expected="a .rti file")
    header = _HSH.match(data[:_LONGEST_HEADER])
    if header is None:
        raise ImageError("expected an RTI file, #HSH1.2, with its header", name=path)
    kind, width, height, channels, terms, basis, size = (int(one) for one in header.groups())
    terms = _TERMS_OF_ORDER.get(terms, terms)
    if kind != 3:
        raise ImageError(f"expected hemispherical harmonics (type 3), got type {kind}", name=path)
    if (channels, basis, size) != (3, 2, 1) or terms not in TERMS["hsh"]:
        raise ImageError(
            f"expected 3 channels of 4, 9 or 16 terms, RGB (2), of one byte, got {channels} channels of "
            f"{terms} terms, basis {basis}, {size} bytes",
            name=path,
        )
    numbers = _body(data[: header.end() + 8 * terms], header.end(), 8 * terms, path).view("<f4")
    scale, bias = numbers[:terms].astype(np.float64), numbers[terms:].astype(np.float64)
    if not (np.isfinite(numbers).all() and (scale != 0).all()):
        raise ImageError("expected scales and biases that are finite, and scales that are not 0", name=path)
    body = _body(data, header.end() + 8 * terms, width * height * 3 * terms, path)
    stored = body.reshape(height, width, 3, terms).copy()
    return RtiImage("hsh", stored, np.tile(scale / 255, (3, 1)), np.tile(-255 * bias / scale, (3, 1)))


def _of_all_channels(image: RtiImage, path: str | Path) -> tuple[FloatArray, FloatArray]:
    """(K,) scale and bias, which these files have once for all channels."""
    if not (np.allclose(image.scale, image.scale[0]) and np.allclose(image.bias, image.bias[0])):
        raise ImageError("expected channels of one scale and bias, as such a file holds them", name=path)
    return image.scale[0], image.bias[0]


def _levels(numbers: list[str], path: str | Path) -> tuple[FloatArray, FloatArray]:
    try:
        values = np.array([float(one) for one in numbers])
    except ValueError as error:
        raise ImageError(f"expected six scales and six biases, got {' '.join(numbers)}", name=path) from error
    if not np.isfinite(values).all():
        raise ImageError(f"expected finite scales and biases, got {' '.join(numbers)}", name=path)
    return values[:6], values[6:]


def _body(data: bytes, start: int, size: int, path: str | Path) -> Bytes:
    """What follows the header; a file that was cut is refused."""
    if size == 0 or len(data) - start < size:
        raise ImageError(f"expected {size} bytes behind the header, got {len(data) - start}", name=path)
    return np.frombuffer(data, np.uint8, size, start)
