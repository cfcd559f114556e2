"""The AEST-based grader: its three indexes, its weights, and the faults it sees."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rumu.errors import RumuError
from rumu_lab.baselines.aest import INDEXES, AestSettings, raw, relations_apart
from rumu_lab.baselines.cell import SIDE, cell_from
from rumu_lab.baselines.lines import StrokeLine
from rumu_lab.baselines.stroke_pairs import curves_of


@pytest.mark.parametrize("work", ["regular-shu", "regular-tian", "clerical-tian", "seal-ren"])
def test_itself_is_one(cell, work):
    same = raw(cell(work), cell(work))
    assert same.raw > 0.98
    assert min(same.features[name] for name in INDEXES) > 0.98


def test_other_characters_are_far_below_a_faulty_copy(cell):
    master = cell("regular-shu")
    others = [raw(cell(f"regular-{name}"), master).raw for name in ("yue", "shui", "tian", "ren", "ri")]
    assert max(others) < 0.6 < raw(cell("regular-shu", "shift", 5), master).raw


@pytest.mark.parametrize(
    "fault",
    [
        "shift",
        "angle",
        "short",
        "stroke_thin",
        "stroke_thick",
        "lean",
        "off_centre",
        "small",
        "squeeze",
        "uneven",
    ],
)
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 5), seeds=(1, 2))
    assert grades[0] > grades[1] > grades[2], grades


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault):
    grades = ladder(raw, "regular-shu", fault, severities=(0, 1, 3))
    assert grades[0] - 0.05 > grades[1] > grades[2], grades


def test_each_index_sees_what_it_is_named_for(cell, moved):
    master = cell("regular-shu")
    same = raw(master, master).features
    aside = raw(moved("regular-shu", shift=(15, 0)), master).features
    assert aside["balance"] == pytest.approx(np.exp(-15 / SIDE / 0.06), abs=0.03)
    assert aside["coordination"] > 0.85 and aside["distribution"] > 0.85
    thick = raw(cell("regular-shu", "stroke_thick", 5), master).features
    assert same["coordination"] - thick["coordination"] > same["balance"] - thick["balance"]
    uneven = raw(cell("regular-shu", "uneven", 5), master).features
    assert uneven["distribution"] < 0.85


def three(turn: float = 0.0, scale: float = 1.0, width: float = 1.0, long: float = 1.0):
    """A level, a standing and a slanting line; the first turned, or longer, or wider than the others are."""
    angles = np.radians([turn, 90.0, 40.0])
    lengths = scale * np.array([long, 1.0, 0.7])
    lines = []
    for k, (a, length) in enumerate(zip(angles, lengths, strict=True)):
        points = np.linspace((0, 0), (length * np.cos(a), length * np.sin(a)), 30) + k
        lines.append(StrokeLine(points, np.full(30, scale * 0.05 * (width if k == 0 else 1.0))))
    return curves_of(lines)


def test_relations_forget_size_and_count_units():
    settings = AestSettings()
    assert relations_apart(three(), three(scale=1.7), settings=settings) == pytest.approx(0.0, abs=1e-9)
    for changed in (three(turn=30.0), three(width=2.0), three(long=2.0), three(turn=-30.0), three(long=0.5)):
        apart = relations_apart(three(), changed, settings=settings)
        assert apart[0, 1] == pytest.approx(1.0) and apart[0, 2] == pytest.approx(1.0)
        assert apart[1, 2] == pytest.approx(0.0, abs=1e-9)


def test_a_direction_is_the_same_from_either_end():
    assert relations_apart(three(), three(turn=180.0), settings=AestSettings()) == pytest.approx(
        0.0, abs=1e-6
    )


def test_the_grade_weighs_the_three_indexes(cell):
    answer = raw(cell("regular-shu", "lean", 4), cell("regular-shu"))
    assert answer.raw == pytest.approx(
        sum(w * answer.features[n] for w, n in zip((0.4, 0.3, 0.3), INDEXES, strict=True))
    )


def bar():
    ink = np.zeros((SIDE, SIDE), bool)
    ink[120:136, 40:216] = True
    return cell_from(ink)


def test_a_single_stroke_can_be_graded():
    assert raw(bar(), bar()).raw > 0.98


def test_without_ink_there_is_one_clear_error():
    with pytest.raises(RumuError, match="ink"):
        cell_from(np.zeros((SIDE, SIDE), bool))


@given(st.integers(0, 2**32 - 1), st.floats(0.002, 0.6), st.floats(2.0, 10.0))
@example(167, 0.28125, 7.5)  # ink that smoothing once spilled over the rim
@settings(max_examples=20, deadline=None)
def test_any_ink_has_a_finite_grade(seed, share, blur):
    field = np.random.default_rng(seed).random((SIDE, SIDE)).astype(np.float32)
    field = cv2.GaussianBlur(field, (0, 0), blur)
    blobs = cell_from(field > np.quantile(field, 1.0 - share))
    for probe, reference in ((blobs, bar()), (bar(), blobs)):
        assert 0.0 <= raw(probe, reference).raw <= 1.0
