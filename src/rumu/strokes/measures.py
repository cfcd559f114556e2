"""One stroke of a copy against the master's: where it lies, how it is turned, how long and wide it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rumu.strokes.centre_lines import SCALE, CentreLine, CentreLines, FramedInk, pixels_at
from rumu.strokes.ink_differences import UNSEEN, InkDifference
from rumu.strokes.matching import LineMatch
from rumu.strokes.stance import Squeeze
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class StrokeMeasureSettings:
    """What counts as the same stroke, and how it is measured.

    own_ink_reach: stroke widths within which ink is a stroke's own. min_coverage: share of a stroke that must
        be found. max_gap: rms radii that a stroke may be broken where it runs on beyond its end. max_shift:
        rms radii that a stroke may have moved.
    strip_width, strip_spread: half-width of the strip in which it may run on, in stroke widths, and how much
        wider that grows, for each unit of length.
    end_share, min_end_widths, max_end_share: share of a stroke that is its entry, and its exit; at least so
        many stroke widths; at most such a share. middle: shares of a stroke between which its middle lies.
    min_ink: points' worth of ink, away from forks, from which the width at a point is seen.
    same_width: logarithm of a stroke's width up to which the character's width is the master's;
        unchanged_share: share of such strokes from which they alone count.
    smoothing: pixels, along the edge, over which it is smoothed to see what swings about it. min_outline:
        length of an edge from which its swings are measured, in units of that.
    """

    own_ink_reach: float = 0.75
    min_coverage: float = 0.4
    max_gap: float = 0.16
    max_shift: float = 0.75
    strip_width: float = 0.6
    strip_spread: float = 0.3
    end_share: float = 0.15
    min_end_widths: float = 0.8
    max_end_share: float = 0.4
    middle: tuple[float, float] = (0.25, 0.75)
    min_ink: float = 0.2
    same_width: float = 0.09
    unchanged_share: float = 0.3
    smoothing: float = 5.0
    min_outline: float = 6.0


MEASURES = StrokeMeasureSettings()


@dataclass(frozen=True, slots=True, eq=False)
class MatchedStroke:
    """One stroke of the master and what became of it; lean, size and place of the whole taken out.

    line: the master's. weight: its share of all the master's strokes by length. coverage: share of it that
        the copy has. present: False when the copy has next to nothing of it. inked: share of it that lies on
        ink of the copy, be it another stroke's.
    shift: (x right, y DOWN), rms radii. turn: degrees, positive clockwise. length, width: over the master's;
        NaN where it cannot be seen: under a crossing. written_width: the same, the squeeze of its part not
        taken out.
    entry, exit: how much wider the first and the last 15 % are than the middle half, less the same of the
        master, as a share of the master's middle: a stroke that is heavy all along has no heavy ends. NaN at
        an end that joins another stroke. entry_alone, exit_alone: the same of the ends, whatever the middle.
    outline: (n, 2) the stroke on the copy's picture, fractions of it, origin top left; where it should
        stand if it is missing.
    """

    line: CentreLine
    weight: float
    coverage: float
    present: bool
    inked: float
    shift: FloatArray
    turn: float
    length: float
    width: float
    written_width: float
    entry: float
    exit: float
    entry_alone: float
    exit_alone: float
    outline: FloatArray
    ink: InkDifference = UNSEEN


@dataclass(frozen=True, eq=False)
class StrokeMeasurer:
    """Measures the strokes of a copy one by one, once the lines of its master are matched with its own.

    framed, copy: the copy's ink and lines. master: the master's lines. found: where the copy has them.
    covered: (n,) which of the master's points the copy has. owner: (m,) number of the stroke that each of the
    copy's points belongs to, or -1.
    expected: (n, 2) the master's points where the whole character's faults put them. upright: (n, 2) where
    the copy has them, its pose taken out. squeeze: of a part of the copy. aspect: of its pose.
    """

    framed: FramedInk
    copy: CentreLines
    master: CentreLines
    found: LineMatch
    covered: BoolArray
    owner: IntArray
    expected: FloatArray
    upright: FloatArray
    squeeze: Squeeze | None
    aspect: float

    @cached_property
    def scale(self) -> float:
        """Length in the master for one of the copy: its size taken out."""
        spread = [float(np.sqrt(np.var(p, axis=0).sum())) for p in (self.found.moved, self.upright)]
        return spread[1] / max(spread[0], 1e-9)

    @cached_property
    def line_widths(self) -> FloatArray:
        """(n,) half-width of the copy's lines; NaN where strokes cross or nothing is."""
        clear = self.found.responsibility * self.copy.points.clear[None]
        weight = clear.sum(axis=1)
        seen = self.covered & self.master.points.clear & (weight > MEASURES.min_ink)
        return np.where(seen, clear @ self.copy.points.radius / np.maximum(weight, 1e-9), np.nan)

    @cached_property
    def width_ratios(self) -> FloatArray:
        """(n,) half-width of the lines over the master's."""
        return self._to_master_widths(self.line_widths) / self.master.points.radius

    @cached_property
    def ink_widths(self) -> FloatArray:
        """(n,) half-width of the ink, in the master's size; of the widest ink within a pixel.

        Read from the ink and not from its centre lines: thinning draws those short, or forks them, where an
        entry was pressed.
        """
        import cv2

        depth = cv2.distanceTransform(self.framed.ink.view(np.uint8), cv2.DIST_L2, 5)
        widest = cv2.dilate(depth, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
        return self._to_master_widths(np.asarray(widest[pixels_at(self.found.moved)] / SCALE, dtype=float))

    def _to_master_widths(self, widths: FloatArray) -> FloatArray:
        """Half-widths with the copy's size, and the squeeze of a part, taken out."""
        q, points = self.squeeze, self.master.points
        widths = widths * self.scale
        if q is None:
            return np.asarray(widths)
        # a part that is too wide widens its vertical strokes, not its horizontal ones
        k, sign = (0, -1.0) if q.axis == "across" else (1, 1.0)
        stretch = np.where(points.xy[:, k] < q.border, q.first, q.second)
        across = (1.0 + sign * points.double[:, 0]) / 2
        return np.asarray(widths / np.sqrt(across * stretch**2 + (1.0 - across)))

    @cached_property
    def whole_width(self) -> float:
        """Width of the copy's strokes over the master's: the same for all unless most of them differ."""
        lines, owner = self.master.lines, self.master.points.owner
        logs = np.log([_median(self.width_ratios[owner == k]) for k in range(len(lines))])
        weight = np.sqrt([line.length for line in lines])
        seen = np.isfinite(logs)
        if not seen.any():
            return 1.0
        logs, weight = logs[seen], weight[seen]
        same = np.abs(logs) < MEASURES.same_width
        chosen = same if same.mean() > MEASURES.unchanged_share else np.ones_like(same)
        order = np.argsort(logs[chosen])
        below = np.cumsum(weight[chosen][order]) / weight[chosen].sum()
        return float(np.exp(logs[chosen][order][int(np.argmax(below >= 0.5))]))

    def radii(self) -> FloatArray:
        """(n,) the copy's half-width at each of the master's points, or what it should be."""
        usual = self.whole_width / self.scale * self.master.points.radius
        return np.where(np.isfinite(self.line_widths), self.line_widths, usual)

    def stroke(self, k: int) -> MatchedStroke:
        """How the copy differs in the stroke of number k."""
        points, line = self.master.points, self.master.lines[k]
        own = np.flatnonzero(points.owner == k)
        want, have = self.expected[own], self.upright[own]
        coverage, shift = float(self.covered[own].mean()), (have - want).mean(axis=0)
        present = coverage >= MEASURES.min_coverage and float(np.hypot(*shift)) < MEASURES.max_shift
        ends = _end_widening(self.ink_widths[own], points.radius[own], line, self.master.width)
        total = max(len(points.xy) * points.spacing, 1e-9)
        moved = self.found.moved[own]
        return MatchedStroke(
            line=line,
            weight=line.length / total,
            coverage=coverage,
            present=present,
            inked=float(self.framed.ink[pixels_at(moved)].mean()),
            shift=shift,
            turn=_turn(want, have),
            length=self._length(k, own) / max(_length(want), 1e-9) if len(own) > 1 else 1.0,
            width=_median(self.width_ratios[own]),
            written_width=_median(self.line_widths[own] * self.scale / points.radius[own]),
            entry=ends[0],
            exit=ends[1],
            entry_alone=ends[2],
            exit_alone=ends[3],
            outline=self.framed.on_picture(moved),
        )

    def _length(self, k: int, own: IntArray) -> float:
        """Length of the copy's stroke in the master's size: the covered part and what extends beyond it."""
        at = np.flatnonzero(self.covered[own])
        if len(at) < 2:
            return 0.0
        line, size = self.found.moved[own][at[0] : at[-1] + 1], self._size
        total = _length(line * size)
        unclaimed = self.copy.points.xy[(self.owner == k) | (self.owner < 0)]
        for end, way in (
            (line[0], line[0] - line[min(3, len(line) - 1)]),
            (line[-1], line[-1] - line[max(len(line) - 4, 0)]),
        ):
            length = math.hypot(*way)
            if length >= 1e-9:
                total += self._extension(unclaimed - end, way / length) * math.hypot(*(way * size)) / length
        return total

    @cached_property
    def _size(self) -> FloatArray:
        """(2,) length in the master for one of the copy, across and down."""
        return np.asarray(self.scale * np.exp(np.array([-0.5, 0.5]) * self.aspect))

    def _extension(self, unclaimed: FloatArray, way: FloatArray) -> float:
        """How far ink, (n, 2) from the end of a stroke, extends beyond it; way: (2,) of unit length."""
        along, aside = unclaimed @ way, np.abs(unclaimed @ np.array([-way[1], way[0]]))
        strip = MEASURES.strip_width * self.copy.width + MEASURES.strip_spread * along
        reached = 0.0
        for step in np.sort(along[(along > 0) & (aside < strip)]):
            if step - reached > MEASURES.max_gap:
                break
            reached = float(step)
        return reached


def _end_widening(
    ink: FloatArray, radius: FloatArray, line: CentreLine, width: float
) -> tuple[float, float, float, float]:
    """How much wider a stroke's entry and exit are than its middle, and how wide they are by themselves.

    In half-widths of the master's middle.
    """
    along = np.linspace(0.0, 1.0, len(ink))
    first, last = MEASURES.middle
    middle = (along >= first) & (along <= last)
    if not middle.any():
        return (float("nan"),) * 4
    share = MEASURES.min_end_widths * width / max(line.length, 1e-9)
    share = min(max(share, MEASURES.end_share), MEASURES.max_end_share)
    usual_radius = radius[middle].mean()
    entry, exit = (
        float(ink[part].mean() / usual_radius) if free else float("nan")
        for part, free in zip((along <= share, along >= 1.0 - share), line.free, strict=True)
    )
    usual = float(ink[middle].mean() / usual_radius)
    return entry - usual, exit - usual, entry, exit


def _median(values: FloatArray) -> float:
    """Median of the finite values; NaN where there is none."""
    seen = np.sort(values[np.isfinite(values)])  # of few values: `np.median` takes six times as long
    half = len(seen) // 2
    if not len(seen):
        return float("nan")
    return float(seen[half] if len(seen) % 2 else (seen[half - 1] + seen[half]) / 2)


def _turn(want: FloatArray, have: FloatArray) -> float:
    """Degrees, clockwise on the page, that best turn the one run of points to the other."""
    a, b = want - want.mean(axis=0), have - have.mean(axis=0)
    if len(a) < 2:
        return 0.0
    return float(np.degrees(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())))


def _length(points: FloatArray) -> float:
    """Length of the line through (n, 2) points."""
    return float(np.hypot(*(points[1:] - points[:-1]).T).sum())


def edge_tremor(framed: FramedInk) -> float:
    """Median deviation of the edge from its smoothed curve, in pixels.

    The median, so that tips and corners, which any smoothing moves, do not count.
    """
    import cv2
    from scipy.ndimage import gaussian_filter1d

    edges, _ = cv2.findContours(framed.ink.view(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    swings, smoothing = [], MEASURES.smoothing
    for edge in edges:
        line = edge[:, 0, :].astype(float)
        if len(line) > MEASURES.min_outline * smoothing:
            fine, coarse = (
                gaussian_filter1d(line, s, axis=0, mode="wrap") for s in (1.0, MEASURES.smoothing)
            )
            way = np.roll(coarse, -1, axis=0) - np.roll(coarse, 1, axis=0)
            way /= np.maximum(np.hypot(*way.T), 1e-9)[:, None]
            off = fine - coarse
            swings.append(np.abs(off[:, 0] * way[:, 1] - off[:, 1] * way[:, 0]))
    return float(np.median(np.concatenate(swings))) if swings else 0.0
