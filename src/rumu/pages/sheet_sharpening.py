"""What blur took from a cell of a photograph is given back, as far as noise allows: Wiener's filter.

A camera closes gaps between strokes and shortens their thin ends. The printed squares of the sheet say how
far edges are smeared, so the smear can be taken back. Source: Wiener, "Extrapolation, interpolation, and
smoothing of stationary time series" (1949).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class SharpeningSettings:
    """How much of the smear is taken back.

    noise: power of the noise over that of the writing, the same at all frequencies. least: pixels of smear,
    as a standard deviation, below which the picture is left as it is. rim: smears by which it is mirrored at
    its border.
    """

    noise: float = 0.02
    least: float = 0.35
    rim: float = 6.0


def sharpen(
    light: npt.NDArray[np.float32], *, smear: float, settings: SharpeningSettings | None = None
) -> npt.NDArray[np.float32]:
    """(H, W) light of a picture that was smeared, sharper; beside steep edges it may overshoot.

    light: 1 on paper, 0 on ink, linear. smear: standard deviation of the smear, in pixels of this picture.
    """
    from scipy.fft import irfft2, rfft2

    settings = settings or SharpeningSettings()
    if smear < settings.least:
        return light
    rim = min(int(np.ceil(settings.rim * smear)), min(light.shape) - 1)
    wide = np.pad(light, rim, mode="reflect")
    transfer = (
        _transfer(wide.shape[0], smear)[:, None] * _transfer(wide.shape[1], smear)[: wide.shape[1] // 2 + 1]
    )
    # paper, of frequency 0, keeps its level
    inverse = transfer * ((1 + settings.noise) / (transfer * transfer + settings.noise))
    sharp = irfft2(rfft2(wide) * inverse, s=wide.shape)
    return np.asarray(sharp[rim : rim + light.shape[0], rim : rim + light.shape[1]], np.float32)


def _transfer(count: int, smear: float) -> npt.NDArray[np.float32]:
    """(count,): what a Gaussian smear leaves of each frequency."""
    frequency = np.fft.fftfreq(count)
    return np.asarray(np.exp(-2 * (np.pi * smear * frequency) ** 2), np.float32)
