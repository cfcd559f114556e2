"""Characters of a column parted by its rhythm: where the ink is thin, at about the pace of the column."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.columns import Column
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class RhythmSettings:
    """What a column is cut by; lengths as shares of its pace, the usual height of a character's place.

    pace: the least and the greatest pace, as shares of the breadth of a column. first: share of the
    strongest echo of the column's ink that its pace has at least; twice and thrice the pace echo as
    well. blur: by how much the ink of each row is smoothed. break_: an empty stretch from this length on
    parts two runs of characters. squeezed, stretched: the height of a place costs 1 when it is lower,
    higher than the pace by this. least: the lowest place. most: the highest. ink: what a cut through a
    row of usual ink costs; touch: what any cut through ink costs besides. gap: what a cut through an
    empty stretch of `clear` height gains.
    """

    pace: tuple[float, float] = (0.9, 2.4)
    first: float = 0.6
    blur: float = 0.04
    break_: float = 0.85
    squeezed: float = 0.3
    stretched: float = 0.22
    least: float = 0.3
    most: float = 1.75
    ink: float = 3.0
    touch: float = 0.15
    gap: float = 0.4
    clear: float = 0.2


@dataclass(frozen=True, slots=True)
class SmallSettings:
    """When ink is a row of small characters, two abreast or one on the right; lengths as shares of the pace.

    half: the height of its place, where that is not as high as the others. low: how high a small
    character is at most. slim: over how many strips one without a neighbour reaches at most. shift: by
    how many strips the middle of the row may lie beside that of the column. dust: how much ink a row may
    hold and still be empty. pair: what two abreast gain. doubt: what it costs to take them for one
    character. flat: how high two that touch are at most. valley: how much ink stands in the middle of
    two that touch, as a share of what stands beside it.
    """

    half: float = 0.55
    low: float = 0.62
    slim: int = 13
    shift: int = 4
    dust: float = 0.06
    pair: float = 0.2
    doubt: float = 1.5
    flat: float = 0.5
    valley: float = 0.25


WHERE_KNOWN = SmallSettings(low=0.66, slim=15, shift=5, dust=0.1)
"""The same on a page that surely has double rows."""


@dataclass(frozen=True, slots=True, eq=False)
class RowInk:
    """Ink of a column by its rows.

    first: the row on the page of ink[0]. ink: (n,) pixels in each row. strips: (n + 1, STRIPS) how many
    connected parts have their middle above each row and reach over each strip; strips run from left to right,
    twelve on either side of the middle of the column. pixels: (n + 1, STRIPS) the ink above each row.
    """

    first: int
    ink: FloatArray
    strips: IntArray
    pixels: IntArray


STRIPS = 24
"""Strips across a column, of 1.2 times its usual breadth."""
_DUST = 0.015  # area of a part that is no stroke, as a share of the square of a column's breadth


def row_ink(column: Column, *, breadth: float) -> RowInk:
    """The ink of each row of a column. breadth: what is usual for the columns of its register, in pixels."""
    top, bottom = column.extent
    ink = np.bincount(column.y - top, minlength=bottom - top).astype(float)
    across = np.clip((column.offset / (1.2 * breadth) + 0.5) * STRIPS, 0, STRIPS - 1).astype(np.intp)
    order = np.argsort(column.part, kind="stable")
    starts = np.nonzero(np.diff(column.part[order], prepend=-1))[0]
    area = np.diff(np.append(starts, len(order)))
    low_y, low_x = (np.minimum.reduceat(v[order], starts) for v in (column.y - top, across))
    high_y, high_x = (np.maximum.reduceat(v[order], starts) + 1 for v in (column.y - top, across))
    stroke = area > _DUST * breadth**2
    middle = (low_y + high_y) // 2
    spans = np.zeros((bottom - top, STRIPS + 1), dtype=np.intp)  # 1 where a part begins, -1 where it ends
    np.add.at(spans, (middle[stroke], low_x[stroke]), 1)
    np.add.at(spans, (middle[stroke], high_x[stroke]), -1)
    covered = spans.cumsum(axis=1)[:, :STRIPS]
    above = np.concatenate([np.zeros((1, STRIPS), dtype=np.intp), covered.cumsum(axis=0)])
    cells = (column.y - top) * STRIPS + across
    pixels = np.bincount(cells, minlength=(bottom - top) * STRIPS).reshape(bottom - top, STRIPS)
    pixels = np.concatenate([np.zeros((1, STRIPS), dtype=np.intp), pixels.cumsum(axis=0)])
    return RowInk(top, ink, above, pixels)


def find_pace(columns: list[Column], *, settings: RhythmSettings | None = None) -> float:
    """The usual distance between the characters of these columns, in pixels, by autocorrelation."""
    settings = settings or RhythmSettings()
    breadth = float(np.median([column.breadth for column in columns]))
    low, high = (share * breadth for share in settings.pace)
    count = int(np.ceil(high)) + 4
    total = np.zeros(count)
    for column in columns:
        ink = row_ink(column, breadth=breadth).ink
        if len(ink) < 2 * high:
            continue
        wave = _blur(ink, 0.12 * breadth) - _blur(ink, 0.8 * breadth)
        power = np.fft.rfft(wave, 2 * len(wave))
        total += np.fft.irfft(power * np.conj(power))[:count] / len(wave)
    lags = np.arange(count)
    inside = (lags >= low) & (lags <= high)
    if not total.any():
        return 1.25 * breadth
    peaks = [k for k in lags[inside] if total[k] == total[max(k - 2, 0) : k + 3].max()]
    strongest = max((total[k] for k in peaks), default=0.0)
    best = int(next((k for k in peaks if total[k] >= settings.first * strongest), lags[inside][0]))
    if low < best < high - 1:
        a, b, c = total[best - 1 : best + 2]
        bend = a - 2 * b + c
        return float(best + (0.5 * (a - c) / bend if bend < 0 else 0.0))
    return float(best)


def _blur(values: FloatArray, sigma: float) -> FloatArray:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, max(sigma, 0.3), mode="constant"))


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """Where a run of characters can be cut.

    at: (m,) rows on the page, the first and the last are its ends. cost: (m, m), what a character from cut i
    to cut j costs, infinite where there can be none; the cost of cutting at j is in it. small: (m, m) bool,
    whether what stands between them is rather a piece of a double row of small characters.
    """

    at: FloatArray
    cost: FloatArray
    small: BoolArray


def runs_of(ink: RowInk, *, pace: float, settings: RhythmSettings) -> list[tuple[int, int]]:
    """Stretches of the column between long empty ones: first row and row after the last, counted in ink."""
    rows = np.nonzero(ink.ink > 0)[0]
    breaks = np.nonzero(np.diff(rows) > settings.break_ * pace)[0]
    starts = np.concatenate([[0], breaks + 1])
    ends = np.concatenate([breaks, [len(rows) - 1]])
    return [(int(rows[s]), int(rows[e]) + 1) for s, e in zip(starts, ends, strict=True)]


def possible_cuts(
    ink: RowInk, run: tuple[int, int], *, pace: float, small: SmallSettings | None, settings: RhythmSettings
) -> Cuts:
    """Empty and thin places of a run, and what each character between two of them would cost.

    small: how rows of small characters are told; None where there are none.
    """
    begin, end = run
    rows = ink.ink[begin:end]
    smooth = _blur(rows, settings.blur * pace)
    usual = max(float(np.quantile(rows[rows > 0], 0.6)), 1.0)
    at, price = _candidates(rows, smooth, usual, pace, settings)
    beyond = 0.5 * _usual_gap(rows, pace)
    at = np.concatenate([[-beyond], at, [len(rows) + beyond]])
    price = np.concatenate([[0.0], price, [0.0]])
    heights = (at[None, :] - at[:, None]) / pace
    i, j = np.nonzero((heights > settings.least) & (heights < settings.most))
    height = heights[i, j]
    off = np.where(height < 1, (height - 1) / settings.squeezed, (height - 1) / settings.stretched) ** 2
    cost, is_small = np.full(heights.shape, np.inf), np.zeros(heights.shape, dtype=bool)
    cost[i, j] = off + price[j]
    if small is not None:
        layout = _small_layout(ink, at + begin, (i, j), pace, small)
        half = ((height - small.half) / (small.half * settings.squeezed)) ** 2
        main = off + np.where(layout > 0, small.doubt, 0.0)
        pair = np.where(layout > 0, np.minimum(off, half) - np.where(layout == 2, small.pair, 0.0), np.inf)
        cost[i, j], is_small[i, j] = np.minimum(main, pair) + price[j], pair < main
    return Cuts(at + ink.first + begin, cost, is_small)


def _small_layout(
    ink: RowInk, at: FloatArray, pairs: tuple[IntArray, IntArray], pace: float, settings: SmallSettings
) -> IntArray:
    """For each pair of cuts: 2 where a right and a left small character stand between them, 1 for one."""
    i, j = pairs
    rows = np.clip(np.rint(at).astype(np.intp), 0, len(ink.ink))
    inked = np.concatenate([np.nonzero(ink.ink > settings.dust * pace)[0], [len(ink.ink)]])
    after = np.searchsorted(inked[:-1], rows)
    first, last = inked[after], inked[np.maximum(after - 1, 0)] + 1
    layout = np.zeros(len(i), dtype=np.intp)
    low = np.nonzero(last[j] - first[i] < settings.low * pace)[0]
    held = ink.strips[rows[j[low]]] - ink.strips[rows[i[low]]] > 0
    until = held.cumsum(axis=1)
    middle, total = STRIPS // 2, until[:, -1]
    for shift in range(-settings.shift, settings.shift + 1):  # a column's middle is known to some strips
        m = middle + shift
        left, right = until[:, m - 2], total - until[:, m]
        clear = ~held[:, m - 1] & ~held[:, m]
        pair = clear & (left >= 3) & (right >= 3)
        alone = (until[:, m - 1] == 0) & (right >= 3) & (right <= settings.slim)
        layout[low] = np.maximum(layout[low], np.where(pair, 2, np.where(alone, 1, 0)))
    flat = np.nonzero(last[j] - first[i] < settings.flat * pace)[0]
    layout[flat[_is_spread(ink.pixels[rows[j[flat]]] - ink.pixels[rows[i[flat]]], settings)]] = 2
    return layout


def _is_spread(pixels: IntArray, settings: SmallSettings) -> BoolArray:
    """(k,) bool: ink that is broader than a character, and thin in the middle. pixels: (k, STRIPS)."""
    middle, side = STRIPS // 2, STRIPS // 4
    broad = pixels[:, :2].any(axis=1) & pixels[:, -2:].any(axis=1)
    beside = (pixels[:, :side].sum(axis=1) + pixels[:, -side:].sum(axis=1)) / (2 * side)
    valley = pixels[:, middle - side // 2 : middle + side // 2 + 1].min(axis=1)
    return np.asarray(broad & (valley < settings.valley * beside))


def _usual_gap(rows: FloatArray, pace: float) -> float:
    """About how much is empty between two characters, in pixels."""
    return min(0.12 * pace, max(1.0, float((rows == 0).mean()) * pace * 0.6))


def _candidates(
    rows: FloatArray, smooth: FloatArray, usual: float, pace: float, settings: RhythmSettings
) -> tuple[FloatArray, FloatArray]:
    """Rows to cut at and what each costs: the middle of empty stretches, and the thinnest rows elsewhere."""
    empty = np.concatenate([[False], rows == 0, [False]])
    edges = np.nonzero(np.diff(empty.astype(np.int8)))[0]
    starts, ends = edges[::2], edges[1::2]
    clear = np.minimum((ends - starts) / pace / settings.clear, 1.0)
    at: list[FloatArray] = [(starts + ends) / 2]
    price: list[FloatArray] = [-settings.gap * clear]
    inner = smooth[1:-1]
    thin = np.nonzero((inner <= smooth[:-2]) & (inner < smooth[2:]) & (rows[1:-1] > 0))[0] + 1
    at.append(thin + 0.5)
    price.append(np.asarray(settings.ink * np.minimum(smooth[thin] / usual, 1.5) + settings.touch))
    places, prices = np.concatenate(at), np.concatenate(price)
    order = np.argsort(places)
    return places[order], prices[order]


@dataclass(frozen=True, slots=True, eq=False)
class CutsByCount:
    """The best cuts of a run for each number of characters.

    cost: (n + 1,), of 0, 1 ... n characters; infinite where it cannot be cut so. before: (n + 1, m), from
    which cut the last character of so many comes.
    """

    cost: FloatArray
    before: IntArray
    at: FloatArray

    def places(self, count: int) -> FloatArray:
        """(count + 1,): the cuts for this number of characters, in rows of the page."""
        k = len(self.at) - 1
        chosen = [k]
        for n in range(count, 0, -1):
            k = int(self.before[n, k])
            chosen.append(k)
        return self.at[chosen[::-1]]


def best_cuts(cuts: Cuts, *, most: int) -> CutsByCount:
    """For each number of characters up to `most`, the cuts that cost least."""
    m = len(cuts.at)
    best = np.full(m, np.inf)
    best[0] = 0.0
    cost, before = [np.inf], [np.zeros(m, dtype=np.intp)]
    for _ in range(most):
        through = best[:, None] + cuts.cost
        origin = np.argmin(through, axis=0)
        best = through[origin, np.arange(m)]
        cost.append(float(best[-1]))
        before.append(origin)
    return CutsByCount(np.array(cost), np.array(before), cuts.at)
