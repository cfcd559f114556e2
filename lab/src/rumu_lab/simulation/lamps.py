"""The oracle of light: renders lit photographs of a surface whose height is known.

Written from the physics alone, so that a mistake in the code it judges cannot hide in it: Lambert's
cosine, the inverse square of the distance, a ray marched toward the lamp for the cast shadow.

Frame: x right, y up, z to the camera, origin at the centre of the sheet at height 0. Arrays are indexed
[row, column] and rows grow downward. Tilt is counter-clockwise from +x (0: the lamp stands at the right,
90: at the top), slant from +z, both in degrees. Heights and positions share one unit; `spacing` is the
length of one pixel in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rumu.errors import CaptureError, SurfaceError
from rumu.values import BoolArray, FloatArray

_SHADOW_BIAS = 1e-3  # pixels; a ray must be under the surface by more than its interpolation error


@dataclass(frozen=True, slots=True)
class DistantLamp:
    """A lamp so far away that its light is parallel and equally strong everywhere.

    tilt, slant: degrees. strength: brightness of white paper that faces the lamp.
    """

    tilt: float
    slant: float
    strength: float = 1.0

    @property
    def direction(self) -> FloatArray:
        """(3,) float64, unit vector from the sheet toward the lamp."""
        tilt, slant = np.radians((self.tilt, self.slant))
        return np.array([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)])


@dataclass(frozen=True, slots=True)
class NearLamp:
    """A point lamp at a place; its light falls off with the square of the distance.

    position: (x, y, z) in the unit of the height, origin at the centre of the sheet, z > 0.
    strength: brightness of white paper that faces the lamp at the distance of the sheet's centre.
    """

    position: tuple[float, float, float]
    strength: float = 1.0

    @property
    def direction(self) -> FloatArray:
        """(3,) float64, unit vector from the sheet's centre toward the lamp."""
        position = np.asarray(self.position, dtype=np.float64)
        return position / np.linalg.norm(position)


Lamp = DistantLamp | NearLamp


@dataclass(frozen=True, slots=True)
class Gloss:
    """A glossy lobe on top of Lambert's law: strength * (n . half-way vector)^exponent, camera at +z."""

    strength: float = 0.3
    exponent: float = 40.0


@dataclass(frozen=True, slots=True)
class Sensor:
    """What the camera does to the light that reaches it, in this order.

    noise: standard deviation of Gaussian noise in linear brightness; seed: of that noise.
    clip: cut to [0, 1], as a real sensor does.
    encoding: 'linear', 'srgb', or a gamma g (stored = linear^(1/g)); needs clip.
    """

    noise: float = 0.0
    seed: int = 0
    clip: bool = True
    encoding: Literal["linear", "srgb"] | float = "linear"

    def __post_init__(self) -> None:
        if self.noise < 0:
            raise CaptureError(f"expected noise >= 0, got {self.noise}")
        if self.encoding != "linear" and not self.clip:
            raise CaptureError(f"expected clip=True with encoding {self.encoding!r}: it is undefined below 0")
        if isinstance(self.encoding, str) and self.encoding not in ("linear", "srgb"):
            raise CaptureError(f"expected encoding 'linear', 'srgb' or a gamma, got {self.encoding!r}")


_PERFECT = Sensor()


def render(
    height: FloatArray,
    albedo: FloatArray | float,
    *,
    lamp: Lamp,
    spacing: float = 1.0,
    normals: FloatArray | None = None,
    cast_shadows: bool = True,
    ambient: float = 0.0,
    veil: float = 0.0,
    gloss: Gloss | None = None,
    sensor: Sensor = _PERFECT,
) -> FloatArray:
    """Photograph of a surface under one lamp: (H, W) or, with a coloured albedo, (H, W, 3) float32.

    height: (H, W) in the unit of `spacing`, the length of one pixel.
    albedo: a number, (H, W) or (H, W, 3), in [0, 1].
    normals: (H, W, 3) exact unit normals when they are known; else central differences of the height.
    cast_shadows: whether what stands before the lamp darkens what lies behind it.
    ambient: light from all sides, reflected by the albedo. veil: stray light that ink does not absorb.
    Raises SurfaceError or CaptureError when the arrays or the lamp make no sense.
    """
    height, albedo = _check(height, albedo, spacing)
    n = normals_of(height, spacing=spacing) if normals is None else np.asarray(normals, dtype=np.float64)
    if n.shape != (*height.shape, 3):
        raise SurfaceError(f"expected normals of shape {(*height.shape, 3)}, got {n.shape}")
    toward, irradiance = _light_at(height, lamp, spacing)
    cosine = np.einsum("hwk,hwk->hw", n, toward)
    lit = cosine > 0.0  # the attached shadow: the surface itself is turned away
    if cast_shadows:
        lit &= ~cast_shadow(height, lamp=lamp, spacing=spacing)
    direct = np.where(lit, irradiance * np.maximum(cosine, 0.0), 0.0)
    glint = np.where(lit, irradiance * _gloss_lobe(n, toward, gloss), 0.0)
    if albedo.ndim == 3:
        direct, glint = direct[..., None], glint[..., None]
    return _record(albedo * (direct + ambient) + glint + veil, sensor)


def photographs(
    height: FloatArray,
    albedo: FloatArray | float,
    *,
    tilts: Sequence[float],
    slant: float | Sequence[float],
    strengths: Sequence[float] | None = None,
    spacing: float = 1.0,
    normals: FloatArray | None = None,
    cast_shadows: bool = True,
    ambient: float = 0.0,
    veil: float = 0.0,
    gloss: Gloss | None = None,
    sensor: Sensor = _PERFECT,
) -> tuple[FloatArray, FloatArray]:
    """One photograph for each tilt, under distant lamps.

    Returns images (N, H, W) or (N, H, W, 3) float32 and lights (N, 3) float64, unit vectors to the lamps.
    tilts: degrees, one for each lamp; slant: degrees, one for all or one for each.
    strengths: of the lamps, 1 for all when not given. Everything else as in `render`; each photograph
    has noise of its own.
    """
    slants = [float(slant)] * len(tilts) if isinstance(slant, int | float) else [float(s) for s in slant]
    power = [1.0] * len(tilts) if strengths is None else [float(s) for s in strengths]
    if not len(tilts) == len(slants) == len(power):
        raise CaptureError(f"expected {len(tilts)} slants and strengths, got {len(slants)} and {len(power)}")
    lamps = [DistantLamp(t, s, p) for t, s, p in zip(tilts, slants, power, strict=True)]
    images = [
        render(
            height,
            albedo,
            lamp=lamp,
            spacing=spacing,
            normals=normals,
            cast_shadows=cast_shadows,
            ambient=ambient,
            veil=veil,
            gloss=gloss,
            sensor=replace(sensor, seed=sensor.seed * 1009 + number),
        )
        for number, lamp in enumerate(lamps)
    ]
    return np.stack(images), np.stack([lamp.direction for lamp in lamps])


def normals_of(height: FloatArray, *, spacing: float = 1.0) -> FloatArray:
    """(H, W, 3) float64 unit normals (-dz/dx, -dz/dy, 1) by central differences, one-sided at the edges."""
    z = np.asarray(height, dtype=np.float64)
    p: FloatArray = np.gradient(z, spacing, axis=1)
    # Rows grow downward while y grows upward, so dz/dy is minus the difference along the rows.
    q: FloatArray = -np.gradient(z, spacing, axis=0)
    return from_slopes(p, q)


def from_slopes(p: FloatArray, q: FloatArray) -> FloatArray:
    """(H, W, 3) float64 unit normals of a surface with slopes p = dz/dx and q = dz/dy, each (H, W)."""
    n = np.stack([-p, -q, np.ones_like(p)], axis=-1)
    return np.asarray(n / np.linalg.norm(n, axis=-1, keepdims=True))


def grid(shape: tuple[int, int], *, spacing: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Positions x and y of every pixel centre, (H, W) float64, origin at the sheet's centre, y up."""
    rows, columns = shape
    x = (np.arange(columns) - (columns - 1) / 2) * spacing
    y = ((rows - 1) / 2 - np.arange(rows)) * spacing
    return np.meshgrid(x, y)


def cast_shadow(height: FloatArray, *, lamp: Lamp, spacing: float = 1.0) -> BoolArray:
    """(H, W) bool, True where something stands between the surface and the lamp.

    A ray leaves every pixel toward the lamp and is followed in steps of one pixel across the sheet; the
    pixel is in shadow when the surface, interpolated linearly, rises above the ray. Beyond the edge of
    the sheet nothing stands.
    """
    from scipy.ndimage import map_coordinates

    z = np.asarray(height, dtype=np.float64)
    step_row, step_column, rise, reach = _rays(z, lamp, spacing)
    shadow = np.zeros(z.shape, dtype=bool)
    top, floor = float(z.max()), float(z.min())
    row, column = np.nonzero(reach > 0)
    for step in range(1, int(np.hypot(*z.shape)) + 1):
        ray = z[row, column] + step * rise[row, column]
        going = (ray < top) & (step < reach[row, column]) & ~shadow[row, column]
        row, column, ray = row[going], column[going], ray[going]
        if row.size == 0:
            break
        at = np.stack([row + step * step_row[row, column], column + step * step_column[row, column]])
        above = map_coordinates(z, at, order=1, mode="constant", cval=floor)
        shadow[row, column] = above > ray + _SHADOW_BIAS * spacing
    return shadow


def _rays(z: FloatArray, lamp: Lamp, spacing: float) -> tuple[FloatArray, ...]:
    """Per pixel: a one-pixel step toward the lamp (rows, columns), its rise, and how many lead there."""
    if isinstance(lamp, DistantLamp):
        dx, dy, dz = (np.full(z.shape, part) for part in lamp.direction)
        length = np.hypot(dx, dy)
        reach = np.where(length > 1e-9, np.inf, 0.0)
    else:
        dx, dy, dz = np.moveaxis(_offset(z, lamp, spacing), -1, 0)
        length = np.hypot(dx, dy)
        reach = length / spacing
    length = np.maximum(length, 1e-12)
    return -dy / length, dx / length, dz / length * spacing, reach


def _offset(z: FloatArray, lamp: NearLamp, spacing: float) -> FloatArray:
    """(H, W, 3): from each point of the surface to the lamp."""
    x, y = grid((z.shape[0], z.shape[1]), spacing=spacing)
    return np.asarray(np.asarray(lamp.position) - np.stack([x, y, z], axis=-1), dtype=np.float64)


def _light_at(z: FloatArray, lamp: Lamp, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Unit vectors toward the lamp (H, W, 3) and the irradiance (H, W) of a surface that faces it."""
    if isinstance(lamp, DistantLamp):
        return np.broadcast_to(lamp.direction, (*z.shape, 3)), np.full(z.shape, lamp.strength)
    if lamp.position[2] <= float(z.max()):
        raise CaptureError(
            f"expected a lamp above the sheet (z > {float(z.max()):g}), got z = {lamp.position[2]:g}"
        )
    offset = _offset(z, lamp, spacing)
    squared = np.einsum("hwk,hwk->hw", offset, offset)
    reference = float(np.dot(lamp.position, lamp.position))
    return offset / np.sqrt(squared)[..., None], lamp.strength * reference / squared


def _gloss_lobe(n: FloatArray, toward: FloatArray, gloss: Gloss | None) -> FloatArray:
    if gloss is None:
        return np.zeros(n.shape[:2])
    half = toward + np.array([0.0, 0.0, 1.0])
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    lobe = np.maximum(np.einsum("hwk,hwk->hw", n, half), 0.0)
    return gloss.strength * np.asarray(lobe**gloss.exponent)


def _record(light: FloatArray, sensor: Sensor) -> FloatArray:
    if sensor.noise > 0:
        light = light + np.random.default_rng(sensor.seed).normal(0.0, sensor.noise, light.shape)
    if sensor.clip:
        light = np.clip(light, 0.0, 1.0)
    if sensor.encoding == "srgb":
        light = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    elif not isinstance(sensor.encoding, str):
        light = light ** (1.0 / sensor.encoding)
    return light.astype(np.float32)


def _check(height: FloatArray, albedo: FloatArray | float, spacing: float) -> tuple[FloatArray, FloatArray]:
    z, rho = np.asarray(height, dtype=np.float64), np.asarray(albedo, dtype=np.float64)
    if z.ndim != 2 or min(z.shape) < 2:
        raise SurfaceError(f"expected a height map of at least 2 x 2, got shape {z.shape}")
    if rho.ndim == 0:
        rho = np.full(z.shape, float(rho))
    if rho.shape not in (z.shape, (*z.shape, 3)):
        raise SurfaceError(f"expected albedo of shape {z.shape} or {(*z.shape, 3)}, got {rho.shape}")
    if not (np.isfinite(z).all() and np.isfinite(rho).all()):
        raise SurfaceError("expected a finite height and albedo, got NaN or infinity")
    if not spacing > 0:
        raise SurfaceError(f"expected spacing > 0, got {spacing}")
    return z, rho
