"""The paper under the ink: where the picture of it begins, how bright it is, which side of it is ink.

Everything here works on a reduced picture, so that it costs the same for a scan and for a large photo.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Polarity = Literal["dark", "light"]
Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]

GRID = 64  # longer side of the reduced picture: strokes stay visible, a quadratic costs nothing
PLAINLY = 0.6  # unlikeliness below which no other polarity is tried; rubbings read as ink start at 0.9
FLAT = 2  # grey levels: what JPEG leaves of a constant colour


@dataclass(frozen=True, slots=True, eq=False)
class Paper:
    """Paper level and polarity of one page.

    level: (h, w) float32 on the reduced grid, 0-255, of `tone` of the same polarity.
    polarity: 'dark' ink on light paper, or 'light' strokes on dark ground (a rubbing).
    """

    level: Floats
    polarity: Polarity


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


def histogram(values: Bytes, *, mask: Bools | None = None) -> npt.NDArray[np.float64]:
    """(256,) float64: how many of the uint8 values, those under the mask if there is one, have each level."""
    import cv2

    under = None if mask is None else mask.astype(np.uint8)
    counts = cv2.calcHist([np.atleast_2d(values)], [0], under, [256], [0, 256])
    return np.asarray(counts, dtype=np.float64).ravel()


def otsu(counts: npt.NDArray[np.float64]) -> float:
    """Threshold of largest between-class variance of a histogram, half-way between two grey levels."""
    below = np.cumsum(counts)
    sums = np.cumsum(counts * np.arange(256))
    total, mass = below[-1], sums[-1]
    within = np.maximum(below * (total - below), 1e-9)
    between = (mass * below / max(total, 1e-9) - sums) ** 2 / within
    best = np.flatnonzero(between >= between.max() * (1 - 1e-9))
    return float(best.mean()) + 0.5


def reduced(picture: Bytes, *, side: int = GRID) -> Bytes:
    """The picture by area averaging, longer side at most `side`."""
    import cv2

    longest = max(picture.shape[:2])
    if longest <= side:
        return picture
    height, width = (max(1, round(n * side / longest)) for n in picture.shape[:2])
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def ink_box(mask: Bools) -> tuple[int, int, int, int]:
    """Rows y0:y1 and columns x0:x1 of the tightest box that holds all that is True; something must be."""
    import cv2

    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    return y, y + height, x, x + width


@dataclass(frozen=True, slots=True)
class SheetLimits:
    """When a picture shows a sheet that lies on something darker; shares of the picture unless said.

    least, most: area of the sheet. bright: share of the sheet that is bright.
    square: share of its tightest rectangle that it fills.
    sharp: step across its outline, as a share of the whole contrast.
    table: share of the picture's border that is dark.
    margin: what is cut off the sheet all round, of the reduced side: its edge is soft and may curl.
    """

    least: float = 0.25
    most: float = 0.97
    bright: float = 0.7
    square: float = 0.8
    sharp: float = 0.4
    table: float = 0.4
    margin: float = 0.03


def sheet_on_table(small: Bytes, *, limits: SheetLimits | None = None) -> Bools | None:
    """(h, w) bool of a reduced picture: the sheet of paper that lies on a darker table; None if none does."""
    import cv2

    limits = limits or SheetLimits()
    gray = tone(small, polarity="dark")
    bright = gray > otsu(histogram(gray))
    rim = np.concatenate([bright[0], bright[-1], bright[:, 0], bright[:, -1]])
    outlines, _ = cv2.findContours(bright.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if 1.0 - rim.mean() < limits.table or not outlines:
        return None
    outline = max(outlines, key=cv2.contourArea)
    sheet = cv2.drawContours(np.zeros(gray.shape, np.uint8), [outline], -1, 1, cv2.FILLED)
    (_, (width, height), _) = cv2.minAreaRect(outline)
    fills = cv2.contourArea(outline) / max(width * height, 1.0)
    if not limits.least < sheet.mean() < limits.most or fills < limits.square:
        return None
    if bright[sheet > 0].mean() < limits.bright or not _sharp(gray, bright, outline[:, 0], limits):
        return None
    cut = 2 * max(1, round(limits.margin * max(gray.shape))) + 1
    border = {"borderType": cv2.BORDER_CONSTANT, "borderValue": 1}  # the picture's own side is no edge
    return np.asarray(cv2.erode(sheet, np.ones((cut, cut), np.uint8), **border) > 0)


def _sharp(gray: Bytes, bright: Bools, outline: npt.NDArray[np.int32], limits: SheetLimits) -> bool:
    """Whether the outline (columns, rows) is an edge and not the middle of a gradient of light."""
    import cv2

    height, width = gray.shape
    x, y = outline[:, 0], outline[:, 1]
    inside = (x > 0) & (x < width - 1) & (y > 0) & (y < height - 1)
    step = cv2.morphologyEx(gray, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))[y[inside], x[inside]]
    depth = float(np.median(gray[bright])) - float(np.median(gray[~bright]))
    return bool(inside.any() and np.median(step) > limits.sharp * depth)


def read_paper(small: Bytes, *, polarity: Polarity | None = None) -> Paper:
    """Fit the paper of a reduced picture under both hypotheses, dark ink and light, and keep the likelier."""
    if polarity is not None:
        return _despite_shadow(small, Paper(fit_level(tone(small, polarity=polarity)), polarity))
    dark = Paper(fit_level(tone(small, polarity="dark")), "dark")
    doubt = unlikeliness(small, dark)
    if doubt < PLAINLY:
        return _despite_shadow(small, dark)
    light = Paper(fit_level(tone(small, polarity="light")), "light")
    return _despite_shadow(small, dark if doubt <= unlikeliness(small, light) else light)


def unlikeliness(small: Bytes, paper: Paper) -> float:
    """How little the dark side of `tone` looks like writing: it fills, it frames, it is thick."""
    import cv2

    value = ratio(tone(small, polarity=paper.polarity), paper.level)
    ink = value < otsu(histogram(value))
    rim = np.concatenate([ink[:2].ravel(), ink[-2:].ravel(), ink[:, :2].ravel(), ink[:, -2:].ravel()])
    thick = cv2.distanceTransform(np.pad(ink, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 3)
    bright_ground = 0.5 if paper.polarity == "light" and float(np.median(paper.level)) < 128 else 0.0
    return float(rim.mean() + ink.mean() + 4.0 * thick.max() / max(ink.shape)) + bright_ground


def _despite_shadow(small: Bytes, paper: Paper) -> Paper:
    """The paper with a sharp shadow in it, where that explains the page better than one smooth level.

    Closing takes away what is narrower than a third of the page: strokes go, a shadow stays in the level.
    It must leave a contrast that is stronger, or thick ink would be taken for a shadow.
    """
    import cv2

    value = tone(small, polarity=paper.polarity)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * (max(small.shape[:2]) // 6) + 1,) * 2)
    level = np.asarray(cv2.morphologyEx(value, cv2.MORPH_CLOSE, kernel), dtype=np.float32)
    shaded = Paper(np.clip(level, 1.0, 255.0), paper.polarity)
    if contrast(small, shaded) < 1.1 * contrast(small, paper) + 0.05:
        return paper
    return shaded if unlikeliness(small, shaded) < unlikeliness(small, paper) - 0.2 else paper


def contrast(small: Bytes, paper: Paper) -> float:
    """How far the dark class lies below the paper, as a share of the paper's level."""
    value = ratio(tone(small, polarity=paper.polarity), paper.level)
    return float(1.0 - np.median(value[value < otsu(histogram(value))], axis=None) / 200.0)


def ratio(value: Bytes, level: npt.NDArray[Any]) -> Bytes:
    """Tone over paper level of the same shape, as uint8: 200 is paper, 0 is black."""
    import cv2

    under = level if level.dtype == np.uint8 else np.clip(np.rint(level), 1, 255).astype(np.uint8)
    return np.asarray(cv2.divide(value, under, scale=200.0), dtype=np.uint8)


def fit_level(value: Bytes) -> Floats:
    """Paper level of a reduced tone: a quadratic over the paper, then what is left of it, smoothed.

    Starts as an upper envelope (expectile), because up to half of the page may be ink.
    """
    import cv2

    shape = value.shape
    z = value.astype(np.float32).ravel()
    basis = _quadratic(shape)
    top = float(np.percentile(z, 99.5))
    weight = np.ones_like(z)
    for _ in range(3):
        fit = _weighted(basis, z, weight)
        weight = np.where(z > fit, np.float32(0.9), np.float32(0.1))
    for _ in range(2):
        level = _bounded(fit, top)
        x = np.clip(200.0 * z / level, 0, 255).astype(np.uint8)
        cut = (otsu(histogram(x)) + 200.0) / 2.0
        weight = (x > cut).astype(np.float32)
        if weight.sum() < 0.05 * z.size:
            break
        fit = _weighted(basis, z, weight)
    level = _bounded(fit, top).reshape(shape)
    keep = weight.reshape(shape)
    sigma = max(shape) / 12.0
    residue = cv2.GaussianBlur(keep * (z.reshape(shape) - level), (0, 0), sigma)
    share = cv2.GaussianBlur(keep, (0, 0), sigma)
    return np.asarray(np.clip(level + residue / (share + 0.1), 1.0, 255.0), dtype=np.float32)


@lru_cache(maxsize=8)
def _quadratic(shape: tuple[int, ...]) -> Floats:
    y, x = np.meshgrid(*(np.linspace(-1, 1, n, dtype=np.float32) for n in shape), indexing="ij")
    x, y = x.ravel(), y.ravel()
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _weighted(basis: Floats, z: Floats, weight: Floats) -> Floats:
    """Weighted least squares; the slopes are held back a little, so that a small patch cannot swing them."""
    scaled = basis * weight[:, None]
    held = np.diag([0, 1, 1, 3, 3, 3]).astype(np.float32) * (1e-2 * z.size)
    coefficients = np.linalg.solve(scaled.T @ basis + held, scaled.T @ z)
    return np.asarray(basis @ coefficients, dtype=np.float32)


def _bounded(fit: Floats, top: float) -> Floats:
    """Keep an extrapolated fit within what a page can be whose brightest spot is `top`."""
    return np.asarray(np.clip(fit, 0.25 * top, 1.1 * top + 1.0), dtype=np.float32)
