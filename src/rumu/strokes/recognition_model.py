"""What every known character looks like, on the axes along which characters differ and hands do not.

Descriptions are whitened by how one character differs from hand to hand (linear discriminant analysis:
Fisher 1936; Fukunaga 1990, "Introduction to statistical pattern recognition", ch. 10), then compared by their
cosine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from rumu.registration.descriptor import less_the_mean
from rumu.values import FloatArray

_EVEN = 1.0  # of the scatter between hands, the share that is taken to be equal along all axes


class Reform(IntEnum):
    """Whether a character was simplified in the 1950s and 1960s."""

    NONE = 0
    TRADITIONAL = 1
    SIMPLIFIED = 2


@dataclass(frozen=True, slots=True, eq=False)
class RecognitionModel:
    """Descriptions of all known characters on the axes along which they differ most.

    basis: (L, k). vectors: (n, k) float32 of unit length. code_points: (n,). usage: (n,), logarithm of how
    often a character stands in common words. reform: (n,), see `Reform`.
    """

    basis: FloatArray
    vectors: FloatArray
    code_points: npt.NDArray[np.uint32]
    usage: FloatArray
    reform: npt.NDArray[np.uint8]

    def project(self, vectors: FloatArray) -> FloatArray:
        """(..., k) of unit length: descriptions, (..., L), on the model's axes."""
        projected = less_the_mean(vectors) @ self.basis
        length = np.linalg.norm(projected, axis=-1, keepdims=True)
        return np.asarray(projected / np.maximum(length, 1e-9), np.float32)


def fit_model(
    vectors: FloatArray,
    by_hand: FloatArray,
    which: Sequence[int],
    *,
    code_points: npt.NDArray[np.uint32],
    axes: int,
) -> dict[str, np.ndarray]:
    """Basis, vectors and code points of a `RecognitionModel` as `recognition.npz` holds them.

    vectors: (n, L), descriptions of characters as copybooks print them. by_hand, which: (m, L), (m,),
    descriptions of characters by many hands, and which of the n each is.
    """
    apart = by_hand - vectors[np.asarray(which)]
    apart = apart - apart.mean(axis=0)
    scatter = apart.T @ apart / len(apart)
    scatter += _EVEN * np.trace(scatter) / len(scatter) * np.eye(len(scatter))
    whitening = np.linalg.cholesky(np.linalg.inv(scatter))
    white = less_the_mean(vectors) @ whitening
    white /= np.linalg.norm(white, axis=1, keepdims=True)
    values, axes_of = np.linalg.eigh(white.T @ white)
    basis = whitening @ axes_of[:, np.argsort(values)[::-1][:axes]]
    basis *= np.sign(basis.sum(axis=0)) / np.abs(basis).max()
    projected = less_the_mean(vectors) @ basis
    projected /= np.linalg.norm(projected, axis=1, keepdims=True)
    return {
        "basis": basis.astype(np.float16),
        "vectors": np.round(projected * (127 / np.abs(projected).max())).astype(np.int8),
        "code_points": code_points,
    }


@lru_cache(maxsize=1)
def recognition_model() -> RecognitionModel:
    """The model that is part of the package."""
    with (files("rumu.strokes") / "recognition.npz").open("rb") as stream, np.load(stream) as stored:
        vectors = stored["vectors"].astype(np.float32)
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        return RecognitionModel(
            stored["basis"].astype(np.float32),
            vectors,
            stored["code_points"],
            stored["usage"].astype(np.float32),
            stored["reform"],
        )
