"""Colour profiles: what a file of another colour space looks like is what comes out."""

from __future__ import annotations

import struct
import warnings
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from rumu.capture.colours import ProfileWarning
from rumu.capture.folder import read_capture
from rumu.capture.image import read_image, read_linear
from rumu.capture.primaries import read_primaries

D50 = np.array([0.9642, 1.0, 0.8249])
PRIMARIES = {  # x, y of red, green and blue, and the exponent
    "Display P3": (((0.680, 0.320), (0.265, 0.690), (0.150, 0.060)), 2.4),
    "Adobe RGB": (((0.640, 0.330), (0.210, 0.710), (0.150, 0.060)), 2.19921875),
    "ProPhoto": (((0.7347, 0.2653), (0.1596, 0.8404), (0.0366, 0.0001)), 1.8),
}
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
D65 = np.array([0.95047, 1.0, 1.08883])
SRGB_TO_XYZ = np.array(
    [[0.4360747, 0.3850649, 0.1430804], [0.2225045, 0.7168786, 0.0606169], [0.0139322, 0.0971045, 0.7141733]]
)  # at D50, as profiles have it


def colorants(name: str) -> np.ndarray:
    """The columns are X, Y, Z at D50 of the primaries."""
    points = np.array([(x / y, 1.0, (1 - x - y) / y) for x, y in PRIMARIES[name][0]]).T
    white = D50 if name == "ProPhoto" else D65
    matrix = points * np.linalg.solve(points, white)
    if name == "ProPhoto":
        return matrix
    adapt = np.linalg.solve(BRADFORD, np.diag((BRADFORD @ D50) / (BRADFORD @ D65)) @ BRADFORD)
    return adapt @ matrix


def icc(space: bytes, tags: dict[bytes, bytes]) -> bytes:
    """A profile of version 2, written by hand."""
    tags = {b"desc": text(b"made for a test"), b"wtpt": xyz(D50), b"cprt": b"text\0\0\0\0none\0"} | tags
    at, table, body = 128 + 4 + 12 * len(tags), b"", b""
    for tag, content in tags.items():
        padded = content + bytes(-len(content) % 4)
        table += struct.pack(">4sII", tag, at + len(body), len(content))
        body += padded
    head = struct.pack(">I4sI4s4s4s", at + len(body), b"test", 0x02400000, b"mntr", space, b"XYZ ")
    head += struct.pack(">6H4s", 2026, 1, 1, 0, 0, 0, b"acsp") + bytes(28) + xyz(D50)[8:] + bytes(48)
    return head[:128] + struct.pack(">I", len(tags)) + table + body


def text(words: bytes) -> bytes:
    return b"desc\0\0\0\0" + struct.pack(">I", len(words) + 1) + words + b"\0" + bytes(78)


def xyz(value: np.ndarray) -> bytes:
    return b"XYZ \0\0\0\0" + struct.pack(">3i", *np.round(value * 65536).astype(int))


def curve(exponent: float) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(exponent * 256))


@lru_cache
def rgb_profile(name: str, curve_of_all: bytes | None = None) -> bytes:
    matrix, exponent = colorants(name), PRIMARIES[name][1]
    tags = {f"{c}XYZ".encode(): xyz(matrix[:, i]) for i, c in enumerate("rgb")}
    return icc(b"RGB ", tags | {f"{c}TRC".encode(): curve_of_all or curve(exponent) for c in "rgb"})


def linear_profile() -> bytes:
    return rgb_profile("Adobe RGB", curve(1.0))


def gray_profile(exponent: float) -> bytes:
    return icc(b"GRAY", {b"kTRC": curve(exponent)})


def srgb_profile() -> bytes:
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def in_space(name: str, srgb: np.ndarray) -> np.ndarray:
    """Colours (..., 3) of sRGB in [0, 1] as they are encoded in another space."""
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    there = linear @ SRGB_TO_XYZ.T @ np.linalg.inv(colorants(name)).T
    return np.clip(there, 0, 1) ** (1 / PRIMARIES[name][1])


def patches() -> np.ndarray:
    """(32, 48, 3): paper, ink, seals, and colours between, of sRGB in [0, 1]."""
    colours = np.array(
        [
            (0.95, 0.92, 0.84),
            (0.1, 0.1, 0.12),
            (0.75, 0.2, 0.16),
            (0.5, 0.5, 0.5),
            (0.3, 0.55, 0.4),
            (0.2, 0.3, 0.7),
        ]
    )
    return np.repeat(np.repeat(colours.reshape(2, 3, 3), 16, axis=0), 16, axis=1)


@pytest.mark.parametrize("name", list(PRIMARIES))
@pytest.mark.parametrize("suffix", ["png", "webp", "tif", "deep.png", "deep.tif"])
def test_colours_come_out_as_srgb(tmp_path: Path, name: str, suffix: str) -> None:
    path, encoded = tmp_path / f"a.{suffix}", in_space(name, patches())
    if suffix == "deep.tif":
        samples = np.round(encoded * 65535).astype(np.uint16)
        profile = rgb_profile(name)
        tags = [(34675, 7, len(profile), profile, True)]
        tifffile.imwrite(path, samples, photometric="rgb", extratags=tags)
    elif suffix == "deep.png":
        samples = np.round(encoded * 65535).astype(np.uint16)
        data = cv2.imencode(".png", samples[..., ::-1])[1].tobytes()
        path.write_bytes(with_profile(data, rgb_profile(name)))
    else:
        Image.fromarray(np.round(encoded * 255).astype(np.uint8)).save(
            path, icc_profile=rgb_profile(name), lossless=True
        )
    off = 1e-3 if suffix.startswith("deep") else 0.02  # sixteen bits are kept
    assert np.abs(read_image(path) - patches()).max() < off


def linear_of(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def deep_tiff(path: Path, encoded: np.ndarray, profile: bytes) -> Path:
    tags = [(34675, 7, len(profile), profile, True)]
    samples = np.round(encoded * 65535).astype(np.uint16)
    tifffile.imwrite(path, samples, photometric="rgb", extratags=tags)
    return path


@pytest.mark.parametrize("name", list(PRIMARIES))
def test_a_profile_tells_that_a_tiff_is_for_a_screen(tmp_path: Path, name: str) -> None:
    path = deep_tiff(tmp_path / "a.tif", in_space(name, patches()), rgb_profile(name))
    assert np.abs(read_linear(path) - linear_of(patches())).max() < 1e-3
    as_it_is = read_linear(path, encoding="linear")
    np.testing.assert_allclose(as_it_is, in_space(name, patches()), atol=1e-4)


@pytest.mark.parametrize("profile", ["Adobe RGB", "linear"])
def test_a_capture_says_that_a_profile_was_used(tmp_path: Path, profile: str) -> None:
    for name in "abc":
        used = linear_profile() if profile == "linear" else rgb_profile(profile)
        deep_tiff(tmp_path / f"{name}.tif", np.clip(patches() + 0.01 * ord(name) - 0.98, 0, 1), used)
    (tmp_path / "capture.json").write_text('{"slant": 45}')
    notes = " ".join(note.en for note in read_capture(tmp_path).notes)
    assert ("a.tif, b.tif, c.tif: decoded by their colour profiles" in notes) == (profile != "linear")
    assert read_capture(tmp_path, encoding="srgb").notes == ()


def test_a_profile_of_light_leaves_light(tmp_path: Path) -> None:
    path = deep_tiff(tmp_path / "a.tif", patches(), linear_profile())
    np.testing.assert_allclose(read_linear(path), patches(), atol=1e-4)


def points(values: np.ndarray) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(f">I{len(values)}H", len(values), *values.astype(int))


def parametric(kind: int, *numbers: float) -> bytes:
    fixed = (round(65536 * one) for one in numbers)
    return b"para\0\0\0\0" + struct.pack(f">HH{len(numbers)}i", kind, 0, *fixed)


@pytest.mark.parametrize(
    "tag",
    [
        parametric(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045),
        points(np.round(65535 * linear_of(np.linspace(0, 1, 1024)))),
    ],
)
def test_curves_of_profiles(tmp_path: Path, tag: bytes) -> None:
    """The curve of sRGB, by parameters and by points, with other primaries so that it must be converted."""
    profile = rgb_profile("Display P3", tag)
    linear = linear_of(patches()) @ SRGB_TO_XYZ.T @ np.linalg.inv(colorants("Display P3")).T
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)
    path = deep_tiff(tmp_path / "a.tif", np.clip(shown, 0, 1), profile)
    assert np.abs(read_linear(path) - linear_of(patches())).max() < 1e-3


@pytest.mark.parametrize(
    "tag",
    [
        b"curv\0\0\0\0" + struct.pack(">I2H", 0x7FFFFFFF, 0, 65535),  # says two milliards of points, has two
        b"curv\0\0\0\0" + struct.pack(">I", 1),
        parametric(0, -2.0),
        parametric(1, 2.2, 0.0, 0.1),
        parametric(9, 1.0),
    ],
)
def test_a_curve_that_cannot_be_makes_no_primaries(tag: bytes) -> None:
    assert read_primaries(rgb_profile("Display P3", tag)) is None


def with_profile(png: bytes, profile: bytes) -> bytes:
    import zlib

    body = b"iCCP" + b"p\0\0" + zlib.compress(profile)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    return png[:33] + chunk + png[33:]  # behind the header


def test_display_p3_of_a_phone_agrees_with_its_srgb_twin(cases: Path) -> None:
    p3, srgb = (read_image(cases / "images" / name) for name in ("p3.jpg", "srgb.png"))
    assert np.abs(p3 - srgb).mean() < 0.01
    np.testing.assert_allclose(p3.mean(axis=(0, 1)), srgb.mean(axis=(0, 1)), atol=0.005)


def test_transparency_is_kept(tmp_path: Path) -> None:
    samples = np.round(in_space("Display P3", patches()) * 255).astype(np.uint8)
    alpha = np.full((32, 48, 1), 255, np.uint8)
    alpha[:8] = 0
    whole = Image.fromarray(np.concatenate([samples, alpha], axis=2))
    whole.save(tmp_path / "a.png", icc_profile=rgb_profile("Display P3"))
    image = read_image(tmp_path / "a.png")
    assert (image[:8] == 1).all()
    assert np.abs(image[8:] - patches()[8:]).max() < 0.02


def test_srgb_under_any_name_changes_nothing(tmp_path: Path) -> None:
    samples = np.arange(48 * 32 * 3, dtype=np.uint32).reshape(32, 48, 3) * 7919 % 256
    Image.fromarray(samples.astype(np.uint8)).save(tmp_path / "a.png", icc_profile=srgb_profile())
    np.testing.assert_array_equal(
        read_image(tmp_path / "a.png"), (samples / np.float32(255)).astype(np.float32)
    )


@pytest.mark.parametrize("deep", [False, True])
def test_gray_profile(tmp_path: Path, deep: bool) -> None:
    ramp, profile = np.linspace(0, 1, 256).reshape(8, 32), gray_profile(1.75)
    linear = ramp**1.75
    if deep:
        tags = [(34675, 7, len(profile), profile, True)]
        tifffile.imwrite(tmp_path / "a.tif", np.round(ramp * 65535).astype(np.uint16), extratags=tags)
    else:
        Image.fromarray(np.round(ramp * 255).astype(np.uint8)).save(tmp_path / "a.tif", icc_profile=profile)
    image = read_image(tmp_path / "a.tif")
    wanted = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert image.ndim == 2
    assert np.abs(image - wanted).max() < 0.02


def test_gray_with_the_profile_of_its_colours(tmp_path: Path) -> None:
    gray = np.tile(np.arange(0, 256, 4, dtype=np.uint8), (16, 1))
    Image.fromarray(gray).save(tmp_path / "a.png", icc_profile=rgb_profile("ProPhoto"))
    image = read_image(tmp_path / "a.png")
    linear = (gray / 255) ** 1.8
    wanted = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert image.ndim == 2
    assert np.abs(image - wanted).max() < 0.02


def cmyk_profile() -> bytes:
    """A CMYK profile whose black ink has L* = 20, which ideal ink does not."""
    # lut8: 4 inputs, 3 outputs (Lab), 2 grid points; L falls to 20 with black and to 60 with full colours
    grid = []
    for node in range(16):
        inks = [node >> 3 & 1, node >> 2 & 1, node >> 1 & 1, node & 1]
        light = 20.0 if inks[3] else 100.0 - 13 * sum(inks[:3])
        grid += [round(light * 2.55), 128, 128]
    ramp = bytes(range(256))
    identity = struct.pack(">9i", *(65536 if i in (0, 4, 8) else 0 for i in range(9)))
    lut = b"mft1\0\0\0\0" + bytes([4, 3, 2, 0]) + identity + ramp * 4 + bytes(grid) + ramp * 3
    profile = icc(b"CMYK", {b"A2B0": lut, b"A2B1": lut})
    return profile[:12] + b"prtr" + b"CMYK" + b"Lab " + profile[24:]


@pytest.mark.parametrize("suffix", ["jpg", "tif", "deep.tif"])
def test_cmyk_by_its_profile(tmp_path: Path, suffix: str) -> None:
    black = np.zeros((32, 32, 4), np.uint8)
    black[:, 16:, 3] = 255
    path, profile = tmp_path / f"a.{suffix}", cmyk_profile()
    if suffix == "deep.tif":
        tags = [(34675, 7, len(profile), profile, True)]
        tifffile.imwrite(path, black.astype(np.uint16) * 257, photometric="separated", extratags=tags)
    else:
        Image.fromarray(black, "CMYK").save(path, icc_profile=profile, quality=98)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        image = read_image(path)
    assert image[:, :12].min() > 0.97  # white paper
    assert np.abs(image - image[..., :1]).max() < 0.02  # neutral
    np.testing.assert_allclose(image[:, 20:], 48 / 255, atol=0.02)  # sRGB of L* = 20; ideal ink is black


@pytest.mark.parametrize("profile", [b"no profile at all" * 20, rgb_profile("Display P3")[:200]])
@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_a_broken_profile_is_ignored_and_said(tmp_path: Path, profile: bytes, suffix: str) -> None:
    path, plain = tmp_path / f"a.{suffix}", tmp_path / f"plain.{suffix}"
    picture = Image.fromarray(np.round(patches() * 255).astype(np.uint8))
    picture.save(plain)
    picture.save(path, icc_profile=profile)
    with pytest.warns(ProfileWarning, match=rf"a\.{suffix}: the colour profile is ignored"):
        image = read_image(path)
    np.testing.assert_array_equal(image, read_image(plain))


def test_a_profile_of_another_kind_of_picture(tmp_path: Path) -> None:
    Image.fromarray(np.round(patches() * 255).astype(np.uint8)).save(
        tmp_path / "a.png", icc_profile=gray_profile(2.2)
    )
    with pytest.warns(ProfileWarning, match="it is one of L pictures"):
        read_image(tmp_path / "a.png")


def test_linear_frames_keep_their_values(tmp_path: Path) -> None:
    samples = np.round(in_space("ProPhoto", patches()) * 255).astype(np.uint8)
    Image.fromarray(samples).save(tmp_path / "a.tif", icc_profile=rgb_profile("ProPhoto"))
    np.testing.assert_allclose(read_linear(tmp_path / "a.tif", encoding="linear"), samples / 255, atol=1e-6)
    srgb = read_linear(tmp_path / "a.tif", encoding="srgb")
    np.testing.assert_array_equal(read_linear(tmp_path / "a.tif"), srgb)
    linear = np.where(patches() <= 0.04045, patches() / 12.92, ((patches() + 0.055) / 1.055) ** 2.4)
    assert np.abs(srgb - linear).max() < 0.03
