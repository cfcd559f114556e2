"""JPEG files that end a few bytes early: they are read when no row of pixels is missing.

A decoder that runs out of data leaves the rest of the picture in one gray, which must not be taken for ink.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rumu.capture.stored import Samples

_END = b"\xff\xd9"
_ONES = b"\xff\x00" * 32  # bits that data would have to go on with for nothing to be missing
_UNIT = 16  # largest side of a unit that a JPEG is coded in, in pixels
_GRAY = 128  # of units that no data have come for
_START_OF_SCAN, _RESTARTS = 0xDA, range(0xD0, 0xD8)
_PROGRESSIVE = (0xC2, 0xC6, 0xCA, 0xCE)


def complete_jpeg(data: bytes) -> tuple[bytes, bytes]:
    """A JPEG that was cut short, with its end mark, and once more with other bits before it.

    Pixels that differ between the two are not in the data. Raises ValueError for a progressive JPEG without
    its last scan.

    A progressive JPEG refines the whole picture scan by scan, so that its rows are all there, and blurred, as
    long as the last scan, which adds one bit, has begun.
    """
    finest: dict[tuple[int, int], int] = {}
    components, is_progressive, refines = 0, False, False
    for marker, body in _segments(data):
        if marker in _PROGRESSIVE:
            is_progressive, components = True, body[5]
        if marker == _START_OF_SCAN and is_progressive:
            count = body[0]
            first, last, bits = body[1 + 2 * count : 4 + 2 * count]
            refines = bits >> 4 > 0
            for component in body[1 : 1 + 2 * count : 2]:
                finest |= {(component, k): bits & 15 for k in range(first, last + 1)}
    complete = len(finest) == 64 * components and not any(finest.values())
    if is_progressive and not (complete and refines):
        raise ValueError("it ends before its last scan")
    return data + _END, data + (b"" if is_progressive else _ONES) + _END


def _segments(data: bytes) -> Iterator[tuple[int, bytes]]:
    """The markers of a JPEG that have a length, and what they hold."""
    at = 2
    while 0 <= at < len(data) - 4:
        marker = data[at + 1]
        if data[at] != 0xFF or marker in (0x00, 0xFF, *_RESTARTS):
            at = data.find(b"\xff", at + 1)  # samples of a scan
            continue
        end = at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        yield marker, data[at + 4 : end]
        at = end


def fill_missing_end(samples: Samples, other: Samples) -> Samples:
    """The picture with what is missing at the end of its last rows continued from above.

    samples, other: (H, W) or (H, W, 3) uint8, as the two files of `complete_jpeg` are decoded. Raises
    ValueError when a whole row of pixels is missing.
    """
    height, width = samples.shape[:2]
    last = samples[-_UNIT:].reshape(-1, width, samples[0, 0].size)
    differs = (last != other[-_UNIT:].reshape(last.shape)).any(axis=2)
    end = np.flatnonzero(~(last[-1] == _GRAY).all(axis=1))  # columns of the last row that are not that gray
    first = min(
        int(np.argmax(differs.any(axis=0))) if differs.any() else width, int(end[-1]) + 1 if len(end) else 0
    )
    if first == 0 or (samples != other)[:-_UNIT].any():
        raise ValueError("it ends before its last rows")
    if first == width:
        return samples
    gray_or_differs = differs | (last == _GRAY).all(axis=2)
    rows = np.flatnonzero(~gray_or_differs[:, first:].any(axis=1))
    top = height - len(last) + (int(rows[-1]) + 1 if len(rows) else 0)
    filled = samples.copy()
    filled[top:, first:] = samples[max(top - 1, 0), first:]
    return filled
