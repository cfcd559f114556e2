"""How the edge of the ink is described: the same for the same hand, whatever the place, and what it tells."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from rumu.assessment.edges import (
    AMOUNTS,
    COMPONENTS,
    KINDS,
    NUMBERS,
    SAMPLES,
    amount,
    describe,
    edge_patches,
    sense,
)
from rumu.registration.points import canvas_of

WORK = "regular-shu"


@pytest.fixture(scope="module")
def canvas(surface):
    return lambda mask: canvas_of(surface(mask).mask).ink


def distance(a, b) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_a_description_has_its_length_and_is_finite(canvas, mask):
    found = describe(canvas(mask(WORK)))
    assert found.shape == (NUMBERS,) == (5 * (2 * COMPONENTS + 1),)  # four sides upright, one turned
    assert np.isfinite(found).all()


def test_place_and_size_do_not_matter_and_lean_is_taken_out(canvas, mask, moved):
    own = describe(canvas(mask(WORK)))
    other = describe(canvas(mask("regular-shui")))
    assert distance(describe(canvas(moved(WORK, shift=(20, -30)))), own) < 0.1 * distance(other, own)
    assert distance(describe(canvas(moved(WORK, scale=0.8))), own) < 0.25 * distance(other, own)
    leaning = canvas(moved(WORK, lean=10.0))
    straightened = distance(describe(leaning, lean=10.0), own)
    assert straightened < 0.5 * distance(describe(leaning), own)
    assert straightened < 0.25 * distance(other, own)


def test_no_side_of_the_page_is_up(canvas, mask, fault):
    master, copy = canvas(mask(WORK)), canvas(fault(WORK, "wobble", 4).mask)
    upright, sideways = (
        describe(np.rot90(copy, k).copy()) - describe(np.rot90(master, k).copy()) for k in (0, 1)
    )
    assert amount(upright).shape == (AMOUNTS,)
    assert distance(amount(sideways), amount(upright)) < 1e-3 * np.abs(amount(upright)).mean()
    assert distance(sense(sideways), sense(upright)) < 1e-3 * np.abs(sense(upright)).mean()


@pytest.mark.parametrize("name", ["wobble", "blunt", "thick", "thin"])
def test_the_worse_the_hand_the_farther_from_the_master(canvas, mask, fault, name):
    own = describe(canvas(mask(WORK)))
    found = [distance(describe(canvas(fault(WORK, name, s).mask)), own) for s in (1, 3, 5)]
    assert 0 < found[0] < found[1] < found[2]


def test_specks_and_tiny_ink_are_described_too(canvas):
    ink = np.zeros((80, 80), bool)
    ink[30:36, 20:60] = True
    ink[50, 50] = True
    assert np.isfinite(describe(canvas(ink))).all()


def test_patches_turned_with_the_edge_have_ink_on_one_side(canvas, mask):
    turned = edge_patches(canvas(mask(WORK)))[1].reshape(-1, SAMPLES, SAMPLES).mean(axis=0)
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
