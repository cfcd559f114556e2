"""Relightable images whose weights are tables, compared with the sums of RelightLab and OpenLIME by terms."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from PIL import Image

from rumu.errors import ImageError
from rumu.rti.exchange import read_rti
from rumu.rti.image import relight_rti

SHAPE = (8, 9)
LAMPS = [(0.6, 0.0, 0.8), (-0.48, 0.36, 0.8), (0.0, -0.6, 0.8), (0.0, 0.0, 1.0), (0.28, 0.8, 0.53)]
RESOLUTION = 4


def write(folder, kind, space, *, luma=7, chroma=2, planes=8):
    """A folder as RelightLab writes it, of random numbers; its info."""
    rng = np.random.default_rng(3)
    count = luma + 2 * chroma if space == "mycc" else planes
    directions = len(LAMPS) if kind == "rbf" else RESOLUTION**2
    info = {
        "width": SHAPE[1], "height": SHAPE[0], "format": "jpg", "type": kind, "colorspace": space,
        "basis": rng.integers(0, 256, (count + 1) * directions * 3).tolist(),
        "materials": [{
            "range": rng.uniform(300, 900, count).tolist(), "scale": rng.uniform(0.5, 1, count).tolist(),
            "bias": rng.uniform(0.3, 0.7, count).tolist(),
        }],
    }  # fmt: skip
    info |= {"yccplanes": [luma, chroma, chroma]} if space == "mycc" else {"nplanes": count}
    info |= {"resolution": RESOLUTION} if kind == "bilinear" else {}
    info |= {"lights": [round(v, 3) for one in LAMPS for v in one], "sigma": 0.3} if kind == "rbf" else {}
    folder.mkdir()
    (folder / "info.json").write_text(json.dumps(info))
    for k in range(math.ceil(count / 3)):
        picture = rng.integers(0, 256, (*SHAPE, 3)).astype(np.uint8)
        Image.fromarray(picture).save(folder / f"plane_{k}.jpg", quality=95, subsampling=0)
    return info


def weights_of(info, light):
    """{direction: weight}"""
    x, y, z = light
    if info["type"] == "rbf":
        given = [info["lights"][3 * d : 3 * d + 3] for d in range(len(LAMPS))]
        all_of = [math.exp(-(math.dist(light, one) ** 2) / info["sigma"] ** 2) for one in given]
        kept = {d: w / sum(all_of) for d, w in enumerate(all_of) if w / sum(all_of) > 0.001}
        return {d: w / sum(kept.values()) for d, w in kept.items()}
    total = abs(x) + abs(y) + abs(z)
    u, v = (((x + y) / total + 1) / 2 * (RESOLUTION - 1), ((y - x) / total + 1) / 2 * (RESOLUTION - 1))
    i, j = (min(RESOLUTION - 2, max(0, math.floor(one))) for one in (u, v))
    du, dv = u - i, v - j
    return {
        i + j * RESOLUTION: (1 - du) * (1 - dv), i + 1 + j * RESOLUTION: du * (1 - dv),
        i + (j + 1) * RESOLUTION: (1 - du) * dv, i + 1 + (j + 1) * RESOLUTION: du * dv,
    }  # fmt: skip


def pixel_by_the_sums(info, samples, light):
    """[red, green, blue] of one pixel, whose planes hold these bytes."""
    directions = len(LAMPS) if info["type"] == "rbf" else RESOLUTION**2
    material = info["materials"][0]

    def colour(plane, channel):
        total = 0.0
        for d, weight in weights_of(info, light).items():
            byte = info["basis"][(plane * directions + d) * 3 + channel]
            total += weight * (byte / 255 if plane == 0 else (byte - 127) / material["range"][plane - 1])
        return total

    found = [colour(0, channel) for channel in range(3)]
    mixed = 3 * info["yccplanes"][1] if info["colorspace"] == "mycc" else 0
    for plane, byte in enumerate(samples):
        value = (byte / 255 - material["bias"][plane]) * material["scale"][plane]
        channels = range(3) if info["colorspace"] == "mrgb" else [plane % 3 if plane < mixed else 0]
        for channel in channels:
            found[channel] += colour(plane + 1, channel) * value
    if info["colorspace"] == "mycc":
        luma, first, second = found
        blue = luma - second / 2 - first / 2
        found = [blue + first, luma + second / 2, blue]
    return [min(1.0, max(0.0, one)) for one in found]


@pytest.mark.parametrize("kind", ["rbf", "bilinear"])
@pytest.mark.parametrize("space", ["mrgb", "mycc"])
def test_tables_are_what_relightlab_and_openlime_add_up(tmp_path, kind, space):
    info = write(tmp_path / "sheet", kind, space)
    image = read_rti(tmp_path / "sheet")
    count = 11 if space == "mycc" else 8
    planes = [np.asarray(Image.open(tmp_path / "sheet" / f"plane_{k}.jpg")) for k in range(-(-count // 3))]
    samples = np.concatenate(planes, axis=2)[..., :count]
    for light in [*LAMPS[:2], (0.1, 0.2, math.sqrt(0.95)), (0.0, 1.0, 0.0)]:
        shown = relight_rti(image, light)
        assert shown.shape == (*SHAPE, 3)
        for row, column in [(0, 0), (7, 8), (2, 4)]:
            wanted = pixel_by_the_sums(info, samples[row, column], light)
            assert shown[row, column] == pytest.approx(wanted, abs=1e-4)


def test_a_lamp_that_is_far_from_all_is_like_the_nearest(tmp_path):
    write(tmp_path / "sheet", "rbf", "mrgb")
    image = read_rti(tmp_path / "sheet")
    narrow = type(image)(*(getattr(image, name) for name in image.__slots__[:-1]), sigma=1e-3)
    near = (0.6, -0.01, 0.8)
    np.testing.assert_allclose(relight_rti(narrow, near), relight_rti(narrow, LAMPS[0]), atol=1e-6)


@pytest.mark.parametrize(
    ("space", "change", "words"),
    [
        ("mrgb", {"basis": [1, 2, 3]}, "a basis of"),
        ("mrgb", {"colorspace": "rgb"}, "colorspace mrgb or mycc"),
        ("mrgb", {"sigma": 0}, "a sigma above 0"),
        ("mrgb", {"lights": None}, "info.json"),
        ("mycc", {"yccplanes": [2, 3, 3]}, "yccplanes"),
        ("mrgb", {"materials": []}, "info.json"),
    ],
)
def test_what_is_damaged_is_refused(tmp_path, space, change, words):
    info = write(tmp_path / "sheet", "rbf", space)
    (tmp_path / "sheet" / "info.json").write_text(json.dumps(info | change))
    with pytest.raises(ImageError, match=words):
        read_rti(tmp_path / "sheet")


def test_a_lamp_behind_the_sheet_is_refused(tmp_path):
    write(tmp_path / "sheet", "bilinear", "mrgb")
    image = read_rti(tmp_path / "sheet")
    for light in [(0.0, 0.5, -0.5), (0.0, 0.0, 0.0), (1.0, 0.0)]:
        with pytest.raises(ImageError, match="expected a"):
            relight_rti(image, light)
