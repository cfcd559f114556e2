"""The tone curve of a photograph, and how far its edges are smeared, from the printed markers in it.

Where blur mixes ink and paper half and half, light is half-way between them, but the level that a camera
stores is not: how far from it depends on the camera, and strokes become thicker or thinner with it. What the
markers look like without a camera is known, so the curve and the smear are fitted to what is seen of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.pages.marker_light import PER_MODULE, cut_marker
from rumu.pages.sheet_markers import marker_modules
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class ToneSettings:
    """How the tone curve is fitted.

    most: markers, the largest, that it is fitted to. step: of their pixels each so many count. outlier:
    residual, over the paper, from which a pixel counts less. gamma, smear, black, paper, size: start of each
    number, least and most: see `fit_tone`. tolerance: relative change at which the fit ends.
    lowest, highest: exponents within which that of a camera lies; what is fitted beyond is taken for these.
    """

    most: int = 6
    step: int = 2
    outlier: float = 0.05
    gamma: tuple[float, float, float] = (1.8, 0.6, 4.0)
    smear: tuple[float, float, float] = (1.5, 0.3, 8.0)
    black: tuple[float, float, float] = (0.02, 0.0, 0.6)
    paper: tuple[float, float, float] = (1.0, 0.8, 1.3)
    size: tuple[float, float, float] = (1.0, 0.9, 1.12)
    tolerance: float = 1e-4
    lowest: float = 1.0
    highest: float = 2.6


@dataclass(frozen=True, slots=True)
class MarkerTone:
    """gamma: exponent that turns levels of the photograph over those of its paper into light.

    smear: standard deviation, in modules of a marker, by which edges are smeared.
    """

    gamma: float
    smear: float


def fit_tone(
    picture: npt.NDArray[np.uint8],
    markers: Sequence[tuple[int, FloatArray]],
    *,
    settings: ToneSettings | None = None,
) -> MarkerTone:
    """The tone curve of one channel of a photograph, (H, W), by least squares.

    markers: one or more, their numbers and corners (4, 2). Fitted are the exponent, the smear, the light of
    black, the level of paper, and the size of the markers over that between their corners: since the level
    at an edge is not half-way, their corners are found a little inside of them.
    """
    import cv2
    from scipy.optimize import least_squares

    settings = settings or ToneSettings()
    largest = sorted(markers, key=lambda one: -cv2.contourArea(one[1].astype(np.float32)))[: settings.most]
    seen = np.array([_over_paper(cut_marker(picture, corners)) for _, corners in largest])
    drawn = [_draw(number) for number, _ in largest]
    middle, step = (seen.shape[1] - 1) / 2, settings.step
    inside = np.s_[:, step:-step:step, step:-step:step]
    seen = seen[inside]

    def difference(numbers: FloatArray) -> FloatArray:
        gamma, smear, black, paper, size = numbers.tolist()
        place = np.array([[size, 0, middle * (1 - size)], [0, size, middle * (1 - size)]])
        light = np.array(
            [
                cv2.GaussianBlur(
                    cv2.warpAffine(one, place, one.shape, borderMode=cv2.BORDER_REPLICATE),
                    (0, 0),
                    smear,
                    borderType=cv2.BORDER_REPLICATE,
                )
                for one in drawn
            ]
        )
        level = paper * (black + (1 - black) * light[inside]) ** (1 / gamma)
        return np.asarray((level - seen).ravel(), np.float64)

    start, low, high = np.array(
        [settings.gamma, settings.smear, settings.black, settings.paper, settings.size]
    ).T
    fitted = least_squares(
        difference,
        start,
        bounds=(low, high),
        loss="soft_l1",
        f_scale=settings.outlier,
        diff_step=1e-3,
        ftol=settings.tolerance,
    ).x
    gamma = float(np.clip(fitted[0], settings.lowest, settings.highest))
    return MarkerTone(gamma, float(fitted[1]) / PER_MODULE)


def _over_paper(patch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """The levels of a marker over those of the paper around it."""
    return np.asarray(patch / max(float(np.quantile(patch, 0.9)), 1.0), np.float32)


def _draw(number: int) -> npt.NDArray[np.float32]:
    """A marker and a module of paper around it, 1 on paper, as `cut_marker` cuts it out."""
    light = np.pad(1 - marker_modules(number).astype(np.float32), 1, constant_values=1.0)
    return np.asarray(np.kron(light, np.ones((PER_MODULE, PER_MODULE), np.float32)))
