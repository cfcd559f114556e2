"""The ink's edge -> numbers that say how a brush was handled, whatever the character.

People mark how strokes begin, end, swell and turn as much as where they stand. Small patches along the edge,
turned with it, show that. Each is written in the principal components of patches from masters' edges
(`edges.npz`, made by `scripts/fit_edges.py` from 250 characters of six stele works), and a picture of ink is
described by the mean and the spread of each component. Three plain numbers stand beside them. Copy and
master are described alike and compared: no point of the one has to be found in the other, and no side of the
page is up. The reconstruction is ours; principal components of patches are standard.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.registration.points import RADIUS
from rumu.values import BoolArray, FloatArray

ComplexArray = npt.NDArray[np.complexfloating[Any, Any]]

HALF = 0.625
"""Half the side of a patch, in rms radii."""
SAMPLES = 13
"""Samples along the side of a patch."""
COMPONENTS = 16
"""Principal components kept."""
PATCH_NUMBERS = 2 * COMPONENTS + 1
"""Numbers from patches: the means, the log spreads and what the components leave."""
PLAIN = ("thinness", "turning", "width")
"""Plain numbers of the edge, as natural logarithms: ink that an opening of 5 pixels of the canvas takes
away, for each pixel of the edge; how much the smoothed outline turns; ink for each pixel of the edge."""
EDGE_NUMBERS = PATCH_NUMBERS + len(PLAIN)
"""Length of a description."""
SMOOTHING = 1.5
"""Pixels of the canvas over which the edge is smoothed before its direction is taken."""
TURNING_SMOOTHING = 3.0
"""The same before its turning is measured."""
_DISC = np.pad(np.ones((3, 3), np.uint8), 1, mode="constant")
_DISC[1:4, [0, 4]] = _DISC[[0, 4], 1:4] = 1  # 5 pixels across, the same from every side
SHORTEST = 12
"""Pixels of an outline below which it is a speck."""


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Principal components of patches.

    mean: (SAMPLES**2,). components: (SAMPLES**2, COMPONENTS), orthonormal columns, the largest first.
    spread: (COMPONENTS,) standard deviation of each over masters' edges.
    """

    mean: FloatArray
    components: FloatArray
    spread: FloatArray


def describe_edge(ink: FloatArray) -> FloatArray:
    """(CANVAS, CANVAS) ink in [0, 1] on the common canvas -> (EDGE_NUMBERS,) float64."""
    full = _full_ink(ink)
    outlines = _outlines(full)
    patches = _in_components(_patches(ink, outlines), _basis())
    return np.concatenate([patches, _plain_numbers(full, outlines)])


def edge_patches(ink: FloatArray) -> FloatArray:
    """(N, SAMPLES**2) the patches of one picture: what a basis is made from."""
    return _patches(ink, _outlines(_full_ink(ink)))


def _full_ink(ink: FloatArray) -> BoolArray:
    return np.asarray(ink > 0.5 * min(float(ink.max()), 1.0))


def _outlines(full: BoolArray) -> list[ComplexArray]:
    """Closed outlines of the ink as complex columns + 1j rows; all points, so that no choice moves a mark."""
    import cv2

    found, _ = cv2.findContours(full.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    long = [c for c in found if len(c) >= SHORTEST] or list(found)
    return [c[:, 0, 0] + 1j * c[:, 0, 1] for c in long]


def _smooth(outline: ComplexArray, width: float) -> tuple[ComplexArray, ComplexArray]:
    """A closed outline smoothed by `width` pixels, and its derivative, both complex."""
    frequency = np.fft.fftfreq(len(outline))
    spectrum = np.fft.fft(outline) * np.exp(-2.0 * (np.pi * frequency * width) ** 2)
    return np.fft.ifft(spectrum), np.fft.ifft(spectrum * 2j * np.pi * frequency)


def _patches(ink: FloatArray, outlines: list[ComplexArray]) -> FloatArray:
    """(N, SAMPLES**2) float32: the ink around each point of the edge, turned with the edge."""
    import cv2

    smooth = [_smooth(outline, SMOOTHING) for outline in outlines]
    points, along = (np.concatenate([pair[k] for pair in smooth]) for k in (0, 1))
    along /= np.maximum(np.abs(along), 1e-6)
    half = HALF * RADIUS
    soft = cv2.GaussianBlur(np.asarray(ink, np.float32), (0, 0), half / SAMPLES)
    steps = np.linspace(-half, half, SAMPLES)
    apart = along[:, None] * (steps[None, :] + 1j * steps[:, None]).ravel()
    columns, rows = (
        (p[:, None] + a).astype(np.float32) for p, a in ((points.real, apart.real), (points.imag, apart.imag))
    )
    return np.asarray(cv2.remap(soft, columns, rows, cv2.INTER_LINEAR), np.float32)


def _in_components(cut: FloatArray, basis: Basis) -> FloatArray:
    """(N, SAMPLES**2) patches -> (PATCH_NUMBERS,) float64."""
    left = cut - basis.mean
    z = left @ basis.components
    rest = np.maximum(np.sum(left * left, axis=1) - np.sum(z * z, axis=1), 0.0)
    z = z / basis.spread
    return np.concatenate(
        [z.mean(axis=0), np.log(z.std(axis=0) + 0.05), [np.log(rest.mean() + 1e-3)]]
    ).astype(float)


def _plain_numbers(full: BoolArray, outlines: list[ComplexArray]) -> FloatArray:
    """(len(PLAIN),) of the ink and its outlines."""
    import cv2

    length = sum(float(np.abs(_smooth(outline, SMOOTHING)[1]).sum()) for outline in outlines)
    turned, straight = 0.0, 0.0
    for outline in outlines:
        along = _smooth(outline, TURNING_SMOOTHING)[1]
        turned += float(np.abs(np.angle(along * np.conj(np.roll(along, 1)))).sum())
        straight += float(np.abs(along).sum())
    page = full.astype(np.uint8)
    thin = np.count_nonzero(page) - np.count_nonzero(cv2.morphologyEx(page, cv2.MORPH_OPEN, _DISC))
    length, straight = max(length, 1.0), max(straight, 1.0)
    return np.log([thin / length + 0.01, turned / straight + 0.01, np.count_nonzero(page) / length])


@lru_cache(maxsize=1)
def _basis() -> Basis:
    with (files("rumu.assessment") / "edges.npz").open("rb") as stream, np.load(stream) as plain:
        return Basis(*(plain[name] for name in ("mean", "components", "spread")))
