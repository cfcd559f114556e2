"""What placing takes out, and that it takes out no more."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import RegistrationError
from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.overlap import iou
from rumu_lab.baselines.placing import align, frame, placement


def test_a_known_move_is_taken_back(cell, moved) -> None:
    master = cell("regular-tian")
    copy = moved("regular-tian", scale=0.8, shift=(12.0, -9.0))
    told = placement(copy, master)
    centre, _ = frame(master.ink)
    off = 0.8 * (centre - (SIDE - 1) / 2) + (SIDE - 1) / 2 + (12.0, -9.0) - centre
    assert told["log_size"] == pytest.approx(np.log(0.8), abs=0.01)
    assert (told["right"], told["up"]) == pytest.approx((off[0] / SIDE, -off[1] / SIDE), abs=0.003)
    assert iou(align(copy, master).ink, master.ink) > 0.93


def test_lean_stays(cell, moved) -> None:
    master = cell("regular-tian")
    assert iou(align(moved("regular-tian", lean=12.0), master).ink, master.ink) < 0.7


def test_ink_that_would_leave_the_cell_is_an_error() -> None:
    dots, wide = np.zeros((2, SIDE, SIDE), bool)
    wide[:10, :10] = wide[-10:, -10:] = wide[:10, -10:] = wide[-10:, :10] = True
    dots[100:105, 100:105] = dots[100:105, 140:145] = True  # blown up, both stand beyond the sides
    with pytest.raises(RegistrationError, match="placed"):
        align(cell_from(dots), cell_from(wide))
