"""PNGs written some rows at a time, each band packed by a thread of its own: for pictures of many megapixels.

A PNG holds one stream of compressed bytes, but such a stream may be put together from parts that begin anew
(a full flush). So bands of rows are made, filtered and packed side by side, and nothing of the size of the
picture exists but the file.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Samples = npt.NDArray[Any]

_BAND = 500_000
"""Pixels that a thread packs at a time."""
_AHEAD = 2
"""Bands for each thread that may be packed before they are written."""
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_STREAM = b"\x78\x01"  # a zlib stream, packed quickly
_GRAY, _COLOUR = 0, 2  # kinds of colour, as the header numbers them
_SUB = 1  # the filter that takes from each byte that of the pixel on its left
_ADLER = 65521


def write_png_bands(
    path: Path, shape: tuple[int, ...], dtype: npt.DTypeLike, band: Callable[[slice], Samples]
) -> None:
    """Write a PNG, quickly rather than small.

    shape: (H, W) gray or (H, W, 3) in colour. dtype: uint8 or uint16. band: makes some rows, (h, W[, 3]), R G
    B; called by several threads. Raises OSError where it cannot be written.
    """
    height, width = shape[:2]
    kind = np.dtype(dtype)
    step = max(1, _BAND // width)
    parts = [slice(top, min(top + step, height)) for top in range(0, height, step)]

    def packed(rows: slice) -> tuple[bytes, int, int]:
        return _packed(_filtered(band(rows).astype(kind.newbyteorder(">"), copy=False)), rows.stop == height)

    with path.open("wb") as file:
        file.write(_SIGNATURE)
        colour = _GRAY if len(shape) == 2 else _COLOUR
        _write_chunk(
            file.write, b"IHDR", struct.pack(">IIBBBBB", width, height, 8 * kind.itemsize, colour, 0, 0, 0)
        )
        _write_chunk(file.write, b"IDAT", _STREAM)
        check = 1
        for content, part_check, length in _in_order(packed, parts):
            _write_chunk(file.write, b"IDAT", content)
            check = _joined(check, part_check, length)
        _write_chunk(file.write, b"IDAT", struct.pack(">I", check))
        _write_chunk(file.write, b"IEND", b"")


def _in_order(
    work: Callable[[slice], tuple[bytes, int, int]], parts: list[slice]
) -> Iterator[tuple[bytes, int, int]]:
    """What threads make of each part, in order, of which few wait at a time."""
    threads = os.cpu_count() or 1
    waiting: deque[Future[tuple[bytes, int, int]]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        for part in parts:
            waiting.append(pool.submit(work, part))
            if len(waiting) > _AHEAD * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _filtered(rows: Samples) -> npt.NDArray[np.uint8]:
    """(h, 1 + bytes of a row) uint8: the rows, each byte less that of the pixel on its left.

    rows: (h, W) or (h, W, 3), the higher byte first.
    """
    pixel = rows.dtype.itemsize * int(np.prod(rows.shape[2:], dtype=int))
    samples = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), -1)
    out = np.empty((samples.shape[0], samples.shape[1] + 1), np.uint8)
    out[:, 0] = _SUB
    out[:, 1 : 1 + pixel] = samples[:, :pixel]
    np.subtract(samples[:, pixel:], samples[:, :-pixel], out=out[:, 1 + pixel :])
    return out


def _packed(filtered: npt.NDArray[np.uint8], last: bool) -> tuple[bytes, int, int]:
    """A part of the stream, the checksum of what it holds, and how many bytes that are."""
    # Only runs of one byte are looked for: there are no other matches in noise.
    packer = zlib.compressobj(1, zlib.DEFLATED, -zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_RLE)
    content = packer.compress(filtered.data) + packer.flush(zlib.Z_FINISH if last else zlib.Z_FULL_FLUSH)
    return content, zlib.adler32(filtered.data), filtered.size


def _joined(before: int, after: int, length: int) -> int:
    """The Adler-32 checksum of two parts, by those of each; length: bytes of the second."""
    low, low_after = before & 0xFFFF, after & 0xFFFF
    first = (low + low_after - 1) % _ADLER
    second = ((before >> 16) + (after >> 16) + length * (low - 1)) % _ADLER
    return second << 16 | first


def _write_chunk(write: Callable[[bytes], object], name: bytes, content: bytes) -> None:
    write(struct.pack(">I", len(content)) + name)
    write(content)
    write(struct.pack(">I", zlib.crc32(content, zlib.crc32(name))))
