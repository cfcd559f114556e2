"""Cosine between histograms of oriented gradients (Dalal and Triggs 2005), by scikit-image.

The copy is placed, and the cell is brought to 64 x 64 and described in their way: nine directions, squares of
8 x 8 pixels, blocks of 2 x 2 squares normalised by themselves.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rumu.values import FloatArray
from rumu_lab.baselines.cell import Cell, Raw
from rumu_lab.baselines.placing import align, placement

SMALL = 64


def raw(probe: Cell, reference: Cell) -> Raw:
    """Cosine of the two descriptors, which have no negative parts.

    features: 'cosine', the grade itself; those of `placement`.
    """
    a, b = describe(align(probe, reference)), describe(reference)
    value = float(a @ b / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-12))
    return Raw(min(value, 1.0), {"cosine": value} | placement(probe, reference))


@lru_cache(maxsize=4)  # many copies of one master come in a row
def describe(cell: Cell) -> FloatArray:
    """(1764,) float64: the histogram of the cell, 7 x 7 blocks of 2 x 2 squares of 9 directions."""
    import cv2
    from skimage.feature import hog

    small = cv2.resize(cell.density, (SMALL, SMALL), interpolation=cv2.INTER_AREA)
    answer = hog(small, orientations=9, pixels_per_cell=(8, 8), cells_per_block=(2, 2), block_norm="L2-Hys")
    return np.asarray(answer, dtype=float)
