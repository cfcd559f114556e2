"""A pair is graded by every method, and a copy that cannot be marked says why."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.gallery.starter import find_work
from rumu_lab.baselines.methods import METHODS
from rumu_lab.experiments.grading import OWN, GradingTask, grade
from rumu_lab.experiments.simulated_copies import Faulty, Written

MASTER = find_work("regular-ren").path


def test_a_pair_is_graded_by_every_method():
    good = grade(GradingTask("good", "c", MASTER, Written(MASTER)))
    worse = grade(GradingTask("bad", "c", MASTER, Faulty(MASTER, "angle", 5, 11)))
    assert set(good.raw) == {*OWN, *METHODS}
    assert good.mark == pytest.approx(100, abs=1) and worse.mark < good.mark
    assert good.refused is None and good.failed == ()


def test_a_refused_copy_says_why(tmp_path):
    from PIL import Image

    Image.new("L", (200, 200), 255).save(tmp_path / "blank.png")
    grades = grade(GradingTask("k", "c", MASTER, Written(tmp_path / "blank.png")))
    assert grades.refused and grades.raw == {} and np.isnan(grades.mark)
