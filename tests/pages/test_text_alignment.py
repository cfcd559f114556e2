"""A text laid onto found characters, by how well each looks like each."""

from __future__ import annotations

import numpy as np

from rumu.pages.text_alignment import FoundCharacters, Step, align


def found_of(z: np.ndarray) -> FoundCharacters:
    """Characters of one column, each so much like each of the text."""
    n, u = z.shape
    return FoundCharacters(
        z=z,
        z_merged=z,
        mergeable=np.zeros(n, dtype=bool),
        beside=np.zeros(n, dtype=bool),
        small=np.zeros(n, dtype=bool),
        height=np.ones(n),
        first=np.arange(n) == 0,
        known=np.ones(u, dtype=bool),
    )


def test_a_few_under_seals_keep_their_places_although_one_looks_like_its_neighbour() -> None:
    """As 少長咸集 of the Lanting Xu, where 少 under a seal looks more like 咸."""
    z = np.full((8, 8), 0.0)
    z[range(8), range(8)] = (2.0, 1.6, 0.5, 0.6, 0.6, 0.2, 1.8, 2.0)
    z[2, 4], z[3, 5] = 1.2, 0.4
    steps = align(found_of(z), np.arange(8), np.arange(8) == 0)
    assert [(one.step, one.found, one.text) for one in steps] == [(Step.MATCH, k, k) for k in range(8)]


def test_what_the_text_leaves_out_is_still_left_out() -> None:
    z = np.full((8, 6), -0.5)
    z[[0, 1, 2, 5, 6, 7], range(6)] = 1.8
    steps = align(found_of(z), np.arange(6), np.arange(6) == 0)
    assert [one.found for one in steps if one.step == Step.SKIP_FOUND] == [3, 4]
