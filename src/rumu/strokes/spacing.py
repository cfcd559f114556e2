"""The white between neighbouring strokes that run side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.strokes.correspondence import StrokeMatch
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class SpacingSettings:
    """Which strokes run side by side.

    slant: degrees off level, or off upright. shared: share of the shorter one's extent that both cover.
    apart: distance of their middles, in stroke widths, at least.
    """

    slant: float = 25.0
    shared: float = 0.5
    apart: float = 0.8


SPACING = SpacingSettings()


@dataclass(frozen=True, slots=True)
class StrokeGap:
    """Two strokes side by side with nothing between them.

    first, second: their numbers, the upper (left) one first. change: of the distance between their middles
    against the master's, lean and size of the whole taken out; 0.2 is a fifth too wide.
    """

    first: int
    second: int
    change: float


def find_gaps(strokes: StrokeMatch) -> tuple[StrokeGap, ...]:
    """Gaps between neighbours that are both level, or both upright, and run side by side."""
    gaps = []
    lines = strokes.master.lines
    steepest = np.tan(np.radians(SPACING.slant))
    for axis in (0, 1):  # horizontals one above another, verticals side by side
        along = [bool(abs(line.chord[1 - axis]) < steepest * abs(line.chord[axis])) for line in lines]
        group = [k for k, stroke in enumerate(strokes.strokes) if along[k] and stroke.present]
        group.sort(key=lambda k: float(lines[k].points[:, 1 - axis].mean()))
        for n, a in enumerate(group):
            beside = (
                b
                for b in group[n + 1 :]
                if _overlap(lines[a].points[:, axis], lines[b].points[:, axis]) > SPACING.shared
            )
            b = next(beside, None)
            if b is None:
                continue
            master = float((lines[b].points - lines[a].points.mean(axis=0)).mean(axis=0)[1 - axis])
            moved = strokes.strokes[b].shift - strokes.strokes[a].shift
            if master > SPACING.apart * strokes.master.width:
                copy = max(master + float(moved[1 - axis]), 0.0)
                gaps.append(StrokeGap(a, b, copy / master - 1.0))
    return tuple(gaps)


def _overlap(a: FloatArray, b: FloatArray) -> float:
    """Share of the shorter one's extent that both cover, of (n,) coordinates each."""
    extents = (float(np.ptp(a)), float(np.ptp(b)))
    both = min(float(a.max()), float(b.max())) - max(float(a.min()), float(b.min()))
    return both / max(min(extents), 1e-9)
