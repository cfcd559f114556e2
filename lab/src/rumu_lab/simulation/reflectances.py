"""Materials other than Lambert's, by formulas that no solver here is built on.

Each says how bright a surface is, seen from +z under a lamp of strength 1; frame as in
`rumu_lab.simulation.lamps`. Sources: Phong's lobe about the halfway vector after Blinn (1977); Cook and
Torrance with Beckmann's distribution (1982); Ashikhmin and Shirley (2000), isotropic; Oren and Nayar (1994);
Burley (2012) with its diffuse part; cloth after the sheen of the same. Where no light falls, cosine <= 0, all
are dark.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from rumu.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Angles:
    """Cosines (P, N): of the normal to lamp, camera, halfway vector; between lamp and the latter."""

    lamp: FloatArray
    camera: FloatArray
    halfway: FloatArray
    between: FloatArray


def _angles(normals: FloatArray, lights: FloatArray) -> _Angles:
    halfway = lights + np.array([0.0, 0.0, 1.0])
    halfway = halfway / np.linalg.norm(halfway, axis=1, keepdims=True)
    lamp = np.clip(normals @ lights.T, 0.0, 1.0)
    camera = np.broadcast_to(np.clip(normals[:, 2:], 1e-3, 1.0), lamp.shape)
    between = np.broadcast_to((lights * halfway).sum(axis=1), lamp.shape)
    return _Angles(lamp, camera, np.clip(normals @ halfway.T, 1e-3, 1.0), between)


def phong(at: _Angles, *, matte: float = 0.5, gloss: float = 0.3, exponent: float = 20.0) -> FloatArray:
    """Lambert's law and a lobe about the halfway vector."""
    return np.asarray(matte * at.lamp + gloss * at.halfway**exponent * (at.lamp > 0))


def beckmann(at: _Angles, *, matte: float = 0.5, gloss: float = 0.2, slope: float = 0.22) -> FloatArray:
    """Lambert's law and facets after Cook and Torrance. slope: root mean square of the facets'."""
    tangent2 = (1.0 - at.halfway**2) / at.halfway**2
    facets = np.exp(-tangent2 / slope**2) / (np.pi * slope**2 * at.halfway**4)
    near = 2.0 * at.halfway * np.minimum(at.camera, at.lamp) / at.between
    fresnel = 0.04 + 0.96 * (1.0 - at.between) ** 5
    lobe = 25.0 * fresnel * facets * np.minimum(1.0, near) / (4.0 * at.camera)
    return np.asarray(matte * at.lamp + gloss * lobe)


def ashikhmin(at: _Angles, *, matte: float = 0.5, gloss: float = 0.3, exponent: float = 25.0) -> FloatArray:
    """A matte ground under gloss, which gives less where it is seen or lit aslant."""
    ground = 28.0 / 23.0 * (1.0 - (1.0 - at.lamp / 2) ** 5) * (1.0 - (1.0 - at.camera / 2) ** 5)
    lobe = (
        (exponent + 1.0)
        / (2.0 * np.pi)
        * at.halfway**exponent
        / (at.between * np.maximum(at.lamp, at.camera))
    )
    return (matte * ground + gloss * lobe) * at.lamp


def oren_nayar(at: _Angles, *, matte: float = 0.5, slope: float = 0.5, lights: FloatArray) -> FloatArray:
    """Rough ground of matte facets. slope: spread of the facets, in radians; lights: (N, 3)."""
    a = 1.0 - 0.5 * slope**2 / (slope**2 + 0.33)
    b = 0.45 * slope**2 / (slope**2 + 0.09)
    incident, seen = np.arccos(at.lamp), np.arccos(at.camera)
    across = np.maximum(np.sin(incident) * np.sin(seen), 1e-6)
    azimuth = (lights[:, 2][None] - at.lamp * at.camera) / across
    wider, narrower = np.maximum(incident, seen), np.minimum(incident, seen)
    return np.asarray(matte * at.lamp * (a + b * np.maximum(azimuth, 0.0) * np.sin(wider) * np.tan(narrower)))


def burley(at: _Angles, *, matte: float = 0.5, roughness: float = 0.8) -> FloatArray:
    """The matte part of Burley's model, brighter or darker at grazing angles by the roughness."""
    grazing = 0.5 + 2.0 * roughness * at.between**2 - 1.0
    return matte * at.lamp * (1.0 + grazing * (1.0 - at.lamp) ** 5) * (1.0 + grazing * (1.0 - at.camera) ** 5)


def cloth(at: _Angles, *, matte: float = 0.5, fuzz: float = 0.3) -> FloatArray:
    """Lambert's law and fibres that shine away from the halfway vector."""
    return np.asarray(at.lamp * (matte + fuzz * np.sqrt(1.0 - at.halfway**2) ** 5))


REFLECTANCES: Mapping[str, Callable[[_Angles, FloatArray], FloatArray]] = {
    "Lambert": lambda at, lights: 0.5 * at.lamp,
    "Phong, exponent 8": lambda at, lights: phong(at, exponent=8.0, gloss=0.4),
    "Phong, exponent 20": lambda at, lights: phong(at),
    "Phong, exponent 60": lambda at, lights: phong(at, exponent=60.0, gloss=0.5),
    "Beckmann, slope .22": lambda at, lights: beckmann(at),
    "Ashikhmin-Shirley": lambda at, lights: ashikhmin(at),
    "Oren-Nayar, slope .3": lambda at, lights: oren_nayar(at, slope=0.3, lights=lights),
    "Oren-Nayar, slope .6": lambda at, lights: oren_nayar(at, slope=0.6, lights=lights),
    "Burley, roughness .8": lambda at, lights: burley(at),
    "cloth": lambda at, lights: cloth(at),
    "Beckmann metal, slope .3": lambda at, lights: beckmann(at, matte=0.02, gloss=0.4, slope=0.3),
}
"""Materials by name."""


def photograph_material(
    normals: FloatArray, lights: FloatArray, name: str, *, noise: float = 0.004, seed: int = 0
) -> FloatArray:
    """(N, H, W) float32 in [0, 1], in steps of 8 bits: a surface of one of `REFLECTANCES`.

    normals: (H, W, 3), unit; lights: (N, 3), unit. Exposed so that one value in thirty is near white or
        beyond; no shadow is cast.
    noise: standard deviation, in linear brightness.
    """
    flat = normals.reshape(-1, 3)
    shown = REFLECTANCES[name](_angles(flat, lights), lights)
    shown = shown / np.quantile(shown, 0.97) * 0.9
    shown = shown + np.random.default_rng(seed).normal(0.0, noise, shown.shape)
    steps = np.round(np.clip(shown, 0.0, 1.0) * 255.0) / 255.0
    return np.asarray(steps.T.reshape(len(lights), *normals.shape[:2]), dtype=np.float32)


def spread_lamps(count: int, *, slant: float = 65.0) -> FloatArray:
    """(N, 3) unit vectors to lamps spread evenly over a dome, on a golden spiral. slant: of the lowest."""
    share = (np.arange(count) + 0.5) / count
    z = 1.0 - (1.0 - np.cos(np.radians(slant))) * share
    aside, tilt = np.sqrt(1.0 - z * z), np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([np.cos(tilt) * aside, np.sin(tilt) * aside, z], axis=1)
