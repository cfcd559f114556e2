"""Registration and the ink's edge -> a few numbers, each with a meaning.

What registration leaves is measured untrimmed and both ways. Two similarities are printed beside the mark and
are no part of it: the paper's, and one that a missing stroke cannot fool.

The edge of the ink shows how a brush was handled, whatever the character. People mark how strokes begin, end,
swell and turn as much as where they stand. Small patches along the edge show that. Each is written in the
principal components of patches from masters' edges (`edges.npz`, made by `scripts/fit_edges.py` from 250
characters of six stele works), and a picture of ink is described by the mean and the spread of each
component. Copy and master are described alike and compared: no point of the one has to be found in the other.
Upright patches are read with the page turned to each of its four sides, so that a mark does not depend on
which side is up. The reconstruction is ours; principal components of patches are standard.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rumu.registration.icp import pose_probe
from rumu.registration.points import RADIUS
from rumu.strokes.omissions import MasterInk, Region, find_regions
from rumu.values import FloatArray, Registration

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
KIND_NUMBERS = 2 * COMPONENTS + 1
"""Numbers of one kind from one side: the means, the log spreads and what the components leave."""
SIDES = {"upright": 4, "turned": 1}
EDGE_NUMBERS = KIND_NUMBERS * sum(SIDES[kind.frame] for kind in KINDS)
"""Length of a description."""
EDGE_AMOUNTS, EDGE_SENSES = KIND_NUMBERS * len(KINDS), KIND_NUMBERS
"""Numbers that `edge_amount` and `edge_sense` give."""
SMOOTHING = 1.5
"""Pixels of the canvas over which the edge is smoothed before its direction is taken."""
SHORTEST = 12
"""Pixels of an outline below which it is a speck."""

RESIDUALS = (
    "position",
    "plane_mean",
    "plane_extra",
    "plane_missing",
    "height",
    "direction",
    "whole",
    "whole_mean",
    "extra",
    "missing",
)
"""What registration leaves, in this order."""

FEATURE_GROUPS: Mapping[str, tuple[str, ...]] = {
    "plane": RESIDUALS[:4],
    "height": ("height",),
    "direction": ("direction",),
    "whole": RESIDUALS[6:],
    "edge_amount": tuple(f"edge_amount_{k}" for k in range(EDGE_AMOUNTS)),
    "edge_sense": tuple(f"edge_sense_{k}" for k in range(EDGE_SENSES)),
    "fullness": ("fullness",),
}
"""All features that a calibration may weigh, in the order of `Features.vector`, by what they rest on."""
FEATURE_NAMES: tuple[str, ...] = tuple(name for group in FEATURE_GROUPS.values() for name in group)
SIGNED_FEATURES: tuple[str, ...] = (*FEATURE_GROUPS["edge_sense"], *FEATURE_GROUPS["fullness"])
"""Features that may speak for a copy as well as against it; more of any other never raises a mark."""

SOFTENING = 0.05
"""Residual, in rms radii, below which differences hardly count: a pixel and a half of the common canvas."""
FULLNESS_RANGE = 0.3
"""Natural logarithm of size, either way, up to which the human marks at hand speak."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """What registration leaves between copy and master, both ways, in rms radii of the ink unless said.

    position: rms distance in the plane; plane_mean: its mean; plane_extra, plane_missing: its upper quartile
        from the copy's points to the master, and from the master's to the copy.
    height: rms difference of normalised height: stroke width for an inflated height.
    direction: rms difference of the doubled stroke direction, from 0 to 2.
    whole: rms distance in all five dimensions; whole_mean, extra, missing: as in the plane.
    """

    position: float = 0.0
    plane_mean: float = 0.0
    plane_extra: float = 0.0
    plane_missing: float = 0.0
    height: float = 0.0
    direction: float = 0.0
    whole: float = 0.0
    whole_mean: float = 0.0
    extra: float = 0.0
    missing: float = 0.0

    def logarithms(self) -> FloatArray:
        """(10,) natural logarithms in the order of RESIDUALS, softened near zero."""
        return np.log(np.array([getattr(self, name) for name in RESIDUALS]) + SOFTENING)


@dataclass(frozen=True, slots=True)
class Features:
    """All that a mark is made of.

    residuals: see Residuals.
    lean: degrees, positive clockwise. offset: distance from the master's place, fraction of the cell.
    size: natural logarithm of the copy's size over the master's; 0 is the same.
    weight: natural logarithm of the copy's mean normalised height over the master's; for an inflated
        height above 0 means heavier strokes.
    regions: where copy and master part.
    edges: the copy's description of its edge less the master's, as `describe_edge` orders it.
    """

    residuals: Residuals
    lean: float
    offset: float
    size: float
    weight: float
    regions: tuple[Region, ...] = ()
    edges: tuple[float, ...] = (0.0,) * EDGE_NUMBERS

    def vector(self) -> FloatArray:
        """(len(FEATURE_NAMES),) float64: log residuals, how much the edge differs and which way, fullness."""
        edges = np.array(self.edges)
        full = np.clip(self.size, -FULLNESS_RANGE, FULLNESS_RANGE)
        return np.concatenate([self.residuals.logarithms(), edge_amount(edges), edge_sense(edges), [full]])


def measure_features(registration: Registration, *, edges: FloatArray, ink: MasterInk) -> Features:
    """Features of one registration.

    edges: (EDGE_NUMBERS,) description of the copy's edge less the master's. ink: the master's.
    """
    heights = registration.probe.xyz[:, 2].mean(), registration.reference.xyz[:, 2].mean()
    return Features(
        residuals=residuals(registration),
        lean=registration.angle,
        offset=float(np.hypot(*registration.shift)),
        size=float(np.log(registration.scale)),
        weight=float(np.log(max(heights[0], 1e-6) / max(heights[1], 1e-6))),
        regions=find_regions(registration, ink),
        edges=tuple(edges.tolist()),
    )


def residuals(registration: Registration) -> Residuals:
    """The residuals of one registration."""
    p, x = pose_probe(registration), registration.reference.xyz
    a = 2 * np.deg2rad(registration.angle)
    d = registration.probe.direction @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    e = registration.reference.direction
    i, j = registration.forward_index, registration.backward_index
    space = np.vstack([p - x[i], p[j] - x])
    turn = np.vstack([d - e[i], d[j] - e])
    flat = np.hypot(space[:, 0], space[:, 1])
    whole = np.concatenate([registration.forward, registration.backward])
    return Residuals(
        position=_rms(space[:, :2]),
        plane_mean=float(flat.mean()),
        plane_extra=float(np.percentile(flat[: len(p)], 75)),
        plane_missing=float(np.percentile(flat[len(p) :], 75)),
        height=_rms(space[:, 2:]),
        direction=_rms(turn),
        whole=float(np.sqrt(np.mean(whole * whole))),
        whole_mean=float(whole.mean()),
        extra=float(np.percentile(registration.forward, 75)),
        missing=float(np.percentile(registration.backward, 75)),
    )


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference * difference, axis=1))))


def sim_paper(registration: Registration) -> float:
    """Eq. (26): SIM = (1 - d_ms / ||X||_F) * 100 %, as printed; X the reference's points, in rms radii.

    Kept for comparison and never used as the mark: d_ms is a squared length and ||X||_F a length, so the
    unit decides; ||X||_F grows with the number of points, so any two characters read above 99; and
    d_ms is one-sided, so a copy of a single stroke reads 100.
    """
    return float((1.0 - registration.d_ms / np.linalg.norm(registration.reference.xyz)) * 100.0)


def similarity(registration: Registration) -> float:
    """Two-sided similarity (ours): 1 - max(E_f, E_b) / r_X; 1 is identical, unrelated shapes about 0.7.

    E_f, E_b: rms distance in (x, y, z) from copy to master and from master to copy after registration;
    r_X: rms distance of the master's points from their mean. Free of unit, origin and number of points.
    """
    p, x = pose_probe(registration), registration.reference.xyz
    forward = p - x[registration.forward_index]
    backward = x - p[registration.backward_index]
    error = max(float(np.mean(np.sum(d * d, axis=1))) for d in (forward, backward))
    spread = float(np.var(x, axis=0).sum())
    return 1.0 - float(np.sqrt(error / spread))


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Principal components of one kind of patch.

    mean: (SAMPLES**2,). components: (SAMPLES**2, COMPONENTS), orthonormal columns, the largest first.
    spread: (COMPONENTS,) standard deviation of each over masters' edges.
    """

    mean: FloatArray
    components: FloatArray
    spread: FloatArray


def describe_edge(ink: FloatArray, *, lean: float = 0.0) -> FloatArray:
    """(CANVAS, CANVAS) ink in [0, 1] on the common canvas -> (EDGE_NUMBERS,) float64.

    lean: degrees clockwise by which the ink leans; taken out of the upright patches, it is charged apart.
    """
    points, along = _edge(ink)
    found = []
    for kind, bases in zip(KINDS, _bases(), strict=True):
        cut = patches(ink, points, along, kind=kind, lean=lean)
        found += [_in_components(cut, basis) for basis in bases]
    return np.concatenate(found)


def edge_amount(difference: FloatArray) -> FloatArray:
    """(EDGE_NUMBERS,) difference of descriptions -> (EDGE_AMOUNTS,) how much, whichever side is up."""
    sided = np.abs(difference).reshape(-1, KIND_NUMBERS)
    ends = np.cumsum([SIDES[kind.frame] for kind in KINDS])
    return np.concatenate([part.mean(axis=0) for part in np.split(sided, ends[:-1])])


def edge_sense(difference: FloatArray) -> FloatArray:
    """(EDGE_NUMBERS,) -> (EDGE_SENSES,) which way the patches that are turned with the edge differ."""
    return np.asarray(difference[-KIND_NUMBERS:], dtype=float)


def _in_components(cut: FloatArray, basis: Basis) -> FloatArray:
    """(N, SAMPLES**2) patches -> (KIND_NUMBERS,) float64."""
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
