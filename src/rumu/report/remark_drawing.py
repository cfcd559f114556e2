"""Remarks as a page shows them: numbered, each with its strokes in the copy and in the master."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rumu.report import wording
from rumu.values import Bilingual, FloatArray, Remark

# All in thousandths of the picture's side.
_RADIUS = 60.0  # of a number, on the smallest picture
_APART = 118.0  # between the middles of two numbers
_RING, _DIRECTIONS = 20.0, 24  # places beside a stroke that are tried for its number: how far apart, how many

Taken = list[tuple[float, float]]


def remark_rows(remarks: Sequence[Remark]) -> list[dict[str, Any]]:
    """The worst first: number, words, size; what is drawn in the copy (lines, box) and in the master."""
    ordered = sorted(remarks, key=lambda remark: -remark.severity)
    on_copy: Taken = []
    on_master: Taken = []
    return [
        {
            "number": number,
            "kind": wording.kind_name(remark.kind),
            "text": Bilingual(remark.zh, remark.en),
            "size": wording.with_unit(remark.size, remark.unit),
            "box": None if remark.outline else _box(remark.region),
            "lines": _drawing(remark.outline, on_copy, absent=remark.kind == "missing"),
            "master": _drawing(remark.master_outline, on_master, absent=False),
        }
        for number, remark in enumerate(ordered, start=1)
    ]


def _drawing(
    outline: Sequence[Sequence[tuple[float, float]]], taken: Taken, *, absent: bool
) -> dict[str, Any] | None:
    """Lines as points of an SVG of 1000 by 1000, and the position of their number.

    taken: positions of other numbers; this one is added. absent: drawn dashed, since it shows where a stroke
    should be.
    """
    if not outline:
        return None
    lines = [1000 * np.clip(np.array(line, float), 0, 1) for line in outline]
    at = number_position(lines[0], taken)
    taken.append(at)
    return {
        "points": [" ".join(f"{x:.0f},{y:.0f}" for x, y in line) for line in lines if len(line) > 1],
        "dots": [(f"{line[0][0]:.0f}", f"{line[0][1]:.0f}") for line in lines if len(line) == 1],
        "dashed": absent,
        "left": at[0] / 10,
        "top": at[1] / 10,
    }


def number_position(line: FloatArray, taken: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Where a number stands: on the line as near to its middle as the others let it, else just beside it.

    line: (n, 2); taken: positions of other numbers; all in thousandths. The number is whole in the picture.
    """
    for x, y in (*_places_on(line), *_places_beside(line)):
        if all(np.hypot(x - a, y - b) >= _APART for a, b in taken):
            return x, y
    return next(_places_on(line))


def _places_on(line: FloatArray) -> Iterator[tuple[float, float]]:
    """Places along the line, from its middle to its ends."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    count = 1 + int(along[-1] // (_RING / 2))
    for share in sorted(np.linspace(0.0, 1.0, count) if count > 1 else [0.5], key=lambda s: abs(s - 0.5)):
        x, y = (float(np.interp(share * along[-1], along, line[:, k])) for k in (0, 1))
        yield _inside(x), _inside(y)


def _places_beside(line: FloatArray) -> Iterator[tuple[float, float]]:
    """Places around the line's own, the nearest first."""
    for ring in range(1, 40):
        for x, y in _places_on(line):
            for turn in np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False):
                reach = _RING * ring
                yield _inside(x + reach * float(np.cos(turn))), _inside(y + reach * float(np.sin(turn)))


def _inside(value: float) -> float:
    return float(np.clip(value, _RADIUS, 1000 - _RADIUS))


def _box(region: tuple[float, float, float, float] | None) -> dict[str, float] | None:
    """A region as CSS percentages."""
    if region is None:
        return None
    x0, y0, x1, y1 = (float(np.clip(v, 0, 1)) for v in region)
    return {"left": 100 * x0, "top": 100 * y0, "width": 100 * (x1 - x0), "height": 100 * (y1 - y0)}
