"""Characters of a page without a grid: registers, columns, and each column parted by its rhythm."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.pages.column_rhythm import (
    WHERE_KNOWN,
    CutsByCount,
    RhythmSettings,
    RowInk,
    SmallSettings,
    best_cuts,
    find_pace,
    possible_cuts,
    row_ink,
    runs_of,
)
from rumu.pages.columns import Column
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class RegisterSettings:
    """What the columns of one register have in common.

    full: by how many paces a column may fall short of the longest and still count as full. agree: share of
    the full columns that must hold the same number of characters. weight: what another number then costs.
    slender, broad: a column more slender than this share of the usual, or broader, has a pace of its own.
    double: share of small characters below which a register has no double rows. lower: how high small
    characters are at most, as a share of the usual height of the others: clerical characters are low for
    their pace.
    """

    full: float = 0.7
    agree: float = 0.5
    weight: float = 2.5
    slender: float = 0.8
    broad: float = 1.35
    double: float = 0.03
    lower: float = 0.84


@dataclass(frozen=True, slots=True, eq=False)
class ColumnPlaces:
    """Where the characters of a column stand.

    at: (n, 2) float64, the rows of the page at which each begins and ends. small: (n,) bool, rows of a double
    row of small characters. doubt: (n,) float64, what each cost. pace: the pace it was cut by, in pixels.
    """

    at: FloatArray
    small: BoolArray
    doubt: FloatArray
    pace: float


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """A stretch of a column that is cut as a whole."""

    best: CutsByCount
    cost: FloatArray
    small: BoolArray

    def count(self) -> int:
        """The number of characters that costs least."""
        return int(np.argmin(self.best.cost))

    def small_count(self) -> int:
        """How many of them are small."""
        k = np.searchsorted(self.best.at, self.best.places(self.count()))
        return int(self.small[k[:-1], k[1:]].sum())


def part_register(
    columns: list[Column], *, rhythm: RhythmSettings | None = None, register: RegisterSettings | None = None
) -> list[ColumnPlaces]:
    """Where the characters of each column of a register stand."""
    rhythm, register = rhythm or RhythmSettings(), register or RegisterSettings()
    breadth = float(np.median([column.breadth for column in columns]))
    pace = find_pace(columns, settings=rhythm)
    paces = [_own_pace(column, pace, breadth, rhythm, register) for column in columns]
    inks = [row_ink(column, breadth=breadth) for column in columns]
    runs = [_runs(ink, p, SmallSettings(), rhythm) for ink, p in zip(inks, paces, strict=True)]
    every = [run for own in runs for run in own]
    few = max(2, register.double * sum(run.count() for run in every))
    smalls = sum(run.small_count() for run in every)
    if smalls:
        known = _where_known(inks, runs, paces, register) if smalls >= few else None
        runs = [_runs(ink, p, known, rhythm) for ink, p in zip(inks, paces, strict=True)]
        if known and sum(run.small_count() for own in runs for run in own) < few:
            runs = [_runs(ink, p, None, rhythm) for ink, p in zip(inks, paces, strict=True)]
    counts = _counts(columns, runs, pace, register)
    return [_places(own, n, p) for own, n, p in zip(runs, counts, paces, strict=True)]


def _where_known(
    inks: list[RowInk], runs: list[list[_Run]], paces: list[float], register: RegisterSettings
) -> SmallSettings:
    """How small characters are told on a page that surely has some; lower where the others are low, too."""
    heights = []
    for ink, own, pace in zip(inks, runs, paces, strict=True):
        inked = np.flatnonzero(ink.ink > WHERE_KNOWN.dust * pace) + ink.first
        for run in own:
            places = run.best.places(run.count())
            k = np.searchsorted(run.best.at, places)
            small = run.small[k[:-1], k[1:]]
            for begin, end, is_small in zip(places[:-1], places[1:], small, strict=True):
                within = inked[(inked >= begin) & (inked < end)]
                if len(within) and not is_small:
                    heights.append((within[-1] + 1 - within[0]) / pace)
    usual = float(np.median(heights)) if heights else 1.0
    share = min(1.0, register.lower * usual / WHERE_KNOWN.low)
    return replace(WHERE_KNOWN, low=share * WHERE_KNOWN.low, flat=share * WHERE_KNOWN.flat)


def _own_pace(
    column: Column, pace: float, breadth: float, rhythm: RhythmSettings, register: RegisterSettings
) -> float:
    """The pace of a column: that of its register, unless its characters are smaller, or those of a title."""
    if column.breadth > register.broad * breadth:
        return max(find_pace([column], settings=rhythm), pace)
    if column.breadth > register.slender * breadth:
        return pace
    own = find_pace([column], settings=rhythm)
    return min(own, pace)


def _runs(ink: RowInk, pace: float, small: SmallSettings | None, rhythm: RhythmSettings) -> list[_Run]:
    found = []
    for begin, end in runs_of(ink, pace=pace, settings=rhythm):
        cuts = possible_cuts(ink, (begin, end), pace=pace, small=small, settings=rhythm)
        best = best_cuts(cuts, most=int((end - begin) / pace * 1.5) + 3)
        if np.isfinite(best.cost).any():
            found.append(_Run(best, cuts.cost, cuts.small))
    return found


def _counts(
    columns: list[Column], runs: list[list[_Run]], pace: float, register: RegisterSettings
) -> list[list[int]]:
    """The number of characters of each run: a full column holds as many as most of the full ones do."""
    counts = [[run.count() for run in own] for own in runs]
    longest = max(column.length for column in columns)
    full = [
        k
        for k, column in enumerate(columns)
        if len(runs[k]) == 1 and column.length > longest - register.full * pace
    ]
    usual, times = np.unique([counts[k][0] for k in full], return_counts=True)
    if not full or times.max() < max(2, register.agree * len(full)):
        return counts
    number = int(usual[np.argmax(times)])
    weight = register.weight * float(times.max()) / len(full)
    for k in full:
        cost = runs[k][0].best.cost
        if number < len(cost) and cost[number] < cost[counts[k][0]] + weight:
            counts[k] = [number]
    return counts


def _places(runs: list[_Run], counts: list[int], pace: float) -> ColumnPlaces:
    at: list[FloatArray] = [np.zeros((0, 2))]
    small: list[BoolArray] = [np.zeros(0, dtype=bool)]
    doubt: list[FloatArray] = [np.zeros(0)]
    for run, count in zip(runs, counts, strict=True):
        places = run.best.places(count)
        k = np.searchsorted(run.best.at, places)
        at.append(np.column_stack([places[:-1], places[1:]]))
        small.append(run.small[k[:-1], k[1:]])
        doubt.append(run.cost[k[:-1], k[1:]])
    return ColumnPlaces(np.concatenate(at), np.concatenate(small), np.concatenate(doubt), pace)
