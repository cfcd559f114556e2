"""Outlines of Chinese punctuation, which the copybooks' strokes lack; in the middle, as in Taiwan."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from rumu.values import FloatArray

_THIN = 0.05  # of a line, as a share of the character's square

Place = tuple[float, float]


def _polygon(points: FloatArray) -> FloatArray:
    """An outline that runs clockwise as it is seen: all do, so that ink stays ink where two overlap."""
    x, y = points.T
    clockwise = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) > 0  # y grows downward
    return points if clockwise else points[::-1]


def _disc(x: float, y: float, radius: float) -> FloatArray:
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    return _polygon(np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)]))


def _ring(x: float, y: float, radius: float) -> tuple[FloatArray, FloatArray]:
    return _disc(x, y, radius), _disc(x, y, radius - _THIN)[::-1]


def _drop(start: Place, end: Place, radius: float) -> FloatArray:
    """A drop, round at `end` and pointed at `start`."""
    way = np.subtract(end, start) / np.hypot(*np.subtract(end, start))
    angles = np.linspace(-np.pi / 2, np.pi / 2, 13)
    side = np.array([-way[1], way[0]])
    round_end = end + radius * (np.outer(np.cos(angles), way) + np.outer(np.sin(angles), side))
    return _polygon(np.vstack([np.array(start)[None], round_end]))


def _line(*points: Place, width: float = _THIN) -> tuple[FloatArray, ...]:
    """A line through points, as a box for each piece that reaches half a width beyond its ends."""
    boxes = []
    for start, end in itertools.pairwise(points):
        way = np.subtract(end, start) / np.hypot(*np.subtract(end, start)) * width / 2
        side = np.array([-way[1], way[0]])
        corners = (start - way - side, end + way - side, end + way + side, start - way + side)
        boxes.append(_polygon(np.array(corners)))
    return tuple(boxes)


def _arc(x: float, y: float, radius: float, first: float, last: float) -> FloatArray:
    """A piece of a circle's line between two angles, degrees clockwise from the right."""
    angles = np.radians(np.linspace(first, last, 25))
    way = np.column_stack([np.cos(angles), np.sin(angles)])
    inner, outer = radius - _THIN / 2, radius + _THIN / 2
    return _polygon(np.array([x, y]) + np.vstack([outer * way, inner * way[::-1]]))


def _turned(outlines: tuple[FloatArray, ...]) -> tuple[FloatArray, ...]:
    """The same, turned by 180 degrees: a closing bracket of an opening one."""
    return tuple(1 - outline for outline in outlines)


def _comma(x: float, y: float) -> tuple[FloatArray, ...]:
    return _disc(x, y, 0.065), _drop((x - 0.06, y + 0.16), (x + 0.02, y + 0.015), 0.045)


_CORNER = _line((0.6, 0.72), (0.6, 0.1), (0.92, 0.1))
_DOUBLE_CORNER = _line(
    (0.52, 0.7), (0.52, 0.1), (0.92, 0.1), (0.92, 0.2), (0.62, 0.2), (0.62, 0.7), (0.52, 0.7)
)
_BRACKET = (_arc(1.32, 0.5, 0.62, 137, 223),)
_ANGLE = _line((0.85, 0.12), (0.62, 0.5), (0.85, 0.88))

PUNCTUATION: Mapping[str, tuple[FloatArray, ...]] = {
    "。": _ring(0.5, 0.52, 0.13),
    "，": _comma(0.5, 0.5),
    "、": (_drop((0.41, 0.41), (0.55, 0.57), 0.06),),
    "：": (_disc(0.5, 0.32, 0.065), _disc(0.5, 0.7, 0.065)),
    "；": (_disc(0.5, 0.3, 0.065), *_comma(0.5, 0.64)),
    "！": (_drop((0.5, 0.66), (0.5, 0.2), 0.06), _disc(0.5, 0.82, 0.06)),
    "？": (_arc(0.5, 0.32, 0.18, -180, 90), *_line((0.5, 0.5), (0.5, 0.66)), _disc(0.5, 0.82, 0.06)),
    "「": _CORNER,
    "」": _turned(_CORNER),
    "『": _DOUBLE_CORNER,
    "』": _turned(_DOUBLE_CORNER),
    "（": _BRACKET,
    "）": _turned(_BRACKET),
    "〈": _ANGLE,
    "〉": _turned(_ANGLE),
    "《": (*_ANGLE, *(outline - (0.24, 0) for outline in _ANGLE)),
    "》": _turned((*_ANGLE, *(outline - (0.24, 0) for outline in _ANGLE))),
    "／": _line((0.86, 0.08), (0.14, 0.92)),
    "→": (*_line((0.1, 0.5), (0.8, 0.5)), _polygon(np.array([(0.7, 0.36), (0.92, 0.5), (0.7, 0.64)]))),
    "−": _line((0.2, 0.5), (0.8, 0.5)),
    "〓": (*_line((0.1, 0.38), (0.9, 0.38), width=0.12), *_line((0.1, 0.62), (0.9, 0.62), width=0.12)),
    "\u3000": (),
}
"""Outlines by character, shares of its square, (x right, y DOWN); what runs anticlockwise is a hole."""
