"""Files of the RTI trade, read back and compared with the formats as published, written a second time."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from PIL import Image
from scipy.special import lpmv

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError, ImageError
from rumu.rti.exchange import read_rti, write_rti
from rumu.rti.fitting import RtiSettings, fit_rti
from rumu.rti.image import RtiImage, harmonics, light_weights, relight_rti
from rumu.values import Capture

RNG = np.random.default_rng(15)
STEP = 1 / 255


def lamps(count: int, *, least: float = 0.2) -> np.ndarray:
    """(N, 3) unit vectors all over the dome."""
    z = np.linspace(least, 0.98, count)
    turn = np.arange(count) * 2.399963
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def photographs(lights: np.ndarray, *, side: int = 24, colour: bool = True) -> Capture:
    """A bumpy sheet of several colours with a little gloss, in linear light."""
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : (side + 5) * 1j]
    normals = np.stack([0.5 * np.sin(4 * x), 0.4 * np.cos(3 * y), np.ones_like(x)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    albedo = np.stack([0.8 - 0.3 * x, 0.5 + 0.2 * y, 0.4 + 0.1 * x * y], axis=2)
    shade = np.clip(np.einsum("hwk,nk->nhw", normals, lights), 0, None)
    images = shade[..., None] * albedo + 0.2 * shade[..., None] ** 20
    images = np.clip(images if colour else images.mean(axis=3), 0, 1).astype(np.float32)
    return Capture(images=images, lights=lights, mask=np.ones(images.shape[1:3], bool), spacing=0.05)


def ptm_by_the_specification(path, u: float, v: float) -> np.ndarray:
    """The picture of a .ptm under a lamp, pixel by pixel from its bytes, as the published format tells."""
    data = path.read_bytes()
    lines = data.split(b"\n", 6)[:6]
    width, height = int(lines[2]), int(lines[3])
    scale, bias = [float(s) for s in lines[4].split()], [int(b) for b in lines[5].split()]
    at = sum(len(line) + 1 for line in lines)
    picture = np.zeros((height, width, 3))
    powers = [u**2, v**2, u * v, u, v, 1.0]
    for row in range(height):
        for column in range(width):
            pixel = row * width + column
            for channel in range(3):
                block = 0 if lines[1] == b"PTM_FORMAT_LRGB" else channel * width * height * 6
                six = data[at + block + 6 * pixel : at + block + 6 * pixel + 6]
                value = sum(p * s * (c - b) for p, s, b, c in zip(powers, scale, bias, six, strict=True))
                if lines[1] == b"PTM_FORMAT_LRGB":
                    value *= data[at + 6 * width * height + 3 * pixel + channel] / 255
                picture[height - 1 - row, column, channel] = min(max(value / 255, 0), 1)
    return picture


def legendre_harmonics(light, terms: int) -> list[float]:
    """Hemispherical harmonics by Legendre functions of scipy, in the order and signs of .rti files."""
    tilt, x = math.atan2(light[1], light[0]), 2 * light[2] - 1
    found = []
    for degree in range(math.isqrt(terms)):
        for m in range(degree, -degree - 1, -1):
            k = abs(m)
            factor = math.sqrt(
                (2 * degree + 1) * math.factorial(degree - k) / (2 * math.pi * math.factorial(degree + k))
            )
            around = 1.0 if m == 0 else math.sqrt(2) * (math.cos(k * tilt) if m > 0 else math.sin(k * tilt))
            sign = (-1) ** k * (-1 if k == 2 else 1)  # scipy's phase is taken back; m = 2 is turned
            found.append(sign * factor * float(lpmv(k, degree, x)) * around)
    return found


def hsh_by_the_format(path, light) -> np.ndarray:
    """The picture of a .rti under a lamp, from its bytes."""
    data = path.read_bytes()
    lines = data.split(b"\r\n", 4)[:4]
    width, height, bands = (int(one) for one in lines[2].split())
    terms = int(lines[3].split()[0])
    at = sum(len(line) + 2 for line in lines)
    scale, bias = np.frombuffer(data, "<f4", 2 * terms, at).reshape(2, terms)
    stored = np.frombuffer(data, np.uint8, offset=at + 8 * terms).reshape(height, width, bands, terms)
    values = (stored / 255 * scale + bias) @ np.array(legendre_harmonics(light, terms))
    return np.clip(values, 0, 1)


@pytest.mark.parametrize("channels", ["lrgb", "rgb"])
@pytest.mark.parametrize("colour", [True, False])
def test_a_ptm_is_what_the_published_format_says(tmp_path, channels, colour):
    capture = photographs(lamps(20), colour=colour)
    fit = fit_rti(capture, channels=channels)
    write_rti(fit.image, tmp_path / "sheet.ptm")
    read = read_rti(tmp_path / "sheet.ptm")
    for light in capture.lights[::5]:
        shown = relight_rti(read, light)
        by_hand = ptm_by_the_specification(tmp_path / "sheet.ptm", light[0], light[1])
        assert np.abs(shown - by_hand).max() < STEP
        assert np.abs(shown - relight_rti(fit.image, light)).max() < STEP


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_rti_is_what_the_published_harmonics_say(tmp_path, order):
    capture = photographs(lamps(30))
    fit = fit_rti(capture, basis="hsh", order=order)
    write_rti(fit.image, tmp_path / "sheet.rti")
    read = read_rti(tmp_path / "sheet.rti")
    assert read.terms == (order + 1) ** 2
    for light in capture.lights[::7]:
        shown = relight_rti(read, light)
        assert np.abs(shown - hsh_by_the_format(tmp_path / "sheet.rti", light)).max() < STEP
        assert np.abs(shown - relight_rti(fit.image, light)).max() < STEP


def openlime_planes(folder, light) -> np.ndarray:
    """The picture of a folder under a lamp, by OpenLIME's sums: (sample - bias) * scale * weight."""
    info = json.loads((folder / "info.json").read_text())
    jpegs = [np.asarray(Image.open(folder / f"plane_{i}.jpg")) / 255 for i in range(info["nplanes"] // 3)]
    scale = np.array(info["materials"][0]["scale"]).reshape(-1, 3)
    bias = np.array(info["materials"][0]["bias"]).reshape(-1, 3)
    x, y, _ = light
    weights = [1, x, y, x * x, x * y, y * y] if info["type"] == "ptm" else legendre_harmonics(light, 9)
    parts = [(one - b) * s for one, b, s in zip(jpegs, bias, scale, strict=True)]
    if info["colorspace"] == "rgb":
        return np.clip(sum(w * part for w, part in zip(weights, parts, strict=False)), 0, 1)
    luminance = sum(weights[3 * j + c] * part[..., c] for j, part in enumerate(parts[1:]) for c in range(3))
    return np.clip(luminance[..., None] * parts[0], 0, 1)


@pytest.mark.parametrize(("basis", "channels"), [("ptm", "lrgb"), ("ptm", "rgb"), ("hsh", "rgb")])
def test_planes_are_what_openlime_adds_up(tmp_path, basis, channels):
    capture = photographs(lamps(30))
    fit = fit_rti(capture, basis=basis, channels=channels)
    write_rti(fit.image, tmp_path / "sheet", capture=capture)
    info = json.loads((tmp_path / "sheet" / "info.json").read_text())
    assert (info["width"], info["height"], info["type"], info["pixelSizeInMM"]) == (29, 24, basis, 0.05)
    assert np.array(info["lights"]).reshape(-1, 3) == pytest.approx(capture.lights)
    read = read_rti(tmp_path / "sheet")
    for light in capture.lights[::7]:
        shown = relight_rti(read, light)
        assert np.abs(shown - openlime_planes(tmp_path / "sheet", light)).max() < STEP
        assert np.sqrt(np.mean((shown - relight_rti(fit.image, light)) ** 2)) < 4 * STEP  # JPEG


def test_harmonics_are_orthonormal_and_those_of_scipy():
    z, weight = np.polynomial.legendre.leggauss(24)
    z, weight = (z + 1) / 2, weight / 2
    turns = np.arange(24) * 2 * np.pi / 24
    grid = harmonics(np.tile(turns, 24), np.repeat(z, 24))
    products = (grid * np.repeat(weight, 24)[:, None] * 2 * np.pi / 24).T @ grid
    assert np.allclose(products, np.eye(16), atol=1e-9)
    for light in lamps(9):
        found = light_weights(light[None], basis="hsh", terms=16)[0]
        assert found == pytest.approx(legendre_harmonics(light, 16), abs=1e-12)


def test_a_polynomial_in_the_lamp_comes_back():
    """Photographs that are a polynomial as a screen shows them are fitted but for the steps of the bytes."""
    lights = lamps(25)
    truth = RNG.uniform([-0.1, -0.1, -0.1, -0.2, -0.2, 0.5], [0.1, 0.1, 0.1, 0.2, 0.2, 0.7], (16, 16, 3, 6))
    shown = np.einsum("hwck,nk->nhwc", truth, light_weights(lights, basis="ptm", terms=6))
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    capture = Capture(images=linear.astype(np.float32), lights=lights, mask=np.ones((16, 16), bool))
    fit = fit_rti(capture, channels="rgb", settings=RtiSettings(beyond=0.0))
    assert fit.residual < 1e-4 and fit.told == 6
    for light, picture in zip(lights, shown, strict=True):
        assert np.abs(relight_rti(fit.image, light) - picture).max() < 3 * STEP


def test_bands_and_threads_change_nothing():
    capture = photographs(lamps(12))
    whole, parts = fit_rti(capture), fit_rti(capture, settings=RtiSettings(tile=12 * 37))
    assert np.array_equal(whole.image.coefficients, parts.image.coefficients)
    assert np.array_equal(whole.image.colour, parts.image.colour)
    assert whole.residual == pytest.approx(parts.residual)


def test_gloss_does_not_bleach_the_colour():
    lights = lamps(20)
    red = np.zeros((20, 10, 10, 3), np.float32) + np.array([0.4, 0.05, 0.05], np.float32)
    red[7] = 1.0  # one lamp is mirrored
    capture = Capture(images=red, lights=lights, mask=np.ones((10, 10), bool))
    colour = fit_rti(capture).image.colour[5, 5] / 255.0
    assert colour[1] / colour[0] == pytest.approx(0.24830 / 0.66519, abs=0.02)  # sRGB of .05 and .4


def test_strengths_that_are_told_are_evened_out():
    lights, strengths = lamps(15), np.tile([0.5, 1.0, 1.5], 5)
    capture = photographs(lights)
    uneven = Capture(
        images=capture.images * (strengths / 1.5).reshape(-1, 1, 1, 1).astype(np.float32),
        lights=lights, mask=capture.mask, strengths=strengths,
    )  # fmt: skip
    even = capture.changed(images=capture.images / 3)
    for light in lights[::4]:
        there, here = (relight_rti(fit_rti(one).image, light) for one in (uneven, even))
        assert np.abs(there - here).max() < 2 * STEP


def test_lamps_in_one_ring_are_said_to_tell_too_little():
    turn = np.arange(12) * np.pi / 6
    ring = np.stack([0.7 * np.cos(turn), 0.7 * np.sin(turn), np.full(12, 0.714)], axis=1)
    fit = fit_rti(photographs(ring / np.linalg.norm(ring, axis=1, keepdims=True)))
    assert fit.told == 5 and "5 of 6" in fit.notes[0].en
    assert not fit_rti(photographs(lamps(12))).notes


@pytest.mark.parametrize(
    ("count", "options", "words"),
    [
        (5, {}, "at least 6 photographs"),
        (8, {"basis": "hsh"}, "at least 9 photographs"),
        (15, {"basis": "hsh", "order": 3}, "at least 16"),
        (20, {"basis": "hsh", "order": 4}, "order 1, 2 or 3"),
        (20, {"basis": "dmd"}, "basis"),
        (20, {"channels": "ycc"}, "channels among"),
    ],
)
def test_what_cannot_be_fitted(count, options, words):
    with pytest.raises(CaptureError, match=words):
        fit_rti(photographs(lamps(count)), **options)


def test_the_older_ptm_with_the_colour_behind_each_pixel(tmp_path):
    image = fit_rti(photographs(lamps(10))).image
    write_rti(image, tmp_path / "new.ptm")
    data = (tmp_path / "new.ptm").read_bytes()
    header = b"\r\n".join(data.split(b"\n", 6)[:6]).replace(b"PTM_1.2", b"PTM_1.1") + b" \r\n"
    pixels = np.concatenate([image.coefficients[::-1, :, 0], image.colour[::-1]], axis=2)
    (tmp_path / "old.ptm").write_bytes(header + pixels.tobytes())
    read = read_rti(tmp_path / "old.ptm")
    assert np.array_equal(read.coefficients, image.coefficients) and np.array_equal(read.colour, image.colour)


@pytest.mark.parametrize("terms", [4, 9])
def test_a_rti_may_tell_the_order_for_the_number_of_its_terms(tmp_path, terms):
    order = {4: 1, 9: 2}[terms]
    write_rti(fit_rti(photographs(lamps(12)), basis="hsh", order=order).image, tmp_path / "a.rti")
    data = (tmp_path / "a.rti").read_bytes()
    (tmp_path / "b.rti").write_bytes(data.replace(b"\n%d 2 1" % terms, b"\n%d 2 1" % order, 1))
    first, second = read_rti(tmp_path / "a.rti"), read_rti(tmp_path / "b.rti")
    assert second.terms == terms and np.array_equal(first.coefficients, second.coefficients)


@pytest.fixture
def written(tmp_path):
    """A .ptm, a .rti and a folder of planes."""
    capture = photographs(lamps(20))
    for name, basis in (("a.ptm", "ptm"), ("a.rti", "hsh"), ("planes", "ptm")):
        write_rti(fit_rti(capture, basis=basis).image, tmp_path / name)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("a.ptm", b"PTM_1.2", b"PTM_9.9", "expected a polynomial texture map"),
        ("a.ptm", b"LRGB", b"JPEGLS_LRGB", "got PTM_FORMAT_JPEGLS_LRGB"),
        ("a.ptm", b"\n29\n", b"\n2900\n", "bytes behind the header"),
        ("a.ptm", b"\n29\n", b"\n0\n", "bytes behind the header"),
        ("a.rti", b"#HSH1.2\r\n3", b"#HSH1.2\r\n1", "got type 1"),
        ("a.rti", b"29 24 3", b"29 24 1", "3 channels"),
        ("a.rti", b"9 2 1", b"7 2 1", "4, 9 or 16 terms"),
        ("a.rti", b"29 24", b"290 24", "bytes behind the header"),
        ("planes/info.json", b'"ptm"', b'"sh"', "expected type ptm or hsh"),
        ("planes/info.json", b'"nplanes": 9', b'"nplanes": 12', "a scale and a bias"),
        ("planes/info.json", b'"width": 29', b'"width": 30', "plane_0.jpg"),
        ("planes/info.json", b'"materials"', b'"material"', "materials"),
    ],
)
def test_what_is_damaged_is_refused_with_its_name(written, name, old, new, words):
    data = (written / name).read_bytes()
    assert old in data
    (written / name).write_bytes(data.replace(old, new, 1))
    with pytest.raises(ImageError, match=words):
        read_rti(written / name)


def test_what_is_none_and_what_a_file_cannot_hold(written):
    (written / "other").mkdir()
    with pytest.raises(ImageError, match=r"info\.json"):
        read_rti(written / "other")
    polynomial, harmonic = read_rti(written / "a.ptm"), read_rti(written / "a.rti")
    with pytest.raises(ImageError, match="expected a polynomial"):
        write_rti(harmonic, written / "b.ptm")
    with pytest.raises(ImageError, match="expected harmonics"):
        write_rti(polynomial, written / "b.rti")
    other = RtiImage("hsh", harmonic.coefficients, harmonic.scale * [[1], [2], [1]], harmonic.bias)
    with pytest.raises(ImageError, match="one scale"):
        write_rti(other, written / "b.rti")
    write_rti(other, written / "b")  # planes hold a scale for each
    assert np.allclose(read_rti(written / "b").scale, other.scale)
    with pytest.raises(ImageError, match="behind"):
        relight_rti(harmonic, (0, 0.5, -0.5))
    assert not (written / "b.ptm").exists() and not (written / "b.rti").exists()


def test_a_real_capture_comes_near_its_photographs(data, tmp_path):
    """240 photographs of a lion's head: more terms come nearer; a picture is near its photograph."""
    capture = read_capture(data / "photometric/lion-rti")
    residuals = [fit_rti(capture, basis="hsh", order=order).residual for order in (1, 2, 3)]
    assert residuals == sorted(residuals, reverse=True)
    write_rti(fit_rti(capture).image, tmp_path / "lion.ptm")
    image = read_rti(tmp_path / "lion.ptm")
    for number in (10, 120, 200):
        linear = capture.photographs.frame(number)
        seen = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        off = relight_rti(image, capture.lights[number]) - seen
        assert np.sqrt(np.mean(off**2)) < 0.06 and abs(np.median(off)) < 0.02
        upside_down = relight_rti(image, capture.lights[number])[::-1] - seen
        assert np.mean(upside_down**2) > 3 * np.mean(off**2)


def test_planes_in_tiles_are_refused_as_what_they_are(tmp_path):
    write_rti(fit_rti(photographs(lamps(12))).image, tmp_path / "planes")
    (tmp_path / "planes" / "plane_0.jpg").rename(tmp_path / "planes" / "plane_0.dzi")
    with pytest.raises(ImageError, match="tiles of a deep zoom"):
        read_rti(tmp_path / "planes")
