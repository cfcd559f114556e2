"""Ablations: a part that helps is shown to help, one that does nothing is not."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.experiments import ablation
from rumu.experiments.made import Faulty, Written
from rumu.experiments.measuring import Task
from rumu.gallery.works import find_work

MASTER = find_work("regular-shui").path
CHARACTERS = np.repeat([f"c{k}" for k in range(12)], 10)
RNG = np.random.default_rng(5)
MARKS = RNG.uniform(20, 80, len(CHARACTERS))


def test_the_variant_that_the_mark_uses_is_among_them():
    assert ablation.base_weights() in ablation.weights()
    assert len({ablation.variant(*w) for w in ablation.weights()}) == len(ablation.weights())
    assert (0.0, ablation.base_weights()[1]) in ablation.weights()


def test_gains(quick):
    names = [ablation.variant(*w) for w in ablation.weights()]
    raw = {name: MARKS / 100 + 0.3 * RNG.normal(size=len(MARKS)) for name in names}
    raw |= {ablation.FORWARD: raw[ablation.base_variant()].copy(), ablation.BACKWARD: -MARKS}
    height, direction = ablation.base_weights()
    raw[ablation.variant(height, direction)] = MARKS / 100
    found = {row["what"]: row for row in ablation.gain_rows(raw, MARKS, list(CHARACTERS), quick)}
    helped = found["both ways, against master to copy"]
    assert helped["clear"] == "helps" and helped["low"] > 1.9 and helped["n"] == 12
    assert found[f"direction x {direction:g}"]["clear"] == "helps"
    raw[ablation.FORWARD] = raw[ablation.base_variant()]
    same = {row["what"]: row for row in ablation.gain_rows(raw, MARKS, list(CHARACTERS), quick)}
    assert same["both ways, against copy to master"]["clear"] == "not shown"


@pytest.mark.parametrize("perfect", [True, False])
def test_one_copy_by_every_variant(perfect):
    copy = Written(MASTER) if perfect else Faulty(MASTER, "missing", 3, 11)
    raw = ablation.measure_variants(Task("k", "c", MASTER, copy)).raw
    assert set(raw) == {
        *(ablation.variant(*w) for w in ablation.weights()),
        *(ablation.FORWARD, ablation.BACKWARD, ablation.DENSITY),
    }
    grades = [value for name, value in raw.items() if name != ablation.DENSITY]
    if perfect:
        assert min(grades) > 0.99
    else:
        assert raw[ablation.BACKWARD] < raw[ablation.FORWARD]


def test_a_blank_copy_is_refused(tmp_path):
    from PIL import Image

    Image.new("L", (200, 200), 255).save(tmp_path / "blank.png")
    assert ablation.measure_variants(Task("k", "c", MASTER, Written(tmp_path / "blank.png"))).refused
