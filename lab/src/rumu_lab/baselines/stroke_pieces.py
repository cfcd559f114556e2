"""Stroke pieces of directional claims, and the choice of those that explain the ink once.

That redundant pieces are removed by how much they overlap is known from the abstract of Su and Wang 2003,
whose references point to a zero-one quadratic problem; the problem as posed here is our reconstruction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rumu.values import BoolArray, FloatArray

MOST = 60
"""Pieces that the choice is made among; the largest, where there are more."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """claim: number of the direction it was found in. pixels: (H, W) bool.

    centre: (2,) x right, y up, in pixels from the bottom left. angle: degrees from +x, counter-clockwise, in
    [0, 180). length, width: of a bar that has its principal moment and its area, in pixels.
    """

    claim: int
    pixels: BoolArray
    centre: FloatArray
    angle: float
    length: float
    width: float

    @property
    def along(self) -> FloatArray:
        """(2,) unit vector of the piece."""
        return np.array([np.cos(np.radians(self.angle)), np.sin(np.radians(self.angle))])


def piece_of(pixels: BoolArray, *, claim: int) -> Piece:
    """A piece from its pixels, of which there must be one at least."""
    rows, columns = np.divmod(np.flatnonzero(pixels), pixels.shape[1])
    cx, cy = float(columns.mean()), pixels.shape[0] - 1.0 - float(rows.mean())
    x, y = columns - cx, pixels.shape[0] - 1.0 - rows - cy
    xx, yy, xy = (float(np.vdot(a, b)) / len(rows) for a, b in ((x, x), (y, y), (x, y)))
    greater = (xx + yy) / 2.0 + math.hypot((xx - yy) / 2.0, xy)
    length = math.sqrt(12.0 * greater + 1.0)
    angle = math.degrees(math.atan2(2.0 * xy, xx - yy)) / 2.0 % 180.0
    return Piece(claim, pixels, np.array([cx, cy]), angle, length, len(rows) / length)


def pieces_of(claims: BoolArray, *, width: float, shortest: float = 1.2) -> list[Piece]:
    """Connected parts of each direction's claims, (directions, H, W), over `shortest` stroke widths long."""
    import cv2

    found = []
    for claim, pixels in enumerate(claims):
        count, labels, stats, _ = cv2.connectedComponentsWithStats(pixels.astype(np.uint8), connectivity=8)
        for k in range(1, count):
            if np.hypot(*stats[k, 2:4]) > shortest * width:
                found.append(piece_of(labels == k, claim=claim))
    return [p for p in found if p.length > shortest * width]


def choose_pieces(pieces: list[Piece], ink: BoolArray, *, spill: float = 1.0) -> list[Piece]:
    """Choose the pieces that explain the ink with the least overlap and spill.

    The pieces z in {0, 1} that leave the least of

        |ink| - sum z_i |B_i & ink| + sum_{i<j} z_i z_j |B_i & B_j & ink| + spill sum z_i |B_i - ink|,

    the ink left uncovered by inclusion and exclusion to the second order: an indefinite zero-one quadratic
    problem, gone down by the flip of one piece that gains most, until none gains.
    """
    from scipy.sparse import csr_array

    pieces = sorted(pieces, key=lambda p: -p.length * p.width)[:MOST]
    if not pieces:
        return []
    inside = csr_array([p.pixels[ink] for p in pieces], dtype=np.int32)
    overlap = (inside @ inside.T).toarray().astype(float)
    area = np.array([np.count_nonzero(p.pixels) for p in pieces])
    covered = overlap.diagonal().copy()
    linear = spill * (area - covered) - covered
    np.fill_diagonal(overlap, 0.0)
    taken = np.zeros(len(pieces))
    for _ in range(10 * len(pieces)):
        change = np.where(taken > 0, -1.0, 1.0) * (linear + overlap @ taken)
        best = int(change.argmin())
        if change[best] >= 0:
            break
        taken[best] = 1.0 - taken[best]
    return [p for p, kept in zip(pieces, taken, strict=True) if kept]


def join_pieces(pieces: list[Piece], *, width: float, turn: float = 15.0) -> list[Piece]:
    """Pieces of one direction that continue each other, with a gap below one width, made one."""
    pieces = list(pieces)
    while True:
        pair = next(
            (
                (a, b)
                for i, a in enumerate(pieces)
                for b in pieces[i + 1 :]
                if a.claim == b.claim and _continues(a, b, width=width, turn=turn)
            ),
            None,
        )
        if pair is None:
            return pieces
        one = piece_of(pair[0].pixels | pair[1].pixels, claim=pair[0].claim)
        pieces = [p for p in pieces if p not in pair] + [one]


def _continues(a: Piece, b: Piece, *, width: float, turn: float) -> bool:
    between = b.centre - a.centre
    if abs((a.angle - b.angle + 90.0) % 180.0 - 90.0) > turn:
        return False
    longer = a if a.length >= b.length else b
    ahead = abs(float(between @ longer.along))
    aside = abs(float(longer.along[0] * between[1] - longer.along[1] * between[0]))
    return ahead - (a.length + b.length) / 2.0 < width and aside < width / 2.0
