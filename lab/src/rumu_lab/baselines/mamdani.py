"""Fuzzy inference in Mamdani's way: min within a rule, max over the rules, centroid of what results.

An input belongs to each of its levels to a degree; a rule holds as far as the least of its conditions
does, and cuts the set of its conclusion off at that height; the answer is the centroid of the union of all
cut sets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rumu.errors import RegistrationError
from rumu.values import FloatArray

Corners = tuple[float, float, float, float]
"""A trapezoid: 0 up to the first, 1 between the second and the third, 0 from the fourth; a triangle where the
middle two are one; a shoulder where the first two or the last two are."""


def trapezoid(x: FloatArray | float, corners: Corners) -> FloatArray:
    """Membership in [0, 1] of each x."""
    a, b, c, d = corners
    x = np.asarray(x, dtype=float)
    rise = np.where(x >= b, 1.0, np.clip((x - a) / max(b - a, 1e-12), 0.0, 1.0))
    fall = np.where(x <= c, 1.0, np.clip((d - x) / max(d - c, 1e-12), 0.0, 1.0))
    return np.asarray(np.minimum(rise, fall))


@dataclass(frozen=True)
class FuzzySystem:
    """levels: the sets of every input, in order. outputs: the sets of the answer, over `universe` (from, to).

    rules: for each combination of levels, one number an input, the number of the output it concludes.
    """

    levels: tuple[Corners, ...]
    outputs: tuple[Corners, ...]
    rules: Mapping[tuple[int, ...], int]
    universe: tuple[float, float] = (0.0, 100.0)

    @cached_property
    def _sampled(self) -> tuple[FloatArray, FloatArray]:
        """(801,) values of the answer, and (outputs, 801) how far each belongs to each output."""
        axis = np.linspace(*self.universe, 801)
        return axis, np.array([trapezoid(axis, corners) for corners in self.outputs])

    def strengths(self, values: Sequence[float]) -> FloatArray:
        """(outputs,) in [0, 1]: how far each output is concluded from one value an input."""
        memberships = np.array([[float(trapezoid(v, level)) for level in self.levels] for v in values])
        holds = memberships[np.arange(len(values)), np.array(list(self.rules))].min(axis=1)
        conclusions = np.array(list(self.rules.values()))
        return np.array([holds[conclusions == k].max(initial=0.0) for k in range(len(self.outputs))])

    def infer(self, values: Sequence[float]) -> float:
        """The answer, within `universe`. Raises RegistrationError where no rule holds at all."""
        axis, sets = self._sampled
        cut = np.minimum(sets, self.strengths(values)[:, None]).max(axis=0)
        total = float(cut.sum())
        if not total > 0.0:
            raise RegistrationError(f"expected values that some rule speaks of, got {tuple(values)}")
        return float(cut @ axis) / total
