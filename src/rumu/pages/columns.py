"""Columns of writing: ridges of ink that run down the page, straight or bent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rumu.pages.page_layout import PartingLine, parting_lines
from rumu.pages.page_parts import PageParts
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class ColumnSettings:
    """How columns are told; lengths in sizes of a character, shares of the pitch where it says so.

    grain: pixels that a character measures where ridges are followed. across, along: standard deviations
    of the blur under which a column is a ridge. neighbourhood: how far a stronger ridge drowns a weaker
    one. ridge: share of the strongest ink beside it that a ridge has at least. ink: the least ink of a
    ridge. joined: how far the pieces of one column may lie beside each other. reach: how far from the
    middle of its column a part of a character lies at most, as a share of the pitch. own: share of a
    part that one column must hold to get all of it. beside: from where on a part stands beside its
    column, as a share of half its breadth. outside: the most columns of a heading outside of the frame.
    ruled: how many lines each column has where columns are ruled. follows: how far from the next a
    column beyond the last line stands at most, as a share of the pitch. fold: how wide, as a share of a
    usual strip, the strip at the fold of a leaf is at most. ornament: how near to both lines of a corner
    its ornament lies. thin: how thick the rest of a line is.
    """

    grain: float = 12.0
    across: float = 0.15
    along: float = 1.3
    neighbourhood: float = 0.7
    ridge: float = 0.5
    ink: float = 0.06
    joined: float = 0.4
    reach: float = 0.62
    own: float = 0.8
    beside: float = 1.05
    outside: int = 2
    ruled: float = 0.6
    follows: float = 1.3
    fold: float = 0.82
    ornament: float = 0.3
    thin: float = 0.25


@dataclass(frozen=True, slots=True)
class Ridge:
    """Where a column runs: its middle as a polynomial x(y), and its ends."""

    curve: tuple[float, ...]
    top: float
    bottom: float

    def at(self, y: FloatArray | float) -> FloatArray:
        """The middle of the column at these heights."""
        return np.asarray(np.polyval(self.curve, np.asarray(y, dtype=float)))


@dataclass(frozen=True, eq=False)
class Column:
    """A column and its ink.

    ridge: where it runs. y, offset: (k,) of each pixel of its ink, the height on the page and how far it
    lies to the right of the column's middle. part: (k,) the number of the connected part it belongs to.
    pitch: distance to the next column, in pixels.
    """

    ridge: Ridge
    y: IntArray
    offset: FloatArray
    part: IntArray
    pitch: float

    @cached_property
    def breadth(self) -> float:
        """How broad its characters are, in pixels."""
        low, high = np.quantile(self.offset, [0.03, 0.97])
        return float(high - low)

    @cached_property
    def extent(self) -> tuple[int, int]:
        """The first row with ink and the one after the last."""
        return int(self.y.min()), int(self.y.max()) + 1

    @property
    def density(self) -> float:
        """Pixels of ink on a row."""
        return len(self.y) / self.length

    @property
    def length(self) -> int:
        """From the first ink to the last, in pixels."""
        return self.extent[1] - self.extent[0]


def find_columns(parts: PageParts, *, settings: ColumnSettings | None = None) -> list[list[Column]]:
    """The columns of each register: registers from top to bottom, columns from right to left.

    Headings beyond the frame are left out; notes, ornaments and page numbers may still be among them, see
    `rumu.pages.furniture`.
    """
    settings = settings or ColumnSettings()
    registers = []
    for chosen, across in _bands(parts) if len(parts.boxes) else []:
        columns = _columns_of_band(parts, chosen, across, settings)
        if columns:
            registers.append(columns)
    return registers


def _bands(parts: PageParts) -> list[tuple[BoolArray, list[PartingLine]]]:
    """For each strip of the page between lines that cross it: (n,) bool, the parts in it, and those lines."""
    middles = (parts.boxes[:, :2] + parts.boxes[:, 2:]) / 2
    extent = np.quantile(middles[:, 0], [0.03, 0.97])
    lines = parting_lines(parts.lines, size=parts.size, extent=(extent[0], extent[1]))
    lines.sort(key=lambda line: float(line.at(extent.mean())))
    band = np.zeros(len(middles), dtype=np.intp)
    for line in lines:
        band += middles[:, 1] > line.at(middles[:, 0])
    return [(band == k, lines[max(k - 1, 0) : k + 1]) for k in range(len(lines) + 1) if (band == k).any()]


def _columns_of_band(
    parts: PageParts, chosen: BoolArray, across: list[PartingLine], settings: ColumnSettings
) -> list[Column]:
    top, bottom = int(parts.boxes[chosen, 1].min()), int(parts.boxes[chosen, 3].max())
    down = parting_lines(
        np.ascontiguousarray(parts.lines[top:bottom].T), size=parts.size, extent=(0, bottom - top)
    )
    down = [_moved(line, top) for line in down]
    chosen = chosen & ~_at_corners(parts, chosen, across, down, settings)
    labels = parts.labels[top:bottom]
    ink = np.concatenate([[False], chosen])[labels]
    ridges = [_moved_down(ridge, top) for ridge in _find_ridges(ink, parts.size, settings)]
    if not ridges:
        return []
    ridges = _join(ridges, parts.size, settings)
    inside = _inside_frame(ridges, down, settings)
    columns = _share_ink(ridges, np.where(ink, labels, 0), top, parts.size, settings)
    return [column for column, within in zip(columns, inside, strict=True) if column is not None and within]


def _at_corners(
    parts: PageParts,
    chosen: BoolArray,
    across: list[PartingLine],
    down: list[PartingLine],
    settings: ColumnSettings,
) -> BoolArray:
    """(n,) bool: ornaments in the corners of the frame, which touch both of its lines, and rests of lines."""
    left, top, right, bottom = parts.boxes.T
    x, y = (left + right) / 2, (top + bottom) / 2
    near, thin = settings.ornament * parts.size, settings.thin * parts.size
    beside = np.zeros(len(x), dtype=bool)
    rest = np.zeros(len(x), dtype=bool)
    for line in across:
        at = line.at(x)
        beside |= (top - near < at) & (at < bottom + near)
        rest |= (bottom - top < thin) & (np.abs(y - at) < near)
    touching = np.zeros(len(x), dtype=bool)
    for line in down:
        at = line.at(y)
        touching |= (left - near < at) & (at < right + near)
        rest |= (right - left < thin) & (np.abs(x - at) < near)
    return np.asarray(chosen & (rest | (beside & touching)))


def _moved(line: PartingLine, along: float) -> PartingLine:
    """The line where its places are counted from a point so much earlier."""
    return PartingLine(tuple(np.poly1d(line.curve)(np.poly1d([1.0, -along])).coeffs.tolist()))


def _moved_down(ridge: Ridge, down: int) -> Ridge:
    """The ridge, moved down by this many pixels."""
    shifted = np.poly1d(ridge.curve)(np.poly1d([1.0, -down]))
    return Ridge(tuple(shifted.coeffs.tolist()), ridge.top + down, ridge.bottom + down)


def _find_ridges(ink: BoolArray, size: float, settings: ColumnSettings) -> list[Ridge]:
    """Ridges of the ink blurred down the page, from right to left."""
    import cv2

    factor = min(1.0, settings.grain / size)
    grain = size * factor
    shape = tuple(max(1, round(side * factor)) for side in ink.shape[::-1])
    small = cv2.resize(ink.astype(np.float32), shape, interpolation=cv2.INTER_AREA)
    border = round(2 * settings.along * grain)
    small = cv2.copyMakeBorder(small, border, border, 0, 0, cv2.BORDER_CONSTANT, value=0)
    dense = cv2.GaussianBlur(
        small, (0, 0), sigmaX=settings.across * grain, sigmaY=settings.along * grain,
        borderType=cv2.BORDER_CONSTANT,
    )  # fmt: skip
    side = 2 * round(settings.neighbourhood * grain) + 1
    strongest = cv2.dilate(dense, np.ones((1, side), np.uint8))
    mask = (dense > settings.ridge * strongest) & (dense > settings.ink)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=4)
    y, x = np.nonzero(labels)
    number, weight = labels[y, x], dense[y, x].astype(float)
    ridges = []
    for k in range(1, count):
        own = number == k
        height = stats[k, cv2.CC_STAT_HEIGHT]
        degree = 2 if height > 8 * grain else 1 if height > 4 * grain else 0
        rows = np.bincount(y[own], weight[own])
        middles = np.bincount(y[own], weight[own] * x[own]) / np.maximum(rows, 1e-9)
        at = np.nonzero(rows)[0]
        curve = np.polyfit(
            (at + 0.5 - border) / factor, (middles[at] + 0.5) / factor, degree, w=np.sqrt(rows[at])
        )
        top = (stats[k, cv2.CC_STAT_TOP] - border) / factor
        ridges.append(Ridge(tuple(curve.tolist()), top, top + height / factor))
    return ridges


def _middle(ridge: Ridge) -> float:
    return float(ridge.at((ridge.top + ridge.bottom) / 2))


def _join(ridges: list[Ridge], size: float, settings: ColumnSettings) -> list[Ridge]:
    """Pieces of one column made one, from right to left."""
    joined: list[Ridge] = []
    for ridge in sorted(ridges, key=lambda one: one.top - one.bottom):  # the longest first
        for k, other in enumerate(joined):
            overlap = min(ridge.bottom, other.bottom) - max(ridge.top, other.top)
            where = (ridge.top + ridge.bottom) / 2
            if (
                overlap < 1.5 * size
                and abs(float(other.at(where) - ridge.at(where))) < settings.joined * size
            ):
                joined[k] = replace(
                    other, top=min(ridge.top, other.top), bottom=max(ridge.bottom, other.bottom)
                )
                break
        else:
            joined.append(ridge)
    return sorted(joined, key=_middle, reverse=True)


def _inside_frame(ridges: list[Ridge], lines: list[PartingLine], settings: ColumnSettings) -> list[bool]:
    """Which columns stand within the frame: a heading outside of it is one or two columns beyond a line."""
    block = [sum(float(line.at((r.top + r.bottom) / 2)) < _middle(r) for line in lines) for r in ridges]
    sizes = {b: block.count(b) for b in set(block)}
    largest = max(sizes.values())
    if largest <= 2 * settings.outside:  # a line beside every column, or hardly any text
        return _between_rules(ridges, lines, settings)
    return [sizes[b] > settings.outside for b in block]


def _between_rules(ridges: list[Ridge], lines: list[PartingLine], settings: ColumnSettings) -> list[bool]:
    """Which columns stand in a strip between two ruled lines, and not in the narrow one at a leaf's fold.

    A column beyond the last line counts where it follows the others at their distance.
    """
    if len(lines) < settings.ruled * len(ridges) or len(ridges) <= 2 * settings.outside:
        return [True] * len(ridges)
    height = [(ridge.top + ridge.bottom) / 2 for ridge in ridges]
    middles = np.array([_middle(ridge) for ridge in ridges])
    usual = float(np.median(np.abs(np.diff(middles))))
    widths = np.full(len(ridges), np.nan)
    for k, y in enumerate(height):
        at = np.sort([float(line.at(y)) for line in lines])
        right = int(np.searchsorted(at, middles[k]))
        if 0 < right < len(at):
            widths[k] = at[right] - at[right - 1]
    strip = float(np.nanmedian(widths)) if np.isfinite(widths).any() else np.inf
    near = np.array([np.abs(np.delete(middles, k) - middles[k]).min() for k in range(len(ridges))])
    beyond = np.isnan(widths)
    keep = np.where(beyond, near < settings.follows * usual, widths > settings.fold * strip)
    return [bool(one) for one in keep]


def _share_ink(
    ridges: list[Ridge], labels: IntArray, top: int, size: float, settings: ColumnSettings
) -> list[Column | None]:
    """Each column with its ink: a part goes to one column where most of it lies there."""
    y, x = np.nonzero(labels)
    number, y = labels[y, x], y + top
    heights = np.arange(y.min(), y.max() + 1)
    middles = np.stack([ridge.at(heights) for ridge in ridges])
    pitch = column_pitch(ridges, size)
    for k, ridge in enumerate(ridges):
        middles[k, (heights < ridge.top - size / 2) | (heights > ridge.bottom + size / 2)] = np.inf
    offsets = x - middles[:, y - heights[0]]
    nearest = np.argmin(np.abs(offsets), axis=0)
    owner = _owners(number, nearest, len(ridges), settings)
    offset = offsets[owner, np.arange(len(x))]
    kept = _near_column(number, offset, settings.reach * pitch)
    columns: list[Column | None] = []
    for k, ridge in enumerate(ridges):
        own = kept & (owner == k)
        own[own] = ~_beyond(offset[own], number[own], settings)
        columns.append(Column(ridge, y[own], offset[own], number[own], pitch) if own.sum() > 8 else None)
    return columns


def _owners(number: IntArray, nearest: IntArray, count: int, settings: ColumnSettings) -> IntArray:
    """(k,): the column of each pixel, that of the whole part where nearly all of it is nearest to one."""
    parts = int(number.max()) + 1
    votes = np.bincount(number * count + nearest, minlength=parts * count).reshape(parts, count)
    winner, total = votes.argmax(axis=1), votes.sum(axis=1)
    clear = votes.max(axis=1) > settings.own * total
    return np.where(clear[number], winner[number], nearest)


def _near_column(number: IntArray, offset: FloatArray, reach: float) -> BoolArray:
    """(k,) bool: pixels of parts whose middle lies within reach of their column."""
    finite = np.where(np.isfinite(offset), offset, 1e9)
    total = np.maximum(np.bincount(number), 1)
    middle = np.bincount(number, finite) / total
    return np.abs(middle[number]) < reach


def _beyond(offset: FloatArray, number: IntArray, settings: ColumnSettings) -> BoolArray:
    """(k,) bool: pixels of parts that lie beside the column as a whole, such as a note in the margin."""
    if not len(offset):
        return np.zeros(0, dtype=bool)
    side = float(np.quantile(np.abs(offset), 0.97))
    inner = np.full(int(number.max()) + 1, np.inf)
    np.minimum.at(inner, number, np.abs(offset))
    return np.asarray(inner[number] > settings.beside * side)


def column_pitch(ridges: list[Ridge], size: float) -> float:
    """The usual distance between neighbouring columns, in pixels."""
    longest = max(ridge.bottom - ridge.top for ridge in ridges)
    long = sorted(_middle(ridge) for ridge in ridges if ridge.bottom - ridge.top > longest / 2)
    steps = np.diff(long)
    steps = steps[steps > 0.7 * size]
    return float(np.quantile(steps, 0.4)) if len(steps) else 1.4 * size
