"""Relightable images for web pages: JPEGs and an info.json, which RelightLab writes and OpenLIME reads.

Three coefficients make the red, green and blue of one JPEG, plane_0.jpg and so on; a coefficient is
(sample - bias) * scale with samples in [0, 1]. Of "rgb" a JPEG holds one term of the three channels. Of
"lrgb" the first JPEG is the colour, and each other one holds three terms of the luminance. The terms of a
polynomial stand in the order 1, u, v, u^2, uv, v^2; harmonics have up to nine. Facts from OpenLIME's
documentation and viewer.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import ImageError
from rumu.inputs import read_json
from rumu.outputs import whole_folder
from rumu.rti.image import TERMS, Basis, Bytes, RtiImage
from rumu.rti.sampled import TABLES, SampledImage, planes_of, sampled_image
from rumu.values import FloatArray

INFO = "info.json"
_PTM_ORDER = [5, 3, 4, 0, 2, 1]  # of our u^2, v^2, uv, u, v, 1
_MOST_TERMS = 9  # of harmonics that OpenLIME has weights for
_QUALITY = 95
"""Of the JPEGs, whose errors the scales multiply."""


def write_planes(
    image: RtiImage,
    folder: str | Path,
    *,
    lights: FloatArray | None = None,
    spacing: float | None = None,
    quality: int = _QUALITY,
) -> None:
    """Write a relightable image as a folder of JPEGs with an info.json; it appears whole or not at all.

    lights: (N, 3) toward the lamps of the photographs. spacing: millimetres for each pixel. quality: of the
    JPEGs, 1-100, without chroma subsampling.
    Raises ImageError for more terms than OpenLIME has, OutputError when the folder cannot be written.
    """
    from PIL import Image

    if image.terms > _MOST_TERMS:
        raise ImageError(
            f"expected at most {_MOST_TERMS} terms (order 2), which OpenLIME shows, got {image.terms}",
            name=folder,
        )
    order = _PTM_ORDER if image.basis == "ptm" else list(range(image.terms))
    if image.colour is not None and image.terms % 3:
        raise ImageError("expected a number of terms that three divide beside a colour", name=folder)
    planes = _planes(image, order)
    scale, bias = (_in_planes(numbers, image, order) for numbers in (255 * image.scale, image.bias / 255))
    if image.colour is not None:
        scale, bias = np.concatenate([np.ones(3), scale]), np.concatenate([np.zeros(3), bias])
    height, width = image.coefficients.shape[:2]
    info: dict[str, Any] = {
        "width": width,
        "height": height,
        "format": "jpg",
        "type": image.basis,
        "colorspace": "rgb" if image.colour is None else "lrgb",
        "nplanes": 3 * len(planes),
        "quality": quality,
        "materials": [{"scale": scale.tolist(), "bias": bias.tolist()}],
    }
    if lights is not None:
        info["lights"] = np.asarray(lights, np.float64).reshape(-1).tolist()
    if spacing is not None:
        info["pixelSizeInMM"] = spacing
    with whole_folder(folder, marker=INFO) as new:
        for number, plane in enumerate(planes):
            jpeg = Image.fromarray(np.ascontiguousarray(plane))
            jpeg.save(new / f"plane_{number}.jpg", quality=quality, subsampling=0)
        (new / INFO).write_text(json.dumps(info, indent=1) + "\n", encoding="utf-8")


def read_planes(path: str | Path) -> RtiImage | SampledImage:
    """A folder with an info.json, or the info.json itself, of a polynomial, of harmonics or of tables.

    Raises ImageError naming what is missing, damaged or of another kind.
    """
    path = Path(path)
    file = path / INFO if path.is_dir() else path
    info = read_json(file, error_type=ImageError, expected="the info.json of a relightable image")
    if isinstance(info, dict) and info.get("type") in TABLES:
        return _read_sampled(file, info)
    try:
        basis, space, count = info["type"], info["colorspace"], int(info["nplanes"])
        shape = int(info["height"]), int(info["width"])
        material = info["materials"][0]
        scale, bias = (np.array(material[name], np.float64) for name in ("scale", "bias"))
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ImageError(f"expected the info.json of a relightable image ({error!r})", name=file) from error
    if basis not in TERMS or space not in ("rgb", "lrgb") or info.get("format", "jpg") != "jpg":
        raise ImageError(
            "expected type ptm or hsh, colorspace rgb or lrgb, or type rbf or bilinear, colorspace mrgb or "
            f"mycc, format jpg, got {basis!r}, {space!r}, {info.get('format')!r}",
            name=file,
        )
    terms = count - 3 if space == "lrgb" else count // 3
    sound = scale.shape == bias.shape == (count,) and np.isfinite([scale, bias]).all() and (scale != 0).all()
    if count % 3 or terms not in TERMS[basis] or not sound:
        raise ImageError(f"expected a scale and a bias of each of {count} planes", name=file)
    return _of_planes(basis, space == "lrgb", _read_all(file, count, shape), scale, bias)


def _read_sampled(file: Path, info: dict[str, Any]) -> SampledImage:
    """A relightable image whose weights are tables."""
    try:
        space, count = info["colorspace"], planes_of(info)
        shape = int(info["height"]), int(info["width"])
        if space not in ("mrgb", "mycc") or info.get("format", "jpg") != "jpg" or not count > 0:
            raise ValueError(f"colorspace mrgb or mycc, format jpg, got {space!r}, {info.get('format')!r}")
        planes = np.concatenate(_read_all(file, count, shape), axis=2)
        return sampled_image(info, np.ascontiguousarray(planes[..., :count]))
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ImageError(f"expected the info.json of a relightable image ({error!r})", name=file) from error


def _read_all(file: Path, count: int, shape: tuple[int, int]) -> list[Bytes]:
    """The JPEGs that hold so many planes, (H, W, 3) each."""
    if any((file.parent / f"plane_0{end}").exists() for end in (".dzi", ".tzi")):
        raise ImageError(
            "expected planes as whole JPEGs (plane_0.jpg), got tiles of a deep zoom (.dzi, .tzi); export the "
            "relightable image as images",
            name=file,
        )
    return [_read_plane(file.parent / f"plane_{i}.jpg", shape) for i in range(-(-count // 3))]


def _planes(image: RtiImage, order: list[int]) -> list[Bytes]:
    """The JPEGs (H, W, 3)."""
    if image.colour is None:
        return [image.coefficients[..., k] for k in order]
    parts = [image.coefficients[:, :, 0, order[k : k + 3]] for k in range(0, len(order), 3)]
    return [image.colour, *parts]


def _in_planes(numbers: FloatArray, image: RtiImage, order: list[int]) -> FloatArray:
    """(C * K,) scales or biases (C, K) as they follow each other in the planes of coefficients."""
    return np.asarray(numbers[:, order].T.reshape(-1) if image.colour is None else numbers[0, order])


def _of_planes(
    basis: Basis, is_lit_colour: bool, planes: list[Bytes], scale: FloatArray, bias: FloatArray
) -> RtiImage:
    order = _PTM_ORDER if basis == "ptm" else list(range(len(planes)))
    back = np.argsort(order)
    if is_lit_colour:
        stored = np.concatenate(planes[1:], axis=2)[:, :, None, back]
        colour = np.clip((planes[0] / 255 - bias[:3]) * scale[:3] * 255, 0, 255).round().astype(np.uint8)
        return RtiImage(basis, stored, scale[None, 3:][:, back] / 255, 255 * bias[None, 3:][:, back], colour)
    stored = np.stack([planes[k] for k in back], axis=3)
    scales, biases = (np.ascontiguousarray(one.reshape(-1, 3).T[:, back]) for one in (scale, bias))
    return RtiImage(basis, stored, scales / 255, 255 * biases)


def _read_plane(path: Path, shape: tuple[int, int]) -> Bytes:
    """(H, W, 3) bytes of one JPEG."""
    from rumu.capture.formats import decode

    stored = decode(path, encoding="linear")
    values = stored.values
    if values.dtype != np.uint8 or values.shape != (*shape, 3):
        raise ImageError(
            f"expected {shape[1]} x {shape[0]} pixels of three bytes, got {values.shape}", name=path
        )
    return np.asarray(values)
