"""The paper under the ink: where the picture shows it, how bright it is, which side is ink.

Level and polarity are judged on a reduced picture, so that it costs the same for a scan as for a large photo.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from rumu.capture.flatfield import quadratic_terms
from rumu.capture.image import Bytes, shrink
from rumu.values import BoolArray, FloatArray

Polarity = Literal["dark", "light"]

REDUCED_SIDE = 64
"""Longer side, in pixels, of the reduced picture: strokes stay visible, a quadratic costs nothing."""
PAPER_GRAY = 200
"""Gray level of the paper in a picture that was divided by it; see `divide_by_paper`."""


@dataclass(frozen=True, slots=True, eq=False)
class Paper:
    """Paper level and polarity of one page.

    level: (h, w) float32 on the reduced grid, 0-255, of `tone` of the same polarity.
    polarity: 'dark' ink on light paper, or 'light' strokes on dark ground (a rubbing).
    shadow: whether the level follows the edge of a shadow, which a finer grid shows better.
    light: level of the darkest part of the page's border, without what is narrower than a third of the page,
        as a share of the brightest part.
    """

    level: FloatArray
    polarity: Polarity
    shadow: bool = False
    light: float = 1.0


# --- gray levels -----------------------------------------------------------------------------------


def tone(view: Bytes, *, polarity: Polarity) -> Bytes:
    """(H, W) uint8 in which ink is dark.

    Dark ink is dark in every channel, so the brightest channel keeps ink and lets red grids and seals fade
    into the paper; strokes of a rubbing are light in every channel, so there it is the darkest, inverted.
    """
    import cv2

    if view.ndim == 2:
        return view if polarity == "dark" else cv2.bitwise_not(view)
    a, b, c = cv2.split(view)
    if polarity == "dark":
        return np.asarray(cv2.max(cv2.max(a, b), c), dtype=np.uint8)
    return np.asarray(cv2.bitwise_not(cv2.min(cv2.min(a, b), c)), dtype=np.uint8)


def histogram(values: Bytes, *, mask: BoolArray | None = None) -> FloatArray:
    """(256,) float64: how many of the uint8 values, those under the mask if there is one, have each level."""
    import cv2

    under = None if mask is None else mask.astype(np.uint8)
    counts = cv2.calcHist([np.atleast_2d(values)], [0], under, [256], [0, 256])
    return np.asarray(counts, dtype=np.float64).ravel()


def otsu_threshold(counts: FloatArray) -> float:
    """Threshold of largest between-class variance of a histogram, half-way between two gray levels.

    Where no pixel lies between ink and paper, many thresholds are equally good: this is their middle, and
    scikit-image's `threshold_otsu` the first of them, the ink itself; it raises for a single gray level.
    It would find another ink in 8 of 253 pictures, its thresholds up to 99.5 levels off:
    `benchmarks/surface.py`.
    """
    below = np.cumsum(counts)
    sums = np.cumsum(counts * np.arange(256))
    total, mass = below[-1], sums[-1]
    within = np.maximum(below * (total - below), 1e-9)
    between = (mass * below / max(total, 1e-9) - sums) ** 2 / within
    best = np.flatnonzero(between >= between.max() * (1 - 1e-9))
    return float(best.mean()) + 0.5


def divide_by_paper(value: Bytes, level: FloatArray | Bytes) -> Bytes:
    """Tone over paper level of the same shape, as uint8: PAPER_GRAY is paper, 0 is black."""
    import cv2

    under = level if level.dtype == np.uint8 else np.clip(np.rint(level), 1, 255).astype(np.uint8)
    return np.asarray(cv2.divide(value, under, scale=float(PAPER_GRAY)), dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class GridSettings:
    """When what is half dark is a pale printed grid: its lines are hairs that cross the whole page.

    hair: half-width of its lines; span: what one of them covers in one piece; both shares of the side.
    hairs: share of its pixels, in per cent, that are so near to an edge; lines are thicker where they cross.
    """

    hair: float = 0.008
    span: float = 0.45
    hairs: float = 98.0


def threshold_below_grid(x: Bytes, threshold: float, *, settings: GridSettings | None = None) -> float:
    """A lower threshold where what is half dark is a printed grid; the threshold itself where it is not.

    x: (H, W) uint8, ink dark. A grid scanned in gray has no colour to be recognised by, but a level of its
    own between ink and paper.
    """
    import cv2

    settings = settings or GridSettings()
    counts = histogram(x)[: int(threshold) + 1]
    if counts.sum() < 64:
        return threshold
    lower = otsu_threshold(np.pad(counts, (0, 256 - len(counts))))
    dark = x < lower
    near = cv2.dilate(dark.astype(np.uint8), np.ones((5, 5), np.uint8))
    between = cv2.bitwise_and(cv2.inRange(x, 0, int(np.ceil(threshold)) - 1), cv2.bitwise_not(255 * near))
    pale = shrink(between, side=256) > 64
    if not (dark.any() and pale.any()):  # a drawing of two levels, or a clean scan
        return threshold
    depth = cv2.distanceTransform(np.pad(pale, 1).astype(np.uint8), cv2.DIST_L2, 3)
    if np.percentile(depth[depth > 0], settings.hairs) > settings.hair * max(pale.shape) + 1:
        return threshold
    _, _, stats, _ = cv2.connectedComponentsWithStats(pale.astype(np.uint8), connectivity=8)
    spans = (stats[1:, 2] > settings.span * pale.shape[1]) | (stats[1:, 3] > settings.span * pale.shape[0])
    return lower if spans.any() else threshold


# --- level and polarity ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PaperSettings:
    """How the level of the paper is fitted, and when a polarity is believed.

    plausible: unlikeliness below which no other polarity is tried; rubbings read as ink start at 0.9.
    thickness: weight of the thickest stroke, over the page's side, in the unlikeliness; dark_ground: what
        light strokes add to it on a ground that is brighter than mid-gray.
    shadow_gain, shadow_offset: a sharp shadow is believed when it leaves this many times the contrast, plus
        this; shadow_likelier: and is less unlikely by this.
    uneven: how far paper may stray from a smooth level, as a share of it; beyond it a level that follows the
        shadow, and halves that, is believed at once. shadow_side: longer side, in pixels, of the picture on
        which it is followed.
    expectile: the first fit is an upper envelope that weighs what lies above it so, because up to half of
        the page may be ink. least_paper: share of the page that must remain as paper to be fitted again.
    stiffness: how much the slopes of the fit are held back, as a share of the pixels, so that a small patch
        cannot swing them; three times that for its curvatures.
    darkest, brightest: limits of the level, as shares of the brightest spot of the page.
    residue_blurs: what the quadratic leaves is smoothed; the page's side in standard deviations of that.
    """

    plausible: float = 0.6
    thickness: float = 4.0
    dark_ground: float = 0.5
    shadow_gain: float = 1.1
    shadow_offset: float = 0.05
    shadow_likelier: float = 0.2
    uneven: float = 0.12
    shadow_side: int = 256
    expectile: float = 0.9
    least_paper: float = 0.05
    stiffness: float = 1e-2
    darkest: float = 0.25
    brightest: float = 1.1
    residue_blurs: float = 12.0


def fit_paper(
    small: Bytes, *, polarity: Polarity | None = None, settings: PaperSettings | None = None
) -> Paper:
    """Fit the paper of a reduced picture as dark ink and as light strokes, and keep the likelier."""
    settings = settings or PaperSettings()
    if polarity is not None:
        return _with_shadow(small, _smooth_paper(small, polarity, settings), settings)
    dark = _smooth_paper(small, "dark", settings)
    doubt = unlikeliness(small, dark, settings)
    if doubt < settings.plausible:
        return _with_shadow(small, dark, settings)
    light = _smooth_paper(small, "light", settings)
    likelier = dark if doubt <= unlikeliness(small, light, settings) else light
    return _with_shadow(small, likelier, settings)


def unlikeliness(small: Bytes, paper: Paper, settings: PaperSettings) -> float:
    """How little the dark side of `tone` looks like writing: it fills, it frames, it is thick."""
    import cv2

    value = divide_by_paper(tone(small, polarity=paper.polarity), paper.level)
    ink = value < otsu_threshold(histogram(value))
    rim = np.concatenate([ink[:2].ravel(), ink[-2:].ravel(), ink[:, :2].ravel(), ink[:, -2:].ravel()])
    thick = cv2.distanceTransform(np.pad(ink, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 3)
    bright_ground = paper.polarity == "light" and float(np.median(paper.level)) < 128
    thickness = settings.thickness * thick.max() / max(ink.shape)
    return float(rim.mean() + ink.mean() + thickness) + (settings.dark_ground if bright_ground else 0.0)


def level_of(view: Bytes, paper: Paper, *, settings: PaperSettings | None = None) -> Bytes:
    """(H, W) uint8 level of the paper, at least 1, of a whole picture whose reduced one was fitted."""
    import cv2

    settings, level = settings or PaperSettings(), paper.level
    if paper.shadow:
        level = _closed_level(shrink(view, side=settings.shadow_side), paper.polarity)
    level = np.clip(np.rint(level), 1, 255).astype(np.uint8)
    return np.asarray(cv2.resize(level, view.shape[1::-1], interpolation=cv2.INTER_LINEAR), np.uint8)


def _closed_level(small: Bytes, polarity: Polarity) -> FloatArray:
    """The page with all that is dark and narrower than a third of it closed."""
    import cv2

    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * (max(small.shape[:2]) // 6) + 1,) * 2)
    closed = cv2.morphologyEx(tone(small, polarity=polarity), cv2.MORPH_CLOSE, kernel)
    return np.clip(np.asarray(closed, dtype=np.float32), 1.0, 255.0)


def _unevenness(small: Bytes, paper: Paper) -> float:
    """How far the brighter class strays from the level, as a share of it: its farthest tenth."""
    value = divide_by_paper(tone(small, polarity=paper.polarity), paper.level)
    bright = value[value > otsu_threshold(histogram(value))].astype(np.float32)
    return float(np.percentile(np.abs(bright - PAPER_GRAY), 90)) / PAPER_GRAY


def _with_shadow(small: Bytes, paper: Paper, settings: PaperSettings) -> Paper:
    """The paper with a sharp shadow in it, where that explains the page better than one smooth level.

    Closing takes away what is narrower than a third of the page: strokes go, a shadow stays in the level.
    It must leave a contrast that is stronger, or thick ink would be taken for a shadow.
    """
    closed = _closed_level(small, paper.polarity)
    rim = np.concatenate([closed[0], closed[-1], closed[:, 0], closed[:, -1]])  # thick ink stands within it
    paper = replace(paper, light=float(np.percentile(rim, 4) / np.percentile(closed, 98)))
    shaded = replace(paper, level=closed, shadow=True)
    if _unevenness(small, paper) > max(settings.uneven, 2.0 * _unevenness(small, shaded)):
        return shaded
    needed = settings.shadow_gain * _contrast(small, paper) + settings.shadow_offset
    if _contrast(small, shaded) < needed:
        return paper
    likelier = unlikeliness(small, paper, settings) - settings.shadow_likelier
    return shaded if unlikeliness(small, shaded, settings) < likelier else paper


def _contrast(small: Bytes, paper: Paper) -> float:
    """How far the dark class lies below the paper, as a share of the paper's level."""
    value = divide_by_paper(tone(small, polarity=paper.polarity), paper.level)
    dark = value < otsu_threshold(histogram(value))
    return float(1.0 - np.median(value[dark], axis=None) / PAPER_GRAY)


def _smooth_paper(small: Bytes, polarity: Polarity, settings: PaperSettings) -> Paper:
    """A quadratic over the paper, then what is left of it, smoothed."""
    import cv2

    value = tone(small, polarity=polarity)
    shape = value.shape
    z = value.astype(np.float32).ravel()
    top = float(np.percentile(z, 99.5))
    limits = (settings.darkest * top, settings.brightest * top + 1.0)  # a fit may swing beyond any page
    above, below = np.float32(settings.expectile), np.float32(1 - settings.expectile)
    weight = np.ones_like(z)
    for _ in range(3):
        fit = _fit_quadratic(shape, z, weight, settings)
        weight = np.where(z > fit, above, below)
    for _ in range(2):
        level = np.asarray(np.clip(fit, *limits), dtype=np.float32)
        x = np.clip(PAPER_GRAY * z / level, 0, 255).astype(np.uint8)
        weight = (x > (otsu_threshold(histogram(x)) + PAPER_GRAY) / 2.0).astype(np.float32)
        if weight.sum() < settings.least_paper * z.size:
            break
        fit = _fit_quadratic(shape, z, weight, settings)
    level = np.asarray(np.clip(fit, *limits), dtype=np.float32).reshape(shape)
    keep = weight.reshape(shape)
    reach = max(shape) / settings.residue_blurs
    residue = cv2.GaussianBlur(keep * (z.reshape(shape) - level), (0, 0), reach)
    share = cv2.GaussianBlur(keep, (0, 0), reach)
    return Paper(np.asarray(np.clip(level + residue / (share + 0.1), 1.0, 255.0), np.float32), polarity)


def _fit_quadratic(
    shape: tuple[int, ...], z: FloatArray, weight: FloatArray, settings: PaperSettings
) -> FloatArray:
    """(N,) weighted least squares of the flattened picture z."""
    basis = _terms_of(shape)
    scaled = basis * weight[:, None]
    ridge = np.diag([0, 1, 1, 3, 3, 3]).astype(np.float32) * (settings.stiffness * z.size)
    coefficients = np.linalg.solve(scaled.T @ basis + ridge, scaled.T @ z)
    return np.asarray(basis @ coefficients, dtype=np.float32)


@lru_cache(maxsize=8)
def _terms_of(shape: tuple[int, ...]) -> FloatArray:
    y, x = np.meshgrid(*(np.linspace(-1, 1, n, dtype=np.float32) for n in shape), indexing="ij")
    return quadratic_terms(x.ravel(), y.ravel())
