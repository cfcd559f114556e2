"""The edge of the ink, piece by piece: how a brush was handled, whatever the character.

People mark how strokes begin, end, swell and turn as much as where they stand. Small patches along the edge
show that. Each is written in the principal components of patches from masters' edges (`edges.npz`, made by
`scripts/fit_edges.py` from 250 characters of six stele works), and a picture of ink is described by the
mean and the spread of each component. Copy and master are described alike and compared: no point of the one
has to be found in the other. Upright patches are read with the page turned to each of its four sides, so that
a mark does not depend on which side is up. The reconstruction is ours; principal components of patches are
standard.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rumu.registration.points import RADIUS
from rumu.values import FloatArray

Frame = Literal["upright", "turned"]
ComplexArray = npt.NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, slots=True)
class PatchKind:
    """One way of cutting patches.

    frame: 'upright' as the page, so that the slant of an entry tells; 'turned' with the edge, so that
        only its shape does. half: half the side, in rms radii.
    """

    frame: Frame
    half: float


KINDS: tuple[PatchKind, ...] = (PatchKind("upright", 0.375), PatchKind("turned", 0.625))
SAMPLES = 13
"""Samples along the side of a patch."""
COMPONENTS = 16
"""Principal components kept of each kind."""
EACH = 2 * COMPONENTS + 1
"""Numbers of one kind from one side: the means, the log spreads and what the components leave."""
SIDES = {"upright": 4, "turned": 1}
NUMBERS = EACH * sum(SIDES[kind.frame] for kind in KINDS)
"""Length of a description."""
AMOUNTS, SENSES = EACH * len(KINDS), EACH
"""Numbers that `amount` and `sense` give."""
SMOOTHING = 1.5
"""Pixels of the canvas over which the edge is smoothed before its direction is taken."""
SHORTEST = 12
"""Pixels of an outline below which it is a speck."""


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Principal components of one kind of patch.

    mean: (SAMPLES**2,). components: (SAMPLES**2, COMPONENTS), orthonormal columns, the largest first.
    spread: (COMPONENTS,) standard deviation of each over masters' edges.
    """

    mean: FloatArray
    components: FloatArray
    spread: FloatArray


def describe(ink: FloatArray, *, lean: float = 0.0) -> FloatArray:
    """(CANVAS, CANVAS) ink in [0, 1] on the common canvas -> (NUMBERS,) float64.

    lean: degrees clockwise by which the ink leans; taken out of the upright patches, it is charged apart.
    """
    points, along = _edge(ink)
    found = []
    for kind, bases in zip(KINDS, _bases(), strict=True):
        cut = patches(ink, points, along, kind=kind, lean=lean)
        found += [_in_components(cut, basis) for basis in bases]
    return np.concatenate(found)


def amount(difference: FloatArray) -> FloatArray:
    """(NUMBERS,) difference of two descriptions -> (AMOUNTS,) how much they differ, whichever side is up."""
    sided = np.abs(difference).reshape(-1, EACH)
    ends = np.cumsum([SIDES[kind.frame] for kind in KINDS])
    return np.concatenate([part.mean(axis=0) for part in np.split(sided, ends[:-1])])


def sense(difference: FloatArray) -> FloatArray:
    """(NUMBERS,) -> (SENSES,) which way the patches that are turned with the edge differ."""
    return np.asarray(difference[-EACH:], dtype=float)


def _in_components(cut: FloatArray, basis: Basis) -> FloatArray:
    """(N, SAMPLES**2) patches -> (EACH,) float64."""
    left = cut - basis.mean
    z = left @ basis.components
    rest = np.maximum(np.sum(left * left, axis=1) - np.sum(z * z, axis=1), 0.0)
    z = z / basis.spread
    return np.concatenate(
        [z.mean(axis=0), np.log(z.std(axis=0) + 0.05), [np.log(rest.mean() + 1e-3)]]
    ).astype(float)


def patches(
    ink: FloatArray, points: ComplexArray, along: ComplexArray, *, kind: PatchKind, lean: float = 0.0
) -> FloatArray:
    """(N, SAMPLES**2) float32: the ink around each of N points, as complex columns + 1j rows.

    along: (N,) complex, unit, the direction of the edge with the ink on one side.
    """
    import cv2

    half = kind.half * RADIUS
    soft = cv2.GaussianBlur(np.asarray(ink, np.float32), (0, 0), half / SAMPLES)
    steps = np.linspace(-half, half, SAMPLES)
    grid = (steps[None, :] + 1j * steps[:, None]).ravel()
    apart = (along[:, None] if kind.frame == "turned" else np.exp(1j * np.deg2rad(lean))) * grid
    columns, rows = (
        (p[:, None] + a).astype(np.float32) for p, a in ((points.real, apart.real), (points.imag, apart.imag))
    )
    return np.asarray(cv2.remap(soft, columns, rows, cv2.INTER_LINEAR), np.float32)


def edge_patches(ink: FloatArray) -> tuple[FloatArray, ...]:
    """The patches of one picture, one array for each of KINDS: what a basis is made from."""
    points, along = _edge(ink)
    return tuple(patches(ink, points, along, kind=kind) for kind in KINDS)


def _edge(ink: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """All points of the edge, so that no choice of them moves a mark, and its direction there.

    (N,) each, complex columns + 1j rows.
    """
    import cv2

    full = ink > 0.5 * min(float(ink.max()), 1.0)
    outlines, _ = cv2.findContours(full.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    long = [c for c in outlines if len(c) >= SHORTEST] or list(outlines)
    smooth = [_smooth(c[:, 0, 0] + 1j * c[:, 0, 1]) for c in long]
    points, along = (np.concatenate([pair[k] for pair in smooth]) for k in (0, 1))
    return points, along / np.maximum(np.abs(along), 1e-6)


def _smooth(outline: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """A closed outline smoothed by SMOOTHING, and its derivative, both complex."""
    frequency = np.fft.fftfreq(len(outline))
    spectrum = np.fft.fft(outline) * np.exp(-2.0 * (np.pi * frequency * SMOOTHING) ** 2)
    return np.fft.ifft(spectrum), np.fft.ifft(spectrum * 2j * np.pi * frequency)


@lru_cache(maxsize=1)
def _bases() -> tuple[tuple[Basis, ...], ...]:
    """Of each kind a basis for each side."""
    with (files("rumu.assessment") / "edges.npz").open("rb") as stream, np.load(stream) as plain:
        return tuple(
            tuple(
                _rotated(
                    Basis(*(plain[f"{kind.frame}_{name}"] for name in ("mean", "components", "spread"))), k
                )
                for k in range(SIDES[kind.frame])
            )
            for kind in KINDS
        )


def _rotated(basis: Basis, quarters: int) -> Basis:
    """For patches of a page turned by so many quarters."""
    places = np.rot90(np.arange(SAMPLES**2).reshape(SAMPLES, SAMPLES), quarters).ravel()
    return Basis(basis.mean[places], basis.components[places], basis.spread)
