"""The search against brute force on small graphs."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rumu.errors import RumuError
from rumu_lab.baselines.semi_admissible import SearchSettings, search


def graph(seed: int, n: int, K: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    nodes, arcs = rng.random((n, K)), rng.random((n, K, n, K)) / max(n - 1, 1)
    nodes[rng.random((n, K)) < 0.2] = np.inf
    nodes[:, -1] = 1.0
    arcs[rng.random(arcs.shape) < 0.1] = np.inf
    arcs[:, -1], arcs[..., -1] = 0.0, 0.0
    return nodes, arcs


def cost(nodes: np.ndarray, arcs: np.ndarray, chosen: tuple[int, ...]) -> float:
    own = sum(nodes[i, k] for i, k in enumerate(chosen))
    return own + sum(arcs[i, chosen[i], j, chosen[j]] for j in range(len(chosen)) for i in range(j))


def optimum(nodes: np.ndarray, arcs: np.ndarray) -> float:
    n, K = nodes.shape
    return min(cost(nodes, arcs, chosen) for chosen in product(range(K), repeat=n))


@given(st.integers(0, 10_000), st.integers(1, 5), st.integers(1, 4))
@settings(max_examples=60, deadline=None)
def test_without_slack_it_finds_the_optimum(seed, n, K):
    nodes, arcs = graph(seed, n, K)
    found = search(nodes, arcs, settings=SearchSettings(slack=0.0))
    assert found.bounded
    assert found.cost == pytest.approx(cost(nodes, arcs, found.chosen))
    assert found.cost == pytest.approx(optimum(nodes, arcs))


@given(st.integers(0, 10_000), st.floats(0.05, 0.5))
@settings(max_examples=40, deadline=None)
def test_with_slack_it_is_within_that_of_the_optimum(seed, slack):
    nodes, arcs = graph(seed, 5, 4)
    found = search(nodes, arcs, settings=SearchSettings(slack=slack))
    assert found.cost == pytest.approx(cost(nodes, arcs, found.chosen))
    assert found.cost <= (1 + slack) * optimum(nodes, arcs) + 1e-9


def test_slack_saves_expansions():
    cases = [graph(seed, 8, 5) for seed in range(8)]
    counts = [
        sum(search(*case, settings=SearchSettings(slack=slack)).expansions for case in cases)
        for slack in (0.0, 0.2, 0.5)
    ]
    assert all(more > fewer for more, fewer in pairwise(counts))


@pytest.mark.parametrize("expansions", [0, 1, 5, 50])
def test_past_its_expansions_a_beam_answers_and_says_so(expansions):
    nodes, arcs = graph(3, 9, 5)
    found = search(nodes, arcs, settings=SearchSettings(slack=0.0, expansions=expansions))
    best = search(nodes, arcs, settings=SearchSettings(slack=0.0))
    assert not found.bounded and best.bounded
    assert found.expansions == expansions
    assert found.cost == pytest.approx(cost(nodes, arcs, found.chosen))
    assert best.cost - 1e-9 <= found.cost <= 1.3 * best.cost


def test_a_wide_beam_is_exhaustive():
    nodes, arcs = graph(5, 4, 4)
    found = search(nodes, arcs, settings=SearchSettings(expansions=0, beam=4**4))
    assert found.cost == pytest.approx(optimum(nodes, arcs))


def test_two_that_exclude_each_other_are_not_both_chosen():
    nodes = np.array([[0.1, 1.0], [0.1, 1.0]])
    arcs = np.zeros((2, 2, 2, 2))
    arcs[0, 0, 1, 0] = np.inf
    assert search(nodes, arcs).cost == pytest.approx(1.1)


@pytest.mark.parametrize(
    ("nodes", "arcs", "said"),
    [
        (np.zeros((2, 3)), np.zeros((2, 3, 3, 2)), "shape"),
        (np.zeros((0, 3)), np.zeros((0, 3, 0, 3)), "shape"),
        (np.full((1, 2), -1.0), np.zeros((1, 2, 1, 2)), "0 or more"),
        (np.full((1, 2), np.nan), np.zeros((1, 2, 1, 2)), "0 or more"),
        (np.full((1, 2), np.inf), np.zeros((1, 2, 1, 2)), "finite"),
        (np.zeros((2, 1)), np.full((2, 1, 2, 1), np.inf), "consistent"),
    ],
)
def test_costs_that_are_no_costs_are_refused(nodes, arcs, said):
    with pytest.raises(RumuError, match=said):
        search(nodes, arcs)
