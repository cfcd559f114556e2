"""The coefficients of a .ptm that is packed as JPEGs: PTM_FORMAT_JPEG_LRGB and PTM_FORMAT_JPEG_RGB.

Motta and Weinberger, "Compression of Polynomial Texture Maps", HPL-2000-143 (R.2); the lines of the header as
the published format 1.2 tells them. Each coefficient, and each colour of an LRGB, is a gray JPEG, rows from
the bottom. Before the JPEGs stand eight lines: the quality, then for each plane its transform (1: the plane
that it is predicted from is inverted), the two parts of a motion vector, its place in the order of decoding,
the plane that it is predicted from (-1: none), the bytes of its JPEG, and the bytes of the corrections that
follow its JPEG. A plane that is predicted holds its difference from the other one, 128 more, modulo 256. A
correction is a place, four bytes with the highest first, and the value that stands there.
"""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rumu.errors import ImageError
from rumu.rti.image import Bytes

_INVERTED = 1
_NONE = -1
_MIDDLE = 128
_CORRECTION = 5


@dataclass(frozen=True, slots=True)
class _Plane:
    """One line of each entry. jpeg, corrections: where their bytes stand in the file."""

    transform: int
    place: int
    predicted_from: int
    jpeg: slice
    corrections: slice


def read_jpeg_planes(data: bytes, start: int, count: int, shape: tuple[int, int], path: str | Path) -> Bytes:
    """The planes of a .ptm, (count, H, W), rows from the bottom as in the file.

    data: the file; start: where the lines about the JPEGs begin.
    Raises ImageError naming the file and what is wrong with it.
    """
    planes = _planes(data, start, count, path)
    found: dict[int, Bytes] = {}
    for number in sorted(range(count), key=lambda one: planes[one].place):
        plane, other = planes[number], planes[number].predicted_from
        values = _gray(data[plane.jpeg], number, shape, path)
        if other != _NONE:
            if other not in found:
                raise ImageError(f"expected plane {other} before plane {number} that it tells", name=path)
            told = 255 - found[other] if plane.transform == _INVERTED else found[other]
            values += told - np.uint8(_MIDDLE)  # modulo 256
        _correct(values.reshape(-1), data[plane.corrections], path)
        found[number] = values
    return np.stack([found[number] for number in range(count)])


def _planes(data: bytes, start: int, count: int, path: str | Path) -> list[_Plane]:
    header = re.compile(rb"\s*(-?\d{1,9})" + 7 * count * rb"[ \t\r\n]+(-?\d{1,9})" + rb"[ \t]*\r?\n")
    match = header.match(data, start)
    if match is None:
        raise ImageError(f"expected 7 x {count} numbers about its JPEGs", name=path)
    numbers = np.array([int(one) for one in match.groups()[1:]]).reshape(7, count)
    transforms, across, up, order, references, sizes, corrections = numbers
    if across.any() or up.any() or not np.isin(transforms, (0, _INVERTED)).all():
        raise ImageError("expected planes without motion vectors, inverted or not, got others", name=path)
    sound = sorted(order) == list(range(count)) and (references >= _NONE).all() and (references < count).all()
    if not sound or (sizes <= 0).any() or (corrections < 0).any() or (corrections % _CORRECTION).any():
        raise ImageError(f"expected the order, the references and the sizes of {count} JPEGs", name=path)
    ends = match.end() + np.cumsum(sizes + corrections)
    if ends[-1] > len(data):
        raise ImageError(f"expected {ends[-1]} bytes in all, got {len(data)}", name=path)
    return [
        _Plane(
            int(transforms[k]), int(order[k]), int(references[k]),
            slice(end - corrections[k] - sizes[k], end - corrections[k]), slice(end - corrections[k], end),
        )
        for k, end in enumerate(ends)
    ]  # fmt: skip


def _gray(jpeg: bytes, number: int, shape: tuple[int, int], path: str | Path) -> Bytes:
    """(H, W) of one gray JPEG."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(jpeg), formats=["JPEG"]) as picture:
            if picture.mode == "L" and picture.size == shape[::-1]:
                return np.array(picture)
            got = f"{picture.size[0]} x {picture.size[1]} pixels of {picture.mode}"
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise ImageError(f"expected a JPEG as plane {number} ({error})", name=path) from error
    raise ImageError(f"expected {shape[1]} x {shape[0]} gray pixels in plane {number}, got {got}", name=path)


def _correct(values: Bytes, corrections: bytes, path: str | Path) -> None:
    """Put single values in their places; `values`, (H * W,), change."""
    listed = np.frombuffer(corrections, np.dtype([("place", ">u4"), ("value", "u1")]))
    if listed.size and listed["place"].max() >= values.size:
        raise ImageError(f"expected corrections of {values.size} pixels, got one beyond them", name=path)
    values[listed["place"]] = listed["value"]
