"""Height from normals across steps: bilateral integration, which lets a pixel follow one of its sides.

Least squares bend a step into a ramp, since a pixel beside it must agree with both neighbours. Here every
pixel weighs its two neighbours in each direction against each other: where the height already found
contradicts its slope on one side more than on the other, that side counts less. After Cao, Santo, Shi, Okura
and Matsushita, "Bilateral normal integration" (2022), from its equations; weights and heights are found in
turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.surface.neighbours import centre_parts, conjugate_gradients, divergence
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class BilateralSettings:
    """How steps are looked for.

    sharpness: how fast a side stops counting, for a squared error larger by the usual one. The paper's k is
        for a squared error of one pixel, whatever the errors are; a step spread over a sheet would stay so.
    negligible: error of a difference, in pixels, that is none.
    rounds: most; settled: largest change of a height, in pixels, below which they end. tolerance, iterations:
    of the conjugate gradients within one round. least: weight that every pair of neighbours keeps.
    """

    sharpness: float = 2.0
    negligible: float = 1e-3
    rounds: int = 40
    settled: float = 0.01
    tolerance: float = 1e-3
    iterations: int = 60
    least: float = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """Pairs of neighbours along rows or columns, turned so that they lie along the last axis.

    wanted: (h, w - 1) difference of each pair, the mean of both slopes. facing: (h, w) squared cosine of each
    pixel's slope. joined: (h, w - 1) trust in each pair, 0 where one of them is outside.
    """

    wanted: FloatArray
    facing: FloatArray
    joined: FloatArray

    def forward_share(self, height: FloatArray, settings: BilateralSettings) -> FloatArray:
        """(h, w) in [0, 1]: how far each pixel follows its next neighbour and not the one before."""
        off_pairs = (np.diff(height, axis=1) - self.wanted) ** 2
        off = np.zeros((2, *height.shape), np.float32)  # of the next neighbour, of the one before
        off[0, :, :-1] = self.facing[:, :-1] * off_pairs
        off[1, :, 1:] = self.facing[:, 1:] * off_pairs
        joined = np.pad(self.joined > 0, ((0, 0), (1, 1)))
        both = joined[:, 1:] & joined[:, :-1]
        usual = float(off[:, both].mean()) + settings.negligible**2 if both.any() else 1.0
        turn = settings.sharpness * (off[0] - off[1]) / np.float32(usual)
        share = 1.0 / (1.0 + np.exp(np.clip(turn, -60.0, 60.0)))
        share = np.where(joined[:, 1:], share, 0.0)
        return np.where(joined[:, :-1], share, joined[:, 1:]).astype(np.float32)

    def pairs(self, share: FloatArray, settings: BilateralSettings) -> tuple[FloatArray, FloatArray]:
        """(h, w - 1) weights of the pairs, and their weights times the differences that they should have."""
        ahead, back = share[:, :-1] * self.facing[:, :-1], (1.0 - share[:, 1:]) * self.facing[:, 1:]
        weights = self.joined * (ahead + back + settings.least)
        return weights, weights * self.wanted


def integrate_bilateral(
    by_column: FloatArray,
    by_row: FloatArray,
    inside: BoolArray,
    trust: FloatArray,
    *,
    start: FloatArray,
    settings: BilateralSettings | None = None,
) -> FloatArray:
    """(H, W) float32 height in pixels, each part of the mask on its own mean, 0 outside.

    by_column, by_row: (H, W) slopes. inside: (H, W). trust: (H, W) in each slope, in [0, 1]. start: (H, W), a
    height to begin with, such as that of least squares.
    """
    settings = settings or BilateralSettings()
    trust = np.where(inside, trust, 0.0).astype(np.float32)
    facing = 1.0 / (1.0 + by_column**2 + by_row**2)
    axes = [
        _Axis(0.5 * (by_column[:, 1:] + by_column[:, :-1]), facing, np.minimum(trust[:, 1:], trust[:, :-1])),
        _Axis(0.5 * (by_row[1:] + by_row[:-1]).T, facing.T, np.minimum(trust[1:], trust[:-1]).T),
    ]
    height = start.astype(np.float32)
    for _ in range(settings.rounds):
        along_rows, along_columns = (
            axes[0].forward_share(height, settings),
            axes[1].forward_share(height.T, settings),
        )
        right, across = axes[0].pairs(along_rows, settings)
        down, along = (np.ascontiguousarray(one.T) for one in axes[1].pairs(along_columns, settings))
        left = divergence(right * np.diff(height, axis=1) - across, down * np.diff(height, axis=0) - along)
        change = conjugate_gradients(
            left, right, down, tolerance=settings.tolerance, iterations=settings.iterations
        )
        height += change
        if np.abs(change).max() < settings.settled:
            break
    return centre_parts(height, inside)
