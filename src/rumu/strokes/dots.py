"""Strokes that stand alone in master and copy, as most dots do: how much ink they hold.

A dot is so short that its line says little of its size, and a shrunk one hardly meets the line where it is
looked for. Where no other stroke touches it, its ink is its own and can be counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import SCALE, FramedInk, from_pixels, pixels_at, to_pixels
from rumu.strokes.correspondence import StrokeMatch
from rumu.values import BoolArray, FloatArray, IntArray

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
    own = match.master.points.owner == position
    in_master, labels = _ink_alone(match.framed_master, match.master.points.xy, own, ~own)
    home = {int(k) for k in labels[own] if k}
    if len(home) != 1 or not (k := home.pop()) or k not in in_master:
        return None
    of_copy, _ = _ink_alone(match.framed, match.moved, own, ~own & match.covered)
    pictures = [abs(float(np.linalg.det(f.to_picture[:, :2]))) for f in (match.framed_master, match.framed)]
    expected = len(in_master[k]) * pictures[0] * abs(float(np.linalg.det(match.pose.linear))) / pictures[1]
    middle = to_pixels(match.moved[own].mean(axis=0))
    near = [
        pixels
        for pixels in of_copy.values()
        if len(pixels) >= _SPECK * expected
        and float(np.hypot(*(pixels[:, ::-1] - middle).T).min()) < _REACH * SCALE
    ]
    if len(near) != 1:
        return None
    area = len(near[0]) / max(expected * min(match.width, 1.0), 1.0)
    return LoneStroke(area, _outline(near[0], match.framed))


def _ink_alone(
    framed: FramedInk, points: FloatArray, own: BoolArray, others: BoolArray
) -> tuple[dict[int, IntArray], IntArray]:
    """Pieces of ink that no other stroke's points lie on, (n, 2) row and column each, by number.

    The second value: (n,) the number of the piece that each of the points lies on, 0 for none.
    """
    import cv2

    _, pieces = cv2.connectedComponents(framed.ink.view(np.uint8), connectivity=8)
    on = pieces[pixels_at(points)]
    taken = set(on[others].tolist())
    alone = [k for k in range(1, int(pieces.max()) + 1) if k not in taken]
    return {k: np.argwhere(pieces == k) for k in alone}, np.where(own | others, on, 0)


def _outline(pixels: IntArray, framed: FramedInk) -> FloatArray:
    import cv2

    mask = np.zeros(framed.ink.shape, np.uint8)
    mask[tuple(pixels.T)] = 1
    edges, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    edge = max(edges, key=len)[:, 0, :].astype(float)
    return framed.on_picture(from_pixels(np.concatenate([edge, edge[:1]])))
