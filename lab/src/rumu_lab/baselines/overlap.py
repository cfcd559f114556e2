"""Intersection over union of the ink: in the cell as written, and after place and size are taken out.

Plain and hard to beat: most faults of a copy move ink away from the master's. It needs no reconstruction.
"""

from __future__ import annotations

import numpy as np

from rumu.values import BoolArray
from rumu_lab.baselines.cell import Cell, Raw
from rumu_lab.baselines.placing import align, placement


def raw(probe: Cell, reference: Cell) -> Raw:
    """Intersection over union in the cell. feature 'iou' is the grade itself."""
    value = iou(probe.ink, reference.ink)
    return Raw(value, {"iou": value})


def raw_aligned(probe: Cell, reference: Cell) -> Raw:
    """Intersection over union once the probe is placed. features: 'iou', and those of `placement`."""
    value = iou(align(probe, reference).ink, reference.ink)
    return Raw(value, {"iou": value} | placement(probe, reference))


def iou(a: BoolArray, b: BoolArray) -> float:
    """Pixels of both over pixels of either, in [0, 1]; 0 for two empty masks."""
    return float(np.count_nonzero(a & b)) / max(1, int(np.count_nonzero(a | b)))
