"""Each number measures what its name says, with the right sign and size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from rumu.assessment import features
from rumu.assessment.features import RESIDUALS, SOFTENING, residuals, sim_paper, similarity
from rumu.registration.icp import pose_probe
from rumu_lab.simulation.glyph import Glyph

WORK = "regular-shui"


def test_a_copy_of_itself_has_nothing_left(measured, mask):
    features = measured(mask(WORK), mask(WORK)).features
    np.testing.assert_allclose([getattr(features.residuals, n) for n in RESIDUALS], 0.0, atol=1e-6)
    np.testing.assert_allclose(features.residuals.logarithms(), np.log(SOFTENING), atol=1e-4)
    assert (features.lean, features.offset, features.size, features.weight) == pytest.approx(
        (0, 0, 0, 0), abs=1e-6
    )


@pytest.mark.parametrize("lean", [-12.0, 7.0])
def test_lean_is_degrees_clockwise(measured, moved, mask, lean):
    assert measured(moved(WORK, lean=lean), mask(WORK)).features.lean == pytest.approx(lean, abs=0.4)


def test_a_character_whose_halves_stand_elsewhere_does_not_lean(measured, mask):
    """The best pose turns by 9 degrees to meet both halves; no stroke is turned."""
    whole = mask(WORK)
    left, right = np.hsplit(whole, 2)
    apart = measured(np.hstack([np.roll(left, 45, axis=0), np.roll(right, -45, axis=0)]), whole)
    assert apart.registration.angle < -7.0
    assert abs(apart.features.lean) < 2.0


@pytest.mark.parametrize("shift", [(30, 40), (-50, 0)])
def test_offset_is_a_share_of_the_cell(measured, moved, mask, shift):
    found = measured(moved(WORK, shift=shift), mask(WORK)).features.offset
    assert found == pytest.approx(np.hypot(*shift) / 512, abs=0.002)


@pytest.mark.parametrize("scale", [0.5, 0.8, 1.15])
def test_size_is_a_logarithm(measured, moved, mask, scale):
    assert measured(moved(WORK, scale=scale), mask(WORK)).features.size == pytest.approx(
        np.log(scale), abs=0.01
    )


def test_weight_is_up_for_heavier_strokes(measured, fault, mask):
    heavy = measured(fault(WORK, "thick", 3).mask, mask(WORK)).features.weight
    thin = measured(fault(WORK, "thin", 3).mask, mask(WORK)).features.weight
    assert heavy > 0.1
    assert thin < -0.1


def test_a_missing_stroke_is_missing_and_an_added_one_extra(laid, mask):
    """On ink of one size and place: the residual grows on the side where the stroke is."""
    whole = mask(WORK)
    lacking = Glyph(whole).without(len(Glyph(whole).strokes) - 1)
    same = residuals(laid(whole, whole, of_copy=880))
    missing, extra = residuals(laid(lacking, whole)), residuals(laid(whole, lacking))
    assert missing.missing > 1.2 * same.missing
    assert missing.missing > missing.extra
    assert extra.extra > extra.missing
    assert missing.missing == pytest.approx(extra.extra, rel=0.05)  # the same pair seen from either side


def test_ink_that_has_no_like_near_counts_no_farther_than_a_limit(laid, mask):
    """A point whose nearest of the same direction lies on another stroke must not decide the residual."""
    r = laid(mask("running-shui"), mask(WORK))
    found = residuals(r)
    assert max(np.hypot(*(pose_probe(r) - r.reference.xyz[r.forward_index])[:, :2].T)) > features.FARTHEST
    assert found.bent <= features.FARTHEST and found.bent < found.position
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(features, "FARTHEST", 1e9)
        assert residuals(r).bent > found.bent


def test_residuals_of_known_points(laid, mask):
    """By hand, both ways."""
    r = laid(mask("running-shui"), mask(WORK))
    found = residuals(r)
    p = r.probe.xyz @ r.T_reference_probe[:3, :3].T + r.T_reference_probe[:3, 3]
    x = r.reference.xyz
    left = [p[i] - x[j] for i, j in enumerate(r.forward_index)] + [
        p[j] - x[i] for i, j in enumerate(r.backward_index)
    ]
    assert found.position == pytest.approx(np.sqrt(np.mean([d[0] ** 2 + d[1] ** 2 for d in left])))
    assert found.height == pytest.approx(np.sqrt(np.mean([d[2] ** 2 for d in left])))
    assert found.extra == pytest.approx(np.quantile(r.forward, 0.75))
    assert found.missing == pytest.approx(np.quantile(r.backward, 0.75))
    assert 0 <= found.direction <= 2


def test_direction_does_not_change_when_both_turn(laid, mask, moved):
    upright = residuals(laid(mask("running-shui"), mask(WORK)))
    leaning = residuals(laid(moved("running-shui", lean=14.0), mask(WORK)))
    assert leaning.direction == pytest.approx(upright.direction, rel=0.1)
    assert leaning.position == pytest.approx(upright.position, rel=0.1)


def test_what_an_even_bend_explains_is_no_fault_of_form(laid, mask):
    """By hand: displacements of a known map are explained, and what is added to them is left."""
    at = np.random.default_rng(0).normal(size=(400, 2))
    stretch = at @ np.array([[0.1, 0.02], [0.0, -0.1]]) + 0.05
    bend = stretch + 0.04 * at**3
    wave = 0.05 * np.stack([np.sin(25 * at[:, 0]), np.cos(25 * at[:, 1])], axis=1)
    assert features._unexplained(at, stretch) == pytest.approx((0.0, 0.0), abs=1e-6)
    bent, warped = features._unexplained(at, bend)
    assert bent > 0.02 and warped == pytest.approx(0.0, abs=1e-6)
    assert features._unexplained(at, bend + wave)[1] == pytest.approx(0.05, rel=0.1)


def test_proportions_and_directions_see_what_is_squeezed(measured, mask):
    import cv2

    whole = mask(WORK)
    narrow = cv2.resize(whole.astype(np.uint8), (410, 512), interpolation=cv2.INTER_NEAREST) > 0
    found = measured(np.pad(narrow, ((0, 0), (51, 51))), whole).features.residuals
    same = measured(whole, whole).features.residuals
    assert found.proportions > 0.1 and found.directions > 0.1
    assert same.proportions == pytest.approx(0.0, abs=1e-9) == same.directions


# the two similarities: the paper's with its traps, and the two-sided one without them


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
