"""What makes coefficients of photographs, and photographs of coefficients, at each place of a sheet.

Under lamps that are far away it is the same everywhere. The direction of a near lamp differs from place to
place: matrices are made for the corners of a grid, and what they find is blended between the corners, so
that no edge of the grid shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.dome import places
from rumu.rti.image import Basis, light_weights
from rumu.values import Capture, FloatArray, IntArray

_CELLS = 12
"""Cells of the grid along the longer side."""
_UNSURE = 0.03
"""Singular value at a corner, as a share of the largest, from which on the corner is believed."""


@dataclass(frozen=True, slots=True, eq=False)
class LampPlaces:
    """The lamps of a capture as a relightable image sees them.

    inverse: (G, K, N) float32, coefficients of values; weights: (G, N, K), values of coefficients; both for
        the corners of a grid, row by row; one corner where the lamps are far away.
    told: how many mixtures of terms the lamps tell in the middle. shape: (H, W). cells: of the grid, (down,
    across). positions: (N, 3) of near lamps in pixels from the middle; None of those far away.
    """

    inverse: FloatArray
    weights: FloatArray
    told: int
    shape: tuple[int, int]
    cells: tuple[int, int]
    positions: FloatArray | None

    @classmethod
    def of(cls, capture: Capture, *, basis: Basis, terms: int, singular: float) -> LampPlaces:
        """Of a capture. singular: of `rumu.rti.fitting.RtiSettings`. Raises ImageError as `light_weights`."""
        height, width = shape = (capture.mask.shape[0], capture.mask.shape[1])
        middle = light_weights(capture.lights, basis=basis, terms=terms)
        told = int(np.linalg.matrix_rank(middle, tol=singular * np.linalg.norm(middle, 2)))
        inverse = np.linalg.pinv(middle, rcond=singular)[None]
        weights, cells = middle[None], (0, 0)
        if capture.positions is not None:
            down, across = cells = tuple(max(1, round(_CELLS * one / max(shape))) for one in shape)
            corners = np.stack(
                np.meshgrid(
                    np.linspace(-width / 2, width / 2, across + 1),
                    np.linspace(height / 2, -height / 2, down + 1),
                ),
                axis=-1,
            ).reshape(-1, 2)
            toward = np.repeat(capture.positions[None], len(corners), axis=0)
            toward[..., :2] -= corners[:, None]
            weights = np.stack([light_weights(one, basis=basis, terms=terms) for one in toward])
            inverse = _inverse_at_corners(weights, inverse, unsure=_UNSURE)
        return cls(
            inverse.astype(np.float32), weights.astype(np.float32), told, shape, cells, capture.positions
        )

    def coefficients(self, values: FloatArray, pixels: IntArray) -> FloatArray:
        """(K, P, C) of values (N, P, C) of some pixels, by their numbers."""
        return self._blended(self.inverse, values, pixels)

    def values(self, coefficients: FloatArray, pixels: IntArray) -> FloatArray:
        """(N, P, C) of coefficients (K, P, C) of some pixels, by their numbers."""
        return self._blended(self.weights, coefficients, pixels)

    def steepness(self, pixels: IntArray) -> FloatArray | None:
        """(N, P) float32: by how much less flat paper is lit where a near lamp stands lower above it.

        Beside the middle of the sheet. The photographs of such a capture show flat paper equally bright
        everywhere. None where the lamps are far away.
        """
        if self.positions is None:
            return None
        x, y = (one.astype(np.float32) for one in places(pixels, self.shape))
        left, up, high = (self.positions[:, axis, None].astype(np.float32) for axis in range(3))
        away = np.sqrt((left - x) ** 2 + (up - y) ** 2 + high**2)
        middle = np.linalg.norm(self.positions, axis=1)[:, None].astype(np.float32)
        return np.asarray(middle / away)

    def _blended(self, matrices: FloatArray, values: FloatArray, pixels: IntArray) -> FloatArray:
        """(A, P, C): matrices (G, A, B) of the corners around each pixel, times values (B, P, C)."""
        if self.positions is None:
            return np.tensordot(matrices[0], values, axes=1)
        down, across = self.cells
        rows, columns = np.divmod(pixels, self.shape[1])
        row, column = (rows + 0.5) * (down / self.shape[0]), (columns + 0.5) * (across / self.shape[1])
        top, left = row.astype(np.intp), column.astype(np.intp)
        below, right = (row - top).astype(np.float32), (column - left).astype(np.float32)
        cell = top * (across + 1) + left
        found = np.empty((matrices.shape[1], *values.shape[1:]), np.float32)
        for one in np.unique(cell):
            inside = np.flatnonzero(cell == one)
            v, h = below[inside, None], right[inside, None]
            shares = [(one, (1 - v) * (1 - h)), (one + 1, (1 - v) * h)]
            shares += [(one + across + 1, v * (1 - h)), (one + across + 2, v * h)]
            some = values[:, inside]
            found[:, inside] = sum(share * np.tensordot(matrices[at], some, axes=1) for at, share in shares)
        return found


def _inverse_at_corners(weights: FloatArray, middle: FloatArray, *, unsure: float) -> FloatArray:
    """(G, K, N): what makes coefficients of values under the directions of each corner.

    Seen from a corner all lamps stand to one side. What they do not tell there is taken as if the corner were
    the middle of the sheet. weights: (G, N, K). middle: (1, K, N), of the middle. unsure: singular value, as
    a share of the largest, at which both count alike.
    """
    turned = weights.transpose(0, 2, 1)
    trust = (unsure * np.linalg.norm(weights, 2, axis=(1, 2))) ** 2
    prior = trust[:, None, None] * np.eye(weights.shape[2])
    return np.asarray(np.linalg.solve(turned @ weights + prior, turned + trust[:, None, None] * middle))
