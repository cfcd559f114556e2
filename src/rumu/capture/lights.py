"""Where the lamps stand: angles and unit vectors, chrome spheres, the paper's three lamps, equal strengths.

A direction points from the sheet toward the lamp: x right, y up, z to the camera. Tilt runs counter-clockwise
from +x as the camera sees it (0 right, 90 top, 180 left, 270 bottom); slant is measured from +z (0 frontal,
90 grazing). Both are in degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.errors import CaptureError
from rumu.values import BoolArray, FloatArray

_PAPER_TILTS = (0.0, 90.0, 180.0, 270.0)
_HIGHLIGHT_SHARE = 0.9  # of the brightest value: the core of a highlight, without its streaks
_SKIRT, _SKIRT_SHARE = 2.0, 0.2  # pixels beyond the highlight, and the share above which they belong to it
_SLANT_RANGE = (1.0, 89.0)  # outside it three lamps of one slant are too near to one plane


@dataclass(frozen=True, slots=True)
class PaperLamps:
    """Three or four lamps that stand as the paper's do.

    slant: degrees, common to all.
    order: indices of the images at tilt 0, 90, 180 and, when there is a fourth, 270: a, b, c and our d.
    """

    slant: float
    order: tuple[int, ...]


def direction(*, tilt: float, slant: float) -> FloatArray:
    """(3,) float64 unit vector toward a lamp at `tilt` and `slant` degrees. Raises CaptureError on NaN."""
    t, s = np.radians(tilt), np.radians(slant)
    if not (np.isfinite(t) and np.isfinite(s)):
        raise CaptureError(f"expected finite tilt and slant in degrees, got tilt {tilt} and slant {slant}")
    return np.array([np.cos(t) * np.sin(s), np.sin(t) * np.sin(s), np.cos(s)])


def tilt_slant(vector: npt.ArrayLike) -> tuple[float, float]:
    """Tilt in [0, 360) and slant in [0, 180] degrees of a direction; the inverse of `direction`.

    vector: (3,), of any length but zero. A vector along z has tilt 0. Raises CaptureError otherwise.
    """
    v = np.asarray(vector, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all() or not v.any():
        raise CaptureError(f"expected a direction of 3 finite numbers, not all zero, got {v.tolist()}")
    tilt = float(np.degrees(np.arctan2(v[1], v[0]))) % 360.0
    # The first remainder of a tiny negative angle rounds up to 360 itself.
    return tilt % 360.0, float(np.degrees(np.arctan2(np.hypot(v[0], v[1]), v[2])))


def from_sphere(image: FloatArray, *, centre: tuple[float, float], radius: float) -> FloatArray:
    """Direction of the lamp whose highlight is seen on a mirror sphere (orthographic camera).

    image: (H, W) or (H, W, 3), linear or not: only the brightest spot is used.
    centre: (column, row) of the sphere in pixels, 0 at the middle of the first pixel. radius: pixels.
    Returns (3,) float64, unit length. The ray toward the camera, v = (0, 0, 1), is mirrored about the normal
    n of the sphere at the highlight: l = 2 (n.v) n - v.
    Raises CaptureError when the circle leaves the image or holds no highlight.
    """
    gray = image if image.ndim == 2 else image.mean(axis=2)
    disc = _sphere_disc(gray.shape, centre=centre, radius=radius)
    column, row = _highlight(gray, disc)
    nx, ny = (column - centre[0]) / radius, -(row - centre[1]) / radius
    normal = np.array([nx, ny, np.sqrt(max(0.0, 1.0 - nx * nx - ny * ny))])
    return np.asarray(2.0 * normal[2] * normal - (0.0, 0.0, 1.0))


def _sphere_disc(shape: tuple[int, ...], *, centre: tuple[float, float], radius: float) -> BoolArray:
    height, width = shape
    inside = 0 <= centre[0] < width and 0 <= centre[1] < height and 2 < radius <= max(shape)
    if not inside:
        raise CaptureError(
            f"expected a sphere inside the {width} x {height} image, got centre {centre} and radius {radius}"
        )
    rows, columns = np.ogrid[:height, :width]
    return np.asarray((columns - centre[0]) ** 2 + (rows - centre[1]) ** 2 < radius**2)


def _highlight(gray: FloatArray, disc: BoolArray) -> tuple[float, float]:
    """(column, row) of the strongest bright spot in the disc: its centroid weighted by brightness."""
    from scipy import ndimage

    inside = gray[disc]
    brightest, usual = float(inside.max()), float(np.median(inside))
    if brightest <= 0 or brightest - usual < 0.2 * brightest:
        raise CaptureError(
            f"expected a highlight on the sphere, got a brightest value of {brightest:.4g} "
            f"beside a median of {usual:.4g}"
        )
    level = usual + _HIGHLIGHT_SHARE * (brightest - usual)
    weight = np.where(disc, gray - level, 0.0).clip(0)
    spots, count = ndimage.label(weight > 0, structure=np.ones((3, 3)))
    # Reflections of windows and of the object are as bright when they saturate, but smaller.
    strength = ndimage.sum_labels(weight, spots, np.arange(1, count + 1))
    spot = spots == int(np.argmax(strength)) + 1
    row, column = ndimage.center_of_mass(weight * spot)
    # Of a spot of a few pixels the brightest alone tell whole pixels; its skirt tells where between them.
    reach = np.sqrt(np.count_nonzero(spot) / np.pi) + _SKIRT
    rows, columns = np.ogrid[: gray.shape[0], : gray.shape[1]]
    around = disc & ((rows - row) ** 2 + (columns - column) ** 2 < reach**2)
    skirt = usual + _SKIRT_SHARE * (brightest - usual)
    row, column = ndimage.center_of_mass(np.where(around, gray - skirt, 0.0).clip(0))
    return float(column), float(row)


def paper_tilts(lights: FloatArray, *, tolerance: float = 2.0) -> PaperLamps | None:
    """The paper's arrangement among three or four lamps, in any order; None when they stand otherwise.

    lights: (N, 3), unit length. Each lamp must stand within `tolerance` degrees of tilt 0, 90, 180
    (and 270) at the mean slant of all.
    """
    count = len(lights)
    if count not in (3, 4):
        return None
    slant = float(np.mean([tilt_slant(light)[1] for light in lights]))
    if not _SLANT_RANGE[0] <= slant <= _SLANT_RANGE[1]:
        return None
    wanted = np.array([direction(tilt=tilt, slant=slant) for tilt in _PAPER_TILTS[:count]])
    cosines = wanted @ np.asarray(lights, dtype=np.float64).T
    order = tuple(int(i) for i in np.argmax(cosines, axis=1))
    far = np.degrees(np.arccos(np.clip(cosines.max(axis=1), -1, 1))).max()
    return PaperLamps(slant, order) if len(set(order)) == count and far <= tolerance else None


def equalise(images: FloatArray, *, paper_mask: BoolArray, lights: FloatArray | None = None) -> FloatArray:
    """Scale each image so that flat blank paper is equally bright in all, removing lamp-to-lamp differences.

    Without it they would appear as one slope of the whole sheet. Brightness is divided by the cosine of each
    lamp's slant first, when `lights` are given: of two equal lamps the lower one lights flat paper less.
    The weakest image keeps its values and the others are scaled down to it, so all values stay in [0, 1].

    images: (N, H, W) or (N, H, W, 3), linear. lights: (N, 3), unit length.
    paper_mask: (H, W) bool, True on flat blank paper.
    Raises CaptureError when there is no paper, or it is black in some image.
    """
    if paper_mask.shape != images.shape[1:3] or not paper_mask.any():
        raise CaptureError(
            f"expected a paper mask of {images.shape[1:3]} with at least one pixel, "
            f"got {paper_mask.shape} with {int(np.count_nonzero(paper_mask))}"
        )
    gray = images if images.ndim == 3 else images.mean(axis=3)
    levels = np.array([float(np.median(one[paper_mask])) for one in gray])
    given = levels if lights is None else levels / np.asarray(lights)[:, 2]
    if not (given > 0).all():
        raise CaptureError(f"expected paper brighter than black in every image, got medians {levels}")
    factors = (given.min() / given).astype(np.float32)
    return np.asarray(images * factors.reshape(-1, *[1] * (images.ndim - 1)))
