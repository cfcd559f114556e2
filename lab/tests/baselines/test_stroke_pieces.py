"""Pieces of known bars, and the choice among pieces that tell the same ink twice."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rumu_lab.baselines.stroke_pieces import choose_pieces, join_pieces, piece_of, pieces_of


def block(rows: slice, columns: slice) -> np.ndarray:
    pixels = np.zeros((100, 100), bool)
    pixels[rows, columns] = True
    return pixels


ROW = block(slice(40, 48), slice(10, 80))


def test_a_bar_is_measured() -> None:
    piece = piece_of(ROW, claim=3)
    assert (piece.length, piece.width) == pytest.approx((70.0, 8.0), rel=0.01)
    assert piece.angle == pytest.approx(0.0, abs=1e-6)
    assert tuple(piece.centre) == pytest.approx((44.5, 99 - 43.5))


def test_angles_are_counter_clockwise_from_the_right() -> None:
    rising = np.zeros((100, 100), bool)
    for k in range(60):
        rising[80 - k, 20 + k : 26 + k] = True
    assert piece_of(rising, claim=0).angle == pytest.approx(45.0, abs=2.0)
    assert piece_of(rising[::-1], claim=0).angle == pytest.approx(135.0, abs=2.0)


def test_short_parts_are_no_pieces() -> None:
    claims = np.array([ROW | block(slice(80, 86), slice(10, 16)), np.zeros((100, 100), bool)])
    (one,) = pieces_of(claims, width=8.0)
    assert one.claim == 0
    np.testing.assert_array_equal(one.pixels, ROW)


def uncovered(taken: list, ink: np.ndarray) -> float:
    """The sum as written in `choose_pieces`."""
    single = sum(int((p.pixels & ink).sum()) for p in taken)
    double = sum(int((p.pixels & q.pixels & ink).sum()) for i, p in enumerate(taken) for q in taken[i + 1 :])
    return int(ink.sum()) - single + double + sum(int((p.pixels & ~ink).sum()) for p in taken)


def test_what_is_told_twice_is_left_out_and_a_crossing_is_not() -> None:
    down = block(slice(10, 90), slice(40, 48))
    ink = ROW | down
    again, spill = block(slice(41, 47), slice(12, 60)), block(slice(0, 8), slice(60, 90))
    pieces = [piece_of(p, claim=k) for k, p in enumerate((again, ROW, spill, down))]
    assert sorted(p.claim for p in choose_pieces(pieces, ink)) == [1, 3]


def test_no_flip_of_one_piece_is_better_and_the_best_of_all_is_near() -> None:
    rng = np.random.default_rng(4)
    ink = rng.random((100, 100)) < 0.5
    pieces = []
    for k in range(9):
        top, left = rng.integers(0, 60, 2)
        pieces.append(piece_of(block(slice(top, top + 30), slice(left, left + 30)) & ink, claim=k))
    mine = choose_pieces(pieces, ink)
    least = uncovered(mine, ink)
    for piece in pieces:
        flipped = [p for p in mine if p is not piece] if piece in mine else [*mine, piece]
        assert uncovered(flipped, ink) >= least
    everything = [
        uncovered([p for p, kept in zip(pieces, z, strict=True) if kept], ink)
        for z in product((0, 1), repeat=len(pieces))
    ]
    assert least <= min(everything) + 0.1 * ink.sum()


def test_pieces_in_line_are_joined_and_neighbours_are_not() -> None:
    left, right, below = (
        block(slice(40, 48), slice(10, 40)),
        block(slice(40, 48), slice(44, 80)),
        block(slice(56, 64), slice(10, 80)),
    )
    found = join_pieces([piece_of(p, claim=0) for p in (left, right, below)], width=8.0)
    assert [p.length for p in found] == pytest.approx([70.0, 72.0], abs=1.0)  # a gap parts the two halves
    apart = join_pieces([piece_of(left, claim=0), piece_of(right, claim=1)], width=8.0)
    assert len(apart) == 2


def test_no_pieces_are_chosen_from_none() -> None:
    assert choose_pieces([], ROW) == []
