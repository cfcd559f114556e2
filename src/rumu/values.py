"""The values that travel between the rooms; shape, unit and frame are checked here, once.

Frame: x right, y up, z toward the camera. Arrays are indexed [row, column]; rows grow downward, so
dz/drow = -q where q = dz/dy. Values are frozen: nothing is changed after it is made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from rumu.errors import CaptureError, RegistrationError, SurfaceError

FloatArray = npt.NDArray[np.floating[Any]]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

Source = Literal["photometric", "inflation", "density"]
Unit = Literal["mm", "px"]
Level = Literal["excellent", "good", "medium", "bad"]

SOURCES: tuple[Source, ...] = ("photometric", "inflation", "density")
UNITS: tuple[Unit, ...] = ("mm", "px")


class Bilingual(NamedTuple):
    """The same words in traditional Chinese and in English."""

    zh: str
    en: str


def _require(ok: bool, error: type[Exception], expected: str, came: object) -> None:
    if not ok:
        raise error(f"expected {expected}, got {came}")


def _require_finite(array: FloatArray, error: type[Exception], name: str) -> None:
    bad = int(array.size - np.count_nonzero(np.isfinite(array)))
    _require(bad == 0, error, f"{name} to be finite", f"{bad} values that are NaN or infinite")


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """N photographs of one sheet from one camera, each lit by one lamp.

    images: (N, H, W) or (N, H, W, 3) float32, linear in light, in [0, 1], N >= 3.
    lights: (N, 3) float64, unit length, from the sheet toward the lamp, not all in one plane.
    mask: (H, W) bool, True where the object is; all True when none was given.
    strengths: (N,) float64, relative strength of each lamp, mean 1; None when unknown.
    spacing: millimetres per pixel, None when unknown.
    names: the file each image came from, for messages.
    """

    images: FloatArray
    lights: FloatArray
    mask: BoolArray
    strengths: FloatArray | None = None
    spacing: float | None = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = self.images.shape[0]
        _require(
            self.images.ndim == 3 or (self.images.ndim == 4 and self.images.shape[3] == 3),
            CaptureError,
            "images of shape (N, H, W) or (N, H, W, 3)",
            self.images.shape,
        )
        _require(n >= 3, CaptureError, "at least 3 images", n)
        _require(self.lights.shape == (n, 3), CaptureError, f"lights of shape ({n}, 3)", self.lights.shape)
        _require(
            self.mask.shape == self.images.shape[1:3] and self.mask.dtype == np.bool_,
            CaptureError,
            f"a bool mask of shape {self.images.shape[1:3]}",
            f"{self.mask.dtype} {self.mask.shape}",
        )
        _require(bool(self.mask.any()), CaptureError, "a mask with at least one pixel", "an empty mask")
        _require_finite(self.images, CaptureError, "images")
        _require(float(self.images.min()) >= 0, CaptureError, "images of 0 or more", self.images.min())
        _require(
            self.spacing is None or (np.isfinite(self.spacing) and self.spacing > 0),
            CaptureError,
            "spacing > 0",
            self.spacing,
        )
        _require_finite(self.lights, CaptureError, "lights")
        lengths = np.linalg.norm(self.lights, axis=1)
        _require(bool(np.allclose(lengths, 1.0, atol=1e-6)), CaptureError, "unit light vectors", lengths)
        _require(
            float(np.linalg.svd(self.lights, compute_uv=False)[-1]) > 1e-3,
            CaptureError,
            "lamps that do not all lie in one plane",
            f"{n} directions of rank below 3",
        )
        if self.strengths is not None:
            _require(self.strengths.shape == (n,), CaptureError, f"{n} strengths", self.strengths.shape)
            _require(bool((self.strengths > 0).all()), CaptureError, "positive strengths", self.strengths)

    @property
    def gray(self) -> FloatArray:
        """(N, H, W) float32: mean of the colour channels."""
        return self.images if self.images.ndim == 3 else self.images.mean(axis=3)


class Deferred:
    """An array of a Surface that may be given as a recipe instead, a function without arguments.

    Then it is made when it is first asked for, checked like any other, and kept: the mark needs neither
    normals nor albedo, and they cost more than the height. A partial of a module's function pickles.
    """

    def __init__(self, check: Callable[[FloatArray, tuple[int, ...]], None]) -> None:
        self._check = check

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, surface: Surface | None, owner: type | None = None) -> FloatArray:
        if surface is None:
            raise AttributeError(self._name)  # a field without a default
        held = vars(surface)[self._name]
        if callable(held):
            held = held()
            self._check(held, surface.height.shape)
            vars(surface)[self._name] = held
        return held  # type: ignore[no-any-return]

    def __set__(self, surface: Surface, given: FloatArray | Callable[[], FloatArray]) -> None:
        vars(surface)[self._name] = given

    def check_given(self, surface: Surface) -> None:
        """Check the array, unless it is still to be made."""
        held = vars(surface)[self._name]
        if not callable(held):
            self._check(held, surface.height.shape)


def _check_normals(normals: FloatArray, shape: tuple[int, ...]) -> None:
    _require(normals.shape == (*shape, 3), SurfaceError, f"normals {(*shape, 3)}", normals.shape)
    _require_finite(normals, SurfaceError, "normals")
    lengths = np.linalg.norm(normals[::8, ::8], axis=-1)  # a sample: this is checked often
    _require(bool(np.allclose(lengths, 1.0, atol=1e-3)), SurfaceError, "unit normals", lengths.min())


def _check_albedo(albedo: FloatArray, shape: tuple[int, ...]) -> None:
    _require(albedo.shape in (shape, (*shape, 3)), SurfaceError, f"albedo of {shape}", albedo.shape)
    _require_unit_range(albedo, "albedo")


def _require_unit_range(array: FloatArray, name: str) -> None:
    _require_finite(array, SurfaceError, name)
    low, high = float(array.min()), float(array.max())
    _require(low >= 0 and high <= 1 + 1e-5, SurfaceError, f"{name} in [0, 1]", (low, high))


@dataclass(frozen=True, eq=False, kw_only=True)
class Surface:
    """A sheet as a surface.

    height: (H, W) float32, in `unit`, 0 at the paper or at the mean; finite everywhere.
    normals: (H, W, 3) float32, unit length, x right, y up, z to the camera.
    albedo: (H, W) or (H, W, 3) float32 in [0, 1], linear; lamp strength times albedo, scaled.
    mask: (H, W) bool. A relief: the ink. A photometric surface: the pixels that were measured.
    confidence: (H, W) float32 in [0, 1], 0 where the height was filled in.
    spacing: length of one pixel in `unit` (1.0 when the unit is 'px').
    source: where the height comes from. Only 'photometric' was measured; 'inflation' and 'density'
        are computed from the ink of one image and say nothing about real relief.
    quality: named figures about how well the capture fits (documented where they are made).
    """

    height: FloatArray
    normals: Deferred = Deferred(_check_normals)
    albedo: Deferred = Deferred(_check_albedo)
    mask: BoolArray
    confidence: FloatArray
    spacing: float
    unit: Unit
    source: Source
    quality: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shape = self.height.shape
        _require(len(shape) == 2, SurfaceError, "a height map of shape (H, W)", shape)
        _require(self.mask.shape == shape, SurfaceError, f"a mask of {shape}", self.mask.shape)
        _require(self.mask.dtype == np.bool_, SurfaceError, "a bool mask", self.mask.dtype)
        _require(self.confidence.shape == shape, SurfaceError, f"confidence {shape}", self.confidence.shape)
        _require_finite(self.height, SurfaceError, "height")
        _require_unit_range(self.confidence, "confidence")
        for name in ("normals", "albedo"):
            vars(Surface)[name].check_given(self)
        _require(self.unit in UNITS, SurfaceError, f"a unit among {UNITS}", self.unit)
        _require(self.source in SOURCES, SurfaceError, f"a source among {SOURCES}", self.source)
        _require(np.isfinite(self.spacing) and self.spacing > 0, SurfaceError, "spacing > 0", self.spacing)


@dataclass(frozen=True, slots=True, eq=False)
class Polyline:
    """A line through points, with its half-width at each of them.

    points: (n >= 1, 2) float64, along the line; whoever makes it names the frame and the unit.
    radius: (n,) float64, half-width there, in the unit of the points.
    """

    points: FloatArray
    radius: FloatArray

    def __post_init__(self) -> None:
        n = len(self.points)
        _require(
            self.points.shape == (n, 2) and n >= 1, SurfaceError, "(n >= 1, 2) points", self.points.shape
        )
        _require(self.radius.shape == (n,), SurfaceError, f"half-widths of ({n},)", self.radius.shape)
        _require_finite(self.points, SurfaceError, "points")
        _require_finite(self.radius, SurfaceError, "half-widths")

    @property
    def along(self) -> FloatArray:
        """(n,) float64, length of the line up to each point."""
        return np.asarray(np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.points, axis=0).T))]))

    @property
    def length(self) -> float:
        """Length of the whole line; 0 for a single point."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def chord(self) -> FloatArray:
        """(2,) float64, from the first point to the last."""
        return np.asarray(self.points[-1] - self.points[0])

    def reversed(self) -> Self:
        """The same line from its other end."""
        return replace(self, points=self.points[::-1], radius=self.radius[::-1])

    def part(self, first: int, last: int) -> Self:
        """The line from the point numbered `first` to the one numbered `last`, both included."""
        return replace(self, points=self.points[first : last + 1], radius=self.radius[first : last + 1])


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """Ink points of one surface, in the frame of its own cell.

    xyz: (N, 3) float64. x right, y up, origin at the centroid of the ink; x, y in units of the rms
        radius of the ink (rms distance from the centroid is 1), z the normalised height times its weight.
    direction: (N, 2) float64, (cos 2t, sin 2t) of the stroke direction t, of length 1 or 0.
    centre: (2,) float64, the centroid from the image's centre, as a fraction of its longer side, y up.
    radius: the rms radius as a fraction of the image's longer side.
    pixel: length of one pixel in units of the rms radius.
    cell: (width, height) of the image as fractions of its longer side; one of them is 1.
    """

    xyz: FloatArray
    direction: FloatArray
    centre: FloatArray
    radius: float
    pixel: float
    cell: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        n = self.xyz.shape[0]
        _require(self.xyz.shape == (n, 3) and n >= 3, RegistrationError, "(N >= 3, 3) points", self.xyz.shape)
        _require(
            self.direction.shape == (n, 2), RegistrationError, f"directions of ({n}, 2)", self.direction.shape
        )
        _require_finite(self.xyz, RegistrationError, "points")
        _require_finite(self.direction, RegistrationError, "directions")


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """The rigid pose that lays the probe on the reference, and what remains.

    T_reference_probe: (4, 4) float64, det of its rotation is +1; applied to `probe.xyz`.
    scale: rms radius of the probe's ink over that of the reference, both as fractions of their cells;
        removed before registration, never by it. 1 is the same size.
    angle: degrees, rotation about z that was needed; positive when the probe leans clockwise.
    shift: (2,) float64, how far the writing stands from its place in the cell, x right, y up, in
        fractions of the cell's longer side.
    overlap: share of the pairs kept by trimming, in [0.4, 1]; trimming serves the pose alone.
    d_ms: mean squared distance in (x, y, z) of the probe's points to their nearest reference points,
        untrimmed, in rms radii squared.
    forward: (N,) float64, distance of each probe point, posed, to its nearest reference point in
        position, height and weighted stroke direction; forward_index: (N,) which one that is.
    backward: (M,) the same from each reference point to the probe; backward_index: (M,).
    converged: False when the loop ended on its iteration limit.
    """

    probe: PointSet
    reference: PointSet
    T_reference_probe: FloatArray
    scale: float
    angle: float
    shift: FloatArray
    overlap: float
    d_ms: float
    forward: FloatArray
    forward_index: IntArray
    backward: FloatArray
    backward_index: IntArray
    converged: bool
    iterations: int

    def __post_init__(self) -> None:
        T = self.T_reference_probe
        _require(T.shape == (4, 4), RegistrationError, "a (4, 4) pose", T.shape)
        _require_finite(T, RegistrationError, "the pose")
        det = float(np.linalg.det(T[:3, :3]))
        _require(abs(det - 1.0) < 1e-6, RegistrationError, "a rigid pose of determinant +1", det)


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing a teacher would say.

    kind: name of the fault, e.g. 'lean', 'size', 'missing', 'extra', 'heavy'.
    size: how large, in `unit`; severity: points of the mark it stands for, for ordering.
    region: (x0, y0, x1, y1) in fractions of the copy's cell, origin top left; None for the whole.
    zh, en: what is wrong and what to do.
    outline: lines of (x, y) in the same fractions that trace the strokes it speaks of; where a missing stroke
        should stand; the edge of ink that is too much.
    """

    kind: str
    size: float
    unit: str
    severity: float
    region: tuple[float, float, float, float] | None
    zh: str
    en: str
    outline: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Assessment:
    """A mark and what it rests on.

    score: 0-100 on the scale of the human panel that calibrated it; None when refused.
    level: 'excellent', 'good', 'medium' or 'bad'; None when refused.
    interval: 80 % interval of the panel's mark; None when refused.
    sim_paper: the paper's similarity, in per cent, as printed. Saturates near 100; never the mark.
    similarity: two-sided similarity, 1 is identical, below about 0.7 unrelated.
    parts: 'brushwork', 'structure', 'ink', each 0-100.
    source: where the heights of copy and master come from.
    refused: the reason when the copy cannot be marked, 'code: sentence', else None; refused_zh: the same in
        Chinese, the sentence alone.
    weights: a teacher's own, of the parts, that the score rests on; None for those fitted to people's marks.
    calibration: what another calibration was fitted on, in words; None for the panel that ships with rumu.
    script: 'seal', 'clerical', 'regular', 'running' or 'cursive' where it was told.
    interval_note, interval_note_zh: what must be said of the interval; None where people's marks cover it.
    """

    score: float | None
    level: Level | None
    interval: tuple[float, float] | None
    sim_paper: float | None
    similarity: float | None
    parts: Mapping[str, float]
    remarks: tuple[Remark, ...]
    registration: Registration | None
    source: tuple[Source, Source] | None
    refused: str | None = None
    refused_zh: str | None = None
    weights: Mapping[str, float] | None = None
    calibration: str | None = None
    script: str | None = None
    interval_note: str | None = None
    interval_note_zh: str | None = None
