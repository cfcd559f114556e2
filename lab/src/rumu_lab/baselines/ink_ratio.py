"""The amount of ink alone: a control that looks at no shape. What does not beat it sees none."""

from __future__ import annotations

import math

import numpy as np

from rumu_lab.baselines.cell import Cell, Raw


def raw(probe: Cell, reference: Cell) -> Raw:
    """The smaller area of ink over the larger. feature 'log_ratio': ln of probe over reference."""
    here, there = (int(np.count_nonzero(cell.ink)) for cell in (probe, reference))
    return Raw(min(here, there) / max(here, there), {"log_ratio": math.log(here / there)})
