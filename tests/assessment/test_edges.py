"""The description of the ink's edge: finite, still under what is no fault, moved by what is one."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from rumu.assessment.edges import COMPONENTS, EDGE_NUMBERS, PLAIN, SAMPLES, describe_edge, edge_patches
from rumu.registration.points import RADIUS, canvas_of

EDGE_WORK = "regular-shu"


@pytest.fixture(scope="module")
def canvas(surface):
    return lambda mask: canvas_of(surface(mask).mask).ink


def distance(a, b) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_a_description_has_its_length_and_is_finite(canvas, mask):
    found = describe_edge(canvas(mask(EDGE_WORK)))
    assert found.shape == (EDGE_NUMBERS,) == (2 * COMPONENTS + 1 + len(PLAIN),)
    assert np.isfinite(found).all()


def test_place_size_and_lean_do_not_matter(canvas, mask, moved):
    own = describe_edge(canvas(mask(EDGE_WORK)))
    other = describe_edge(canvas(mask("regular-shui")))
    for change in ({"shift": (20, -30)}, {"scale": 0.8}, {"lean": 10.0}):
        changed = describe_edge(canvas(moved(EDGE_WORK, **change)))
        assert distance(changed, own) < 0.3 * distance(other, own), change


def test_no_side_of_the_page_is_up(canvas, mask, fault):
    master, copy = canvas(mask(EDGE_WORK)), canvas(fault(EDGE_WORK, "wobble", 4).mask)
    upright, sideways = (
        describe_edge(np.rot90(copy, k).copy()) - describe_edge(np.rot90(master, k).copy()) for k in (0, 1)
    )
    assert distance(sideways, upright) < 0.01 * np.abs(upright).mean()


def test_the_plain_numbers_are_what_they_say(canvas):
    """A disc: ink for each pixel of its edge is half the radius, and its outline turns once."""
    y, x = np.mgrid[:200, :200]
    thinness, turning, width = describe_edge(canvas(np.hypot(x - 100, y - 100) < 60))[-len(PLAIN) :]
    radius = RADIUS * np.sqrt(2)
    assert np.exp(width) == pytest.approx(radius / 2, rel=0.03)
    assert np.exp(turning) - 0.01 == pytest.approx(1 / radius, rel=0.15)
    assert np.exp(thinness) - 0.01 < 0.05
    rough = np.random.default_rng(0).random((200, 200)) < 0.35
    torn = describe_edge(canvas((np.hypot(x - 100, y - 100) < 60) & ~rough))[-len(PLAIN) :]
    assert torn[0] > thinness + 1 and torn[1] > turning + 1 and torn[2] < width


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
    turned = edge_patches(canvas(mask(EDGE_WORK))).reshape(-1, SAMPLES, SAMPLES).mean(axis=0)
    upper, lower = turned[: SAMPLES // 2].mean(), turned[SAMPLES // 2 + 1 :].mean()
    assert max(upper, lower) > 1.5 * min(upper, lower)


def test_the_shipped_basis_is_a_refit_of_the_masters(data):
    """Fails when patches were changed and `scripts/fit_edges.py` was not run."""
    path = Path(__file__).parents[2] / "scripts" / "fit_edges.py"
    spec = importlib.util.spec_from_file_location("fit_edges", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["fit_edges"] = module
    spec.loader.exec_module(module)
    fitted = module.fitted(data)
    shipped = np.load(path.parents[1] / "src/rumu/assessment/edges.npz")
    components = shipped["components"]
    np.testing.assert_allclose(components.T @ components, np.eye(COMPONENTS), atol=1e-5)
    overlap = np.linalg.svd(components[:, :8].T @ fitted["components"][:, :8])[1]
    assert overlap.min() > 0.99
    np.testing.assert_allclose(shipped["mean"], fitted["mean"], atol=1e-3)
    np.testing.assert_allclose(shipped["spread"], fitted["spread"], rtol=1e-2)
