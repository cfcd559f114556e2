"""The nearest points: brute force agrees, however often and however far the points that ask have moved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from rumu.registration.nearest import Nearest


@pytest.mark.parametrize("follows", [False, True])
@pytest.mark.parametrize("count", [1, 2, 40, 512, 513, 1500])  # a product up to 512, then a tree
@pytest.mark.parametrize("step", [0.3, 0.01, 0.0])  # far, near, and not at all
def test_every_answer_is_that_of_brute_force(follows, count, step):
    rng = np.random.default_rng(count)
    cloud, asking = rng.normal(size=(count, 5)), rng.normal(size=(700, 5))
    nearest = Nearest(cloud, follows=follows)
    for _ in range(6):
        squared, index = nearest(asking)
        apart = cdist(asking, cloud)
        np.testing.assert_allclose(np.sqrt(squared), apart.min(axis=1), atol=2e-6)
        np.testing.assert_allclose(apart[np.arange(700), index], np.sqrt(squared), atol=1e-12)
        asking = asking + step * rng.normal(size=asking.shape)


def test_what_was_answered_before_stays():
    """An answer is a value: the next search does not write into it."""
    rng = np.random.default_rng(0)
    cloud, asking = rng.normal(size=(900, 5)), rng.normal(size=(50, 5))
    nearest = Nearest(cloud, follows=True)
    _, first = nearest(asking)
    before = first.copy()
    nearest(asking + 1.0)
    np.testing.assert_array_equal(first, before)


def test_other_points_may_ask():
    rng = np.random.default_rng(1)
    cloud = rng.normal(size=(900, 5))
    nearest = Nearest(cloud, follows=True)
    for n in (50, 80, 50):
        asking = rng.normal(size=(n, 5))
        np.testing.assert_array_equal(nearest(asking)[1], cdist(asking, cloud).argmin(axis=1))
