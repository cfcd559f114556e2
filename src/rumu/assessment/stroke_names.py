"""What a teacher would call a stroke: its kind, and which of that kind it is; Chinese and English."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rumu.assessment.lines import Line
from rumu.values import FloatArray


class Name(NamedTuple):
    """The same words in traditional Chinese and in English."""

    zh: str
    en: str


DOT = Name("點", "dot")
HORIZONTAL = Name("橫", "horizontal")
VERTICAL = Name("豎", "vertical")
LEFT_FALLING = Name("撇", "left-falling stroke")
RIGHT_FALLING = Name("捺", "right-falling stroke")
RISING = Name("提", "rising stroke")
HOOK = Name("鉤", "hook")
CURVE = Name("曲筆", "curved stroke")
RING = Name("圈", "ring")

_NUMBERS = "一二三四五六七八九十"
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
_ROWS = (("上", "top"), ("中", "middle"), ("下", "bottom"))
_COLUMNS = (("左", "left"), ("", ""), ("右", "right"))


def kind_of(line: Line, *, width: float) -> Name:
    """The kind of a stroke, by its direction and shape. width: of a common stroke, rms radii."""
    right, down = line.chord
    straight = float(np.hypot(right, down))
    if straight < 0.35 * line.length and line.length > 4 * width:
        return RING
    if line.length < 2.6 * width:
        return DOT if any(line.free) or line.length < 1.5 * width else _by_direction(right, down)
    if straight < 0.75 * line.length:
        return CURVE
    if line.length < 4.0 * width and line.free != (True, True) and down < -0.3 * abs(right):
        return HOOK
    return _by_direction(right, down)


def _by_direction(right: float, down: float) -> Name:
    """y grows downward: 0 runs to the right, 90 down, 180 to the left."""
    angle = float(np.degrees(np.arctan2(down, right)))
    if -25.0 <= angle <= 18.0:
        return HORIZONTAL
    if 72.0 <= angle <= 108.0:
        return VERTICAL
    if 18.0 < angle < 72.0:
        return RIGHT_FALLING
    if -90.0 < angle < -25.0:
        return RISING
    return LEFT_FALLING


def names_of(lines: Sequence[Line], *, width: float) -> tuple[Name, ...]:
    """A name for each stroke that no other of the character has.

    Several horizontals are counted from the top, several verticals from the left; others go by their place.
    """
    kinds = [kind_of(line, width=width) for line in lines]
    middles = np.array([line.points.mean(axis=0) for line in lines])
    points = np.concatenate([line.points for line in lines])
    low, high = points.min(axis=0), points.max(axis=0)
    names: list[Name] = [Name("", "")] * len(lines)
    for kind in dict.fromkeys(kinds):
        same = [k for k, own in enumerate(kinds) if own == kind]
        for k, name in zip(same, _told_apart(kind, middles[same], low, high), strict=True):
            names[k] = name
    return tuple(names)


def _told_apart(kind: Name, middles: FloatArray, low: FloatArray, high: FloatArray) -> list[Name]:
    if len(middles) > 1 and kind in (HORIZONTAL, VERTICAL):
        axis = 1 if kind == HORIZONTAL else 0
        rank = np.argsort(np.argsort(middles[:, axis])) + 1
        return [_counted(kind, int(n)) for n in rank]
    places = [place_of((middle - low) / np.maximum(high - low, 1e-9)) for middle in middles]
    if len(set(places)) == len(places):
        return [Name(f"{zh}的{kind.zh}", f"the {kind.en} at the {en}") for zh, en in places]
    rank = np.argsort(np.argsort(middles @ np.array([0.35, 1.0]))) + 1
    return [
        Name(f"第{_number(int(n))}{kind.zh}（{zh}）", f"the {_ordinal(int(n))} {kind.en} ({en})")
        for n, (zh, en) in zip(rank, places, strict=True)
    ]


def _counted(kind: Name, n: int) -> Name:
    if kind == HORIZONTAL:
        return Name(f"第{_number(n)}橫", f"the {_ordinal(n)} horizontal from the top")
    return Name(f"左起第{_number(n)}豎", f"the {_ordinal(n)} vertical from the left")


def _number(n: int) -> str:
    return _NUMBERS[n - 1] if n <= 10 else f"十{_NUMBERS[n - 11]}" if n < 20 else str(n)


def _ordinal(n: int) -> str:
    return _ORDINALS[n - 1] if n <= 10 else f"{n}th"


def place_of(at: FloatArray) -> Name:
    """The ninth of a box in which a point lies; (x, y) in fractions of it, origin top left."""
    column, row = (int(np.clip(3 * v, 0, 2)) for v in at)
    (row_zh, row_en), (column_zh, column_en) = _ROWS[row], _COLUMNS[column]
    if row == 1:
        return Name(f"{column_zh}側", column_en) if column_zh else Name("中部", "centre")
    return Name(f"{column_zh}{row_zh}部", f"{row_en} {column_en}".strip())
