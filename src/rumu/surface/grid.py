"""Printed grids, gray or black: found by their straight thin lines, and taken off the page.

米字格, 田字格, 九宫格, 回宫格, 方格. A line of a grid is straight, has one width and one gray from end to
end, is far thinner than a brush stroke, and ends at another line or at the side of the picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.capture.image import Bytes, shrink
from rumu.surface.paper import PAPER_GRAY
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class GridLineSettings:
    """When dark lines are a printed grid. Lengths are shares of the picture's shorter side unless said.

    least: shorter side, in pixels, of a picture on which lines are sought: on a smaller one, a character of a
        page, lines of a pixel are as wide as strokes.
    side: longer side, in pixels, of the reduced picture on which lines are sought. thickness: of the widest
        line. contrast: least darkness of a line, in gray levels of 200 for the paper. pixels: fewest of its
        pixels, over the side, for a look at all.
    votes: pixels on a straight line, over the side, from which it is looked at; most: lines looked at.
    apart: distance up to which two are one line. sway: how far the line found first may lie beside the true
        one. bow: how far it may bend.
    straight: usual distance from its own curve, in reduced pixels. cover: share of the places along it, where
        it is not under ink, that show it; dashes are half. length: of the shortest. gap: of the longest blank
        between its pieces.
    even: usual difference of its gray from place to place, as a share of its darkness.
    end: distance from another line, or the picture's side, within which it must end.
    square: degrees by which lines that cross may differ from a right angle.
    soft: pixels by which a line's edge is blurred, beyond its width. lighter: gray levels by which it must be
        lighter than the ink for its own gray to tell it from ink.
    """

    least: int = 64
    side: int = 512
    thickness: float = 0.016
    contrast: int = 14
    pixels: float = 0.6
    votes: float = 0.2
    most: int = 48
    apart: float = 0.02
    sway: float = 0.01
    bow: float = 0.01
    straight: float = 0.6
    cover: float = 0.4
    length: float = 0.22
    gap: float = 0.07
    even: float = 0.3
    end: float = 0.03
    square: float = 12.0
    soft: float = 1.2
    lighter: float = 30.0


@dataclass(frozen=True, slots=True, eq=False)
class GridLine:
    """One line of a grid.

    path: (N, 2) its middle (column, row), in pixels. width: in pixels. gray: its level.
    """

    path: FloatArray
    width: float
    gray: float

    @property
    def direction(self) -> FloatArray:
        """(2,) from its first to its last point, of unit length."""
        run = self.path[-1] - self.path[0]
        return np.asarray(run / max(float(np.hypot(*run)), 1e-6))


def remove_grid(x: Bytes, *, settings: GridLineSettings | None = None) -> tuple[Bytes, int]:
    """The page without its printed grid, and how many pixels its lines covered; the page itself without one.

    x: (H, W) uint8, ratio to the paper, PAPER_GRAY on paper and 0 for black.
    """
    import cv2

    settings = settings or GridLineSettings()
    if min(x.shape) < settings.least:
        return x, 0
    small = shrink(x, side=settings.side)
    reach = 2 * round(settings.thickness * min(small.shape) / 2) + 3
    closed = cv2.morphologyEx(small, cv2.MORPH_CLOSE, np.ones((reach, reach), np.uint8))
    thin = np.asarray(cv2.subtract(closed, small) > settings.contrast)
    if np.count_nonzero(thin) < settings.pixels * min(small.shape):
        return x, 0
    lines = _find_lines(x, thin, settings)
    if not lines:
        return x, 0
    thick = closed < PAPER_GRAY / 2
    written = np.count_nonzero(thick) > settings.pixels * min(small.shape)
    ink = float(np.median(small[thick]) if written else small.min())
    return _without(x, lines, ink, settings)


# --- finding ---------------------------------------------------------------------------------------


def _find_lines(x: Bytes, thin: BoolArray, settings: GridLineSettings) -> list[GridLine]:
    """Lines that are a grid together: each ends at another or at the picture's side, and two cross."""
    lines: list[GridLine] = []
    near = settings.end * min(x.shape)
    for start, stop in _candidates(thin, settings):
        line = _trace(x, start, stop, settings)
        if line is not None and not any(_covers(other, line, near) for other in lines):
            lines.append(line)
    while True:
        kept = [
            line for line in lines if _ends_well(line, [o for o in lines if o is not line], x.shape, near)
        ]
        if len(kept) == len(lines):
            break
        lines = kept
    least = float(np.sin(np.deg2rad(settings.square)))
    crossing = any(abs(float(a.direction @ b.direction)) < least for a in lines for b in lines)
    return lines if crossing else []


def _candidates(thin: BoolArray, settings: GridLineSettings) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Where straight lines enter and leave the picture, in shares of (width, height), the clearest first."""
    import cv2

    height, width = thin.shape
    votes = max(20, round(settings.votes * min(thin.shape)))
    found = cv2.HoughLines(thin.astype(np.uint8), 1, np.pi / 360, votes)
    if found is None:
        return
    size, apart = np.array([width - 1.0, height - 1.0]), settings.apart * min(thin.shape)
    chosen: list[tuple[FloatArray, FloatArray]] = []
    for rho, theta in found[:, 0][:2000]:
        ends = _chord(float(rho), float(theta), size)
        if ends is None or any(_same(ends, other, apart) for other in chosen):
            continue
        chosen.append(ends)
        yield ends[0] / size, ends[1] / size
        if len(chosen) == settings.most:
            return


def _covers(line: GridLine, part: GridLine, near: float) -> bool:
    """Whether a line lies along another from end to end."""
    return all(np.hypot(*(line.path - end).T).min() < near for end in (part.path[0], part.path[-1]))


def _chord(rho: float, theta: float, size: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """The two points at which x cos(theta) + y sin(theta) = rho meets the sides of the picture."""
    normal = np.array([np.cos(theta), np.sin(theta)])
    along, on = np.array([-normal[1], normal[0]]), rho * normal
    low, high = -np.inf, np.inf
    for k in range(2):
        if abs(along[k]) < 1e-9:
            if not -1.0 <= on[k] <= size[k] + 1.0:
                return None
            continue
        a, b = sorted(((0.0 - on[k]) / along[k], (size[k] - on[k]) / along[k]))
        low, high = max(low, a), min(high, b)
    return (on + low * along, on + high * along) if high > low else None


def _same(a: tuple[FloatArray, FloatArray], b: tuple[FloatArray, FloatArray], apart: float) -> bool:
    straight = max(float(np.abs(a[k] - b[k]).max()) for k in range(2))
    crossed = max(float(np.abs(a[k] - b[1 - k]).max()) for k in range(2))
    return min(straight, crossed) < apart


def _trace(x: Bytes, start: FloatArray, stop: FloatArray, settings: GridLineSettings) -> GridLine | None:
    """The printed line near a straight one, from where it begins to where it ends; None if there is none."""
    side = min(x.shape)
    size = np.array([x.shape[1] - 1.0, x.shape[0] - 1.0])
    a, b = start * size, stop * size
    length = float(np.hypot(*(b - a)))
    if length < settings.length * side:
        return None
    step = max(1.0, side / settings.side)  # pixels of the page for one of what is looked at
    count = int(length / step)
    along = (b - a) / length
    normal = np.array([-along[1], along[0]])
    middle = a + np.linspace(0.0, length, count)[:, None] * along
    wide = settings.thickness * side / step
    strip = _strip(x, middle, normal, round(settings.sway * side / step + wide) + 2, step)
    offset, shown, _ = _read_strip(strip, round(settings.sway * side / step), wide, settings)
    curve = _fit_curve(offset, shown, settings, bow=settings.bow * side / step)
    if curve is None:
        return None
    middle = middle + (curve * step)[:, None] * normal
    strip = _strip(x, middle, normal, round(wide) + 3, step)
    _, shown, hidden = _read_strip(strip, 1, wide, settings)
    run = _longest_run(shown, hidden, round(settings.gap * side / step))
    if run is None:
        return None
    first, last = run
    seen, blank = shown[first:last], ~shown[first:last] & ~hidden[first:last]
    enough = seen.sum() >= settings.cover * (seen.sum() + blank.sum())
    if (last - first) * step < settings.length * side or not enough or seen.sum() < 8:
        return None
    profiles = strip[first:last][seen]
    half = strip.shape[1] // 2
    gray = profiles[:, half - 1 : half + 2].min(axis=1)
    level = float(np.median(gray))
    darkness = PAPER_GRAY - level
    if float(np.median(np.abs(gray - level))) > settings.even * darkness / 1.5:
        return None
    width = float(np.median((profiles < PAPER_GRAY - darkness / 2).sum(axis=1))) * step
    return GridLine(middle[first:last], max(width, 1.0), level)


def _strip(x: Bytes, middle: FloatArray, normal: FloatArray, half: int, step: float) -> FloatArray:
    """(N, 2 half + 1) float32: the page across a path; paper outside the picture."""
    import cv2

    across = np.arange(-half, half + 1) * step
    at = middle[:, None, :] + across[None, :, None] * normal
    columns, rows = (np.ascontiguousarray(at[:, :, k], np.float32) for k in range(2))
    border, outside = cv2.BORDER_CONSTANT, float(PAPER_GRAY)
    seen = cv2.remap(x, columns, rows, cv2.INTER_LINEAR, borderMode=border, borderValue=outside)
    return np.asarray(cv2.blur(seen, (1, 5)), np.float32)


def _read_strip(
    strip: FloatArray, sway: int, wide: float, settings: GridLineSettings
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """At each place along a strip: how far off its middle it is darkest, and whether a line is there, or ink.

    sway: how far it is sought, wide: of the widest line, both in samples.
    """
    half, reach = strip.shape[1] // 2, round(wide)
    inner = strip[:, half - sway : half + sway + 1]
    low = inner.min(axis=1)
    # the middle of what is as dark as the darkest
    weight = np.clip(low[:, None] + settings.contrast / 2 - inner, 0.0, None) + 1e-6
    offset = (weight * np.arange(-sway, sway + 1)).sum(axis=1) / weight.sum(axis=1)
    place, row = half + np.rint(offset).astype(int), np.arange(len(strip))
    spots = np.arange(1, reach + 2)
    left, right = (
        strip[row[:, None], np.clip(place[:, None] + sign * spots, 0, strip.shape[1] - 1)].max(axis=1)
        for sign in (-1, 1)
    )
    shown = np.minimum(left, right) - low > settings.contrast
    hidden = ~shown & (low < PAPER_GRAY - 2 * settings.contrast)
    return offset, np.asarray(shown), np.asarray(hidden)


def _fit_curve(
    offset: FloatArray, shown: BoolArray, settings: GridLineSettings, *, bow: float
) -> FloatArray | None:
    """(N,) a slightly bent curve through the offsets where the line shows; None where there is none."""
    at, used = np.linspace(-1.0, 1.0, len(offset)), shown.copy()
    if used.sum() < 12:
        return None
    for _ in range(4):
        fit = np.polynomial.Polynomial.fit(at[used], offset[used], 2, domain=[-1, 1])
        off = np.abs(offset - fit(at))
        limit = max(2.5 * float(np.median(off[used])), 1.0)
        closer = shown & (off < limit)
        if closer.sum() < 12 or (closer == used).all():
            break
        used = closer
    if float(np.median(off[shown])) > settings.straight or abs(float(fit.coef[2])) > bow:
        return None
    return np.asarray(fit(at))


def _longest_run(shown: BoolArray, hidden: BoolArray, gap: int) -> tuple[int, int] | None:
    """First and last + 1 of the longest piece in which no blank is longer than `gap`."""
    at = np.flatnonzero(shown)
    if not len(at):
        return None
    blank = np.concatenate([[0], np.cumsum(~shown & ~hidden)])
    breaks = np.flatnonzero(blank[at[1:]] - blank[at[:-1]] > gap)
    starts, stops = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(at) - 1]])
    longest = int(np.argmax(at[stops] - at[starts]))
    return int(at[starts[longest]]), int(at[stops[longest]]) + 1


def _ends_well(line: GridLine, others: list[GridLine], shape: tuple[int, ...], near: float) -> bool:
    """Whether both ends lie on another line or at the picture's side."""
    size = np.array(shape[::-1])
    for end in (line.path[0], line.path[-1]):
        at_side = bool((end < near).any() or (end > size - 1 - near).any())
        meets = (np.hypot(*(other.path - end).T).min() < near for other in others)
        if not at_side and not any(meets):
            return False
    return True


# --- taking away -----------------------------------------------------------------------------------


def _bands(
    lines: list[GridLine], shape: tuple[int, ...], settings: GridLineSettings
) -> tuple[Bytes, npt.NDArray[np.uint8]]:
    """(H, W) uint8 each: 255 on the lines with their soft edges, and the gray of the line there."""
    import cv2

    band, level = np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
    more = settings.end * min(shape) / 2
    for line in sorted(lines, key=lambda line: -line.gray):  # where two cross the darker counts
        path = np.vstack(
            [line.path[0] - more * line.direction, line.path, line.path[-1] + more * line.direction]
        )
        points = np.rint(path * 16).astype(np.int32).reshape(-1, 1, 2)
        thickness = round(line.width + 2 * settings.soft)
        for canvas, value in ((band, 255), (level, int(max(line.gray, 1)))):
            cv2.polylines(canvas, [points], False, value, thickness, cv2.LINE_8, 4)
    return band, level


def _without(x: Bytes, lines: list[GridLine], ink: float, settings: GridLineSettings) -> tuple[Bytes, int]:
    """The page with paper, or the ink that crosses it, where the lines were; pixels of the lines."""
    import cv2

    band, level = _bands(lines, x.shape, settings)
    at = band > 0
    gray = level.astype(np.float32)
    # How much ink covers a lighter line; a line as dark as ink tells nothing of itself.
    lighter = at & (gray - ink > settings.lighter)
    cover = np.clip((gray - x) / np.maximum(gray - ink, 1.0), 0.0, 1.0)
    cover = np.clip(1.25 * cover - 0.25, 0.0, 1.0)  # the line's own grain is no ink
    clean = x.copy()
    clean[at] = PAPER_GRAY
    clean[lighter] = np.minimum(PAPER_GRAY, PAPER_GRAY - (PAPER_GRAY - ink) * cover[lighter]).astype(np.uint8)
    widest = max(line.width for line in lines) + 2 * settings.soft
    size = 2 * round(widest) + 1
    bridged = cv2.morphologyEx(
        clean, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    )
    clean[at] = bridged[at]
    return clean, int(np.count_nonzero(at & (x < PAPER_GRAY - settings.contrast) & (clean > x)))
