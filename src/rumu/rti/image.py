"""A relightable image: what each pixel shows is a weighted sum, whose weights depend on the lamp alone.

    value(lamp) = sum over k of  weight_k(lamp) * scale_k * (byte_k - bias_k)

with the weights of polynomial texture maps (Malzbender, Gelb, Wolters 2001) or of hemispherical harmonics
(Gautron, Krivanek, Pattanaik, Bouatouch 2004). Values are as a screen shows them (sRGB), as in all such
files.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError
from rumu.rti.sampled import SampledImage, check_light, relight_sampled
from rumu.values import FloatArray

Basis = Literal["ptm", "hsh"]
BASES: tuple[Basis, ...] = get_args(Basis)
TERMS: dict[Basis, tuple[int, ...]] = {"ptm": (6,), "hsh": (4, 9, 16)}
"""How many terms there are: of harmonics of 1st, 2nd and 3rd order (order + 1)^2."""
_BAND = 500_000
"""Pixels that are relit at a time."""

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class RtiImage:
    """A relightable image as its files store it.

    basis: 'ptm', terms u^2, v^2, uv, u, v, 1; or 'hsh', in the order of `harmonics`.
    coefficients: (H, W, C, K) uint8, rows from the top; C is 3, or 1 where a colour is lit by one luminance.
    scale, bias: (C, K) float64, a coefficient is scale * (byte - bias).
    colour: (H, W, 3) uint8, of each pixel in full light; None where each channel has its own coefficients.
    Raises ImageError where they do not belong together.
    """

    basis: Basis
    coefficients: Bytes
    scale: FloatArray
    bias: FloatArray
    colour: Bytes | None = None

    def __post_init__(self) -> None:
        shape = self.coefficients.shape
        if self.basis not in BASES or len(shape) != 4 or shape[3] not in TERMS[self.basis]:
            raise ImageError(f"expected coefficients of {BASES}, got {self.basis!r} with shape {shape}")
        if (shape[2], self.colour is None) not in ((3, True), (1, False)):
            raise ImageError(f"expected three channels, or one with a colour, got {shape[2]}")
        if self.colour is not None and self.colour.shape != (*shape[:2], 3):
            raise ImageError(f"expected a colour of shape {(*shape[:2], 3)}, got {self.colour.shape}")
        for name, numbers in (("scale", self.scale), ("bias", self.bias)):
            if numbers.shape != shape[2:] or not np.isfinite(numbers).all():
                raise ImageError(f"expected a finite {name} of shape {shape[2:]}, got {numbers.shape}")

    @property
    def terms(self) -> int:
        """How many coefficients each channel of a pixel has."""
        return int(self.coefficients.shape[3])


def relight_rti(image: RtiImage | SampledImage, light: npt.ArrayLike) -> FloatArray:
    """A relightable image under one lamp.

    Parameters
    ----------
    image
        As `read_rti` or `fit_rti` gives it.
    light
        (3,) toward the lamp, of any length: x right, y up, z to the camera, not behind the sheet.

    Returns
    -------
    (H, W, 3) float32 ndarray
        As a screen shows it (sRGB), in [0, 1].

    Raises
    ------
    ImageError
        When the direction is none, or lies behind the sheet.
    """
    if isinstance(image, SampledImage):
        return relight_sampled(image, check_light(light))
    weights = light_weights(np.asarray(light, np.float64)[None], basis=image.basis, terms=image.terms)[0]
    factors = (weights * image.scale).astype(np.float32)
    offsets = -(factors * image.bias).sum(axis=1).astype(np.float32)
    height, width, channels, terms = image.coefficients.shape
    flat = image.coefficients.reshape(-1, channels, terms)
    colour = None if image.colour is None else image.colour.reshape(-1, 3)
    lit = np.empty((height * width, 3), np.float32)
    for start in range(0, len(flat), _BAND):
        part = slice(start, start + _BAND)
        values = np.einsum("pck,ck->pc", flat[part].astype(np.float32), factors) + offsets
        if colour is not None:
            values = values * (colour[part].astype(np.float32) / 255)
        lit[part] = np.clip(values, 0.0, 1.0)
    return lit.reshape(height, width, 3)


def light_weights(lights: FloatArray, *, basis: Basis, terms: int) -> FloatArray:
    """(N, K) float64: by what each coefficient is multiplied under each lamp.

    lights: (N, 3), toward the lamps, of any length. terms: one of `TERMS` of the basis.
    Raises ImageError for a direction of no length, or from behind the sheet.
    """
    length = np.linalg.norm(lights, axis=-1, keepdims=True)
    if lights.ndim != 2 or lights.shape[1] != 3 or not np.isfinite(lights).all() or not (length > 0).all():
        raise ImageError(f"expected directions toward lamps, (N, 3), finite and not 0, got {lights.tolist()}")
    u, v, z = (lights / length).T
    if (z < -1e-9).any():
        raise ImageError(f"expected lamps before the sheet, got one behind it (z = {z.min():.3f})")
    if basis == "ptm":
        return np.stack([u * u, v * v, u * v, u, v, np.ones_like(u)], axis=1)
    return harmonics(np.arctan2(v, u), np.clip(z, 0.0, 1.0))[:, :terms]


def harmonics(tilt: FloatArray, cosine: FloatArray) -> FloatArray:
    """(N, 16) float64: real hemispherical harmonics of degree 0 to 3, in the order and signs of .rti files.

    tilt: (N,) radians. cosine: (N,) of the slant, in [0, 1]. Within a degree the terms stand from cos(m tilt)
    over m = 0 to sin(m tilt), m falling and rising; those of m = 2 have the sign turned, as all programs of
    the trade have it. Orthonormal over the hemisphere. Gautron et al., "A Novel Hemispherical Basis for
    Accurate and Efficient Rendering" (2004), Eq. 6 there: Legendre functions of 2 cos(slant) - 1.
    """
    c, pi = cosine, np.pi
    x = 2.0 * c - 1.0  # the shifted argument
    across = np.sqrt(c - c * c)  # half of sqrt(1 - x^2)
    of_degree_1 = np.sqrt(6 / pi) * across
    of_degree_2 = np.sqrt(30 / pi) * x * across
    two = -np.sqrt(30 / pi) * across**2
    of_degree_3 = 2 * np.sqrt(21 / pi) * across * (1 - 5 * across**2)
    two_of_3 = -np.sqrt(210 / pi) * x * across**2
    three = 2 * np.sqrt(35 / pi) * across**3
    return np.stack(
        [
            np.full_like(c, 1 / np.sqrt(2 * pi)),
            of_degree_1 * np.cos(tilt),
            np.sqrt(3 / (2 * pi)) * x,
            of_degree_1 * np.sin(tilt),
            two * np.cos(2 * tilt),
            of_degree_2 * np.cos(tilt),
            np.sqrt(5 / (2 * pi)) * (1 - 6 * across**2),
            of_degree_2 * np.sin(tilt),
            two * np.sin(2 * tilt),
            three * np.cos(3 * tilt),
            two_of_3 * np.cos(2 * tilt),
            of_degree_3 * np.cos(tilt),
            np.sqrt(7 / (2 * pi)) * x * (1 - 10 * across**2),
            of_degree_3 * np.sin(tilt),
            two_of_3 * np.sin(2 * tilt),
            three * np.sin(3 * tilt),
        ],
        axis=1,
    )
