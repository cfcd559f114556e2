"""Structural similarity of the two cells (Wang, Bovik, Sheikh, Simoncelli 2004), by scikit-image.

The copy is placed first: in the cell as written the crop would be marked, not the writing. Both are brought
to 64 x 64, where the publication's windows (Gaussian, sigma 1.5) are as wide as a stroke; at 256 x 256 no two
outlines agree in a window, and copies that people mark alike part. Windows that show paper in both count as
alike, so even another character of few strokes keeps more than half.
"""

from __future__ import annotations

from rumu_lab.baselines.cell import Cell, Raw
from rumu_lab.baselines.placing import align, placement

SMALL = 64


def raw(probe: Cell, reference: Cell) -> Raw:
    """Mean structural similarity of the densities, below 0 cut.

    features: 'ssim', the mean, in [-1, 1]; those of `placement`.
    """
    import cv2
    from skimage.metrics import structural_similarity

    a, b = (
        cv2.resize(cell.density, (SMALL, SMALL), interpolation=cv2.INTER_AREA)
        for cell in (align(probe, reference), reference)
    )
    options = {"data_range": 1.0, "gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False}
    value = float(structural_similarity(a, b, **options))
    return Raw(min(max(value, 0.0), 1.0), {"ssim": value} | placement(probe, reference))
