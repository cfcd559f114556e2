"""Polynomial texture maps packed as JPEGs, packed here as the published format tells it."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from rumu.errors import ImageError
from rumu.rti.exchange import read_rti
from rumu.rti.image import relight_rti

HEIGHT, WIDTH = 24, 33
SCALE = [1.5, 1.25, 1.0, 2.0, 2.0, 1.0]
BIAS = [128, 120, 130, 100, 90, 10]


def smooth_planes(count: int) -> np.ndarray:
    """(count, HEIGHT, WIDTH) uint8, rows from the top, of which every fifth is much like the one before."""
    y, x = np.mgrid[0 : 1 : HEIGHT * 1j, 0 : 1 : WIDTH * 1j]
    planes = [128 + 90 * np.sin(3 * x + k) * np.cos(2 * y - k) + 20 * (y - 0.5) for k in range(count)]
    for k in range(4, count, 5):
        planes[k] = planes[k - 1] + 10 * x
    return np.clip(planes, 0, 255).astype(np.uint8)


def jpeg(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(values)).save(file, "JPEG", quality=98)
    return file.getvalue()


def packed(planes: np.ndarray, *, predicted: dict[int, tuple[int, int]] | None = None, **changed) -> bytes:
    """A .ptm: `predicted` tells for some planes from which other they are predicted, and by which transform.

    Planes that are predicted are decoded last, and corrected where the sum leaves the range of a byte.
    """
    count, predicted = len(planes), predicted or {}
    first = [k for k in range(count) if k not in predicted]
    order = [0] * count
    for place, k in enumerate([*first, *predicted]):
        order[k] = place
    bottom = planes[:, ::-1]
    jpegs, corrections, shown = [b""] * count, [b""] * count, {}
    for k in [*first, *predicted]:
        wanted = bottom[k]
        if k in predicted:
            other, transform = predicted[k]
            told = 255 - shown[other] if transform else shown[other]
            residual = wanted.astype(int) - told + 128
            far = np.flatnonzero((residual < 4) | (residual > 251))
            corrections[k] = b"".join(int(i).to_bytes(4, "big") + bytes([wanted.reshape(-1)[i]]) for i in far)
            jpegs[k] = jpeg(np.clip(residual, 0, 255).astype(np.uint8))
        else:
            jpegs[k] = jpeg(wanted)
        stored = np.asarray(Image.open(io.BytesIO(jpegs[k]))).astype(int)
        shown[k] = stored if k not in predicted else (stored + told - 128) % 256
    entries = {
        "transforms": [predicted.get(k, (0, 0))[1] for k in range(count)],
        "across": [0] * count,
        "up": [0] * count,
        "order": order,
        "references": [predicted.get(k, (-1, 0))[0] for k in range(count)],
        "sizes": [len(one) for one in jpegs],
        "corrections": [len(one) for one in corrections],
    } | changed
    name = "PTM_FORMAT_JPEG_LRGB" if count == 9 else "PTM_FORMAT_JPEG_RGB"
    lines = ["PTM_1.2", name, f"{WIDTH}", f"{HEIGHT}", *(" ".join(map(str, one)) for one in (SCALE, BIAS))]
    lines += ["98", *(" ".join(map(str, one)) for one in entries.values())]
    body = b"".join(part for pair in zip(jpegs, corrections, strict=True) for part in pair)
    return "\n".join(lines).encode() + b"\n" + body


def shown_by_the_formula(planes: np.ndarray, u: float, v: float) -> np.ndarray:
    powers = [u * u, v * v, u * v, u, v, 1.0]
    sums = [
        sum(w * s * (p.astype(float) - b) for w, s, b, p in zip(powers, SCALE, BIAS, six, strict=True)) / 255
        for six in (planes[i : i + 6] for i in range(0, len(planes) - 5, 6))
    ]
    if len(planes) == 9:
        return np.clip(sums[0][..., None] * planes[6:].transpose(1, 2, 0) / 255, 0, 1)
    return np.clip(np.stack(sums, axis=2), 0, 1)


@pytest.mark.parametrize("count", [9, 18])
@pytest.mark.parametrize("predicted", [None, {1: (0, 0), 4: (3, 0), 5: (3, 1)}])
def test_jpegs_are_unpacked_as_the_format_says(tmp_path, count, predicted):
    planes = smooth_planes(count)
    (tmp_path / "a.ptm").write_bytes(packed(planes, predicted=predicted))
    image = read_rti(tmp_path / "a.ptm")
    assert (image.colour is None) == (count == 18)
    for u, v in ((0.0, 0.0), (0.5, -0.3), (-0.6, 0.6)):
        shown = relight_rti(image, (u, v, np.sqrt(1 - u * u - v * v)))
        off = np.abs(shown - shown_by_the_formula(planes, u, v))
        assert off.mean() < 0.01 and off.max() < 0.06  # JPEGs of quality 98, times the scales


def test_a_correction_is_taken(tmp_path):
    planes = smooth_planes(9)
    planes[1, 3, 5] = 255 - planes[1, 3, 5]
    planes[1, 10:14] = 255 - planes[0, 10:14]
    planes[0, 10:14, 8:20] = 2
    planes[1, 10:14, 8:20] = 253
    data = packed(planes, predicted={1: (0, 0)})
    assert int(data.split(b"\n")[13].split()[1]) >= 5 * 40  # bytes of corrections of plane 1
    (tmp_path / "a.ptm").write_bytes(data)
    stored = read_rti(tmp_path / "a.ptm").coefficients
    assert (stored[11:13, 9:19, 0, 1] == 253).all()


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"across": [0, 0, 3, 0, 0, 0, 0, 0, 0]}, "motion vectors"),
        ({"transforms": [0, 2, 0, 0, 0, 0, 0, 0, 0]}, "inverted or not"),
        ({"order": [0, 1, 2, 3, 4, 5, 6, 7, 7]}, "order"),
        ({"references": [3, -1, -1, -1, -1, -1, -1, -1, -1]}, "expected plane 3 before plane 0"),
        ({"references": [9, -1, -1, -1, -1, -1, -1, -1, -1]}, "references"),
        ({"sizes": [10**8] * 9}, "bytes in all"),
        ({"sizes": [20] * 9}, "a JPEG as plane 0"),
        ({"corrections": [4] + [0] * 8}, "sizes"),
        ({"order": [0, 1]}, "7 x 9 numbers"),
    ],
)
def test_what_is_damaged_is_refused(tmp_path, changed, words):
    (tmp_path / "a.ptm").write_bytes(packed(smooth_planes(9), **changed))
    with pytest.raises(ImageError, match=words):
        read_rti(tmp_path / "a.ptm")


def test_jpegs_of_another_size_are_refused(tmp_path):
    data = packed(smooth_planes(9)).replace(b"\n33\n24\n", b"\n24\n33\n", 1)
    (tmp_path / "a.ptm").write_bytes(data)
    with pytest.raises(ImageError, match="expected 24 x 33 gray pixels in plane 0, got 33 x 24"):
        read_rti(tmp_path / "a.ptm")
