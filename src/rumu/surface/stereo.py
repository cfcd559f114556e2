"""Photometric stereo: brightness under known lamps gives normals and albedo.

Frame: x right, y up, z to the camera; p = dz/dx, q = dz/dy. Tilt counter-clockwise from +x, slant from +z, in
degrees. Brightness is linear. The strength of the lamp and the albedo cannot be separated; `albedo` is their
product throughout.

With three lamps p and q hold no albedo at all: ink on flat paper gives p = q = 0 however black it is. What is
measured here is relief, never ink.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.errors import SurfaceError
from rumu.image_stack import SATURATION, ImageStack
from rumu.values import BoolArray, FloatArray

SHADOW_FLOOR = 0.004  # one step of 8 bits: what is darker may as well be black
SHADOW_SHARE = 0.02  # of the brightest of the same pixel's values: a lamp that gives less does not reach it
_TINY = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Gradients:
    """What the paper's three lamps say about each pixel.

    p, q: (H, W) float32, dz/dx and dz/dy; 0 where not valid.
    albedo: (H, W) float32, lamp strength times albedo; 0 where not valid.
    valid: (H, W) bool, lit by every lamp and not saturated.
    fourth_lamp: median of |d - (a + c - b)| relative to the mean brightness where valid: how well a fourth
        photograph is predicted by the other three; None when there is no fourth.
    """

    p: FloatArray
    q: FloatArray
    albedo: FloatArray
    valid: BoolArray
    fourth_lamp: float | None = None

    @property
    def normals(self) -> FloatArray:
        """(H, W, 3) float32, unit length."""
        return normals_from_gradients(self.p, self.q)


def three_lamps(
    a: FloatArray, b: FloatArray, c: FloatArray, *, slant: float, d: FloatArray | None = None
) -> Gradients:
    """Slopes and albedo from the paper's three photographs, Eq. (2)-(4), and an optional fourth.

    a, b, c, d: (H, W) linear brightness at tilt 0, 90, 180 and 270 degrees, all at one slant:

        a = rho (-p sin s + cos s) / D,  b = rho (-q sin s + cos s) / D,  c = rho (p sin s + cos s) / D,

    with D = sqrt(p^2 + q^2 + 1). slant: degrees, strictly between 0 and 90: at both ends the three
    directions fall into one plane. Without d, q is sqrt(3) times noisier than p.
    Raises SurfaceError for images of different or wrong shape, values that are not finite, a bad slant.
    """
    images = [_check_image(one, name) for one, name in zip((a, b, c), "abc", strict=True)]
    fourth = None if d is None else _check_image(d, "d")
    if not 0.0 < slant < 90.0:
        raise SurfaceError(f"expected a slant strictly between 0 and 90 degrees, got {slant}")
    tangent, cosine = float(np.tan(np.radians(slant))), float(np.cos(np.radians(slant)))
    shapes = {one.shape for one in images} | ({fourth.shape} if fourth is not None else set())
    if len(shapes) != 1:
        raise SurfaceError(f"expected images of one shape, got {sorted(shapes)}")
    stack = np.stack([*images, *([] if fourth is None else [fourth])])
    valid = all_lit(stack)
    a_, b_, c_ = (np.where(valid, one, 1.0) for one in images)
    d_ = None if fourth is None else np.where(valid, fourth, 1.0)
    p, q = _slopes(a_, b_, c_, d_, tangent=tangent)
    albedo = _strength_times_albedo(a_, c_, p, q, cosine=cosine)
    check = None if fourth is None else _fourth_lamp(stack[:, valid])
    p, q, albedo = (np.where(valid, one, 0.0).astype(np.float32) for one in (p, q, albedo))
    return Gradients(p, q, albedo, valid, check)


def _slopes(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray | None, *, tangent: float
) -> tuple[FloatArray, FloatArray]:
    """Slopes: p by Eq. (5) and q by Eq. (6); the albedo cancels in both.

    With a fourth lamp q = (d - b) / ((a + c) tan s), our addition: it makes q as quiet as p.
    """
    facing = (a + c) * tangent
    return (c - a) / facing, (a + c - 2.0 * b if d is None else d - b) / facing


def _strength_times_albedo(
    a: FloatArray, c: FloatArray, p: FloatArray, q: FloatArray, *, cosine: float
) -> FloatArray:
    """Lamp strength times albedo, Eq. (7)."""
    return np.asarray((a + c) / (2.0 * cosine) * np.sqrt(1.0 + p * p + q * q))


def _fourth_lamp(stack: FloatArray) -> float:
    """Median of |d - (a + c - b)| over the mean brightness; 0 when nothing is valid. stack: (4, P)."""
    if stack.shape[1] == 0:
        return 0.0
    a, b, c, d = stack
    return float(np.median(np.abs(d - (a + c - b)) / stack.mean(axis=0)))


def scaled_normals(brightness: FloatArray, lights: FloatArray) -> FloatArray:
    """(P, 3) float64: albedo times normal, the least-squares solution of Eq. (1).

    brightness: (P, N), one row for each pixel; lights: (N, 3). Lambert's law i = rho (n . l), which in slopes
    reads rho (-p cos t sin s - q sin t sin s + cos s) / sqrt(p^2 + q^2 + 1), is linear in rho n.
    """
    return np.asarray(brightness @ np.linalg.pinv(lights).T, dtype=np.float64)


def split(scaled: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals (P, 3) and albedo (P,), float32, from their product; (0, 0, 1) where it is zero."""
    albedo = np.linalg.norm(scaled, axis=1)
    facing = np.array([0.0, 0.0, 1.0])
    normals = np.where(albedo[:, None] > _TINY, scaled / np.maximum(albedo, _TINY)[:, None], facing)
    return normals.astype(np.float32), albedo.astype(np.float32)


def channel_albedo(
    images: FloatArray, normals: FloatArray, lights: FloatArray, *, weights: FloatArray
) -> FloatArray:
    """(P, 3) float32: albedo of each colour once the normals are known.

    images: (N, P, 3); normals: (P, 3); lights: (N, 3), times strength; weights: (P, N) trust in each value.
    """
    shading = np.maximum(normals.astype(np.float64) @ lights.T, 0.0)
    trusted = weights * shading
    power = np.maximum((trusted * shading).sum(axis=1), _TINY)
    return np.asarray(np.einsum("pn,npc->pc", trusted, images) / power[:, None]).astype(np.float32)


def normals_from_gradients(p: FloatArray, q: FloatArray) -> FloatArray:
    """(H, W, 3) float32 unit normals (-p, -q, 1) / sqrt(p^2 + q^2 + 1). p, q: (H, W)."""
    normals = np.stack([-p, -q, np.ones_like(p)], axis=-1)
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True)).astype(np.float32)


def gradients_from_normals(normals: FloatArray, *, steepest: float = 10.0) -> tuple[FloatArray, FloatArray]:
    """Slopes p and q, each (H, W) float32, of normals (H, W, 3).

    steepest: limit of sqrt(p^2 + q^2); 10 is 84 degrees. A steeper slope, or a normal turned away from the
    camera, keeps its direction and gets that limit: no height map can hold more. (0, 0, 0) gives 0, 0.
    """
    n = np.asarray(normals, dtype=np.float32)
    sideways = np.hypot(n[..., 0], n[..., 1])
    toward = np.maximum(n[..., 2], np.maximum(sideways / steepest, _TINY))
    return -n[..., 0] / toward, -n[..., 1] / toward


def all_lit(images: FloatArray) -> BoolArray:
    """(H, W) bool: no image in shadow and none saturated, as three lamps need. images: (N, H, W)."""
    floor = np.maximum(SHADOW_FLOOR, SHADOW_SHARE * images.max(axis=0))
    return np.asarray((images.min(axis=0) > floor) & (images.max(axis=0) < SATURATION))


def enough_lit(images: FloatArray) -> BoolArray:
    """(H, W) bool: three images at least are neither in shadow nor saturated. images: (N, H, W)."""
    floor = np.maximum(SHADOW_FLOOR, SHADOW_SHARE * images.max(axis=0))
    return np.asarray(np.count_nonzero((images > floor) & (images < SATURATION), axis=0) >= 3)


def check_stack(images: FloatArray | ImageStack, lights: FloatArray) -> None:
    """Raise SurfaceError unless images are (N >= 3, H, W[, 3]) and finite and lights (N, 3) span space."""
    shape = images.shape
    if len(shape) not in (3, 4) or shape[0] < 3 or shape[3:] not in ((), (3,)):
        raise SurfaceError(f"expected images of shape (N >= 3, H, W) or (N, H, W, 3), got {shape}")
    if lights.shape != (shape[0], 3):
        raise SurfaceError(f"expected lights of shape ({shape[0]}, 3), got {lights.shape}")
    arrays = [lights] if isinstance(images, ImageStack) else [lights, *images]  # a stack was checked before
    if not all(np.isfinite(one).all() for one in arrays):
        raise SurfaceError("expected finite images and lights, got NaN or infinite values")
    if np.linalg.svd(lights, compute_uv=False)[-1] <= 1e-3:
        raise SurfaceError("expected lamps that do not all lie in one plane, got directions of rank below 3")


def _check_image(image: FloatArray, name: str) -> FloatArray:
    array = np.asarray(image, dtype=np.float64)
    if array.ndim != 2:
        raise SurfaceError(f"expected image {name} of shape (H, W), got {array.shape}")
    if not np.isfinite(array).all():
        raise SurfaceError(f"expected a finite image {name}, got NaN or infinite values")
    return array
