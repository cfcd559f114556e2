"""RelightLab's .dome files: where the lamps of a dome stand, near the sheet or far away; and their fall-off.

A .dome is JSON. "lightConfiguration" says which of its lists holds: "directional" (directions), "spherical"
(positionsSphere, or directions on a sphere of domeDiameter, lifted by verticalOffset) or "lights3d"
(positions3d). Positions and imageWidth, the width of the sheet in a photograph, share one unit, mm as
RelightLab writes it; the origin is the middle of the photograph, x right, y up, z to the camera.
"ledAdjust" multiplies the values of each lamp. Facts from RelightLab's documentation.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rumu.capture.photographs import capture_error
from rumu.errors import CaptureError
from rumu.image_stack import Floats, ImageStack, Pixels
from rumu.inputs import read_json
from rumu.values import FloatArray

_KINDS = ("directional", "spherical", "lights3d")


@dataclass(frozen=True, slots=True, eq=False)
class Dome:
    """Lamps of a dome.

    lights: (N, 3) unit vectors from the middle of the sheet. positions: (N, 3) from the middle of the
    photograph, in mm; None of lamps far away. strengths: (N,), mean 1, None when they are not told.
    width: of the photograph in mm; None when it is not told, as by domes that were never given one.
    """

    lights: FloatArray
    positions: FloatArray | None
    strengths: FloatArray | None
    width: float | None


def read_dome(path: Path) -> Dome:
    """Read a .dome. Raises CaptureError naming the file and the entry that is wrong."""
    content = read_json(path, error_type=CaptureError, expected="the JSON of a .dome")
    kind = content.get("lightConfiguration", "directional") if isinstance(content, dict) else None
    if kind not in _KINDS:
        raise capture_error(
            path,
            en=f'expected "lightConfiguration" among {", ".join(_KINDS)}, got {kind!r}',
            zh=f'"lightConfiguration" 應是 {"、".join(_KINDS)} 之一，卻是 {kind!r}',
        )
    width = _length(path, content, "imageWidth")
    directions = _vectors(path, content, "directions", "xyz")
    positions = None
    if kind == "lights3d":
        key = "positions3d" if content.get("positions3d") else "positions"  # as versions before 2024 call it
        positions = _vectors(path, content, key, "xyz")
    elif kind == "spherical":
        positions = _vectors(path, content, "positionsSphere", "xyz")
        diameter = _length(path, content, "domeDiameter")
        if not len(positions) and diameter is not None:
            lift = _number(path, "verticalOffset", content.get("verticalOffset", 0.0))
            positions = diameter / 2 * directions + (0.0, 0.0, lift)
        if diameter is None and not np.any(positions):
            positions = None  # a sphere of no size: only directions are told
    vectors = directions if positions is None else positions
    length = np.linalg.norm(vectors, axis=1)
    if not len(vectors) or not (length > 0).all() or not (vectors[:, 2] > 0).all():
        raise capture_error(
            path,
            en=f"expected lamps above the sheet (z > 0), got {len(vectors)} of which not all are",
            zh=f"燈都應在紙的上方（z > 0）；這裡有 {len(vectors)} 盞，並非都是",
        )
    return Dome(vectors / length[:, None], positions, _strengths(path, content, len(vectors)), width)


def dome_text(positions: FloatArray, strengths: FloatArray | None, *, spacing: float, columns: int) -> str:
    """The text of a .dome that tells near lamps, as `read_dome` reads it.

    positions: (N, 3) in pixels from the middle of the photograph, which is `columns` wide. strengths: (N,) of
    the lamps, where they are known. spacing: millimetres of a pixel.
    """
    content: dict[str, Any] = {
        "lightConfiguration": "lights3d",
        "imageWidth": columns * spacing,
        "positions3d": [dict(zip("xyz", map(float, one), strict=True)) for one in positions * spacing],
    }
    if strengths is not None:
        content["ledAdjust"] = [dict.fromkeys("rgb", float(1.0 / one)) for one in strengths]
    return json.dumps(content, indent=1)


def _strengths(path: Path, content: dict[str, Any], count: int) -> FloatArray | None:
    adjust = _vectors(path, content, "ledAdjust", "rgb")
    if len(adjust) != count or not (adjust > 0).all() or np.ptp(adjust.mean(axis=1)) < 1e-6:
        return None
    strengths = 1 / adjust.mean(axis=1)
    return np.asarray(strengths / strengths.mean())


def _vectors(path: Path, content: dict[str, Any], key: str, names: str) -> FloatArray:
    """(N, 3), empty where the entry is not there."""
    rows = content.get(key) or []
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise capture_error(
            path, en=f'expected "{key}" to be a list of {{...}}', zh=f'"{key}" 應是一列 {{...}}'
        )
    found = [[_number(path, key, row.get(name)) for name in names] for row in rows]
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def _length(path: Path, content: dict[str, Any], key: str) -> float | None:
    """A length; None where it is not told, or 0, as RelightLab writes what it was not told."""
    value = _number(path, key, content.get(key, 0.0))
    if value < 0:
        raise capture_error(
            path,
            en=f'expected "{key}" above 0, in the unit of the positions, got {value:g}',
            zh=f'"{key}" 應大於 0，單位與燈的位置相同，卻是 {value:g}',
        )
    return value or None


def _number(path: Path, key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise capture_error(
            path, en=f'expected numbers in "{key}", got {value!r}', zh=f'"{key}" 應是數，卻是 {value!r}'
        )
    return float(value)


@dataclass(frozen=True, slots=True, eq=False)
class FallOffGain:
    """What makes a flat sheet under a near lamp as bright everywhere as under one far away.

    A flat sheet shows z / r^3 of a lamp at height z and distance r. position: (3,) in pixels from the middle.
    shape: (H, W). factor: so that equal lamps look equal, and nothing gets brighter.
    """

    position: FloatArray
    shape: tuple[int, int]
    factor: float

    def at(self, pixels: Pixels) -> Floats:
        """(P,) float32, above 0 and at most 1."""
        x, y = places(pixels, self.shape)
        away = (x - self.position[0]) ** 2 + (y - self.position[1]) ** 2 + self.position[2] ** 2
        return np.asarray(self.factor * away**1.5, np.float32)


def places(pixels: Pixels, shape: tuple[int, int]) -> tuple[Floats, Floats]:
    """X and y of pixels by their numbers, (P,) each, in pixels from the middle, y up. shape: (H, W)."""
    rows, columns = np.divmod(pixels, shape[1])
    return columns - (shape[1] - 1) / 2, (shape[0] - 1) / 2 - rows


def without_fall_off(stack: ImageStack, positions: FloatArray) -> ImageStack:
    """Photographs in which flat paper is evenly bright. positions: (N, 3) of the lamps, in pixels."""
    height, width = shape = stack.shape[1], stack.shape[2]
    corners = np.array([0, width - 1, (height - 1) * width, height * width - 1])
    power = 1 / np.linalg.norm(positions, axis=1)
    gains = [FallOffGain(one, shape, float(p)) for one, p in zip(positions, power, strict=True)]
    most = max(float(gain.at(corners).max()) for gain in gains)
    return stack.times([FallOffGain(one.position, shape, one.factor / most) for one in gains])
