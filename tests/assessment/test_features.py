"""Each number measures what its name says, with the right sign and size."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from rumu.assessment.features import (
    COMPONENTS,
    EDGE_AMOUNTS,
    EDGE_NUMBERS,
    KINDS,
    RESIDUALS,
    SAMPLES,
    SOFTENING,
    describe_edge,
    edge_amount,
    edge_patches,
    edge_sense,
    residuals,
    sim_paper,
    similarity,
)
from rumu.registration.icp import pose_probe
from rumu.registration.points import canvas_of
from rumu_lab.simulation.glyph import Glyph

WORK = "regular-shui"
EDGE_WORK = "regular-shu"


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


@pytest.fixture(scope="module")
def canvas(surface):
    return lambda mask: canvas_of(surface(mask).mask).ink


def distance(a, b) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_a_description_has_its_length_and_is_finite(canvas, mask):
    found = describe_edge(canvas(mask(EDGE_WORK)))
    assert found.shape == (EDGE_NUMBERS,) == (5 * (2 * COMPONENTS + 1),)  # four sides upright, one turned
    assert np.isfinite(found).all()


def test_place_and_size_do_not_matter_and_lean_is_taken_out(canvas, mask, moved):
    own = describe_edge(canvas(mask(EDGE_WORK)))
    other = describe_edge(canvas(mask("regular-shui")))
    assert distance(describe_edge(canvas(moved(EDGE_WORK, shift=(20, -30)))), own) < 0.1 * distance(
        other, own
    )
    assert distance(describe_edge(canvas(moved(EDGE_WORK, scale=0.8))), own) < 0.25 * distance(other, own)
    leaning = canvas(moved(EDGE_WORK, lean=10.0))
    straightened = distance(describe_edge(leaning, lean=10.0), own)
    assert straightened < 0.5 * distance(describe_edge(leaning), own)
    assert straightened < 0.25 * distance(other, own)


def test_no_side_of_the_page_is_up(canvas, mask, fault):
    master, copy = canvas(mask(EDGE_WORK)), canvas(fault(EDGE_WORK, "wobble", 4).mask)
    upright, sideways = (
        describe_edge(np.rot90(copy, k).copy()) - describe_edge(np.rot90(master, k).copy()) for k in (0, 1)
    )
    assert edge_amount(upright).shape == (EDGE_AMOUNTS,)
    assert distance(edge_amount(sideways), edge_amount(upright)) < 1e-3 * np.abs(edge_amount(upright)).mean()
    assert distance(edge_sense(sideways), edge_sense(upright)) < 1e-3 * np.abs(edge_sense(upright)).mean()


@pytest.mark.parametrize("name", ["wobble", "blunt", "thick", "thin"])
def test_the_worse_the_hand_the_farther_from_the_master(canvas, mask, fault, name):
    own = describe_edge(canvas(mask(EDGE_WORK)))
    found = [distance(describe_edge(canvas(fault(EDGE_WORK, name, s).mask)), own) for s in (1, 3, 5)]
    assert 0 < found[0] < found[1] < found[2]


def test_specks_and_tiny_ink_are_described_too(canvas):
    ink = np.zeros((80, 80), bool)
    ink[30:36, 20:60] = True
    ink[50, 50] = True
    assert np.isfinite(describe_edge(canvas(ink))).all()


def test_patches_turned_with_the_edge_have_ink_on_one_side(canvas, mask):
    turned = edge_patches(canvas(mask(EDGE_WORK)))[1].reshape(-1, SAMPLES, SAMPLES).mean(axis=0)
    upper, lower = turned[: SAMPLES // 2].mean(), turned[SAMPLES // 2 + 1 :].mean()
    assert max(upper, lower) > 1.5 * min(upper, lower)


def test_the_shipped_basis_is_a_refit_of_the_masters(data):
    """Fails when patches were changed and `scripts/fit_edges.py` was not run."""
    path = Path(__file__).parents[2] / "scripts" / "fit_edges.py"
    spec = importlib.util.spec_from_file_location("fit_edges", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["fit_edges"] = module
    spec.loader.exec_module(module)
    fitted = module.bases(data)
    shipped = np.load(path.parents[1] / "src/rumu/assessment/edges.npz")
    for kind in KINDS:
        components = shipped[f"{kind.frame}_components"]
        np.testing.assert_allclose(components.T @ components, np.eye(COMPONENTS), atol=1e-5)
        overlap = np.linalg.svd(components[:, :8].T @ fitted[f"{kind.frame}_components"][:, :8])[1]
        assert overlap.min() > 0.99
        np.testing.assert_allclose(shipped[f"{kind.frame}_mean"], fitted[f"{kind.frame}_mean"], atol=1e-3)
        np.testing.assert_allclose(shipped[f"{kind.frame}_spread"], fitted[f"{kind.frame}_spread"], rtol=1e-2)
