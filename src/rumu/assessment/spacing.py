"""The white between neighbouring strokes that run side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.assessment.strokes import Strokes
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class Gap:
    """Two strokes side by side with nothing between them.

    first, second: their numbers, the upper (left) one first. master, copy: distance between their middles,
    rms radii, lean and size of the whole taken out.
    """

    first: int
    second: int
    master: float
    copy: float

    @property
    def change(self) -> float:
        """Relative; 0.2 is a fifth too wide."""
        return self.copy / self.master - 1.0


def find_gaps(strokes: Strokes) -> tuple[Gap, ...]:
    """Gaps between neighbours that run within 20 degrees of each other for half of the shorter one."""
    gaps = []
    lines = strokes.master.lines
    for axis in (0, 1):  # lying strokes above each other, standing ones beside each other
        group = [
            k for k, line in enumerate(lines) if _runs_along(line.chord, axis) and strokes.strokes[k].present
        ]
        group.sort(key=lambda k: float(lines[k].points[:, 1 - axis].mean()))
        for n, a in enumerate(group):
            b = next(
                (b for b in group[n + 1 :] if _shared(lines[a].points, lines[b].points, axis) > 0.5), None
            )
            if b is None:
                continue
            master = float((lines[b].points - lines[a].points.mean(axis=0)).mean(axis=0)[1 - axis])
            moved = strokes.strokes[b].shift - strokes.strokes[a].shift
            if master > 0.8 * strokes.master.width:
                gaps.append(Gap(a, b, master, max(master + float(moved[1 - axis]), 0.0)))
    return tuple(gaps)


def _runs_along(chord: FloatArray, axis: int) -> bool:
    return bool(abs(chord[1 - axis]) < np.tan(np.radians(25.0)) * abs(chord[axis]))


def _shared(a: FloatArray, b: FloatArray, axis: int) -> float:
    """Share of the shorter one's extent that both cover."""
    (a0, a1), (b0, b1) = ((float(p[:, axis].min()), float(p[:, axis].max())) for p in (a, b))
    return (min(a1, b1) - max(a0, b0)) / max(min(a1 - a0, b1 - b0), 1e-9)
