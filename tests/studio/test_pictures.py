"""Which files are pictures, and how they are normalised."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from rumu.studio.errors import Unusable
from rumu.studio.pictures import MAX_SIDE, check_picture, format_of, normalise_picture


def test_a_picture_is_recognised_by_its_content(packed, cross):
    assert normalise_picture(packed(cross())).ending == "png"
    assert normalise_picture(packed(cross(), "JPEG")).ending == "jpg"
    for no_picture in (
        b"",
        b"x",
        b"<svg/>",
        b"\x89PNG\r\n\x1a\n",
        b"%PDF-1.7",
    ):
        with pytest.raises(Unusable):
            check_picture(no_picture)


def test_a_truncated_picture_is_refused(packed, cross):
    whole = packed(cross(400, 400))
    check_picture(whole[: len(whole) // 2])  # its head is fine
    with pytest.raises(Unusable, match="cut short"):
        normalise_picture(whole[: len(whole) // 2])


def test_pixels_are_counted_before_they_are_decoded():
    """A head that promises 30000 x 30000 pixels and a body that has none: refused from the head."""
    head = struct.pack(">IIBBBBB", 30000, 30000, 8, 0, 0, 0, 0)
    chunk = b"IHDR" + head
    data = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    body = zlib.compress(b"\0" * 1000)
    data += struct.pack(">I", len(body)) + b"IDAT" + body + struct.pack(">I", zlib.crc32(b"IDAT" + body))
    with pytest.raises(Unusable) as refused:
        check_picture(data)
    assert refused.value.code in ("too_many_pixels", "no_picture")


def test_too_many_bytes(packed, cross):
    with pytest.raises(Unusable) as refused:
        check_picture(packed(cross()), max_bytes=100)
    assert refused.value.code == "too_large"


def test_metadata_of_the_camera_is_dropped_and_the_picture_is_turned_upright(packed):
    page = Image.new("RGB", (120, 60), "white")
    page.paste("black", (0, 0, 30, 60))  # ink at the left
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned a quarter clockwise
    exif[0x010E] = "secret position"
    data = packed(page, "JPEG", exif=exif, quality=95)
    assert b"secret" in data
    stored = normalise_picture(data)
    assert b"secret" not in stored.data and (stored.width, stored.height) == (60, 120)
    upright = np.asarray(Image.open(io.BytesIO(stored.data)).convert("L"))
    assert upright[:25].mean() < 60  # now at the top
    assert upright[40:].mean() > 200


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "LA", "P", "1", "I;16"])
def test_all_modes_keep_ink_dark_and_paper_pale(packed, cross, mode):
    deep = Image.fromarray(np.asarray(cross(), np.uint16) * 257)
    image = deep if mode == "I;16" else cross().convert(mode)
    stored = np.asarray(Image.open(io.BytesIO(normalise_picture(packed(image)).data)).convert("L"))
    assert stored[100, 100] < 60 and stored[5, 5] > 240


def test_transparent_pixels_become_paper(packed):
    clear = Image.new("RGBA", (50, 50), (0, 0, 0, 0))
    stored = np.asarray(Image.open(io.BytesIO(normalise_picture(packed(clear)).data)).convert("L"))
    assert stored.min() == 255


def test_a_large_photograph_is_reduced(packed, cross):
    stored = normalise_picture(packed(cross(4000, 3000), "JPEG"))
    assert (stored.width, stored.height) == (MAX_SIDE, MAX_SIDE * 3 // 4)


def test_the_format_of_a_work_is_that_of_its_content(packed, cross):
    for name, ending in (("TIFF", "tif"), ("WEBP", "webp"), ("GIF", "gif"), ("MPO", "jpg"), ("AVIF", "avif")):
        assert format_of(packed(cross(), name)) == ending
    with pytest.raises(Unusable):
        format_of(packed(cross(300, 300)), max_pixels=1000)


@pytest.mark.parametrize("side", [4, 16, 23])
def test_a_small_picture_is_told_so_with_its_size(packed, side):
    with pytest.raises(Unusable) as refused:
        check_picture(packed(Image.new("L", (side, side))))
    assert refused.value.code == "too_small"
    assert refused.value.en == f"Too small: expected at least 24 x 24 pixels, got {side} x {side}."
    assert "24 × 24" in refused.value.zh and f"{side} × {side}" in refused.value.zh


def test_a_narrow_picture_is_told_so(packed):
    with pytest.raises(Unusable, match=r"Too narrow: .* 40 times the other, got 30 x 3000 pixels"):
        check_picture(packed(Image.new("L", (30, 3000))))


@pytest.mark.parametrize("name", ["MPO", "WEBP", "AVIF", "HEIF", "TIFF", "GIF", "BMP"])
def test_copies_may_have_any_format(packed, cross, name):
    if name == "HEIF":
        pytest.importorskip("pillow_heif").register_heif_opener()
    stored = normalise_picture(packed(cross(), name))
    assert stored.ending == ("png" if name in ("TIFF", "GIF", "BMP") else "jpg")
    gray = np.asarray(Image.open(io.BytesIO(stored.data)).convert("L"))
    assert gray[100, 100] < 60 and gray[5, 5] > 240


def test_pictures_of_museums_and_programs(cases):
    for name in ("images/la16.tif", "images/mpo.jpg", "images/p3.jpg"):
        normalise_picture((cases / name).read_bytes())
    for name in (
        "thin-16x3000.png",
        "kept-6879-FAULT.tif",
        "kept-7959-FAULT.jpg",
        "assess-174-FAULT.jpg",
        "bomb-depth.tif",
    ):
        with pytest.raises(Unusable) as refused:
            normalise_picture((cases / "hostile" / name).read_bytes())
        assert refused.value.zh != Unusable.zh and "/tmp" not in refused.value.en + refused.value.zh
    with pytest.raises(Unusable, match="HEIC"):
        normalise_picture((cases / "images/x.heic").read_bytes())
