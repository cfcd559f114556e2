"""Strokes that stand alone in master and copy, as most dots do: how much ink they hold.

A dot is so short that its line says little of its size, and a shrunk one hardly meets the line where it is
looked for. Where no other stroke touches it, its ink is its own and can be counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import SCALE, pixels_at, to_pixels
from rumu.strokes.correspondence import StrokeMatch
from rumu.values import FloatArray

_REACH = 0.35
"""Rms radii from where a stroke was laid within which its ink may stand."""
_SPECK = 0.08
"""Share of the master's ink below which something is a speck."""


@dataclass(frozen=True, slots=True, eq=False)
class LoneStroke:
    """A stroke that stands alone.

    area: of its ink over the master's, the size of the whole taken out, and the width of all strokes where
    they are thin. outline: (n, 2) its edge on the copy's picture, closed, in fractions of it.
    """

    area: float
    outline: FloatArray


def find_lone_stroke(match: StrokeMatch, position: int) -> LoneStroke | None:
    """The stroke at a position among the master's; None where it joins another, or several may be it."""
    framed, framed_master = match.framed, match.framed_master
    own = match.master.points.owner == position
    in_master = framed_master.pieces[pixels_at(match.master.points.xy)]
    home = set(in_master[own].tolist()) - {0}
    if len(home) != 1 or home & set(in_master[~own].tolist()):
        return None
    pictures = [abs(float(np.linalg.det(f.to_picture[:, :2]))) for f in (framed_master, framed)]
    size = abs(float(np.linalg.det(match.pose.linear))) * pictures[0] / pictures[1]
    expected = size * np.count_nonzero(framed_master.pieces == home.pop())
    taken = framed.pieces[pixels_at(match.moved[~own & match.covered])]
    near = []
    for piece in set(range(1, int(framed.pieces.max()) + 1)) - set(taken.tolist()):
        pixels = np.argwhere(framed.pieces == piece)[:, ::-1]
        away = float(np.hypot(*(pixels - to_pixels(match.moved[own].mean(axis=0))).T).min())
        if len(pixels) >= _SPECK * expected and away < _REACH * SCALE:
            near.append((piece, len(pixels)))
    if len(near) != 1:
        return None
    ((piece, count),) = near
    area = count / max(expected * min(match.width, 1.0), 1.0)
    return LoneStroke(area, framed.outline_of(framed.pieces == piece))
