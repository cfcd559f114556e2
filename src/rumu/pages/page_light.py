"""Uneven light on a page evened: one smooth field, taken from its paper.

Only light that changes slowly is evened. Where the paper itself is of two kinds, such as silk on a lighter
mount, no smooth field fits it and the picture stays as it is; so does a rubbing, which has hardly any paper.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.values import FloatArray

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class PageLightSettings:
    """How light is evened; in values of sRGB from 0 to 1, which are nearly a power of the light.

    side: longer side, in pixels, of the reduced picture in which paper is looked for. window: side of the
        square, as a share of that, in which paper is the brightest. degree: of the polynomial in x and y that
        the logarithm of the paper's value is. robust: deviation of it from which paper counts for less.
    uneven: the darkest paper over the brightest above which light counts as even. smooth: the largest typical
        deviation of the paper's logarithm from the field. dark: paper that is darker is none. most: the
        largest gain.
    """

    side: int = 240
    window: float = 0.07
    degree: int = 3
    robust: float = 0.03
    uneven: float = 0.92
    smooth: float = 0.02
    dark: float = 0.25
    most: float = 2.0


def even_light(picture: Picture, *, settings: PageLightSettings | None = None) -> Picture:
    """A page (H, W, 3) uint8 sRGB as if it were lit evenly; the same array where it is, or nothing tells."""
    import cv2

    settings = settings or PageLightSettings()
    height, width = picture.shape[:2]
    scale = settings.side / max(height, width)
    size = round(width * scale), round(height * scale)
    if scale >= 1 or min(size) < 8:
        return picture
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA).mean(axis=2).astype(np.float32) / 255
    window = round(settings.window * settings.side) | 1
    paper = cv2.dilate(cv2.medianBlur(small, 3), np.ones((window, window), np.uint8))
    paper = cv2.blur(paper, (window, window), borderType=cv2.BORDER_REPLICATE)
    if float(np.median(paper)) < settings.dark:
        return picture
    level = np.log(np.maximum(paper, 1e-3)).ravel().astype(float)
    fitted = _robust_fit(_terms(*size, settings.degree), level, settings)
    if float(np.median(np.abs(level - fitted))) > settings.smooth:
        return picture
    field = np.exp(fitted - np.quantile(fitted, 0.98)).reshape(paper.shape)
    if float(np.quantile(field, 0.02)) > settings.uneven:
        return picture
    gain = np.clip(1 / field, 1.0, settings.most).astype(np.float32)
    whole = cv2.resize(gain, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(
        np.dstack([cv2.multiply(picture[..., k], whole, dtype=cv2.CV_8U) for k in range(3)]), np.uint8
    )


def _terms(width: int, height: int, degree: int) -> FloatArray:
    """(width * height, k): the products of powers of x and y up to a degree, row by row."""
    x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    return np.stack([x.ravel() ** i * y.ravel() ** j for i, j in powers], axis=1)


def _robust_fit(terms: FloatArray, values: FloatArray, settings: PageLightSettings) -> FloatArray:
    """(n,): the polynomial that most of the values lie on."""
    weights = np.ones(len(values))
    fitted = values
    for _ in range(10):
        weighted = terms * weights[:, None]
        fitted = terms @ np.linalg.solve(weighted.T @ terms, weighted.T @ values)
        weights = 1 / (1 + ((values - fitted) / settings.robust) ** 2)
    return np.asarray(fitted)
