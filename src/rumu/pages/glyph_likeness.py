"""How alike the ink of a found character and a printed one are: directions of edges in a coarse grid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rumu.characters.stroke_data import find_character
from rumu.values import BoolArray, FloatArray, IntArray

_SIDE = 48  # pixels of the square that a character is drawn into
_CELLS = 8  # cells of the grid along a side
_DIRECTIONS = 8  # of edges, over half a turn
_BATCH = 200  # characters described at a time
_MARGIN = 4  # pixels of paper around the character

Floats = npt.NDArray[np.float32]


def describe_ink(pixels: Sequence[tuple[IntArray, IntArray]]) -> Floats:
    """(n, d) float32 of length 1: the characters whose ink has these rows and columns, (k,) each."""
    return _describe([_normal(_mask(y, x)) for y, x in pixels])


def describe_printed(characters: Sequence[str]) -> tuple[Floats, BoolArray]:
    """(n, d) float32: characters as copybooks print them; and (n,) bool, whether their strokes are known."""
    import cv2

    drawn = [np.zeros((_SIDE, _SIDE), dtype=np.float32)] * len(characters)
    known = np.zeros(len(characters), dtype=bool)
    for k in sorted(range(len(characters)), key=lambda one: characters[one]):  # as they are stored
        found = find_character(characters[k])
        if found is None:
            continue
        known[k] = True
        canvas = np.zeros((128, 128), dtype=np.uint8)
        for stroke in found.strokes:
            cv2.fillPoly(canvas, [np.rint(stroke.polygon() * 127).astype(np.int32)], 255)
        drawn[k] = _normal(canvas)
    return _describe(drawn), known


def _mask(y: IntArray, x: IntArray) -> npt.NDArray[np.uint8]:
    mask = np.zeros((int(np.ptp(y)) + 1, int(np.ptp(x)) + 1), dtype=np.uint8)
    mask[y - y.min(), x - x.min()] = 255
    return mask


def _normal(mask: npt.NDArray[np.uint8]) -> Floats:
    """(_SIDE, _SIDE): the ink in the middle of the square; a flat character stays flat, but less so."""
    import cv2

    ys, xs = np.nonzero(mask.any(axis=1))[0], np.nonzero(mask.any(axis=0))[0]
    square = np.zeros((_SIDE, _SIDE), dtype=np.float32)
    if not len(ys):
        return square
    cut = mask[ys[0] : ys[-1] + 1, xs[0] : xs[-1] + 1]
    height, width = cut.shape
    full = _SIDE - 2 * _MARGIN
    longest = max(height, width)
    tall, wide = (max(4, round(full * (side / longest) ** 0.6)) for side in (height, width))
    way = cv2.INTER_AREA if longest > full else cv2.INTER_LINEAR
    small = cv2.resize(cut, (wide, tall), interpolation=way).astype(np.float32) / 255
    top, left = (_SIDE - tall) // 2, (_SIDE - wide) // 2
    square[top : top + tall, left : left + wide] = small
    return square


def _describe(squares: list[Floats]) -> Floats:
    import cv2

    if not squares:
        return np.zeros((0, _CELLS * _CELLS * _DIRECTIONS), dtype=np.float32)
    if len(squares) > _BATCH:
        return np.concatenate([_describe(squares[k : k + _BATCH]) for k in range(0, len(squares), _BATCH)])
    stack = np.stack([cv2.GaussianBlur(square, (0, 0), 1.2) for square in squares])
    gy, gx = np.gradient(stack, axis=(1, 2))
    strength = np.hypot(gx, gy)
    turn = np.mod(np.arctan2(gy, gx), np.pi) * (_DIRECTIONS / np.pi)
    lower = np.floor(turn).astype(np.intp) % _DIRECTIONS
    share = (turn - np.floor(turn)).astype(np.float32)
    n = len(squares)
    cells = np.zeros((n, _DIRECTIONS, _SIDE, _SIDE), dtype=np.float32)
    who, row, column = np.ogrid[:n, :_SIDE, :_SIDE]
    cells[who, lower, row, column] += strength * (1 - share)
    cells[who, (lower + 1) % _DIRECTIONS, row, column] += strength * share
    pool = _pooling()
    pooled = np.einsum("cr,ndrs,es->ndce", pool, cells, pool, optimize=True).reshape(n, -1)
    pooled = np.sqrt(np.maximum(pooled, 0))
    return np.asarray(
        pooled / np.maximum(np.linalg.norm(pooled, axis=1, keepdims=True), 1e-6), dtype=np.float32
    )


def turned_description(described: Floats, turns: int) -> Floats:
    """(n, d): what descriptions (n, d) become when their ink is turned by quarters counter-clockwise."""
    maps = described.reshape(len(described), _DIRECTIONS, _CELLS, _CELLS)
    maps = np.rot90(maps, turns, axes=(2, 3))
    return np.roll(maps, turns * _DIRECTIONS // 2, axis=1).reshape(described.shape)


def _pooling() -> Floats:
    """(_CELLS, _SIDE): how much each row counts for each cell; neighbouring cells overlap."""
    middles = (np.arange(_CELLS) + 0.5) * _SIDE / _CELLS
    apart = (np.arange(_SIDE) + 0.5)[None, :] - middles[:, None]
    return np.exp(-0.5 * (apart / (0.6 * _SIDE / _CELLS)) ** 2).astype(np.float32)


def likeness(found: Floats, printed: Floats, known: BoolArray) -> FloatArray:
    """(n, m): how much better each printed character fits each found one than the others do; about -2 to 5.

    0 where a printed character is not known.
    """
    alike = (found @ printed.T).astype(float)
    if known.sum() < 2:
        return np.zeros_like(alike)
    middle = alike[:, known].mean(axis=1, keepdims=True)
    spread = np.maximum(alike[:, known].std(axis=1, keepdims=True), 0.02)
    return np.where(known[None, :], (alike - middle) / spread, 0.0)
