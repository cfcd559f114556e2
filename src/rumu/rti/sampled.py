"""Relightable images whose weights are tables: what RelightLab writes as 'rbf' and 'bilinear'.

What a pixel shows under a lamp is a colour that all pixels share, plus its coefficients times colours:

    value(lamp) = colour_0(lamp) + sum over p of coefficient_p * colour_p(lamp)

The colours are told for some lamps ('rbf', blended by how near they are) or for a square grid of directions
('bilinear', an octahedron laid flat and turned by 45 degrees), and lie between them elsewhere. In "mrgb" they
are red, green and blue; in "mycc" luma and two differences (YCoCg), of which a coefficient has one alone.
Facts from RelightLab's reader and OpenLIME's viewer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError
from rumu.values import FloatArray

Tables = Literal["rbf", "bilinear"]
TABLES: tuple[Tables, ...] = ("rbf", "bilinear")
_BAND = 500_000  # pixels that are relit at a time
_LEAST = 1e-3  # share of a lamp, of all, below which it does not count
_ZERO = 127  # the byte of a colour that is none
_TO_RGB = np.array([[1.0, 0.5, -0.5], [1.0, 0.0, 0.5], [1.0, -0.5, -0.5]])
"""Red, green and blue of luma and two differences (YCoCg)."""

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class SampledImage:
    """A relightable image with tables for weights.

    basis: 'rbf' or 'bilinear'. coefficients: (H, W, P) uint8; scale, bias: (P,), a coefficient is
    scale * (byte / 255 - bias). colours: (P + 1, D, 3) float64, red, green and blue for each of D lamps or
    directions, first that of all pixels. lights: (D, 3) toward the lamps of 'rbf', each of which reaches
    about `sigma`.
    """

    basis: Tables
    coefficients: Bytes
    scale: FloatArray
    bias: FloatArray
    colours: FloatArray
    lights: FloatArray | None = None
    sigma: float = 1.0


def relight_sampled(image: SampledImage, light: FloatArray) -> FloatArray:
    """(H, W, 3) float32 in [0, 1], as a screen shows it. light: (3,) toward the lamp, of unit length."""
    base, *rest = np.einsum("d,pdk->pk", _shares(image, light), image.colours)
    factors = image.scale[:, None] * np.array(rest)  # (P, 3)
    offset = (base - image.bias @ factors).astype(np.float32)
    factors = (factors / 255).astype(np.float32)
    height, width, planes = image.coefficients.shape
    flat = image.coefficients.reshape(-1, planes)
    lit = np.empty((height * width, 3), np.float32)
    for start in range(0, len(flat), _BAND):
        part = slice(start, start + _BAND)
        lit[part] = np.clip(flat[part].astype(np.float32) @ factors + offset, 0.0, 1.0)
    return lit.reshape(height, width, 3)


def _shares(image: SampledImage, light: FloatArray) -> FloatArray:
    """(D,) how much each lamp or direction of the tables counts under a lamp; 1 together."""
    if image.lights is not None:
        far2 = ((image.lights - light) ** 2).sum(axis=1)
        shares = np.exp(-(far2 - far2.min()) / image.sigma**2)
        shares /= shares.sum()
        shares[shares <= _LEAST] = 0.0
        return np.asarray(shares / shares.sum())
    side = round(image.colours.shape[1] ** 0.5)
    x, y, z = light
    across = np.array([x + y, y - x]) / (abs(x) + abs(y) + abs(z))
    place = (across + 1.0) / 2.0 * (side - 1)
    cell = np.clip(np.floor(place), 0, side - 2).astype(int)
    right, up = place - cell
    grid = np.zeros((side, side))  # rows by y
    grid[cell[1] : cell[1] + 2, cell[0] : cell[0] + 2] = np.outer([1 - up, up], [1 - right, right])
    return grid.reshape(-1)


def planes_of(info: dict[str, Any]) -> int:
    """How many coefficients an info.json of this kind tells. Raises ValueError for numbers that cannot be."""
    if info["colorspace"] != "mycc":
        return int(info["nplanes"])
    luma, *chroma = _ycc_planes(info)
    return luma + sum(chroma)


def sampled_image(info: dict[str, Any], coefficients: Bytes) -> SampledImage:
    """What an info.json tells of coefficients (H, W, P).

    Raises KeyError, IndexError, TypeError, ValueError for one that is damaged.
    """
    count = coefficients.shape[2]
    material = info["materials"][0]
    scale, bias, reach = (np.array(material[name], np.float64) for name in ("scale", "bias", "range"))
    if not scale.shape == bias.shape == reach.shape == (count,) or not np.isfinite([scale, bias]).all():
        raise ValueError(f"scale, bias and range of each of {count} planes")
    if not (np.isfinite(reach) & (reach != 0)).all():
        raise ValueError("a range of 0")
    lights, sigma = None, 1.0
    if info["type"] == "rbf":
        lights = np.array(info["lights"], np.float64).reshape(-1, 3)
        sigma, directions = float(info["sigma"]), len(lights)
        if not np.isfinite(lights).all() or not sigma > 0 or not directions:
            raise ValueError("lights and a sigma above 0")
    else:
        directions = int(info["resolution"]) ** 2
        if int(info["resolution"]) < 2:
            raise ValueError("a resolution of 2 or more")
    table = np.array(info["basis"], np.float64)
    if table.size != (count + 1) * directions * 3:
        raise ValueError(f"a basis of {(count + 1) * directions * 3} numbers, got {table.size}")
    colours = table.reshape(count + 1, directions, 3)
    colours[0] /= 255
    colours[1:] = (colours[1:] - _ZERO) / reach[:, None, None]
    if info["colorspace"] == "mycc":
        _, chroma, _ = _ycc_planes(info)
        own = np.array([plane % 3 if plane < 3 * chroma else 0 for plane in range(count)])
        colours[1:] *= (np.arange(3) == own[:, None])[:, None, :]
        colours = colours @ _TO_RGB.T
    return SampledImage(info["type"], coefficients, scale, bias, colours, lights, sigma)


def _ycc_planes(info: dict[str, Any]) -> tuple[int, int, int]:
    """Planes of luma and of each difference."""
    luma, first, second = (int(one) for one in info["yccplanes"])
    if first != second or not 0 <= first <= luma:
        raise ValueError(
            f"yccplanes with as much of both differences, not more than of luma, got {info['yccplanes']}"
        )
    return luma, first, second


def check_light(light: npt.ArrayLike) -> FloatArray:
    """(3,) of unit length. Raises ImageError for no direction, or one from behind the sheet."""
    given = np.asarray(light, np.float64)
    length = float(np.linalg.norm(given))
    if given.shape != (3,) or not np.isfinite(given).all() or length == 0:
        raise ImageError(f"expected a direction toward a lamp, (3,), finite and not 0, got {given.tolist()}")
    if given[2] < -1e-9 * length:
        raise ImageError(f"expected a lamp before the sheet, got one behind it (z = {given[2] / length:.3f})")
    return given / length
