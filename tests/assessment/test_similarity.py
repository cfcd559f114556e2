"""The paper's similarity with its traps, and the two-sided one without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from rumu.assessment.similarity import sim_paper, similarity
from rumu.registration.icp import pose_probe
from rumu_lab.simulation.glyph import Glyph

WORK = "regular-shui"


def test_a_copy_of_itself_is_the_same(laid, mask):
    same = laid(mask(WORK), mask(WORK))
    assert sim_paper(same) == pytest.approx(100.0, abs=1e-9)
    assert similarity(same) == pytest.approx(1.0, abs=1e-9)


def test_sim_is_the_equation_as_printed(laid, mask):
    r = laid(mask("regular-ren"), mask(WORK))
    p, x = pose_probe(r), r.reference.xyz
    d_ms = np.mean(((p[:, None] - x[None]) ** 2).sum(axis=2)[np.arange(len(p)), r.forward_index])
    frobenius = np.sqrt(np.trace(x.T @ x))
    assert sim_paper(r) == pytest.approx((1 - d_ms / frobenius) * 100, rel=1e-12)


@pytest.mark.parametrize("other", ["regular-shu", "regular-ri", "seal-ren", "cursive-yue", "clerical-tian"])
def test_the_papers_sim_is_above_99_for_another_character(laid, mask, other):
    """Why it cannot be the mark."""
    r = laid(mask(other), mask(WORK))
    assert sim_paper(r) > 99.0
    assert similarity(r) < 0.88


def test_the_papers_sim_rises_with_the_number_of_points(laid, mask):
    few, many = (laid(mask("regular-shu"), mask(WORK), count=n) for n in (300, 3000))
    assert sim_paper(many) > sim_paper(few) + 0.1
    assert similarity(many) == pytest.approx(similarity(few), abs=0.03)


def test_a_half_of_the_writing_fools_the_papers_sim_and_not_the_other(laid, mask):
    """The same points, half of them struck out, in the same place: nothing that is left lies far off."""
    whole = laid(mask(WORK), mask(WORK), of_copy=880)
    left = whole.probe.xyz[:, 0] < 0
    half = replace(
        whole,
        probe=replace(whole.probe, xyz=whole.probe.xyz[left], direction=whole.probe.direction[left]),
        forward=whole.forward[left],
        forward_index=whole.forward_index[left],
        d_ms=mean_squared(whole, left),
    )
    p, x = pose_probe(half), half.reference.xyz
    back = cKDTree(p).query(x)
    half = replace(half, backward=back[0], backward_index=back[1])
    assert sim_paper(half) == pytest.approx(sim_paper(whole), abs=0.01)
    assert similarity(half) < similarity(whole) - 0.2


def mean_squared(r, chosen) -> float:
    p, x = pose_probe(r), r.reference.xyz
    return float(np.mean(np.sum((p - x[r.forward_index])[chosen] ** 2, axis=1)))


@pytest.mark.parametrize("stroke", [0, 1, 2])
def test_a_missing_stroke_costs_similarity(laid, mask, stroke):
    lacking = laid(Glyph(mask(WORK)).without(stroke), mask(WORK))
    assert similarity(lacking) < similarity(laid(mask(WORK), mask(WORK), of_copy=880)) - 0.08


def test_similarity_is_the_same_in_both_roles(laid, mask):
    there, back = laid(mask("running-shui"), mask(WORK)), laid(mask(WORK), mask("running-shui"))
    assert similarity(there) == pytest.approx(similarity(back), abs=0.02)
