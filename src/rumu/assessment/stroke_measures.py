"""One stroke of a sheet against the master's: where it lies, how it is turned, how long and wide it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.assessment.lines import Drawing, Line
from rumu.assessment.matching import Match
from rumu.assessment.pose import Squeeze
from rumu.assessment.sheets import RADIUS, SIDE, Sheet, pixels
from rumu.values import BoolArray, FloatArray, IntArray

END = 0.15
"""Share of a stroke that is its entry, and its exit."""
_SWING = 5.0
"""Pixels of a sheet, along the edge, over which it is smoothed to see what swings about it."""


@dataclass(frozen=True, slots=True)
class StrokeSettings:
    """What counts as the same stroke.

    near: stroke widths within which ink is a stroke's own. present: share of a stroke that must be found.
    gap: rms radii that a stroke may be broken. most: rms radii that a stroke may have moved.
    """

    near: float = 0.75
    present: float = 0.4
    gap: float = 0.16
    most: float = 0.75


@dataclass(frozen=True, slots=True, eq=False)
class StrokeFound:
    """One stroke of the master and what became of it; lean, size and place of the whole taken out.

    line: the master's. weight: its share of all the master's strokes by length. coverage: share of it that
        the copy has. present: False when the copy has next to nothing of it. inked: share of it that lies on
        ink of the copy, be it another stroke's.
    shift: (x right, y DOWN), rms radii. turn: degrees, positive clockwise. length, width: over the master's;
        NaN where it cannot be seen: under a crossing.
    entry, exit: how much wider the first and the last 15 % are than the middle half, less the same of the
        master, as a share of the master's middle: a stroke that is heavy all along has no heavy ends. NaN at
        an end that joins another stroke.
    outline: (n, 2) the stroke on the copy's picture, fractions of it, origin top left; where it should
        stand if it is missing.
    """

    line: Line
    weight: float
    coverage: float
    present: bool
    inked: float
    shift: FloatArray
    turn: float
    length: float
    width: float
    entry: float
    exit: float
    outline: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """All that is known of one sheet against a master's, to be read stroke by stroke.

    expected: (n, 2) the master's points where the whole character's faults put them. upright: (n, 2) where
    the copy has them, its pose taken out. widths: (n,) half-widths of the copy's lines on its sheet;
    breadths: (n,) of its ink there.
    """

    sheet: Sheet
    mine: Drawing
    model: Drawing
    settings: StrokeSettings
    moved: FloatArray
    covered: BoolArray
    owner: IntArray
    expected: FloatArray
    upright: FloatArray
    squeeze: Squeeze | None
    widths: FloatArray
    breadths: FloatArray

    @property
    def total(self) -> float:
        """Length of all the master's strokes."""
        return float(len(self.model.points.xy) * self.model.points.spacing)

    @property
    def scale(self) -> float:
        """Master's measure for one of the sheet's: the copy's size taken out."""
        spread = [float(np.sqrt(np.var(p, axis=0).sum())) for p in (self.moved, self.upright)]
        return spread[1] / max(spread[0], 1e-9)

    @property
    def ratio(self) -> FloatArray:
        """(n,) half-width of the lines over the master's."""
        return self._in_the_masters_measure(self.widths) / self.model.points.radius

    @property
    def ink(self) -> FloatArray:
        """(n,) half-width of the ink in the master's measure."""
        return self._in_the_masters_measure(self.breadths)

    def _in_the_masters_measure(self, widths: FloatArray) -> FloatArray:
        q, double = self.squeeze, self.model.points.double
        widths = widths * self.scale
        if q is None:
            return np.asarray(widths)
        # a part made wide makes its standing strokes wide, and leaves the lying ones
        k, sign = (0, -1.0) if q.axis == "across" else (1, 1.0)
        stretch = np.where(self.model.points.xy[:, k] < q.parting, q.first, q.second)
        across = (1.0 + sign * double[:, 0]) / 2
        return np.asarray(widths / np.sqrt(across * stretch**2 + (1.0 - across)))

    @property
    def whole(self) -> float:
        """Width of the copy's strokes over the master's: the same for all unless most of them differ."""
        ratio = self.ratio
        count = len(self.model.lines)
        logs = np.log([_median(ratio[self.model.points.owner == k]) for k in range(count)])
        weight = np.sqrt([line.length for line in self.model.lines])
        seen = np.isfinite(logs)
        if not seen.any():
            return 1.0
        logs, weight = logs[seen], weight[seen]
        same = np.abs(logs) < 0.09
        chosen = same if same.mean() > 0.3 else np.ones_like(same)
        order = np.argsort(logs[chosen])
        below = np.cumsum(weight[chosen][order]) / weight[chosen].sum()
        return float(np.exp(logs[chosen][order][int(np.argmax(below >= 0.5))]))

    def stroke(self, k: int, ratios: FloatArray, ink: FloatArray) -> StrokeFound:
        model, line = self.model, self.model.lines[k]
        own = np.flatnonzero(model.points.owner == k)
        want, have = self.expected[own], self.upright[own]
        coverage, shift = float(self.covered[own].mean()), (have - want).mean(axis=0)
        entry, exit = _swelling(ink[own], model.points.radius[own], line, model.width)
        to_picture = self.sheet.to_picture
        return StrokeFound(
            line=line,
            weight=line.length / max(self.total, 1e-9),
            coverage=coverage,
            present=coverage >= self.settings.present and float(np.hypot(*shift)) < self.settings.most,
            inked=self._inked(own),
            shift=shift,
            turn=_turn(want, have),
            length=self._length(k, own) / max(_length(want), 1e-9) if len(own) > 1 else 1.0,
            width=_median(ratios[own]),
            entry=entry,
            exit=exit,
            outline=self.moved[own] @ to_picture[:, :2].T + to_picture[:, 2],
        )

    def _inked(self, own: IntArray) -> float:
        column, row = np.clip(np.round(pixels(self.moved[own])).astype(int), 0, SIDE - 1).T
        return float(self.sheet.ink[row, column].mean())

    def _length(self, k: int, own: IntArray) -> float:
        """Of the copy's stroke, in the master's measure: what is covered, and what runs on beyond."""
        at = np.flatnonzero(self.covered[own])
        if len(at) < 2:
            return 0.0
        line = self.moved[own][at[0] : at[-1] + 1]
        inner = float(np.hypot(*np.diff(line, axis=0).T).sum())
        beyond = self._beyond(k, line[0], line[0] - line[min(3, len(line) - 1)])
        beyond += self._beyond(k, line[-1], line[-1] - line[max(len(line) - 4, 0)])
        return (inner + beyond) * self.scale

    def _beyond(self, k: int, end: FloatArray, way: FloatArray) -> float:
        """How far the stroke's own ink runs on from an end."""
        length = float(np.hypot(*way))
        if length < 1e-9:
            return 0.0
        way = way / length
        free = self.mine.points.xy[(self.owner == k) | (self.owner < 0)] - end
        along, aside = free @ way, np.abs(free @ np.array([-way[1], way[0]]))
        ahead = np.sort(along[(along > 0) & (aside < 0.6 * self.mine.width + 0.3 * along)])
        reached = 0.0
        for step in ahead:
            if step - reached > self.settings.gap:
                break
            reached = float(step)
        return reached


def _ends(along: FloatArray, line: Line, width: float) -> tuple[BoolArray, BoolArray]:
    """The entry and the exit: 15 % of a stroke, and at least most of its width."""
    share = float(np.clip(0.8 * width / max(line.length, 1e-9), END, 0.4))
    return along <= share, along >= 1.0 - share


def _swelling(ink: FloatArray, radius: FloatArray, line: Line, width: float) -> tuple[float, float]:
    """How much wider a stroke's entry and exit are than its middle, in half-widths of the master's middle."""
    along = np.linspace(0.0, 1.0, len(ink))
    middle = (along >= 0.25) & (along <= 0.75)
    if not middle.any():
        return float("nan"), float("nan")
    entry, exit = (
        float((ink[part].mean() - ink[middle].mean()) / radius[middle].mean()) if free else float("nan")
        for part, free in zip(_ends(along, line, width), line.free, strict=True)
    )
    return entry, exit


def _median(values: FloatArray) -> float:
    seen = values[np.isfinite(values)]
    return float(np.median(seen)) if len(seen) else float("nan")


def _turn(want: FloatArray, have: FloatArray) -> float:
    """Degrees, clockwise on the page, that best turn the one run of points to the other."""
    a, b = want - want.mean(axis=0), have - have.mean(axis=0)
    if len(a) < 2:
        return 0.0
    return float(np.degrees(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())))


def _length(points: FloatArray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def half_widths(found: Match, copy: Drawing, master: Drawing, covered: BoolArray) -> FloatArray:
    """(n,) half-width of the copy at the master's points; NaN where strokes cross or nothing is."""
    clear = found.share * copy.points.clear[None]
    weight = clear.sum(axis=1)
    seen = covered & master.points.clear & (weight > 0.2)
    value = clear @ copy.points.radius / np.maximum(weight, 1e-9)
    return np.where(seen, value, np.nan)


def breadths(sheet: Sheet, points: FloatArray) -> FloatArray:
    """(n,) rms radii: half-width of the widest ink within a pixel of points (n, 2) of the frame.

    Read from the ink and not from its centre lines: thinning draws those short, or forks them, where an
    entry was pressed.
    """
    import cv2

    depth = cv2.distanceTransform(sheet.ink.view(np.uint8), cv2.DIST_L2, 5)
    widest = cv2.dilate(depth, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
    column, row = np.clip(np.round(pixels(points)).astype(int), 0, SIDE - 1).T
    return np.asarray(widest[row, column] / RADIUS, dtype=float)


def edge_tremor(sheet: Sheet) -> float:
    """Pixels by which the edge swings about its own smoothed line, at a place like most places.

    The median, so that tips and corners, which leave any smoothed line, do not count.
    """
    import cv2
    from scipy.ndimage import gaussian_filter1d

    edges, _ = cv2.findContours(sheet.ink.view(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    swings = []
    for edge in edges:
        line = edge[:, 0, :].astype(float)
        if len(line) > 6 * _SWING:
            fine, coarse = (gaussian_filter1d(line, s, axis=0, mode="wrap") for s in (1.0, _SWING))
            way = np.roll(coarse, -1, axis=0) - np.roll(coarse, 1, axis=0)
            way /= np.maximum(np.hypot(*way.T), 1e-9)[:, None]
            off = fine - coarse
            swings.append(np.abs(off[:, 0] * way[:, 1] - off[:, 1] * way[:, 0]))
    return float(np.median(np.concatenate(swings))) if swings else 0.0
