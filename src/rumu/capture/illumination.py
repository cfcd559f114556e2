"""Even out the light on a flat sheet: by the paper's bands, its SVD split, or the fit that we recommend.

A near lamp lights the near edge of a sheet more than the far one. Three methods find by how much:

    'bands'    the paper's: K' from the levels of a band at each edge, then the inverse-square law between.
    'svd'      the paper's: the same, with K' read from the leading singular components of the image.
    'masked'   ours, recommended: the light is fitted to all blank paper (flatfield.py).

Why nothing is ever divided by the L of the SVD split:
  * It is argued from Retinex, a product of light and reflectance, but splits the image into a sum. The
    'multiplicative' kind splits the logarithm instead; both are offered.
  * The leading components of a page of calligraphy are mostly ink, since horizontal and vertical strokes are
    of low rank: L resembles the ink more than the light. Averaged over the blank paper of two bands it gives
    the right K' with any k, as the image itself does without any split.
  * Singular values depend on the size of the image; no k holds for all.

The paper does not print how K' corrects the pixels between the bands: `gain` is our closed form of it.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from rumu.capture.flatfield import Flatfield, fit_flatfield
from rumu.capture.lights import equalise, tilt_slant
from rumu.errors import CaptureError
from rumu.values import BoolArray, Capture, FloatArray

Method = Literal["masked", "bands", "svd"]
SplitKind = Literal["additive", "multiplicative"]
METHODS: tuple[Method, ...] = get_args(Method)

_EVEN = 1.02  # a ratio up to this is noise of even light, not a lamp on the wrong side
_BLACK = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Bands:
    """The two bands of a sheet, at the edge nearest to the lamp and at the farthest.

    near, far: (H, W) bool. position: (H, W) float32, pixels from the middle of the near band, away from the
    lamp. distance: pixels between the middles of the bands.
    """

    near: BoolArray
    far: BoolArray
    position: FloatArray
    distance: float


@dataclass(frozen=True, slots=True, eq=False)
class Rectified:
    """An image as an even light would show it.

    image: (H, W) or (H, W, 3) float32, at the brightness of the near edge; may exceed 1 where light was weak.
    K: the paper's K', level of the darker band over that of the brighter one, at most 1.
    gain: (H, W) float32, what the image was multiplied by.
    paper: (H, W) bool, blank paper. spread: relative rms unevenness of the paper, before and after.
    swapped: True when the lamp stands on the side opposite to its label; warning then says so, else None.
    """

    image: FloatArray
    K: float
    gain: FloatArray
    paper: BoolArray
    spread: tuple[float, float]
    swapped: bool = False
    warning: str | None = None


# --- the inverse-square law ------------------------------------------------------------------------


def inverse_square_ratio(distance: float, *, step: float) -> float:
    """How much weaker a lamp at `distance` lights a point that is `step` farther away.

    Eq. (9): I2 / I1 = (r / (r + s))^2, with r the distance and s the step in one unit. In (0, 1].
    """
    if not (distance > 0 and step >= 0):
        raise CaptureError(f"expected distance > 0 and step >= 0, got {distance} and {step}")
    return 1.0 if math.isinf(distance) else (distance / (distance + step)) ** 2


def lamp_distance(ratio: float, *, step: float) -> float:
    """Distance of the lamp at which a point `step` farther away is lit `ratio` times as strongly.

    Eq. (10): r = s sqrt(k) / (1 - sqrt(k)), solved from the inverse-square law; without the radicals, which
    print easily loses, it would not solve it. In the unit of `step`; infinite at a ratio of 1.
    Raises CaptureError when the ratio is not in (0, 1]: the lamp is on the other side.
    """
    if not 0 < ratio <= 1:
        raise CaptureError(f"expected a ratio in (0, 1], got {ratio}")
    root = math.sqrt(ratio)
    return math.inf if root == 1 else step * root / (1 - root)


def gain(position: FloatArray, *, ratio: float, distance: float) -> FloatArray:
    """What to multiply by at `position` so that the light is as at position 0; ours, in closed form.

    With the lamp at the distance that follows from K', ((r + t) / r)^2 = (1 + t/d (1/sqrt(K') - 1))^2:
    1 at t = 0 and 1/K' at t = d. No metric distance is needed, and nothing is divided by zero at K' = 1.
    position: t, any shape; distance: d, in the same unit.
    """
    return np.asarray(1 + position * ((1 / math.sqrt(ratio) - 1) / distance)) ** 2


# --- bands -----------------------------------------------------------------------------------------


def find_bands(shape: tuple[int, int], *, tilt: float, n: int = 7) -> Bands:
    """The bands for a lamp at `tilt` degrees: n columns or rows at each edge.

    Tilt 0: near are the right-most n columns; 90: the top n rows; 180: the left-most columns. At a general
    tilt the pixels are ordered along -(cos tilt, sin tilt) and each band has as many as n lines across.
    Raises CaptureError when the two bands would meet.
    """
    height, width = shape
    t = math.radians(tilt)
    across = abs(math.cos(t)) * height + abs(math.sin(t)) * width
    count = round(n * across)
    if n < 1 or 2 * count >= height * width:
        raise CaptureError(f"expected bands of 1 to {min(shape) // 2 - 1} pixels, got n = {n}")
    # x is the column and y is minus the row, so the way from the lamp is -x cos + row sin.
    rows, columns = np.arange(height, dtype=np.float32), np.arange(width, dtype=np.float32)
    away = math.sin(t) * rows[:, None] - math.cos(t) * columns[None, :]
    ordered = np.partition(away.ravel(), [count - 1, away.size - count])
    near, far = away <= ordered[count - 1], away >= ordered[-count]
    start, end = (float(away[band].mean(dtype=np.float64)) for band in (near, far))
    return Bands(near, far, away - np.float32(start), end - start)


def band_levels(image: FloatArray, bands: Bands, *, paper: BoolArray) -> tuple[float, float]:
    """Level of the near band and of the far band.

    Eq. (11)-(12), with two changes: only blank paper counts, and the median takes the place of the mean,
    since one stroke that runs into the far band moves a mean of everything from .55 to .35.
    image, paper: (H, W). Raises CaptureError when a band holds no blank paper.
    """
    levels = []
    for name, band in (("near", bands.near), ("far", bands.far)):
        blank = image[band & paper]
        if blank.size == 0:
            raise CaptureError(f"expected blank paper in the {name} band, found none; use method 'masked'")
        levels.append(float(np.median(blank)))
    return levels[0], levels[1]


def band_ratio(near_level: float, far_level: float) -> float:
    """K', the far level as a share of the near level: Eq. (13). Above 1 on a wrong label."""
    if not (near_level > 0 and far_level > 0):
        raise CaptureError(f"expected bands brighter than black, got levels {near_level} and {far_level}")
    return far_level / near_level


# --- the SVD split ---------------------------------------------------------------------------------


def svd_split(
    image: FloatArray, *, k: int = 7, kind: SplitKind = "additive"
) -> tuple[FloatArray, FloatArray]:
    """The paper's L ("illumination", the k leading singular components) and R ("reflectance", the rest).

    Eq. (14)-(15): I = U W V^T with W cut after k values; I = L + R. As 'multiplicative', which Retinex asks
    for, the logarithm is split and I = L R. Do not divide an image by L: it is mostly ink (see above).
    image: (H, W), linear. Both results (H, W) float32.
    """
    side = min(image.shape)
    if not 1 <= k <= side:
        raise CaptureError(f"expected 1 to {side} singular values, got k = {k}")
    if kind not in ("additive", "multiplicative"):
        raise CaptureError(f"expected kind 'additive' or 'multiplicative', got {kind!r}")
    values = np.asarray(image, dtype=np.float64)
    if kind == "additive":
        leading = _leading_components(values, k)
        return leading.astype(np.float32), (values - leading).astype(np.float32)
    logs = np.log(np.maximum(values, _BLACK))
    leading = _leading_components(logs, k)
    return np.exp(leading).astype(np.float32), np.exp(logs - leading).astype(np.float32)


def _leading_components(values: FloatArray, k: int) -> FloatArray:
    from scipy.sparse.linalg import svds

    if 3 * k >= min(values.shape):
        u, w, vt = np.linalg.svd(values, full_matrices=False)
        return np.asarray((u[:, :k] * w[:k]) @ vt[:k])
    # A fixed start keeps the result the same from run to run.
    u, w, vt = svds(values, k=k, v0=np.ones(min(values.shape)))
    return np.asarray((u * w) @ vt)


def svd_ratio(
    image: FloatArray, bands: Bands, *, paper: BoolArray, k: int = 7, kind: SplitKind = "additive"
) -> float:
    """K' read from L, the leading components, instead of the image: Eq. (16), over blank paper.

    image, paper: (H, W). Of the additive split it is right for any k, as it is without a split: the bands
    matter. The logarithm makes ink deeper than paper is bright, so the multiplicative split leaks ink into
    the bands and reads up to 0.08 too high (on simulated pages) below about ten components.
    """
    leading, _ = svd_split(image, k=k, kind=kind)
    levels = [leading[band & paper] for band in (bands.near, bands.far)]
    if not all(level.size for level in levels):
        raise CaptureError("expected blank paper in both bands, found none; use method 'masked'")
    return band_ratio(float(levels[0].mean()), float(levels[1].mean()))


# --- rectification ---------------------------------------------------------------------------------


def rectify(
    image: FloatArray,
    *,
    tilt: float,
    method: Method = "masked",
    n: int = 7,
    k: int = 7,
    kind: SplitKind = "additive",
    mask: BoolArray | None = None,
) -> Rectified:
    """An image of a flat sheet as even light would show it.

    image: (H, W) or (H, W, 3), linear; the three channels share one gain. tilt: of its lamp, in degrees.
    n: width of the bands, the paper's n. k: singular values kept by 'svd'; kind: of its split.
    mask: (H, W) bool, the sheet. Methods: see the head of this file.
    Raises CaptureError when no blank paper is found, in the image or in a band.
    """
    if method not in METHODS:
        raise CaptureError(f"expected a method among {', '.join(METHODS)}, got {method!r}")
    gray = image if image.ndim == 2 else image.mean(axis=2)
    light = fit_flatfield(gray, mask=mask)
    bands = find_bands((gray.shape[0], gray.shape[1]), tilt=tilt, n=n)
    ratio = _ratio(gray, light, bands, method=method, k=k, kind=kind)
    swapped = ratio > 1
    if swapped:  # the bands of a lamp on the opposite side
        position = np.float32(bands.distance) - bands.position
        bands, ratio = Bands(bands.far, bands.near, position, bands.distance), 1 / ratio
    if method == "masked":
        factor = (light.level[bands.near].mean() / light.level).astype(np.float32)
    else:
        factor = gain(bands.position, ratio=ratio, distance=bands.distance).astype(np.float32)
    spread = (_unevenness(gray, light.paper), _unevenness(gray * factor, light.paper))
    scaled = (image * (factor if image.ndim == 2 else factor[:, :, None])).astype(np.float32)
    wrong = swapped and 1 / ratio > _EVEN
    warning = (
        f"the lamp labelled tilt {tilt:.0f} stands on the other side: the band away from it is "
        f"{1 / ratio:.2f} times as bright; the bands were swapped, check the labels of the images"
    )
    return Rectified(scaled, ratio, factor, light.paper, spread, wrong, warning if wrong else None)


def _ratio(
    gray: FloatArray, light: Flatfield, bands: Bands, *, method: Method, k: int, kind: SplitKind
) -> float:
    """K' by one of the methods, above 1 when the lamp stands on the other side."""
    if method == "masked":
        return band_ratio(float(light.level[bands.near].mean()), float(light.level[bands.far].mean()))
    if method == "svd":
        return svd_ratio(gray, bands, paper=light.paper, k=k, kind=kind)
    return band_ratio(*band_levels(gray, bands, paper=light.paper))


def _unevenness(gray: FloatArray, paper: BoolArray, tile: int = 16) -> float:
    """Relative rms deviation of blank paper, averaged in tiles to drown its grain, from its mean."""
    step = -(-max(gray.shape) // 512)
    values, blank = gray[::step, ::step], paper[::step, ::step]
    rows, columns = (np.arange(0, n, tile) for n in values.shape)

    def sums(array: FloatArray) -> FloatArray:
        by_rows = np.add.reduceat(array, rows, axis=0, dtype=np.float64)
        return np.asarray(np.add.reduceat(by_rows, columns, axis=1))

    count = sums(blank.astype(np.float32))
    means = sums(values * blank)[count > 0] / count[count > 0]
    return float(np.sqrt(np.average((means / means.mean() - 1) ** 2, weights=count[count > 0])))


def rectify_capture(capture: Capture, *, method: Method = "masked", n: int = 7, k: int = 7) -> Capture:
    """A capture of a flat sheet as distant lamps of one strength would show it.

    Every image is rectified along the tilt of its lamp, then all are scaled so that blank paper agrees. Only
    for flat sheets: of any other object the light and the shape cannot be separated this way.
    Warns (UserWarning) of each lamp that stands on the side opposite to its label. Raises CaptureError when
    an image has no blank paper, or none is common to all.
    """
    images = np.empty_like(capture.images)
    paper = capture.mask.copy()
    for i, (image, light) in enumerate(zip(capture.images, capture.lights, strict=True)):
        done = rectify(image, tilt=tilt_slant(light)[0], method=method, n=n, k=k, mask=capture.mask)
        if done.warning:
            name = capture.names[i] if i < len(capture.names) else f"image {i}"
            warnings.warn(f"{name}: {done.warning}", UserWarning, stacklevel=2)
        images[i] = done.image
        paper &= done.paper
    if not paper.any():
        raise CaptureError("expected blank paper that every image shows, found none")
    even = equalise(images, paper_mask=paper, lights=capture.lights)
    peak = max(1.0, float(even.max()))
    return replace(capture, images=even / np.float32(peak), strengths=np.ones(len(images)))
