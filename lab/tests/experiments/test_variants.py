"""Every variant of the comparison on one copy."""

from __future__ import annotations

import pytest

from rumu.gallery.starter import find_work
from rumu_lab.experiments import variants
from rumu_lab.experiments.grading import GradingTask
from rumu_lab.experiments.simulated_copies import Faulty, Written

MASTER = find_work("regular-shui").path
OPEN = find_work("regular-ren").path


def test_the_variant_that_the_mark_uses_is_among_them():
    assert variants.base_weights() in variants.weights()
    assert len({variants.variant(*w) for w in variants.weights()}) == len(variants.weights())
    assert (0.0, variants.base_weights()[1]) in variants.weights()


@pytest.mark.parametrize("perfect", [True, False])
def test_one_copy_by_every_variant(perfect):
    copy = Written(MASTER) if perfect else Faulty(MASTER, "missing", 3, 11)
    raw = variants.grade_by_variants(GradingTask("k", "c", MASTER, copy)).raw
    assert set(raw) == {
        *(variants.variant(*w) for w in variants.weights()),
        *(variants.FORWARD, variants.BACKWARD, variants.DENSITY),
    }
    grades = [value for name, value in raw.items() if name != variants.DENSITY]
    if perfect:
        assert min(grades) > 0.99
    else:
        assert raw[variants.BACKWARD] < raw[variants.FORWARD]


def test_a_blank_copy_is_refused(tmp_path):
    from PIL import Image

    Image.new("L", (200, 200), 255).save(tmp_path / "blank.png")
    assert variants.grade_by_variants(GradingTask("k", "c", MASTER, Written(tmp_path / "blank.png"))).refused


def test_blots_show_in_the_darkness_and_both_kinds_of_height_are_graded():
    near, far = (
        variants.grade_by_heights(GradingTask("k", "c", OPEN, Faulty(OPEN, "dry", severity, 11))).raw
        for severity in (1, 5)
    )
    assert set(near) == set(far) == set(variants.HEIGHT_METHODS)
    assert far["inflation"] < near["inflation"]
