"""PNGs that are put together from bands: other programs read the same samples."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.surface import png_files
from rumu.surface.png_files import write_png_bands


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("shape", [(1, 1), (7, 5), (37, 41), (37, 41, 3), (200, 3, 3)])
@pytest.mark.parametrize("band", [1, 100, 10**9])
def test_what_is_written_is_read(tmp_path, monkeypatch, kind, shape, band):
    """By two libraries, whatever rows a band holds; Pillow checks the sums of all chunks."""
    monkeypatch.setattr(png_files, "_BAND", band)
    rng = np.random.default_rng(3)
    samples = rng.integers(0, np.iinfo(kind).max, shape, dtype=kind, endpoint=True)
    path = tmp_path / "one.png"
    write_png_bands(path, shape, kind, lambda rows: samples[rows])
    read = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert read.dtype == kind
    assert (read[..., ::-1] if len(shape) == 3 else read).tolist() == samples.tolist()
    with Image.open(path) as picture:
        picture.verify()
    if kind is np.uint8:
        with Image.open(path) as picture:
            assert np.array_equal(np.asarray(picture), samples)


def test_a_long_picture_has_the_checksum_of_its_stream(tmp_path):
    """OpenCV and Pillow do not look at the checksum of the stream; zlib does."""
    import zlib

    samples = np.random.default_rng(4).integers(0, 255, (1500, 1000), dtype=np.uint8)
    path = tmp_path / "long.png"
    write_png_bands(path, samples.shape, np.uint8, lambda rows: samples[rows])
    content, stream, at = path.read_bytes(), b"", 8
    while at < len(content):
        length, name = int.from_bytes(content[at : at + 4], "big"), content[at + 4 : at + 8]
        stream += content[at + 8 : at + 8 + length] if name == b"IDAT" else b""
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(stream), np.uint8).reshape(1500, 1001)
    assert np.array_equal(np.cumsum(rows[:, 1:], axis=1, dtype=np.uint8), samples)


def test_a_band_that_fails_is_told(tmp_path):
    """An error of a thread reaches the caller."""

    def broken(rows: slice) -> np.ndarray:
        raise MemoryError("no room")

    with pytest.raises(MemoryError, match="no room"):
        write_png_bands(tmp_path / "one.png", (10, 10), np.uint8, broken)
