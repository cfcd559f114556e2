"""A surface -> ink points in a frame that has no unit and no origin of its own.

Only ink is sampled: with the blank sheet included nearest neighbours are trivially close and any pose
fits. The size of the writing is divided out here, and recorded, so that registration stays rigid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.errors import RegistrationError, SurfaceError
from rumu.values import BoolArray, FloatArray, IntArray, PointSet, Surface

CANVAS = 172
"""Side of the square, in pixels, to which the ink of every surface is scaled."""
RADIUS = 32.0
"""Rms radius of the ink on that canvas, in pixels."""
INFLATION_TOP = 0.1
"""Inflated height that counts as 1, in rms radii: about a common stroke's half-width."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """How ink points are taken.

    count: about how many points at most; one in each square of a grid over the ink, so that none clump. By
        default every pixel of the canvas with ink is a point, so that no choice of points moves a mark.
    height_weight: zeta, the weight of the normalised height against x and y in rms radii. The paper
        leaves the scale of z open; this one was chosen on human marks (see `rumu experiments run e3c`).
    """

    count: int = 20_000
    height_weight: float = 1.0


def normalise_height(
    height: FloatArray, *, mask: BoolArray, bounds: tuple[float, float] | None = None, noise: float = 0.0
) -> FloatArray:
    """Eq. (17): h' = (h - min h) / (max h - min h) over the mask; (H, W) float -> the same, 0 off the mask.

    As printed one outlying pixel sets the scale, so min and max are the 0.5 and 99.5 percentiles over the
    mask (values beyond stay beyond, they are not cut), or `bounds` when both surfaces of a pair have a
    common unit.
    Raises SurfaceError for a flat map: a range of zero, or below six times `noise`.
    """
    if not mask.any():
        raise SurfaceError("expected a height map with ink to normalise, got an empty mask")
    low, high = bounds or tuple(np.percentile(height[mask], (0.5, 99.5)))
    if not high - low > max(6.0 * noise, 1e-12):
        raise SurfaceError(f"expected a height map with relief, got a flat one (range {high - low:.3g})")
    return np.where(mask, (height - low) / (high - low), 0.0).astype(np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Canvas:
    """The ink of one surface on the common canvas, where all ink has one size and one centre.

    mask: (H, W) bool, the ink in the surface's own pixels. centre: (2,) its centroid, (column, row), and
    radius: its rms radius, in those pixels. ink: (CANVAS, CANVAS) float32 in [0, 1].
    """

    mask: BoolArray
    centre: FloatArray
    radius: float
    ink: FloatArray

    @property
    def solid(self) -> BoolArray:
        """(CANVAS, CANVAS) bool: the pixels that may become points. Hairlines pale when they shrink."""
        return np.asarray(self.ink > 0.5 * min(float(self.ink.max()), 1.0))


def canvas_of(mask: BoolArray) -> Canvas:
    """(H, W) ink -> the same on the common canvas, its size and position taken out.

    Raises RegistrationError when there is too little ink.
    """
    rows, columns = np.nonzero(mask)
    if len(rows) < 20:
        raise RegistrationError(f"expected a surface with at least 20 pixels of ink, got {len(rows)}")
    radius = float(np.hypot(columns.std(), rows.std()))
    if radius < 2.0:
        raise RegistrationError(f"expected ink with an rms radius of 2 pixels or more, got {radius:.2f}")
    centre = np.array([columns.mean(), rows.mean()])
    return Canvas(mask, centre, radius, _warp_to_canvas(mask, centre=centre, radius=radius))


def sample_points(
    surface: Surface, *, canvas: Canvas | None = None, settings: Sampling | None = None
) -> PointSet:
    """Ink points of a surface, taken on the common canvas, with the direction of the stroke at each.

    canvas: of the surface's ink, where it is known already.
    An inflated height has the unit of the page, so its bounds are the paper and a tenth of the rms radius
    for copy and master alike, and a stroke twice as wide stays twice as high; other sources are
    normalised each by its own range.
    Raises RegistrationError when the surface holds too little ink to compare, SurfaceError when its height
    was measured and is flat, as ink on paper is.
    """
    settings, canvas = settings or Sampling(), canvas or canvas_of(ink_mask(surface))
    mask, centre, radius = canvas.mask, canvas.centre, canvas.radius
    height = surface.height / surface.spacing
    bounds, noise = (0.0, INFLATION_TOP * radius), 0.0
    if surface.source != "inflation":
        bounds, noise = _height_bounds(height, ink=mask, paper=surface.mask & ~mask)
    relief = normalise_height(height, mask=mask, bounds=bounds, noise=noise)
    relief = _warp_to_canvas(relief, centre=centre, radius=radius)
    h, w = surface.height.shape
    longer = max(h, w)
    y, x = _one_per_square(canvas.solid, count=settings.count)
    half = (CANVAS - 1) / 2
    z = settings.height_weight * relief[y, x]
    return PointSet(
        xyz=np.column_stack([(x - half) / RADIUS, (half - y) / RADIUS, z]).astype(float),
        direction=stroke_direction(canvas.ink, rows=y, columns=x).astype(float),
        centre=np.array([centre[0] + 0.5 - w / 2, h / 2 - centre[1] - 0.5]) / longer,
        radius=radius / longer,
        pixel=1.0 / radius,
        cell=(w / longer, h / longer),
    )


def ink_mask(surface: Surface) -> BoolArray:
    """(H, W) bool: the ink of a surface. A relief knows it; a measured surface shows it in its albedo."""
    if surface.source != "photometric":
        return surface.mask
    from rumu.surface.ink import find_ink

    return find_ink(surface.albedo, linear=True).mask & surface.mask


def _height_bounds(
    height: FloatArray, *, ink: BoolArray, paper: BoolArray
) -> tuple[tuple[float, float], float]:
    """Bounds from the range of the ink and the level of the paper, and how much the height varies on it.

    Ink on flat paper has no relief: what is measured is then noise, which normalising would blow up.
    """
    low, high = np.percentile(height[ink], (0.5, 99.5))
    if not paper.any():
        return (float(low), float(high)), 0.0
    level = float(np.median(height[paper]))
    noise = 1.4826 * float(np.median(np.abs(height[paper] - level)))
    return (min(float(low), level), max(float(high), level)), noise


def stroke_direction(ink: FloatArray, *, rows: IntArray, columns: IntArray) -> FloatArray:
    """(H, W) ink in [0, 1], N pixels -> (N, 2) float32: (cos 2t, sin 2t) of the stroke direction t, y up.

    From the structure tensor at a 24th and a 16th of the rms radius; t and t + 180 are one, hence 2t.
    """
    import cv2

    soft = cv2.GaussianBlur(ink, (0, 0), RADIUS / 24)
    gx, gy = cv2.Sobel(soft, cv2.CV_32F, 1, 0), -cv2.Sobel(soft, cv2.CV_32F, 0, 1)
    xx, yy, xy = (
        cv2.GaussianBlur(a, (0, 0), RADIUS / 16)[rows, columns] for a in (gx * gx, gy * gy, gx * gy)
    )
    # the gradient crosses the stroke: its double angle turned by 180 degrees is the stroke's
    double = np.stack([yy - xx, -2.0 * xy], axis=-1)
    length = np.linalg.norm(double, axis=-1, keepdims=True)
    return np.asarray(double / np.maximum(length, 1e-6), dtype=np.float32)


def _warp_to_canvas(image: BoolArray | FloatArray, *, centre: FloatArray, radius: float) -> FloatArray:
    """Ink in [0, 1] or relief on the common canvas, (CANVAS, CANVAS) float32."""
    import cv2

    scale = RADIUS / radius
    half = (CANVAS - 1) / 2
    M = np.array([[scale, 0.0, half - scale * centre[0]], [0.0, scale, half - scale * centre[1]]])
    image = image.astype(np.float32)
    if scale < 1:  # smooth before shrinking, or edges alias
        image = cv2.GaussianBlur(image, (0, 0), 0.4 / scale)
    return np.asarray(cv2.warpAffine(image, M, (CANVAS, CANVAS), flags=cv2.INTER_LINEAR), np.float32)


def _one_per_square(solid: BoolArray, *, count: int) -> tuple[IntArray, IntArray]:
    """Rows and columns of one ink pixel in each square of a grid: the one nearest the square's centre."""
    rows, columns = np.nonzero(solid)
    side = np.sqrt(len(rows) / count)
    if side <= 1.0:  # a square holds no more than one
        return rows, columns
    v, u = rows / side, columns / side
    square = v.astype(np.int64) * (CANVAS + 1) + u.astype(np.int64)
    off_centre = (v % 1 - 0.5) ** 2 + (u % 1 - 0.5) ** 2
    order = np.lexsort((off_centre, square))
    _, first = np.unique(square[order], return_index=True)
    chosen = order[first]
    return rows[chosen], columns[chosen]
