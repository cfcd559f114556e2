"""Which way up a page lies, told by its characters: each votes on how far it is turned.

A vote is linear in the description of the ink (directions of edges in a coarse grid). The weights were fitted
on all characters whose strokes are known, as copybooks print them: `scripts/fit_upright.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import numpy as np

from rumu.pages.glyph_likeness import Floats, describe_ink, turned_description
from rumu.values import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class UprightSettings:
    """When a page is turned.

    most: characters that are asked. least: fewest that must answer. clear: by how many standard errors their
    mean vote for another way up must exceed that for the way the page lies; spread: least standard deviation
    of a vote that is reckoned with.
    """

    most: int = 150
    least: int = 6
    clear: float = 4.0
    spread: float = 1.0


def quarter_turns(
    looks: Sequence[tuple[IntArray, IntArray]], *, settings: UprightSettings | None = None
) -> int:
    """By how many quarter turns counter-clockwise (as `numpy.rot90` turns) a page must be turned, 0-3.

    looks: rows and columns of the ink of each of its characters, (k,) each. 0 where too few are sure.
    """
    settings = settings or UprightSettings()
    step = max(1, -(-len(looks) // settings.most))
    asked = [look for look in looks[::step] if len(look[0])]
    if len(asked) < settings.least:
        return 0
    votes = turn_votes(describe_ink(asked))
    best = int(votes.mean(axis=0).argmax())
    lead = votes[:, best] - votes[:, 0]
    error = max(float(lead.std(ddof=1)), settings.spread) / np.sqrt(len(lead))
    return best if lead.mean() > settings.clear * error else 0


def turn_votes(described: Floats) -> FloatArray:
    """(n, 4): how much each character speaks for being upright after 0, 1, 2, 3 quarter turns.

    described: (n, d), see `describe_ink`.
    """
    weights = _weights()
    return np.stack([turned_description(described, turns) @ weights for turns in range(4)], axis=1)


@lru_cache(maxsize=1)
def _weights() -> Floats:
    """(d,): of each element of a description."""
    with (files("rumu.pages") / "upright.npz").open("rb") as stream, np.load(stream) as stored:
        return np.asarray(stored["weights"], np.float32)
