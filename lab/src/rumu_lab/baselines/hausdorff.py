"""Hausdorff distance of the two outlines, at the 95th percentile, after place and size are taken out.

The greatest distance of all depends on a single pixel; the 95th percentile, used for segmentations, does not.
"""

from __future__ import annotations

import math

import numpy as np

from rumu.values import BoolArray, FloatArray
from rumu_lab.baselines.cell import SIDE, Cell, Raw
from rumu_lab.baselines.placing import align, placement

SHARE = 95.0
REACH = 0.1
"""Distance, in cells, at which the grade has fallen to 1/e."""


def raw(probe: Cell, reference: Cell) -> Raw:
    """exp(-d / REACH), d the greater of the two directed distances.

    features, in cells: 'distance' d; 'forward' from the probe's outline to the reference's, which is long
    where ink is in excess; 'backward' the other way, long where ink is missing; those of `placement`.
    """
    ink = align(probe, reference).ink
    forward, backward = (
        directed_distance(ink, reference.ink) / SIDE,
        directed_distance(reference.ink, ink) / SIDE,
    )
    distance = max(forward, backward)
    features = {"distance": distance, "forward": forward, "backward": backward}
    return Raw(math.exp(-distance / REACH), features | placement(probe, reference))


def directed_distance(a: BoolArray, b: BoolArray) -> float:
    """95th percentile of the distances, in pixels, from the outline of a to that of b."""
    return float(np.percentile(_distance_to(outline(b))[outline(a)], SHARE))


def outline(ink: BoolArray) -> BoolArray:
    """Ink pixels that touch paper by a side; beyond the picture is paper."""
    import cv2

    cross = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
    inner = cv2.erode(np.pad(ink, 1).astype(np.uint8), cross)[1:-1, 1:-1] > 0
    return np.asarray(ink & ~inner)


def _distance_to(line: BoolArray) -> FloatArray:
    import cv2

    return np.asarray(cv2.distanceTransform((~line).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))
