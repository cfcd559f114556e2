"""The nearest points of one cloud to another that is moved again and again, as closest points ask for them.

The answers are exact but for rounding: of two points that are equally far to float32 either may be given.
Measured on ink in five dimensions: up to a few hundred points one matrix product is the quickest; beyond,
OpenCV's single KD-tree takes half of what SciPy's does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rumu.values import FloatArray, IntArray

Search = Callable[[FloatArray], tuple[IntArray, FloatArray]]
"""(N, d) -> (N,) index of the nearest; (N,) how far the second is at least, where two were sought."""

_FEW = 512
"""Points of a cloud up to which all distances are worked out at once."""
_ROUNDING = 1e-5
"""What float32 may take from or add to a distance, in rms radii."""


class Nearest:
    """A cloud to be searched.

    points: (M, d). follows: the same points will ask again and again, each time moved a little. Then the
    nearest of a point is kept while nothing else can have come nearer: all others were at least as far as
    the second, so as long as the nearest is nearer than that less what the point has moved since, it stays
    the nearest, and only the rest is searched again (Greenspan and Godin 2001).
    """

    def __init__(self, points: FloatArray, *, follows: bool) -> None:
        self._points = points = np.ascontiguousarray(points)
        few = len(points) <= _FEW
        self._search: Search = _by_product(points) if few else _by_tree(points, count=2 if follows else 1)
        self._follows = follows and not few
        self._asked: FloatArray | None = None

    def __call__(self, queries: FloatArray) -> tuple[FloatArray, IntArray]:
        """(N, d) points -> (N,) squared distances to the nearest, (N,) which one it is."""
        if self._follows and self._asked is not None and len(self._asked) == len(queries):
            return self._followed(queries, self._asked)
        index, second = self._search(queries)
        if self._follows:
            self._asked, self._index, self._second = queries.copy(), index.copy(), second
        return self._squared_to(index, queries), index

    def _followed(self, queries: FloatArray, asked: FloatArray) -> tuple[FloatArray, IntArray]:
        moved = np.sqrt(_squared(queries - asked))
        squared = self._squared_to(self._index, queries)
        doubtful = np.flatnonzero(np.sqrt(squared) + moved > self._second)
        if len(doubtful):
            asked[doubtful] = again = queries.take(doubtful, axis=0)
            index, self._second[doubtful] = self._search(again)
            self._index[doubtful], squared[doubtful] = index, self._squared_to(index, again)
        return squared, self._index.copy()

    def _squared_to(self, index: IntArray, queries: FloatArray) -> FloatArray:
        return _squared(queries - self._points.take(index, axis=0))


def _by_product(points: FloatArray) -> Search:
    """|q - x|^2 / 2 less |q|^2 / 2 is |x|^2 / 2 - q . x: one product with a column of ones."""
    table = np.vstack([-points.T, 0.5 * _squared(points)]).astype(np.float32)
    d = points.shape[1]

    def search(queries: FloatArray) -> tuple[IntArray, FloatArray]:
        with_one = np.ones((len(queries), d + 1), np.float32)
        with_one[:, :d] = queries
        return (with_one @ table).argmin(axis=1), np.zeros(len(queries))

    return search


def _by_tree(points: FloatArray, *, count: int) -> Search:
    """count: how many of the nearest are sought, 1 or 2."""
    import cv2

    tree = cv2.flann.Index(  # type: ignore[attr-defined]
        np.ascontiguousarray(points, dtype=np.float32), {"algorithm": 4, "leaf_max_size": 15}
    )

    def search(queries: FloatArray) -> tuple[IntArray, FloatArray]:
        index, squared = tree.knnSearch(queries.astype(np.float32), count, params={"checks": -1})
        return index[:, 0].astype(np.intp), np.sqrt(squared[:, -1]).astype(float) - _ROUNDING

    return search


def _squared(apart: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ij,ij->i", apart, apart))
