"""The copies that experiments look at, as small recipes that travel between processes.

A recipe says how its picture comes about; the picture is made where it is measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Picture = npt.NDArray[np.uint8]


class Recipe(Protocol):
    """How a copy comes about."""

    def picture(self) -> Path | Picture:
        """A file, or (H, W) or (H, W, 3) uint8, dark ink on light paper."""
        ...


@dataclass(frozen=True, slots=True)
class Written:
    """A copy that somebody wrote, or a master itself, as a file."""

    path: Path

    def picture(self) -> Path:
        """The file."""
        return self.path


@dataclass(frozen=True, slots=True)
class Faulty:
    """A master with one simulated fault at a severity from 0 to 5."""

    master: Path
    fault: str
    severity: float
    seed: int

    def picture(self) -> Picture:
        """(H, W) uint8."""
        from rumu_lab.simulation.faults import apply

        return _gray(apply(ink_of(self.master), self.fault, severity=self.severity, seed=self.seed).ink)


@dataclass(frozen=True, slots=True)
class AtDegree:
    """A simulated copy at one of the four degrees."""

    master: Path
    degree: str
    seed: int

    def picture(self) -> Picture:
        """(H, W) uint8."""
        from rumu_lab.simulation.copies import copy_at

        return _gray(copy_at(ink_of(self.master), self.degree, seed=self.seed).ink)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Disturbed:
    """A copy as a worse photograph would show it: the writing is the same.

    kind: 'blur', 'noise', 'jpeg', 'tint', 'grid', 'light' or 'resolution'. amount: standard deviation in
    pixels; of noise, white being 1; quality; colour of the paper; colour of the lines; light at the far
    corner; side in pixels.
    """

    copy: AtDegree | Faulty
    kind: str
    amount: float | tuple[float, ...]
    seed: int = 0

    def picture(self) -> Picture:
        """(H, W, 3) uint8."""
        light = np.repeat(_picture_of(self.copy)[..., None], 3, axis=2).astype(np.float32) / 255.0
        changed = _NUISANCES[self.kind](light, self.amount, np.random.default_rng(self.seed))
        return np.asarray(np.round(255.0 * np.clip(changed, 0.0, 1.0)), dtype=np.uint8)


@lru_cache(maxsize=4)
def ink_of(master: Path) -> npt.NDArray[np.bool_]:
    """(H, W) bool, the ink of a picture."""
    from rumu.surface.relief import relief

    return relief(master).mask


@lru_cache(maxsize=4)  # many disturbed pictures of one copy come in a row
def _picture_of(copy: AtDegree | Faulty) -> Picture:
    return copy.picture()


def _gray(ink: Any) -> Picture:
    return np.asarray(np.round(255.0 * (1.0 - ink)), dtype=np.uint8)


def _blur(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    import cv2

    return cv2.GaussianBlur(light, (0, 0), amount)


def _noise(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    return light + amount * rng.standard_normal(light.shape[:2])[..., None]


def _jpeg(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    import cv2

    coded = cv2.imencode(".jpg", np.round(255 * light).astype(np.uint8), (cv2.IMWRITE_JPEG_QUALITY, amount))
    return np.asarray(cv2.imdecode(coded[1], cv2.IMREAD_COLOR), np.float32) / 255.0


def _tint(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    return light * np.array(amount)


def _grid(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    """The cell's frame and its eight rays, two pixels of 512 wide, beneath the ink."""
    import cv2

    side = light.shape[0]
    lines, wide, last = np.zeros(light.shape[:2], np.uint8), max(1, round(side / 256)), side - 1
    edge, middle = round(0.02 * side), side // 2
    cv2.rectangle(lines, (edge, edge), (last - edge, last - edge), 255, wide)
    for a, b in (
        ((edge, edge), (last - edge, last - edge)),
        ((last - edge, edge), (edge, last - edge)),
        ((middle, edge), (middle, last - edge)),
        ((edge, middle), (last - edge, middle)),
    ):
        cv2.line(lines, a, b, 255, wide, cv2.LINE_AA)
    share = (lines / 255.0)[..., None]
    return light * (1.0 - share * (1.0 - np.array(amount)))


def _light(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    """Full at the upper left corner, `amount` at the lower right, even between."""
    rows, columns = (np.linspace(0, 1, n) for n in light.shape[:2])
    along = (rows[:, None] + columns[None, :]) / 2
    return light * (1.0 - (1.0 - amount) * along)[..., None]


def _resolution(light: Any, amount: Any, rng: np.random.Generator) -> Any:
    import cv2

    method = cv2.INTER_AREA if amount < light.shape[0] else cv2.INTER_CUBIC
    return cv2.resize(light, (int(amount), int(amount)), interpolation=method)


_NUISANCES: Mapping[str, Any] = {
    "blur": _blur,
    "noise": _noise,
    "jpeg": _jpeg,
    "tint": _tint,
    "grid": _grid,
    "light": _light,
    "resolution": _resolution,
}
