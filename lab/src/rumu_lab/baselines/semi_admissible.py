"""Search for the cheapest consistent choice of one candidate for each node of a relational graph.

The publication's keyword is "semi-admissible search" over node and arc costs; which one it is was not to be
read. Our reconstruction is the A* with a FOCAL list of Pearl and Kim: the state expanded next is the deepest
among those whose bound is within (1 + slack) of the least, so the answer costs at most (1 + slack) times
the optimum. Past a number of expansions a beam carries on from what is open, and the result says so.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import count

import numpy as np

from rumu.errors import RumuError
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """How far and how widely the search looks.

    slack: epsilon of A*; 0 is the admissible search. expansions: most states expanded before the beam.
    beam: its width.
    """

    slack: float = 0.2
    expansions: int = 20_000
    beam: int = 32


@dataclass(frozen=True, slots=True)
class Choice:
    """The answer of the search.

    chosen: the candidate of each node. cost: of all nodes and arcs together. expansions: states expanded.
    bounded: whether the cost is known to be within (1 + slack) of the optimum; a beam cannot tell.
    """

    chosen: tuple[int, ...]
    cost: float
    expansions: int
    bounded: bool


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """The first nodes decided. spent: their cost; bound: spent plus the least the rest can cost.

    above: (rest + 1, K), what the parent's undecided nodes cost, arcs to what it had decided included; the
    state's own table is made of it only when it is expanded, as most never are.
    """

    chosen: tuple[int, ...]
    spent: float
    bound: float
    above: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """nodes, arcs: as given. ahead: (n, K), the least that a candidate's arcs to later nodes can cost."""

    nodes: FloatArray
    arcs: FloatArray
    ahead: FloatArray

    @classmethod
    def of(cls, nodes: FloatArray, arcs: FloatArray) -> _Problem:
        n = len(nodes)
        present = np.where(np.isfinite(nodes)[None, None], arcs, np.inf)
        least = present.min(axis=3)
        later = np.arange(n)[None] > np.arange(n)[:, None]
        ahead = np.where(later[:, None], least, 0.0).sum(axis=2)
        return cls(nodes, arcs, ahead)

    def children(self, state: _State) -> list[_State]:
        d = len(state.chosen)
        table = state.above
        if d > 0:
            table = table[1:] + self.arcs[d - 1, state.chosen[-1], d:]
        spent = state.spent + table[0]
        bounds = spent + (table[None, 1:] + self.arcs[d, :, d + 1 :] + self.ahead[d + 1 :]).min(axis=2).sum(
            axis=1
        )
        return [
            _State((*state.chosen, k), float(spent[k]), float(bounds[k]), table)
            for k in np.flatnonzero(np.isfinite(bounds)).tolist()
        ]


def search(nodes: FloatArray, arcs: FloatArray, *, settings: SearchSettings | None = None) -> Choice:
    """The choice of least cost: the sum of `nodes[i, k_i]` and of `arcs[i, k_i, j, k_j]` over i < j.

    nodes: (n, K) float64 >= 0, inf where node i has no k-th candidate; each node has a finite one.
    arcs: (n, K, n, K) float64 >= 0, inf for two that exclude each other; read for i < j only. Nodes are
        decided in the order given. The bound is admissible: for each undecided node the least that it, its
        arcs to the decided, and each of its arcs to later ones taken by itself can cost.
    Raises RumuError when the shapes do not belong together, a cost is negative or NaN, or all choices
    are inconsistent.
    """
    settings = settings or SearchSettings()
    _check(nodes, arcs)
    problem = _Problem.of(nodes, arcs)
    root = _State((), 0.0, float((nodes + problem.ahead).min(axis=1).sum()), nodes)
    found, frontier, expansions = _focal(root, problem, settings)
    bounded = found is not None
    if found is None:
        found = _beam(frontier, problem, settings.beam)
    if found is None:
        raise RumuError("expected candidates of which some choice is consistent, got none")
    return Choice(found.chosen, found.spent, expansions, bounded)


def _check(nodes: FloatArray, arcs: FloatArray) -> None:
    if nodes.ndim != 2 or nodes.size == 0 or arcs.shape != nodes.shape * 2:
        raise RumuError(
            f"expected costs of shape (n, K) and (n, K, n, K), got {nodes.shape} and {arcs.shape}"
        )
    if not (bool((nodes >= 0).all()) and bool((arcs >= 0).all())):
        raise RumuError("expected costs of 0 or more, got negative ones or NaN")
    if not np.isfinite(nodes).any(axis=1).all():
        raise RumuError("expected a finite candidate for each node, got a node without one")


def _focal(
    root: _State, problem: _Problem, settings: SearchSettings
) -> tuple[_State | None, list[_State], int]:
    """The goal, or None with the open states when the expansions are used up."""
    n, ticket, expanded = len(problem.nodes), count(), 0
    waiting = [(root.bound, next(ticket), root)]  # open states not yet in focal, by bound
    least = list(waiting)  # all open states by bound; those expanded are dropped when they surface
    focal: list[tuple[int, float, int, _State]] = []
    closed: set[int] = set()
    while least and expanded < settings.expansions:
        while least and least[0][1] in closed:
            closed.discard(heapq.heappop(least)[1])
        if not least:
            break
        limit = (1.0 + settings.slack) * least[0][0] + 1e-12
        while waiting and waiting[0][0] <= limit:
            bound, key, state = heapq.heappop(waiting)
            heapq.heappush(focal, (-len(state.chosen), bound, key, state))
        _, _, key, state = heapq.heappop(focal)
        if len(state.chosen) == n:
            return state, [], expanded
        closed.add(key)
        expanded += 1
        for child in problem.children(state):
            item = (child.bound, next(ticket), child)
            heapq.heappush(least, item)
            heapq.heappush(waiting, item)
    return None, [state for _, key, state in least if key not in closed], expanded


def _beam(frontier: list[_State], problem: _Problem, width: int) -> _State | None:
    """Level by level from the open states, keeping the `width` of least bound on each."""
    n = len(problem.nodes)
    level: list[_State] = []
    for depth in range(n):
        level = level + [state for state in frontier if len(state.chosen) == depth]
        level = sorted(level, key=lambda state: state.bound)[:width]
        level = [child for state in level for child in problem.children(state)]
    level += [state for state in frontier if len(state.chosen) == n]
    return min(level, key=lambda state: state.spent, default=None)
