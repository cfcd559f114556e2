"""The GFSE-based grader: its ceiling, its floor, and the faults it sees."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.gfse import GfseSettings, alike_pieces, extract, raw


@pytest.mark.parametrize("work", ["regular-shu", "clerical-tian", "seal-shui", "cursive-yue"])
def test_itself_is_one(cell, work: str) -> None:
    assert raw(cell(work), cell(work)).raw > 0.93


def test_other_characters_are_at_the_floor(cell) -> None:
    master = cell("regular-shu")
    others = [raw(cell(f"regular-{name}"), master).raw for name in ("yue", "shui", "tian", "ren", "ri")]
    assert max(others) < 0.45, others


@pytest.mark.parametrize("work", ["regular-tian", "clerical-ri"])
def test_a_mirrored_character_falls_far(cell, work: str) -> None:
    master = cell(work)
    mirrored = type(master)(master.ink[:, ::-1].copy(), master.density[:, ::-1].copy())
    turned = type(master)(np.rot90(master.ink).copy(), np.rot90(master.density).copy())
    assert raw(turned, master).raw < 0.6
    assert raw(mirrored, master).raw < 0.95


@pytest.mark.parametrize("fault", ["shift", "angle", "thin", "thick", "lean", "squeeze", "uneven", "short"])
def test_each_fault_costs_the_more_the_larger_it_is(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-shu", fault, severities=(0, 2, 5), seeds=(1, 2))
    assert (np.diff(grades) < 0).all(), grades


@pytest.mark.parametrize("fault", ["missing", "extra"])
def test_a_stroke_too_few_or_too_many_costs(ladder, fault: str) -> None:
    grades = ladder(raw, "regular-tian", fault, severities=(0, 1, 3))
    assert max(grades[1:]) < 0.8, grades


def test_a_stroke_left_out_lowers_the_pieces_likeness_by_its_length(cell) -> None:
    whole = extract(cell("regular-tian"), cell("regular-tian").width, GfseSettings()).pieces
    lost, *rest = sorted(whole, key=lambda p: -p.length)
    lengths = [p.length for p in whole]
    expected = 1 - lost.length / (2 * sum(lengths) - lost.length)
    assert alike_pieces(tuple(rest), whole, settings=GfseSettings()) == pytest.approx(expected, abs=1e-6)
    assert alike_pieces((), whole, settings=GfseSettings()) == 0.0


def test_the_pieces_explain_nearly_all_ink(cell) -> None:
    import cv2

    for work in ("regular-shu", "clerical-tian", "running-shui"):
        master = cell(work)
        found = extract(master, master.width, GfseSettings())
        ink = cv2.resize(master.ink.astype(np.float32), (128, 128), interpolation=cv2.INTER_AREA) >= 0.5
        union = np.logical_or.reduce([p.pixels for p in found.pieces])
        assert (union & ink).sum() > 0.7 * ink.sum()
        assert (union & ~ink).sum() < 0.35 * ink.sum()
