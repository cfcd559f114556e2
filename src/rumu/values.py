"""The values that pass from one package to the next; shape, unit and frame are checked here, once.

Frame: x right, y up, z toward the camera. Arrays are indexed [row, column]; rows grow downward: dz/drow = -q
where q = dz/dy. Values are frozen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple, Self, get_args

import numpy as np
import numpy.typing as npt

from rumu.errors import CaptureError, RegistrationError, SurfaceError
from rumu.image_stack import ImageStack, KeepsPhotographs

FloatArray = npt.NDArray[np.floating[Any]]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]
Source = Literal["photometric", "inflation", "density"]
Unit = Literal["mm", "px"]
Level = Literal["excellent", "good", "medium", "bad"]
Script = Literal["seal", "clerical", "regular", "running", "cursive"]
SOURCES: tuple[Source, ...] = ("photometric", "inflation", "density")
_SCRIPTS_ZH = ("篆書", "隸書", "楷書", "行書", "草書")
SCRIPTS: dict[Script, str] = dict(zip(get_args(Script), _SCRIPTS_ZH, strict=True))
"""The five scripts and their names in Chinese."""


class Bilingual(NamedTuple):
    """The same words in traditional Chinese and in English."""

    zh: str
    en: str


Array = FloatArray | Callable[[], FloatArray]
"""An array, or a function without arguments that computes it when it is first asked for."""


def _require(error: type[Exception], holds: bool, expected: str, came: object) -> None:
    """Raise `error` with what was expected and what came, unless the condition holds."""
    if not holds:
        raise error(f"expected {expected}, got {came}")


def _require_finite(error: type[Exception], array: FloatArray, name: str) -> None:
    if array.size >= 10_000 or not np.isfinite(np.vdot(array, array)):  # the quickest answer for a short line
        ends = float(array.min(initial=0)), float(array.max(initial=0))  # NaN, where there is any
        _require(error, bool(np.isfinite(ends).all()), f"{name} to be finite", "values that are NaN or inf")


def _require_unit_range(error: type[Exception], array: FloatArray, name: str) -> None:
    _require_finite(error, array, name)
    low, high = float(array.min()), float(array.max())
    _require(error, low >= 0 and high <= 1 + 1e-5, f"{name} in [0, 1]", (low, high))


@dataclass(frozen=True, eq=False)
class Capture(KeepsPhotographs):
    """N photographs of one sheet from one camera, each lit by one lamp.

    Parameters
    ----------
    images
        (N, H, W) or (N, H, W, 3) float32, N >= 3, linear in light, 0 or more; 1 is the sensor's white. May be
        given as an ImageStack, whose photographs keep their own bits; `photographs` has that of any capture.
    lights
        (N, 3) float64, unit vectors from the sheet toward each lamp (x right, y up, z toward the camera),
        not all in one plane.
    mask
        (H, W) bool, True where the object is; all True when none was given.
    strengths, spacing, positions
        (N,) float64, relative strength of each lamp, mean 1; millimetres per pixel; (N, 3) float64, pixels
        from the middle, of near lamps in images free of fall-off (capture/dome.py); None when unknown.
    names, notes
        The file that each image came from; what was read otherwise than it was written there.
    orientation, lamps_as_given
        'exif' if images were turned so, 'stored' if not, None without it; whether to take the lamps anyhow.

    Raises
    ------
    CaptureError
        When photographs, lamps and mask do not belong together; the message names the one that does not.
    """

    images: FloatArray  # type: ignore[assignment]
    lights: FloatArray
    mask: BoolArray
    strengths: FloatArray | None = None
    spacing: float | None = None
    names: tuple[str, ...] = ()
    orientation: Literal["stored", "exif"] | None = None
    notes: tuple[Bilingual, ...] = ()
    lamps_as_given: bool = False
    positions: FloatArray | None = None

    def __post_init__(self) -> None:
        require = partial(_require, CaptureError)
        images, lights, mask, spacing = self.__dict__["images"], self.lights, self.mask, self.spacing
        n, shape = images.shape[0], images.shape[1:3]
        gray_or_colour = len(images.shape) in (3, 4) and images.shape[3:] in ((), (3,))
        require(gray_or_colour, "images of shape (N, H, W) or (N, H, W, 3)", images.shape)
        require(n >= 3, "at least 3 images", n)
        require(lights.shape == (n, 3), f"lights of shape ({n}, 3)", lights.shape)
        is_mask = mask.shape == shape and mask.dtype == np.bool_ and bool(mask.any())
        require(is_mask, f"a bool mask of shape {shape}, not empty", f"{mask.dtype} {mask.shape}")
        if not isinstance(images, ImageStack):  # which was checked when it was decoded
            _require_finite(CaptureError, images, "images")
            require(images.min() >= 0, "images of 0 or more", images.min())
        require(spacing is None or (np.isfinite(spacing) and spacing > 0), "spacing > 0", spacing)
        _require_finite(CaptureError, lights, "lights")
        require(np.allclose(np.linalg.norm(lights, axis=1), 1, atol=1e-6), "unit light vectors", lights)
        rank_3 = np.linalg.svd(lights, compute_uv=False)[-1] > 1e-3
        require(rank_3, "lamps that do not all lie in one plane", f"{n} directions of rank below 3")
        if self.strengths is not None:
            right = self.strengths.shape == (n,) and bool((self.strengths > 0).all())
            require(right, f"{n} positive strengths", self.strengths)
        if self.positions is not None:
            above = self.positions.shape == (n, 3) and bool((self.positions[:, 2] > 0).all())
            require(above, f"{n} positions above the sheet", self.positions)


@dataclass(frozen=True, eq=False, kw_only=True)
class Surface:
    """A sheet as a surface: its height, and what light makes of it.

    Parameters
    ----------
    height
        (H, W) float32, in `unit`, 0 at the paper or at the mean; finite everywhere.
    normals_from, albedo_from
        The normals and the albedo, or a function without arguments that computes them. A mark needs neither,
        and computing them takes longer than the height. For pickling, give a partial of a module's function.
    mask
        (H, W) bool. Of a relief: the ink. Of a photometric surface: the pixels that were measured.
    confidence
        (H, W) float32 in [0, 1], 0 where the height was filled in.
    spacing, unit
        Length of one pixel, and its unit, which is that of the height, too: 'mm', or 'px' (then 1.0).
    source
        Where the height comes from. Only 'photometric' was measured; 'inflation' and 'density' are computed
        from the ink of one image and say nothing about real relief.
    quality
        Named figures about how well the capture fits, documented where they are computed.

    Attributes
    ----------
    normals
        (H, W, 3) float32, unit length, x right, y up, z toward the camera.
    albedo
        (H, W) or (H, W, 3) float32 in [0, 1], linear: lamp strength times albedo, scaled.

    Raises
    ------
    SurfaceError
        When the arrays do not belong together or leave their range; for normals and albedo that are computed
        later, then.
    """

    height: FloatArray
    normals_from: Array
    albedo_from: Array
    mask: BoolArray
    confidence: FloatArray
    spacing: float
    unit: Unit
    source: Source
    quality: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require, shape = partial(_require, SurfaceError), self.height.shape
        require(len(shape) == 2, "a height map of shape (H, W)", shape)
        require(self.mask.shape == shape, f"a mask of {shape}", self.mask.shape)
        require(self.mask.dtype == np.bool_, "a bool mask", self.mask.dtype)
        require(self.confidence.shape == shape, f"confidence {shape}", self.confidence.shape)
        _require_finite(SurfaceError, self.height, "height")
        _require_unit_range(SurfaceError, self.confidence, "confidence")
        for name in ("normals", "albedo"):
            if not callable(getattr(self, f"{name}_from")):
                getattr(self, name)  # which checks it
        require(self.unit in get_args(Unit), f"a unit among {get_args(Unit)}", self.unit)
        require(self.source in SOURCES, f"a source among {SOURCES}", self.source)
        require(np.isfinite(self.spacing) and self.spacing > 0, "spacing > 0", self.spacing)

    @cached_property
    def normals(self) -> FloatArray:
        """(H, W, 3) float32, unit length, x right, y up, z toward the camera."""
        normals = self.normals_from() if callable(self.normals_from) else self.normals_from
        require, shape = partial(_require, SurfaceError), (*self.height.shape, 3)
        require(normals.shape == shape, f"normals {shape}", normals.shape)
        _require_finite(SurfaceError, normals, "normals")
        lengths = np.linalg.norm(normals[::8, ::8], axis=-1)  # a sample: this is checked often
        require(bool(np.allclose(lengths, 1.0, atol=1e-3)), "unit normals", lengths.min())
        return normals

    @cached_property
    def albedo(self) -> FloatArray:
        """(H, W) or (H, W, 3) float32 in [0, 1], linear."""
        albedo = self.albedo_from() if callable(self.albedo_from) else self.albedo_from
        shape = self.height.shape
        _require(SurfaceError, albedo.shape in (shape, (*shape, 3)), f"albedo of {shape}", albedo.shape)
        _require_unit_range(SurfaceError, albedo, "albedo")
        return albedo


@dataclass(frozen=True, slots=True, eq=False)
class Polyline:
    """A line through points, with its half-width at each of them.

    points: (n >= 1, 2) float64, along the line; whoever makes it names the frame and the unit.
    radius: (n,) float64, half-width there, in the unit of the points.
    """

    points: FloatArray
    radius: FloatArray

    def __post_init__(self) -> None:
        n, require = len(self.points), partial(_require, SurfaceError)
        require(self.points.shape == (n, 2) and n >= 1, "(n >= 1, 2) points", self.points.shape)
        require(self.radius.shape == (n,), f"half-widths of ({n},)", self.radius.shape)
        _require_finite(SurfaceError, self.points, "points")
        _require_finite(SurfaceError, self.radius, "half-widths")

    @property
    def along(self) -> FloatArray:
        """(n,) float64, length of the line up to each point."""
        return np.concatenate([[0.0], np.cumsum(np.hypot(*(self.points[1:] - self.points[:-1]).T))])

    @property
    def length(self) -> float:
        """Length of the whole line; 0 for a single point."""
        return float(np.hypot(*(self.points[1:] - self.points[:-1]).T).sum())

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
    radius: the rms radius as a fraction of the image's longer side. pixel: length of one in rms radii.
    cell: (width, height) of the image as fractions of its longer side; one of them is 1.
    """

    xyz: FloatArray
    direction: FloatArray
    centre: FloatArray
    radius: float
    pixel: float
    cell: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        n, require = len(self.xyz), partial(_require, RegistrationError)
        require(self.xyz.shape == (n, 3) and n >= 3, "(N >= 3, 3) points", self.xyz.shape)
        require(self.direction.shape == (n, 2), f"directions of ({n}, 2)", self.direction.shape)
        _require_finite(RegistrationError, self.xyz, "points")
        _require_finite(RegistrationError, self.direction, "directions")


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """The rigid pose that lays the probe on the reference, and what remains.

    Attributes
    ----------
    probe, reference
        N ink points of the copy and M of the master.
    T_reference_probe
        (4, 4) float64, det of its rotation is +1 (else RegistrationError); applied to `probe.xyz`.
    scale
        Rms radius of the probe's ink over that of the reference, both as fractions of their cells; removed
        before registration, never by it. 1 is the same size.
    angle
        Degrees, rotation about z that was needed; positive when the probe leans clockwise.
    shift
        (2,) float64, how far the writing stands from its place in the cell, x right, y up, in fractions of
        the cell's longer side.
    overlap
        Share of the pairs kept by trimming, in [0.4, 1]; trimming serves the pose alone.
    d_ms
        Mean squared distance of the probe's points to their nearest reference points, in rms radii squared.
    forward, forward_index
        (N,) float64, distance of each probe point, posed, to its nearest reference point in position, height
        and weighted stroke direction; (N,) which one that is.
    backward, backward_index
        (M,) the same from each reference point to the probe.
    converged, iterations
        False when the loop ended on its limit of iterations; how many it took.
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
        T, require = self.T_reference_probe, partial(_require, RegistrationError)
        require(T.shape == (4, 4), "a (4, 4) pose", T.shape)
        _require_finite(RegistrationError, T, "the pose")
        require(abs((det := np.linalg.det(T[:3, :3])) - 1.0) < 1e-6, "a rigid pose of determinant +1", det)


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing a teacher would say.

    kind: of the fault: 'lean', 'missing', ... size: in `unit`. severity: points of the mark, for ordering.
    region: (x0, y0, x1, y1) in fractions of the copy's cell, origin top left; None for the whole.
    zh, en: what is wrong and what to do. outline: lines of (x, y) in the same fractions that trace the
        strokes it speaks of, where a missing one should stand, or ink that is too much. master_outline: those
        strokes in the master's cell. stroke: its number in the order of writing, from 1, if it is of one.
    """

    kind: str
    size: float
    unit: str
    severity: float
    region: tuple[float, float, float, float] | None
    zh: str
    en: str
    outline: tuple[tuple[tuple[float, float], ...], ...] = ()
    master_outline: tuple[tuple[tuple[float, float], ...], ...] = ()
    stroke: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Assessment:
    """A mark and what it rests on.

    Attributes
    ----------
    score, interval, level, percentile
        0-100 on the scale of a human panel; the 80 % interval of its mark; 'excellent', 'good', 'medium' or
        'bad'; the share of learners' copies that get less, in per cent, where known. All None when refused.
    sim_paper, similarity
        The paper's, in per cent, which saturates near 100 and is never the mark; two-sided: 1 is identical.
    parts, deductions, praise, remarks, untold
        'brushwork', 'structure', 'ink', each 0-100; points taken off for 'lean', 'offset', 'size'; one thing
        that is good, or None; what to correct, at most three, the worst first; the faults found besides.
    registration, source
        The pose that the mark rests on; where the heights of copy and master come from. None when refused.
    refused, refused_zh, turned_by
        Why the copy cannot be marked, 'code: sentence', else None; the sentence in Chinese; degrees clockwise
        (90, 180, 270) that turn the picture upright, where it needs that.
    weights, calibration, script, character, interval_note, interval_note_zh
        A teacher's weights of the parts, else None; what another calibration was fitted on, in words; one of
        SCRIPTS; what the remarks take the master for, given or recognised; what must be said of the interval.
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
    turned_by: int | None = None
    weights: Mapping[str, float] | None = None
    calibration: str | None = None
    script: str | None = None
    interval_note: str | None = None
    interval_note_zh: str | None = None
    untold: tuple[Remark, ...] = ()
    praise: Bilingual | None = None
    percentile: float | None = None
    character: str | None = None
    deductions: Mapping[str, float] = field(default_factory=dict)
