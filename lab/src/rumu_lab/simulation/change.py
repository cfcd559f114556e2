"""What a fault did to a glyph, as the families of faults hand it back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu_lab.simulation.glyph import Region

FloatArray = npt.NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """depth: (H, W) float32, the ink after the fault. size: of the fault, in the unit of its kind.

    strokes: numbers of those that were struck. region: where. en, zh: what was done.
    density: darkness of the ink, one number for all of it; None is 1.
    """

    depth: FloatArray
    size: float
    strokes: tuple[int, ...]
    region: Region
    en: str
    zh: str
    density: float | None = None
