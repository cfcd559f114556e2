"""Photographs of a capture fitted as a relightable image, by least squares, some pixels at a time.

All pixels have the same lamps, so one pseudo-inverse serves all of them, and a few where lamps stand near.
Beside the photographs in their own bits only the bytes of the result exist at full size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np

from rumu.capture.stored import to_srgb
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack, Progress, each_range
from rumu.rti.image import TERMS, Basis, RtiImage
from rumu.rti.lamp_places import LampPlaces
from rumu.values import Bilingual, Capture, FloatArray, IntArray

Channels = Literal["lrgb", "rgb"]
CHANNELS: tuple[Channels, ...] = get_args(Channels)
_LEVELS = 65536


@dataclass(frozen=True, slots=True)
class RtiSettings:
    """How a relightable image is fitted.

    beyond: share of the coefficients of a term that may lie beyond what its bytes reach, on either side; they
        are cut to the nearest. singular: singular value of the lamps' weights, as a share of the largest,
        below which the lamps do not tell that mixture of terms; it is then left out. bright: quantile over
        the lamps that counts as full light of a pixel; what is brighter is gloss, and has no say in its
        colour.
        looked_at: about how many pixels say how far the coefficients reach. tile: values that a thread
        works on at a time.
    """

    beyond: float = 1e-4
    singular: float = 0.02
    bright: float = 0.9
    looked_at: int = 400_000
    tile: int = 400_000


@dataclass(frozen=True, slots=True, eq=False)
class RtiFit:
    """A relightable image with how well it fits.

    residual: rms difference of the image before its coefficients became bytes from the photographs as a
    screen shows them, where 1 is white. told: how many mixtures of its terms the lamps tell. notes: what a
    person should know.
    """

    image: RtiImage
    residual: float
    told: int
    notes: tuple[Bilingual, ...]


def fit_rti(
    capture: Capture,
    *,
    basis: Basis = "ptm",
    order: int = 2,
    channels: Channels | None = None,
    settings: RtiSettings | None = None,
    progress: Progress | None = None,
) -> RtiFit:
    """Fit a relightable image to the photographs of a capture.

    Parameters
    ----------
    capture
        Its lamps are taken as they are; strengths that its lamp file tells are evened out. Those with
        positions count as near: each place has directions of its own.
    basis
        'ptm': a polynomial of second order in the lamp's direction. 'hsh': hemispherical harmonics.
    order
        Of the harmonics, 1 to 3: 4, 9 or 16 terms. A polynomial has 6.
    channels
        'lrgb': one luminance that lights a colour; 'rgb': coefficients of their own for each channel. When
        None 'lrgb' for polynomials, 'rgb' for harmonics.
    settings, progress
        See `RtiSettings`; called with what is done, how many parts of it are done and how many there are.

    Returns
    -------
    RtiFit
        The image, and how well it fits.

    Raises
    ------
    CaptureError
        When there are fewer lamps than terms, or an argument is none of those.
    """
    settings = settings or RtiSettings()
    if basis not in TERMS or (basis == "hsh" and order not in (1, 2, 3)):
        raise CaptureError(f"expected basis 'ptm', or 'hsh' of order 1, 2 or 3, got {basis!r} of {order}")
    channels = channels or ("lrgb" if basis == "ptm" else "rgb")
    if channels not in CHANNELS:
        raise CaptureError(f"expected channels among {', '.join(CHANNELS)}, got {channels!r}")
    terms = TERMS[basis][0 if basis == "ptm" else order - 1]
    stack, lamps = capture.photographs, len(capture.lights)
    if lamps < terms:
        raise CaptureError(
            f"expected at least {terms} photographs for {terms} terms, got {lamps}",
            zh=f"{terms} 項的擬合至少要 {terms} 張照片，這裡只有 {lamps} 張。",
        )
    places = LampPlaces.of(capture, basis=basis, terms=terms, singular=settings.singular)
    weaker = np.ones(lamps) if capture.strengths is None else capture.strengths.min() / capture.strengths
    fit = _LeastSquares(stack, places, weaker.astype(np.float32), channels, settings)
    scale, bias = fit.levels()
    image, residual = fit.whole(basis, scale, bias, progress)
    told = places.told
    return RtiFit(image, residual, told, () if told == terms else (_too_alike(told, terms),))


def _too_alike(told: int, terms: int) -> Bilingual:
    return Bilingual(
        f"燈的位置只能定出 {terms} 項中的 {told} 項（例如都在同一高度）；離這些燈遠的方向只是估計。",
        f"the lamps tell only {told} of {terms} terms, as when all stand equally high; what is shown under "
        "lamps far from them is a guess",
    )


@dataclass(frozen=True, slots=True, eq=False)
class _LeastSquares:
    """The photographs, and what makes coefficients of them. weaker: (N,) in (0, 1]."""

    stack: ImageStack
    places: LampPlaces
    weaker: FloatArray
    channels: Channels
    settings: RtiSettings

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """(K,) scale and (K,) bias of the bytes, so that nearly all coefficients of some pixels are in reach.

        The bias is a whole number in [0, 255], as .ptm files want it; so 0 is always in reach.
        """
        step = max(1, self.stack.pixels // self.settings.looked_at)
        pixels = np.arange(0, self.stack.pixels, step)
        found, _ = self._coefficients(self._shown(self.stack.at(pixels), pixels), pixels)
        share = self.settings.beyond
        low, high = np.quantile(found.reshape(len(found), -1), [share, 1 - share], axis=1)
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
        scale = np.maximum(high - low, 1e-3) / 254  # one less than 255: the bias is rounded
        return scale, np.round(-low / scale)

    def whole(
        self, basis: Basis, scale: FloatArray, bias: FloatArray, progress: Progress | None
    ) -> tuple[RtiImage, float]:
        """The image, and the rms residual."""
        height, width = self.stack.shape[1:3]
        count, terms = (1 if self.channels == "lrgb" else 3), len(scale)
        stored = np.empty((self.stack.pixels, count, terms), np.uint8)
        colour = np.empty((self.stack.pixels, 3), np.uint8) if count == 1 else None

        def one(part: slice) -> float:
            pixels = np.arange(part.start, part.stop)
            values = self._shown(self.stack.range(part.start, part.stop), pixels)
            found, full = self._coefficients(values, pixels)
            levels = found / scale[:, None, None].astype(np.float32) + bias[:, None, None].astype(np.float32)
            stored[part] = np.clip(np.round(levels), 0, 255).astype(np.uint8).transpose(1, 2, 0)
            if colour is not None:
                colour[part] = np.round(np.clip(full, 0, 1) * 255).astype(np.uint8)
            fitted = self.places.values(found, pixels)
            seen = values if values.ndim == 3 else values[..., None]
            off = (fitted * full if count == 1 else fitted) - seen
            return float(np.vdot(off, off)) / int(off.shape[2])

        size = max(1, self.settings.tile // len(self.stack))
        sums = each_range(
            one, self.stack.pixels, size=size, label="Fitting the relightable image", progress=progress
        )
        residual = np.sqrt(sum(sums) / (self.stack.pixels * len(self.stack)))
        image = RtiImage(
            basis,
            stored.reshape(height, width, count, terms),
            np.tile(scale, (count, 1)),
            np.tile(bias, (count, 1)),
            None if colour is None else colour.reshape(height, width, 3),
        )
        return image, float(residual)

    def _shown(self, light: FloatArray, pixels: IntArray) -> FloatArray:
        """(N, P[, 3]) linear light of some pixels as a screen shows it, in [0, 1]."""
        even = light * self.weaker.reshape(-1, *[1] * (light.ndim - 1))
        steepness = self.places.steepness(pixels)
        if steepness is not None:
            even *= steepness if even.ndim == 2 else steepness[..., None]
        levels = np.clip(even * np.float32(_LEVELS - 1) + np.float32(0.5), 0, _LEVELS - 1)
        return np.take(_screen_values(), levels.astype(np.uint16))

    def _coefficients(self, values: FloatArray, pixels: IntArray) -> tuple[FloatArray, FloatArray]:
        """(K, P, C) coefficients of values (N, P[, 3]), and (P, 3) the colour in full light, for 'lrgb'."""
        if self.channels == "rgb":
            each = values if values.ndim == 3 else np.repeat(values[..., None], 3, axis=2)
            return self.places.coefficients(each, pixels), np.ones((1, 3), np.float32)
        gray = values if values.ndim == 2 else values.mean(axis=2)
        rank = int(self.settings.bright * (len(gray) - 1))
        full = np.maximum(np.partition(gray, rank, axis=0)[rank], np.float32(1e-4))
        colour = np.ones((1, 3), np.float32)
        if values.ndim == 3:  # which, lit by the luminance, comes nearest to the photographs without gloss
            trust = np.where(gray <= full, gray, np.float32(0))
            power = np.maximum((trust * gray).sum(axis=0), np.float32(1e-8))
            colour = np.einsum("np,npc->pc", trust, values) / power[:, None]
        return self.places.coefficients((gray / full)[..., None], pixels), colour * full[:, None]


@lru_cache(maxsize=1)
def _screen_values() -> FloatArray:
    """(65536,) float32: the sRGB value of each level of linear light."""
    return to_srgb(np.linspace(0.0, 1.0, _LEVELS)).astype(np.float32)
