"""Points -> one feature vector, similar for one character by many hands: finds candidates to register.

The outline's directions are counted on a grid over the character, twice: as it stands, and with its rows and
columns stretched so that strokes are evenly dense, which forgives a radical written too wide or too low.
Known from character recognition: gradient directions on a grid (Liu et al. 2003, "Handwritten digit
recognition: benchmarking of state-of-the-art techniques") and normalisation by line density (Tsukumo and
Tanaka 1988); weights and sizes are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from rumu.registration.points import CANVAS, RADIUS
from rumu.values import BoolArray, FloatArray, IntArray, PointSet

DIRECTIONS = 8
VERSION = 1
"""Raised whenever `describe` changes, so that no vector is compared with one of another kind."""

_STEPS = 1000.0
"""A number of a vector is stored as a byte: value times this; hardly any is above .255."""
COHORT_SIZE = 10
"""How many of the most similar other characters say what likeness different shapes reach."""


@dataclass(frozen=True, slots=True)
class DescriptorSettings:
    """How a character is described.

    side: of the square, in pixels, on which directions are taken. cells: of the grid along each side.
    reach: half the width of the part described, in rms radii, or standard deviations of rows and columns.
    evenness: how far strokes are spread evenly; 0 only evens out width and height, 1 is all line density.
    spread: blur of the grid's cells, as a share of a cell, so that a small shift costs little.
    """

    side: int = 64
    cells: int = 8
    reach: float = 2.2
    evenness: float = 0.8
    spread: float = 0.55

    @property
    def length(self) -> int:
        """Numbers in one vector."""
        return 2 * DIRECTIONS * self.cells**2


def describe(points: PointSet, *, settings: DescriptorSettings | None = None) -> FloatArray:
    """The vector of one character: (settings.length,) float32, of unit length, all 0 or more.

    How alike two are is computed by `likeness`.
    """
    half = (CANVAS - 1) / 2
    at = np.rint(half + points.xyz[:, :2] * (RADIUS, -RADIUS)).astype(int)
    column, row = np.clip(at, 0, CANVAS - 1).T
    ink = np.zeros((CANVAS, CANVAS), np.float32)
    ink[row, column] = 1.0
    return describe_canvas(ink, settings=settings)


def describe_canvas(ink: FloatArray | BoolArray, *, settings: DescriptorSettings | None = None) -> FloatArray:
    """The same vector from (CANVAS, CANVAS) ink, 1 where points lie and 0 elsewhere."""
    settings = settings or DescriptorSettings()
    ink = ink.astype(np.float32)
    evenly = RADIUS * settings.reach * (2 * (np.arange(settings.side) + 0.5) / settings.side - 1)
    at = (CANVAS - 1) / 2 + evenly
    rows, columns = np.nonzero(ink)
    views = (
        _sample_canvas(ink, rows=at, columns=at),
        _sample_canvas(
            ink,
            rows=_even_density(rows, np.abs(np.diff(ink, axis=0, prepend=0)).sum(axis=1), settings),
            columns=_even_density(columns, np.abs(np.diff(ink, axis=1, prepend=0)).sum(axis=0), settings),
        ),
    )
    vector = np.concatenate([_directions_on_grid(view, settings) for view in views])
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float32)


def likeness(vector: FloatArray, vectors: FloatArray) -> FloatArray:
    """How alike one vector is to others, (L,) and (N, L) -> (N,); (L,) and (L,) -> a number.

    The cosine after the mean of 6,590 characters in regular script is subtracted, since what all writing
    shares distinguishes nothing: 1 for the same outline, about 0 for any two characters.
    """
    own, others = less_the_mean(vector), less_the_mean(vectors)
    lengths = np.sqrt(np.einsum("...j,...j->...", others, others))
    return np.asarray(others @ own / np.maximum(lengths * np.linalg.norm(own), 1e-6))


def less_the_mean(vectors: FloatArray) -> FloatArray:
    """(..., L) vectors less the mean of 6,590 characters in regular script, which all writing shares."""
    return vectors - _mean_vector()


def to_bytes(vectors: FloatArray) -> npt.NDArray[np.uint8]:
    """Vectors (..., L) as they are stored; see `from_bytes`."""
    return np.asarray(np.clip(np.rint(vectors * _STEPS), 0, 255), dtype=np.uint8)


def from_bytes(stored: npt.NDArray[np.uint8]) -> FloatArray:
    """(..., L) float32, what `to_bytes` made bytes of, to half a thousandth."""
    return np.asarray(stored / np.float32(_STEPS))


def beyond_others(vector: FloatArray, other: FloatArray) -> float:
    """Likeness of two vectors, (L,) each, beyond what other characters reach.

    Most pairs of one character are above -0.1, most of two below. What is subtracted is half of what either
    reaches, on average, with the ten that are most like it of 973 characters in regular script: some shapes
    are like many. Known from speaker verification as adaptive score normalisation (Karam et al. 2011,
    "Towards reduced false-alarms using cohorts").
    """
    usual = []
    for one in (vector, other):
        centred = one - _mean_vector()
        most_alike = np.sort(_other_characters() @ centred)[-COHORT_SIZE:]
        usual.append(float(most_alike.mean() / max(float(np.linalg.norm(centred)), 1e-6)))
    return float(likeness(vector, other)) - 0.5 * sum(usual)


def mirror(points: PointSet) -> PointSet:
    """The same ink seen from behind the paper."""
    return replace(points, xyz=points.xyz * (-1.0, 1.0, 1.0), direction=points.direction * (1.0, -1.0))


def turn(points: PointSet, *, degrees: int) -> PointSet:
    """The same ink turned clockwise in its plane by 0, 90, 180 or 270 degrees."""
    xyz, direction = points.xyz, points.direction
    for _ in range(degrees // 90):  # a direction is twice an angle: a quarter turn reverses it
        xyz, direction = xyz[:, (1, 0, 2)] * (1.0, -1.0, 1.0), -direction
    return replace(points, xyz=xyz, direction=direction)


@lru_cache(maxsize=1)
def _other_characters() -> FloatArray:
    """(N, L) float32, each of unit length once the mean is taken away."""
    with (
        (files("rumu.registration") / "other_characters.npz").open("rb") as stream,
        np.load(stream) as stored,
    ):
        vectors = from_bytes(stored["vectors"]) - _mean_vector()
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True), dtype=np.float32)


@lru_cache(maxsize=1)
def _mean_vector() -> FloatArray:
    with (files("rumu.registration") / "mean_description.npy").open("rb") as stream:
        return np.asarray(np.load(stream), dtype=np.float32)


def _even_density(at: IntArray, crossings: FloatArray, settings: DescriptorSettings) -> FloatArray:
    """(side,) at which rows (or columns) to sample, so that each holds as many crossings of the outline.

    at: the row of each ink pixel. crossings: (CANVAS,) changes between paper and ink in each row.
    """
    window = np.hanning(21)
    density = np.convolve(crossings, window / window.sum(), "same")
    middle, reach = at.mean(), settings.reach * max(float(at.std()), 1.0)
    inside = np.abs(np.arange(CANVAS) - middle) <= reach
    share = settings.evenness * density / max(float(density[inside].sum()), 1e-6)
    share = np.where(inside, share + (1 - settings.evenness) / inside.sum(), 0.0)
    total = np.cumsum(share)
    wanted = (np.arange(settings.side) + 0.5) / settings.side
    return np.asarray(np.interp(wanted, total / total[-1], np.arange(CANVAS) + 0.5) - 0.5)


def _sample_canvas(ink: FloatArray, *, rows: FloatArray, columns: FloatArray) -> FloatArray:
    """(side, side) float32: the canvas at these rows and columns, (side,) each."""
    import cv2

    x, y = np.meshgrid(columns.astype(np.float32), rows.astype(np.float32))
    soft = cv2.GaussianBlur(ink, (0, 0), 0.6)
    return np.asarray(cv2.remap(soft, x, y, cv2.INTER_LINEAR), np.float32)


def _directions_on_grid(view: FloatArray, settings: DescriptorSettings) -> FloatArray:
    """(DIRECTIONS * cells * cells,) of unit length: roots of the outline's gradients in each cell.

    A gradient between two of the eight directions counts for both.
    """
    import cv2

    soft = cv2.GaussianBlur(view, (0, 0), 1.0)
    gx, gy = cv2.Sobel(soft, cv2.CV_32F, 1, 0), -cv2.Sobel(soft, cv2.CV_32F, 0, 1)
    turn = ((np.arctan2(gy, gx) / (2 * np.pi) * DIRECTIONS) % DIRECTIONS).ravel()
    length, below = np.hypot(gx, gy).ravel(), np.floor(turn)
    parts, pixel = np.zeros((DIRECTIONS, view.size), np.float32), np.arange(view.size)
    first = below.astype(int) % DIRECTIONS
    parts[first, pixel] = length * (1 - turn + below)
    parts[(first + 1) % DIRECTIONS, pixel] = length * (turn - below)
    grid = _grid(settings)
    cells = grid @ parts.reshape(DIRECTIONS, settings.side, settings.side) @ grid.T
    vector = np.sqrt(np.maximum(cells, 0.0)).ravel()
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-6))


@lru_cache(maxsize=4)
def _grid(settings: DescriptorSettings) -> FloatArray:
    """(cells, side) float32: the weight of each row (or column) in each row (or column) of cells."""
    import cv2

    step = settings.side / settings.cells
    centres = np.rint((np.arange(settings.cells) + 0.5) * step - 0.5).astype(int)
    each = np.eye(settings.side, dtype=np.float32)
    return np.asarray(cv2.GaussianBlur(each, (0, 0), sigmaX=1e-6, sigmaY=settings.spread * step)[centres])
