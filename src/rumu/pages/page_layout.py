"""How a page is divided: the ruled lines that part its registers, and what stands outside of the text."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class LayoutSettings:
    """What parts registers and blocks; lengths in sizes of a character.

    grain: pixels that a character measures where lines are counted. coverage: share of the text's width or
    height that a parting line covers at least. lean: the steepest line, as rise over run. run: the shortest
    piece of a line. apart: how far two parting lines are apart at least. blank: the lowest empty strip that
    parts two registers without a line. piece: the shortest piece of a line that bends; long: share of the
    text's extent that it covers at least; thin: how far its pixels lie from its curve.
    """

    grain: float = 10.0
    coverage: float = 0.4
    lean: float = 0.1
    run: float = 1.2
    apart: float = 0.9
    blank: float = 0.9
    piece: float = 0.5
    long: float = 0.6
    thin: float = 0.15


@dataclass(frozen=True, slots=True)
class PartingLine:
    """A line across the page, straight or bent.

    curve: coefficients of a polynomial, the highest power first: how far down (or to the right) it lies, in
    pixels, at each place from the left (or the top).
    """

    curve: tuple[float, ...]

    def at(self, along: FloatArray | float) -> FloatArray:
        """How far down, or to the right, the line lies at these places along it."""
        return np.asarray(np.polyval(self.curve, np.asarray(along, dtype=float)))


def parting_lines(
    lines: BoolArray, *, size: float, extent: tuple[float, float], settings: LayoutSettings | None = None
) -> list[PartingLine]:
    """Ruled lines that cross the page from side to side, from top to bottom.

    lines: (H, W) bool; for lines that run down the page, give its transpose. extent: where the text begins
    and ends along the lines, in pixels.
    """
    import cv2

    settings = settings or LayoutSettings()
    factor = min(1.0, settings.grain / size)
    shape = tuple(max(1, round(side * factor)) for side in lines.shape[::-1])
    small = cv2.resize(lines.view(np.uint8) * np.uint8(255), shape, interpolation=cv2.INTER_AREA)
    run = max(3, round(settings.run * size * factor))
    flat = cv2.morphologyEx((small > 25).astype(np.uint8), cv2.MORPH_OPEN, np.ones((1, run), np.uint8))
    begin, end = (edge * factor for edge in extent)
    y, x = np.nonzero(flat)
    within = (x >= begin) & (x <= end)
    y, x = y[within], x[within]
    if not len(y) or end - begin < 4:
        return []
    lean, counts = _best_lean(x, y, flat.shape, settings)
    peaks = _peaks(counts, least=settings.coverage * (end - begin), apart=settings.apart * size * factor)
    margin = flat.shape[1]  # as _best_lean shifts
    found = [_fit(x, y, peak - margin + lean * x, settings.apart * size * factor / 2) for peak in peaks]
    found += _bent_lines(small > 25, found, (begin, end), size * factor, settings)
    scale = [
        factor,
        1.0,
        1 / factor,
    ]  # a curve a x² + b x + c of the small picture, in pixels of the large one
    return [PartingLine(tuple(float(a * b) for a, b in zip(curve, scale, strict=True))) for curve in found]


def _bent_lines(
    mask: BoolArray,
    known: list[FloatArray],
    extent: tuple[float, float],
    size: float,
    settings: LayoutSettings,
) -> list[FloatArray]:
    """Curves of connected lines that bend or lean too much to fall into one row, apart from those known."""
    import cv2

    piece = max(3, round(settings.piece * size))
    flat = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((1, piece), np.uint8))
    joined = cv2.dilate(flat, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    found: list[FloatArray] = []
    middle, least = sum(extent) / 2, settings.long * (extent[1] - extent[0])
    for k in range(1, count):
        if stats[k, cv2.CC_STAT_WIDTH] < least:
            continue
        y, x = np.nonzero((labels == k) & (flat > 0))
        if len(np.unique(x)) < max(least, 4):
            continue
        each = 1 / np.bincount(x)[x]  # what hangs on the line, such as the mark of a fold, weighs little
        weights = each
        for _ in range(6):
            curve = np.polyfit(x, y, 2, w=weights)
            off = np.abs(y - np.polyval(curve, x)) / (settings.thin * size)
            weights = each / (1 + off**2)
        on_line = x[(off < 1) & (x >= extent[0]) & (x <= extent[1])]
        rise = abs(np.diff(np.polyval(curve, extent))[0])
        if len(np.unique(on_line)) < least or rise > 2 * settings.lean * (extent[1] - extent[0]):
            continue
        at = np.polyval(curve, middle)
        if all(abs(np.polyval(one, middle) - at) > settings.apart * size for one in [*known, *found]):
            found.append(np.asarray(curve))
    return found


def _fit(x: IntArray, y: IntArray, line: FloatArray, reach: float) -> FloatArray:
    """The curve of second degree through the pixels of lines near a straight one."""
    near = np.abs(y - line) < reach
    if near.sum() < 4 or np.ptp(x[near]) < 8:
        return np.concatenate([[0.0], np.polyfit(x, line, 1)])
    curve = np.polyfit(x[near], y[near], 2)
    for _ in range(2):
        close = near & (np.abs(y - np.polyval(curve, x)) < reach / 2)
        if close.sum() > 8 and np.ptp(x[close]) > 0.5 * np.ptp(x[near]):
            curve = np.polyfit(x[close], y[close], 2)
    return np.asarray(curve)


def _best_lean(
    x: IntArray, y: IntArray, shape: tuple[int, ...], settings: LayoutSettings
) -> tuple[float, FloatArray]:
    """The lean under which pixels of lines fall into fewest rows, and how many columns each row covers."""
    best: tuple[float, float, FloatArray] | None = None
    height, width = shape
    steps = max(2, round(settings.lean * width / 2))
    for lean in np.linspace(-settings.lean, settings.lean, 2 * steps + 1):
        row = np.rint(y - lean * x).astype(np.intp) + width
        covered = np.zeros((height + 2 * width, width), bool)
        covered[row, x] = True
        counts = np.count_nonzero(covered, axis=1).astype(float)
        thick = np.convolve(counts, np.ones(2), mode="same")  # a line on the border of two rows is one line
        score = float((np.minimum(thick, width) ** 3).sum())
        if best is None or score > best[0]:
            best = score, float(lean), thick
    assert best is not None
    return best[1], best[2]


def _peaks(counts: FloatArray, *, least: float, apart: float) -> list[int]:
    """Rows that are covered well, the best of each neighbourhood, from top to bottom."""
    chosen: list[int] = []
    for row in np.argsort(-counts):
        if counts[row] < least:
            break
        if all(abs(row - other) >= apart for other in chosen):
            chosen.append(int(row))
    return sorted(chosen)
