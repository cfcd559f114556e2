"""Files and arrays become images, or one clear error."""

from __future__ import annotations

import os
import struct
import warnings
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.capture.image import (
    as_image,
    luminance,
    read_colours,
    read_frame,
    read_image,
    read_linear,
    read_mask,
    to_linear,
)
from rumu.errors import ImageError

RNG = np.random.default_rng(7)
GRAY = RNG.integers(0, 256, (20, 30), dtype=np.uint8)
COLOUR = RNG.integers(0, 256, (20, 30, 3), dtype=np.uint8)
GRAY16 = RNG.integers(0, 65536, (20, 30), dtype=np.uint16)
COLOUR16 = RNG.integers(0, 65536, (20, 30, 3), dtype=np.uint16)
FLOAT = RNG.random((20, 30, 3)).astype(np.float32)


def png(width: int, height: int, *, depth: int, kind: int, rows: bytes = b"") -> bytes:
    """A PNG written by hand, for what Pillow cannot write."""

    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def write_exr(path: Path, channels: dict[str, np.ndarray]) -> Path:
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    return path


# --- what is read ----------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["png", "bmp", "tif", "ppm", "webp"])
def test_eight_bit_colour_is_stored_values_over_255(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    Image.fromarray(COLOUR).save(path, lossless=True)
    image = read_image(path)
    assert image.dtype == np.float32 and image.flags.c_contiguous
    np.testing.assert_array_equal(image, COLOUR / np.float32(255))


@pytest.mark.parametrize("suffix", ["png", "bmp", "tif", "pgm"])
def test_eight_bit_gray_keeps_two_axes(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    Image.fromarray(GRAY).save(path)
    np.testing.assert_array_equal(read_image(path), GRAY / np.float32(255))


def test_one_bit_and_palette(tmp_path: Path) -> None:
    black = GRAY > 128
    Image.fromarray(black).save(tmp_path / "bit.png")
    np.testing.assert_array_equal(read_image(tmp_path / "bit.png"), black.astype(np.float32))
    few = Image.fromarray(COLOUR // 64 * 64).convert("P", palette=Image.Palette.ADAPTIVE, colors=64)
    few.save(tmp_path / "palette.png")
    np.testing.assert_array_equal(
        read_image(tmp_path / "palette.png"), np.asarray(few.convert("RGB")) / np.float32(255)
    )


def test_jpeg_is_close(tmp_path: Path) -> None:
    smooth = np.tile(np.linspace(20, 230, 64).astype(np.uint8), (64, 1))
    Image.fromarray(smooth).save(tmp_path / "a.jpg", quality=95)
    assert np.abs(read_image(tmp_path / "a.jpg") - smooth / 255).max() < 0.02


@pytest.mark.parametrize("samples", [GRAY16, COLOUR16], ids=["gray", "colour"])
@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_sixteen_bits_survive(tmp_path: Path, samples: np.ndarray, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"  # OpenCV writes TIFF with LZW, which tifffile alone cannot read
    assert cv2.imwrite(str(path), samples[..., ::-1] if samples.ndim == 3 else samples)
    np.testing.assert_array_equal(read_image(path), samples / np.float32(65535))


@pytest.mark.parametrize("compression", [None, "zlib"])
@pytest.mark.parametrize("planar", ["contig", "separate"])
def test_deep_tiff_layouts(tmp_path: Path, compression: str | None, planar: str) -> None:
    stored = COLOUR16 if planar == "contig" else np.moveaxis(COLOUR16, 2, 0)
    tifffile.imwrite(
        tmp_path / "a.tif", stored, photometric="rgb", planarconfig=planar, compression=compression
    )
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif"), COLOUR16 / np.float32(65535))


def test_white_is_zero_tiff_is_inverted(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", GRAY16, photometric="miniswhite")
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif"), (65535 - GRAY16) / np.float32(65535))


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_float_tiff(tmp_path: Path, dtype: type) -> None:
    tifffile.imwrite(tmp_path / "a.tif", FLOAT.astype(dtype), photometric="rgb")
    np.testing.assert_allclose(read_image(tmp_path / "a.tif"), FLOAT, atol=1e-3)


@pytest.mark.parametrize("channels", ["RGB", "RGBA", "Y"])
def test_exr(tmp_path: Path, channels: str) -> None:
    opaque = np.dstack([FLOAT, np.ones((20, 30), np.float32)])
    samples = {"RGB": FLOAT, "RGBA": opaque, "Y": FLOAT[..., 0].copy()}[channels]
    path = write_exr(tmp_path / "a.exr", {channels: samples})
    np.testing.assert_array_equal(read_image(path), FLOAT if "R" in channels else FLOAT[..., 0])


def test_cmyk_becomes_rgb(tmp_path: Path) -> None:
    Image.new("CMYK", (16, 16), (255, 0, 0, 0)).save(tmp_path / "cyan.jpg", quality=100)
    np.testing.assert_allclose(read_image(tmp_path / "cyan.jpg")[8, 8], [0, 1, 1], atol=0.02)
    tifffile.imwrite(
        tmp_path / "k.tif", np.full((9, 9, 4), (0, 65535, 0, 32768), np.uint16), photometric="separated"
    )
    np.testing.assert_allclose(read_image(tmp_path / "k.tif")[4, 4], [0.5, 0, 0.5], atol=1e-4)


@pytest.mark.parametrize("mode", ["LA", "RGBA", "P"])
def test_alpha_lies_over_white(tmp_path: Path, mode: str) -> None:
    picture = Image.new("RGBA", (16, 16), (0, 0, 0, 255))
    picture.paste((0, 0, 0, 0), (0, 0, 8, 16))
    picture.convert(mode).save(tmp_path / "a.png")
    image = read_image(tmp_path / "a.png")
    assert image[5, 2].max() == 1.0 and image[5, 2].min() == 1.0 and image[5, 12].max() == 0.0
    assert (image.ndim == 2) == (mode == "LA")


def test_sixteen_bit_alpha_lies_over_white(tmp_path: Path) -> None:
    samples = np.zeros((10, 12, 2), np.uint16)
    samples[:, 6:, 1] = 65535
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in samples)
    (tmp_path / "a.png").write_bytes(png(12, 10, depth=16, kind=4, rows=rows))
    image = read_image(tmp_path / "a.png")
    assert image[..., 0][3, 2] == 1.0 and image[..., 0][3, 9] == 0.0


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", ["jpg", "png", "tif", "deep.tif", "deep.png"])
def test_exif_orientation_is_applied(tmp_path: Path, orientation: int, suffix: str) -> None:
    upright = np.full((16, 32), 128, np.uint8)
    upright[:8, :16] = 255
    upright[8:, 16:] = 0
    undo = {1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 6: 8, 7: 7, 8: 6}[orientation]
    exif = Image.Exif()
    exif[0x0112] = undo
    from PIL import ImageOps

    tagged = Image.fromarray(upright)
    tagged.getexif()[0x0112] = undo
    turned = ImageOps.exif_transpose(tagged)
    exif[0x0112] = orientation
    path = tmp_path / f"a.{suffix}"
    if suffix == "deep.tif":
        deep = np.asarray(turned).astype(np.uint16) * 257
        tifffile.imwrite(path, deep, extratags=[(0x0112, "H", 1, orientation, True)])
    elif suffix == "deep.png":
        deep = np.repeat((np.asarray(turned).astype(np.uint16) * 257)[..., None], 3, axis=2)
        rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in deep)
        body = exif.tobytes().removeprefix(b"Exif\0\0")
        chunk = struct.pack(">I", len(body)) + b"eXIf" + body + struct.pack(">I", zlib.crc32(b"eXIf" + body))
        data = png(deep.shape[1], deep.shape[0], depth=16, kind=2, rows=rows)
        path.write_bytes(data[:33] + chunk + data[33:])
    else:
        turned.save(path, exif=exif, quality=100)
    image = luminance(read_image(path))
    assert image.shape == upright.shape
    assert np.abs(image - upright / 255).max() < 0.03
    frame, told = read_frame(path, encoding="linear")  # of a camera that stood still: not turned
    assert told == orientation
    assert np.abs(luminance(frame) - np.asarray(turned) / 255).max() < 0.03


# --- what is refused -------------------------------------------------------------------------------


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"gone\.png: expected an image .* cannot open it \(No such file"):
        read_image(tmp_path / "gone.png")


def test_folder(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="expected an image file, found a folder"):
        read_image(tmp_path)


def test_pipe_and_impossible_name(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(ImageError, match="expected an image file, found a device or a pipe"):
        read_image(tmp_path / "a.png")
    with pytest.raises(ImageError, match=r"cannot open it \(embedded null byte"):
        read_image("a\0b.png")


@pytest.mark.parametrize("kept", [9, 20, 40])
def test_file_cut_within_its_header(tmp_path: Path, kept: int, capfd: pytest.CaptureFixture[str]) -> None:
    for suffix in ("png", "jpg", "tif"):
        Image.fromarray(COLOUR).save(tmp_path / f"whole.{suffix}")
        data = (tmp_path / f"whole.{suffix}").read_bytes()
        (tmp_path / f"a.{suffix}").write_bytes(data[:kept])
        with pytest.raises(ImageError, match=r"a\.\w+: the image is cut short or broken"):
            read_image(tmp_path / f"a.{suffix}")
    assert capfd.readouterr().err == ""


def test_empty_file(tmp_path: Path) -> None:
    (tmp_path / "a.png").touch()
    with pytest.raises(ImageError, match=r"a\.png: expected an image .* the file is empty"):
        read_image(tmp_path / "a.png")


def test_text_named_png(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("hello, this is no picture")
    with pytest.raises(ImageError, match=r"a\.png: expected an image .* found something else .*hello"):
        read_image(tmp_path / "a.png")


@pytest.mark.parametrize("suffix", ["png", "jpg", "webp", "deep.png", "deep.tif", "lzw.tif", "exr"])
@pytest.mark.parametrize("share", [0.5, 0.9])
def test_file_cut_short(tmp_path: Path, suffix: str, share: float) -> None:
    whole, path = tmp_path / f"whole.{suffix}", tmp_path / f"a.{suffix}"
    noise = RNG.integers(0, 256, (200, 200, 3), dtype=np.uint8)
    if suffix == "exr":
        write_exr(whole, {"RGB": noise.astype(np.float32) / 255})
    elif suffix == "deep.tif":
        tifffile.imwrite(whole, noise.astype(np.uint16))
    elif suffix in ("deep.png", "lzw.tif"):
        cv2.imwrite(str(whole), noise.astype(np.uint16))
    else:
        Image.fromarray(noise).save(whole)
    data = whole.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(ImageError, match=r"a\.[a-z.]+: the image is cut short or broken"):
        read_image(path)


def test_one_pixel(tmp_path: Path) -> None:
    Image.new("L", (1, 1)).save(tmp_path / "a.png")
    with pytest.raises(ImageError, match=r"a\.png: too small: expected at least 8 x 8 pixels, got 1 x 1"):
        read_image(tmp_path / "a.png")


@pytest.mark.parametrize("depth", [8, 16])
def test_bomb_is_refused_from_its_header(tmp_path: Path, depth: int) -> None:
    (tmp_path / "a.png").write_bytes(png(30_000, 30_000, depth=depth, kind=2))
    with pytest.raises(ImageError, match=r"expected at most 120 megapixels, the header says 900"):
        read_image(tmp_path / "a.png")


def test_large_image_between_the_limits_of_pillow_and_ours(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png(13_000, 10_000, depth=8, kind=0))
    with pytest.raises(ImageError, match=r"expected at most 120 megapixels, the header says 130"):
        read_image(tmp_path / "a.png")
    (tmp_path / "b.png").write_bytes(png(11_000, 10_000, depth=8, kind=0))  # allowed, but holds no pixels
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ImageError, match="cut short or broken"):
            read_image(tmp_path / "b.png")


def test_nan_in_a_float_tiff(tmp_path: Path) -> None:
    broken = FLOAT.copy()
    broken[3, 4, 0], broken[5, 6, 1] = np.nan, np.inf
    tifffile.imwrite(tmp_path / "a.tif", broken, photometric="rgb")
    for read in (read_image, read_linear):
        with pytest.raises(
            ImageError, match=r"a\.tif: expected finite values, got 2 that are NaN or infinite"
        ):
            read(tmp_path / "a.tif")


def test_float_outside_the_unit_range(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", FLOAT * 4, photometric="rgb")
    with pytest.raises(
        ImageError, match=r"a\.tif: expected float values in \[0, 1\], got values from .* to 3\.9"
    ):
        read_image(tmp_path / "a.tif")


def test_integers_of_32_bits(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", GRAY16.astype(np.uint32))
    with pytest.raises(ImageError, match="expected 8-bit, 16-bit or float samples, got 32-bit uint32"):
        read_image(tmp_path / "a.tif")


def test_camera_raw_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "a.dng").write_bytes(b"II*\0 and more")
    with pytest.raises(ImageError, match="camera raw is not read; develop it to a linear 16-bit TIFF"):
        read_image(tmp_path / "a.dng")


def test_exr_without_colours_names_its_channels(tmp_path: Path) -> None:
    path = write_exr(tmp_path / "a.exr", {"Z": FLOAT[..., 0].copy()})
    with pytest.raises(ImageError, match=r"a\.exr: expected EXR channels R, G, B or Y, found Z"):
        read_image(path)


# --- linear light ----------------------------------------------------------------------------------


def test_srgb_curve() -> None:
    image = np.array([[0, 0.04045, 0.5, 1]], np.float32)
    np.testing.assert_allclose(to_linear(image), [[0, 0.0031308, 0.2140411, 1]], atol=1e-6)
    assert to_linear(image).dtype == np.float32


def test_auto_decodes_jpeg_alone(tmp_path: Path) -> None:
    for suffix in ("jpg", "png"):
        Image.new("L", (16, 16), 128).save(tmp_path / f"a.{suffix}")
    bright, dark = 128 / 255, 0.2158605
    assert read_linear(tmp_path / "a.jpg")[8, 8] == pytest.approx(dark, abs=1e-6)
    assert read_linear(tmp_path / "a.png")[8, 8] == pytest.approx(bright, abs=1e-6)
    assert read_linear(tmp_path / "a.jpg", encoding="linear")[8, 8] == pytest.approx(bright, abs=1e-6)
    assert read_linear(tmp_path / "a.png", encoding="srgb")[8, 8] == pytest.approx(dark, abs=1e-6)
    with pytest.raises(ImageError, match="encoding: expected one of auto, linear, srgb, got 'gamma'"):
        read_linear(tmp_path / "a.png", encoding="gamma")  # type: ignore[arg-type]


def test_float_files_keep_their_range_when_linear(tmp_path: Path) -> None:
    samples = FLOAT * 5 - 0.5
    tifffile.imwrite(tmp_path / "a.tif", samples, photometric="rgb")
    np.testing.assert_array_equal(read_linear(tmp_path / "a.tif"), np.maximum(samples, 0))


def test_mask_is_bright_and_opaque(tmp_path: Path) -> None:
    picture = Image.new("RGBA", (16, 16), (255, 255, 255, 255))
    picture.paste((255, 255, 255, 0), (0, 0, 8, 16))
    picture.save(tmp_path / "a.png")
    expected = np.zeros((16, 16), bool)
    expected[:, 8:] = True
    np.testing.assert_array_equal(read_mask(tmp_path / "a.png"), expected)


# --- arrays ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("array", "expected"),
    [
        (GRAY, GRAY / 255),
        (COLOUR16, COLOUR16 / 65535),
        (GRAY > 99, (GRAY > 99) * 1.0),
        (FLOAT.astype(np.float64), FLOAT),
        (GRAY[..., None], GRAY / 255),
    ],
)
def test_arrays(array: np.ndarray, expected: np.ndarray) -> None:
    image = as_image(array)
    assert image.dtype == np.float32
    np.testing.assert_allclose(image, expected, atol=1e-7)


def test_array_alpha_lies_over_white() -> None:
    samples = np.zeros((10, 10, 4), np.uint8)
    samples[5:, :, 3] = 255
    image = as_image(samples)
    assert image.shape == (10, 10, 3) and image[0].min() == 1 and image[9].max() == 0


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros(9), r"photo: expected an image of shape \(H, W\) or \(H, W, 3\), got \(9,\)"),
        (np.zeros((9, 9, 5)), r"got \(9, 9, 5\)"),
        (np.zeros((9, 9), np.int64), "expected bool, uint8, uint16 or float values, got int64"),
        (np.zeros((3, 9)), "expected at least 8 x 8 pixels, got 9 x 3"),
        (np.full((9, 9), np.nan), "expected finite values, got 81 that are NaN"),
        (np.full((9, 9), 200.0), r"expected float values in \[0, 1\], got values from 200 to 200"),
    ],
)
def test_bad_arrays(array: np.ndarray, message: str) -> None:
    with pytest.raises(ImageError, match=message):
        as_image(array, name="photo")


def test_luminance_weights_sum_to_one() -> None:
    np.testing.assert_allclose(luminance(np.ones((8, 8, 3), np.float32)), 1, atol=1e-6)
    assert luminance(np.array([[[0, 1, 0]]], np.float32))[0, 0] == pytest.approx(0.7152)


@pytest.mark.parametrize(
    ("mode", "value", "shown"),
    [("L", 90, (90, 90, 90)), ("RGB", (10, 90, 200), (10, 90, 200)), ("LA", (0, 51), (204, 204, 204)),
     ("RGBA", (255, 0, 0, 128), (255, 127, 127)), ("1", 1, (255, 255, 255))],
)  # fmt: skip
def test_a_picture_in_colour_lies_on_white_whatever_its_mode(tmp_path, mode, value, shown):
    Image.new(mode, (40, 30), value).save(tmp_path / "picture.png")
    colours = read_colours(tmp_path / "picture.png")
    assert colours.shape == (30, 40, 3) and colours.dtype == np.uint8 and colours.flags.c_contiguous
    assert tuple(colours[7, 9]) == shown
