"""Make the weights by which a page is turned upright: `python scripts/fit_upright.py`.

Describes every character whose strokes are known as copybooks print it, turns each description by 0 to 3
quarters, and fits the linear vote by which the upright one wins (multinomial logistic regression with a
ridge). Writes src/rumu/pages/upright.npz; prints how many characters that were left out of the fit are told
rightly. No page and no master is read.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from rumu.characters.stroke_data import known_characters
from rumu.pages.glyph_likeness import Floats, describe_printed, turned_description
from rumu.values import FloatArray

ROOT = Path(__file__).parents[1]
RIDGE, ROUNDS, LEFT_OUT = 3e-4, 60, 5  # every fifth character is left out of the fit that is judged


def four_ways(described: Floats) -> FloatArray:
    """(n, 4, d): the descriptions after 0 to 3 quarter turns."""
    return np.stack([turned_description(described, turns) for turns in range(4)], axis=1).astype(float)


def fit(described: Floats) -> FloatArray:
    """(d,): the weights under which the upright description gets the largest of its four votes."""
    ways = four_ways(described)

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        votes = ways @ weights
        shares = np.exp(votes - votes.max(axis=1, keepdims=True))
        shares /= shares.sum(axis=1, keepdims=True)
        value = -float(np.log(np.maximum(shares[:, 0], 1e-12)).mean()) + RIDGE * float(weights @ weights) / 2
        shares[:, 0] -= 1
        return value, np.einsum("nr,nrd->d", shares, ways) / len(ways) + RIDGE * weights

    start = np.zeros(described.shape[1])
    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": ROUNDS}).x)


if __name__ == "__main__":
    described, _ = describe_printed(known_characters())
    held = np.arange(len(described)) % LEFT_OUT == 0
    votes = four_ways(described[held]) @ fit(described[~held])
    print(f"{(votes.argmax(axis=1) == 0).mean():.1%} of {held.sum()} characters left out are told rightly")
    np.savez_compressed(ROOT / "src/rumu/pages/upright.npz", weights=fit(described).astype(np.float16))
