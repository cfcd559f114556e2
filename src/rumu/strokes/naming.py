"""What a teacher would call a stroke and a place: its kind, and which of that kind; Chinese and English."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.strokes.centre_lines import CentreLine
from rumu.values import Bilingual, FloatArray

DOT = Bilingual("點", "dot")
HORIZONTAL = Bilingual("橫", "horizontal")
VERTICAL = Bilingual("豎", "vertical")
LEFT_FALLING = Bilingual("撇", "left-falling stroke")
RIGHT_FALLING = Bilingual("捺", "right-falling stroke")
RISING = Bilingual("提", "rising stroke")
HOOK = Bilingual("鉤", "hook")
CURVE = Bilingual("曲筆", "curved stroke")
RING = Bilingual("圈", "ring")

_NUMBERS = "一二三四五六七八九十"
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
_ROWS = (("上", "top"), ("中", "middle"), ("下", "bottom"))
_COLUMNS = (("左", "left"), ("", ""), ("右", "right"))
_COMPASS = (
    Bilingual("右", "right"), Bilingual("右下", "lower right"), Bilingual("下", "bottom"),
    Bilingual("左下", "lower left"), Bilingual("左", "left"), Bilingual("左上", "upper left"),
    Bilingual("上", "top"), Bilingual("右上", "upper right"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class NamingSettings:
    """Where one kind of stroke ends and another begins. Lengths in stroke widths.

    ring: distance of the ends over the length, below which a stroke of more than ring_length is a ring.
    dot: length below which a stroke that joins no other at one end is a dot; corner: below which any is.
    curve: distance of the ends over the length, below which a stroke is curved.
    hook: length below which a stroke that joins another is a hook, if it rises by more than hook_slope.
    rising, level, upright: degrees, y downward, up to which a stroke rises; up to which it is level; and
        between which it is upright.
    order: weights of x and y by which strokes of one kind are counted.
    """

    ring: float = 0.35
    ring_length: float = 4.0
    dot: float = 2.6
    corner: float = 1.5
    curve: float = 0.75
    hook: float = 4.0
    hook_slope: float = 0.3
    rising: float = -25.0
    level: float = 18.0
    upright: tuple[float, float] = (72.0, 108.0)
    order: tuple[float, float] = (0.35, 1.0)


NAMING = NamingSettings()


def kind_of(line: CentreLine, *, width: float) -> Bilingual:
    """The kind of a stroke, by its direction and shape. width: of a common stroke, rms radii."""
    s, (right, down) = NAMING, line.chord
    straight, length = float(np.hypot(right, down)), line.length
    if straight < s.ring * length and length > s.ring_length * width:
        return RING
    if length < s.dot * width:
        return DOT if any(line.free) or length < s.corner * width else _kind_by_direction(right, down)
    if straight < s.curve * length:
        return CURVE
    if length < s.hook * width and line.free != (True, True) and down < -s.hook_slope * abs(right):
        return HOOK
    return _kind_by_direction(right, down)


def _kind_by_direction(right: float, down: float) -> Bilingual:
    """The kind of a straight stroke; angles: 0 to the right, 90 down, 180 to the left."""
    s, angle = NAMING, float(np.degrees(np.arctan2(down, right)))
    if s.rising <= angle <= s.level:
        return HORIZONTAL
    if s.upright[0] <= angle <= s.upright[1]:
        return VERTICAL
    if s.level < angle < s.upright[0]:
        return RIGHT_FALLING
    if -90.0 < angle < s.rising:
        return RISING
    return LEFT_FALLING


def name_strokes(lines: Sequence[CentreLine], *, width: float) -> tuple[Bilingual, ...]:
    """A unique name for each stroke of a character.

    Several horizontals are counted from the top, several verticals from the left; others go by their place.
    """
    kinds = [kind_of(line, width=width) for line in lines]
    middles = np.array([line.points.mean(axis=0) for line in lines])
    points = np.concatenate([line.points for line in lines])
    low, high = points.min(axis=0), points.max(axis=0)
    names: list[Bilingual] = [Bilingual("", "")] * len(lines)
    for kind in dict.fromkeys(kinds):
        same = [k for k, own in enumerate(kinds) if own == kind]
        for k, name in zip(same, _name_of_kind(kind, middles[same], low, high), strict=True):
            names[k] = name
    return tuple(names)


def _name_of_kind(kind: Bilingual, middles: FloatArray, low: FloatArray, high: FloatArray) -> list[Bilingual]:
    """Names for all strokes of one kind, by their middles, (n, 2); low, high: of the whole character."""
    if len(middles) > 1 and kind in (HORIZONTAL, VERTICAL):
        rank = np.argsort(np.argsort(middles[:, 1 if kind == HORIZONTAL else 0])) + 1
        numbers = [_number_words(int(n)) for n in rank]
        if kind == HORIZONTAL:
            return [Bilingual(f"第{zh}橫", f"the {en} horizontal from the top") for zh, en in numbers]
        return [Bilingual(f"左起第{zh}豎", f"the {en} vertical from the left") for zh, en in numbers]
    places = [place_of((middle - low) / np.maximum(high - low, 1e-9)) for middle in middles]
    if len(set(places)) == len(places):
        return [Bilingual(f"{zh}的{kind.zh}", f"the {kind.en} at the {en}") for zh, en in places]
    rank = np.argsort(np.argsort(middles @ np.array(NAMING.order))) + 1
    return [
        Bilingual(f"第{number.zh}{kind.zh}（{zh}）", f"the {number.en} {kind.en} ({en})")
        for number, (zh, en) in zip((_number_words(int(n)) for n in rank), places, strict=True)
    ]


def _number_words(n: int) -> Bilingual:
    """The number n in Chinese and the ordinal in English."""
    if n <= 10:
        return Bilingual(_NUMBERS[n - 1], _ORDINALS[n - 1])
    return Bilingual(f"十{_NUMBERS[n - 11]}" if n < 20 else str(n), f"{n}th")


def place_of(at: FloatArray) -> Bilingual:
    """The ninth of a box in which a point lies; (x, y) in fractions of it, origin top left."""
    column, row = (int(np.clip(3 * v, 0, 2)) for v in at)
    (row_zh, row_en), (column_zh, column_en) = _ROWS[row], _COLUMNS[column]
    if row == 1:
        return Bilingual(f"{column_zh}側", column_en) if column_zh else Bilingual("中部", "centre")
    return Bilingual(f"{column_zh}{row_zh}部", f"{row_en} {column_en}".strip())


def direction_of(way: FloatArray) -> Bilingual:
    """The nearest of eight directions; way: (x right, y DOWN)."""
    return _COMPASS[round(float(np.arctan2(way[1], way[0])) / (np.pi / 4)) % 8]


def way_of(way: FloatArray) -> str:
    """Where something stands that is off in this direction, in English; way: (x right, y DOWN)."""
    words = direction_of(way).en.replace("bottom", "lower").replace("top", "upper").split()
    said = {"left": "too far left", "right": "too far right", "lower": "too low", "upper": "too high"}
    return " and ".join(said[word] for word in words)
