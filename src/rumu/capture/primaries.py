"""Colour profiles (ICC) that are three curves and a matrix, for pictures of 16 bits.

The layout of a profile and of its curves: ICC.1:2010, chapters 7.2, 7.3, 10.5, 10.15.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rumu.capture.stored import Samples, to_srgb
from rumu.values import FloatArray

_LEVELS = 65536
_STRIP = 256  # rows that are converted at a time
_SRGB = np.array(
    [[0.4360747, 0.3850649, 0.1430804], [0.2225045, 0.7168786, 0.0606169], [0.0139322, 0.0971045, 0.7141733]]
)
"""Columns: X, Y, Z of the primaries of sRGB under D50, as profiles tell them (Lindbloom)."""
_PARAMETERS = {0: 1, 1: 3, 2: 4, 3: 5, 4: 7}  # of a parametric curve, by its kind


@dataclass(frozen=True, slots=True, eq=False)
class Primaries:
    """curves: (3, 65536) float32, the light of each level. matrix: (3, 3), to linear sRGB."""

    curves: FloatArray
    matrix: FloatArray

    def convert(self, samples: Samples) -> Samples:
        """(H, W, 3) uint16 as sRGB of 16 bits; what sRGB does not hold is cut."""
        converted = np.empty_like(samples)
        shown = _shown_levels()
        for top in range(0, len(samples), _STRIP):
            part = samples[top : top + _STRIP]
            light = np.stack([curve[part[..., k]] for k, curve in enumerate(self.curves)], axis=2)
            light = light @ self.matrix.T.astype(np.float32)
            converted[top : top + _STRIP] = shown[
                np.rint(np.clip(light, 0, 1) * (len(shown) - 1)).astype(int)
            ]
        return converted


@lru_cache(maxsize=1)
def _shown_levels() -> Samples:
    """Levels of sRGB in 16 bits of 2^20 steps of light, fine enough for the darkest."""
    return np.asarray(np.rint(to_srgb(np.linspace(0, 1, 1 << 20)) * (_LEVELS - 1)), np.uint16)


def read_primaries(profile: bytes) -> Primaries | None:
    """The curves and the matrix of a profile; None of one that has others, or tables."""
    try:
        tags = _tags(profile)
        if b"A2B0" in tags:
            return None
        curves = np.stack([_curve(tags[name]) for name in (b"rTRC", b"gTRC", b"bTRC")])
        columns = [struct.unpack(">3i", tags[name][8:20]) for name in (b"rXYZ", b"gXYZ", b"bXYZ")]
    except (KeyError, ValueError, IndexError, ZeroDivisionError, struct.error):
        return None
    if not np.isfinite(curves).all():
        return None
    matrix = np.linalg.solve(_SRGB, np.array(columns, np.float64).T / 65536)
    return Primaries(curves.astype(np.float32), matrix)


def _tags(profile: bytes) -> dict[bytes, bytes]:
    """The tags of a profile by their signatures."""
    (count,) = struct.unpack(">I", profile[128:132])
    found = {}
    for at in range(132, min(132 + 12 * count, len(profile) - 11), 12):
        name, start, size = struct.unpack(">4sII", profile[at : at + 12])
        found[name] = profile[start : start + size]
    return found


def _curve(tag: bytes) -> FloatArray:
    """(65536,) the light of each level. Raises ValueError for a curve of another kind."""
    levels = np.linspace(0, 1, _LEVELS)
    if tag[:4] == b"curv":
        (count,) = struct.unpack(">I", tag[8:12])
        if count == 0:
            return levels
        if len(tag) < 12 + 2 * count:
            raise ValueError("expected all points of the curve")
        points = np.frombuffer(tag[12 : 12 + 2 * count], ">u2").astype(np.float64)
        if count == 1:
            return np.asarray(levels ** (points[0] / 256))
        return np.interp(levels, np.linspace(0, 1, count), points / 65535)
    if tag[:4] != b"para":
        raise ValueError("expected a curve")
    (kind,) = struct.unpack(">H", tag[8:10])
    if kind not in _PARAMETERS:
        raise ValueError("expected a parametric curve")
    count = _PARAMETERS[kind]
    told = np.array(struct.unpack(f">{count}i", tag[12 : 12 + 4 * count])) / 65536
    g, a, b, c, d, e, f = np.pad(told, (0, 7 - count)).tolist()
    if g <= 0:
        raise ValueError("expected an exponent above 0")
    if kind == 0:
        return np.asarray(levels**g)
    if kind in (1, 2):
        d, (c, shift) = -b / a, (0.0, c)
        e = f = shift
    upper = np.maximum(a * levels + b, 0) ** g + e
    return np.asarray(np.where(levels >= d, upper, c * levels + f))
