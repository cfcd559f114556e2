"""What the IGLS-based grader tells the learner, in Chinese and English.

That there are such instructions is known from the abstract; which, and their words, are our
reconstruction: the sign of what each feature found, where it lies beyond a tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rumu.values import BoolArray, FloatArray
from rumu_lab.baselines.cell import Cell
from rumu_lab.baselines.igls import log_sizes, offset

TOLERATED_OFFSET = 0.02
"""Cells that the centroid may stand off without a word."""
TOLERATED_SIZE = 0.05
"""Share by which width or height may differ without a word."""
TOLERATED_INK = 0.03
"""Share of the ink that may lie in the wrong third without a word."""


@dataclass(frozen=True, slots=True)
class Instruction:
    """One sentence to the learner.

    feature: 'centre', 'size' or 'projections'. amount: what was measured, signed: cells to the right or up,
    share too wide or too high, share of the ink too much in that third. zh, en: what to do.
    """

    feature: str
    amount: float
    zh: str
    en: str


def instructions(probe: Cell, reference: Cell) -> tuple[Instruction, ...]:
    """What to do about centre, size and projections, in this order; empty within all tolerances."""
    return (*_centre(probe, reference), *_size(probe, reference), *_projections(probe, reference))


def _centre(probe: Cell, reference: Cell) -> list[Instruction]:
    right, up = offset(probe, reference)
    words = ((right, ("左", "left"), ("右", "right")), (up, ("下", "down"), ("上", "up")))
    return [
        Instruction(
            "centre",
            off,
            f"重心偏{(low, high)[off > 0][0]} {abs(off):.0%}，往{(high, low)[off > 0][0]}寫。",
            f"Write further {(high, low)[off > 0][1]}: the centre is {abs(off):.0%} of the cell off.",
        )
        for off, low, high in words
        if abs(off) > TOLERATED_OFFSET
    ]


def _size(probe: Cell, reference: Cell) -> list[Instruction]:
    words = (("寬", "窄", "wider", "narrower"), ("高", "矮", "taller", "lower"))
    found = []
    for ratio, (large, small, more, less) in zip(log_sizes(probe, reference), words, strict=True):
        share = math.expm1(ratio)
        if abs(share) > TOLERATED_SIZE:
            is_zh, be_zh, be_en = (large, small, less) if share > 0 else (small, large, more)
            zh = f"字太{is_zh}（{abs(share):.0%}），寫{be_zh}些。"
            en = f"Write it {be_en}: it differs by {abs(share):.0%}."
            found.append(Instruction("size", share, zh, en))
    return found


def _projections(probe: Cell, reference: Cell) -> list[Instruction]:
    """For each direction the third of the writing with the largest surplus or deficit of ink."""
    words = (
        (("左邊", "the left"), ("中間", "the middle from left to right"), ("右邊", "the right")),
        (("上部", "the top"), ("中部", "the middle from top to bottom"), ("下部", "the bottom")),
    )
    found = []
    for axis, names in enumerate(words):
        thirds = _thirds(probe.ink, axis=axis) - _thirds(reference.ink, axis=axis)
        worst = int(np.abs(thirds).argmax())
        amount = float(thirds[worst])
        if abs(amount) > TOLERATED_INK:
            zh, en = names[worst]
            do_zh, do_en = (
                ("太密，寫疏些", "too crowded: open it")
                if amount > 0
                else ("太疏，寫滿些", "too empty: fill it")
            )
            found.append(
                Instruction(
                    "projections", amount, f"{zh}{do_zh}（{abs(amount):.0%}）。", f"At {en} it is {do_en}."
                )
            )
    return found


def _thirds(ink: BoolArray, *, axis: int) -> FloatArray:
    """(3,) shares of the ink in thirds of its own box, from the left (axis 0) or from the top (axis 1)."""
    places = np.nonzero(ink)[1 - axis]
    counts = np.histogram(places, bins=3, range=(places.min() - 0.5, places.max() + 0.5))[0]
    return np.asarray(counts / len(places))
