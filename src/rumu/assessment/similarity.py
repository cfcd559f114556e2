"""Two similarities: the paper's, printed for the record, and one that a missing stroke cannot fool."""

from __future__ import annotations

import numpy as np

from rumu.registration.icp import pose_probe
from rumu.values import Registration


def sim_paper(registration: Registration) -> float:
    """Eq. (26): SIM = (1 - d_ms / ||X||_F) * 100 %, as printed; X the reference's points, in rms radii.

    Kept for comparison and never used as the mark: d_ms is a squared length and ||X||_F a length, so the
    unit decides; ||X||_F grows with the number of points, so any two characters read above 99; and
    d_ms is one-sided, so a copy of a single stroke reads 100.
    """
    return float((1.0 - registration.d_ms / np.linalg.norm(registration.reference.xyz)) * 100.0)


def similarity(registration: Registration) -> float:
    """Two-sided similarity (ours): 1 - max(E_f, E_b) / r_X; 1 is identical, unrelated shapes about 0.7.

    E_f, E_b: rms distance in (x, y, z) from copy to master and from master to copy after registration;
    r_X: rms distance of the master's points from their mean. Free of unit, origin and number of points.
    """
    p, x = pose_probe(registration), registration.reference.xyz
    forward = p - x[registration.forward_index]
    backward = x - p[registration.backward_index]
    error = max(float(np.mean(np.sum(d * d, axis=1))) for d in (forward, backward))
    spread = float(np.var(x, axis=0).sum())
    return 1.0 - float(np.sqrt(error / spread))
