"""What a teacher would call a stroke and a place: its kind, and which of that kind; Chinese and English."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter
from rumu.strokes.centre_lines import CentreLine
from rumu.values import Bilingual, FloatArray

DOT = Bilingual("點", "dot")
HORIZONTAL = Bilingual("橫", "horizontal")
VERTICAL = Bilingual("豎", "vertical")
LEFT_FALLING = Bilingual("撇", "left-falling stroke")
RIGHT_FALLING = Bilingual("捺", "right-falling stroke")
RISING = Bilingual("提", "rising stroke")
RING = Bilingual("圈", "ring")
FOLD = Bilingual("折", "fold")
SLANTED = Bilingual("斜", "slant")
PLAIN_KINDS = (DOT, HORIZONTAL, VERTICAL, LEFT_FALLING, RIGHT_FALLING, RISING)
"""Strokes that do not bend."""
_SLANTED_HOOKS = ("臥鉤", "斜鉤", "彎鉤")
_LEGS = {
    HORIZONTAL: Bilingual("橫段", "horizontal"),
    VERTICAL: Bilingual("豎段", "vertical"),
    LEFT_FALLING: Bilingual("撇段", "left-falling"),
    RIGHT_FALLING: Bilingual("斜段", "slanting"),
    RISING: Bilingual("提段", "rising"),
    DOT: Bilingual("點段", "dotted"),
    FOLD: Bilingual("折段", "downward"),
    SLANTED: Bilingual("斜段", "slanting"),
}
_FIRST_LEGS = {kind.zh: kind for kind in (HORIZONTAL, VERTICAL, LEFT_FALLING)}

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
    rising, level, upright: degrees, y downward, up to which a stroke rises; up to which it is level; and
        between which it is upright.
    hook_share: of its stroke's longest leg, up to which a last leg is a hook. whole_share: of a stroke
        without its hook, from which a leg is the whole of it: its corner was not seen.
    """

    ring: float = 0.35
    ring_length: float = 4.0
    dot: float = 2.6
    corner: float = 1.5
    rising: float = -25.0
    level: float = 18.0
    upright: tuple[float, float] = (72.0, 108.0)
    hook_share: float = 0.6
    whole_share: float = 0.85


NAMING = NamingSettings()


def kind_of(line: CentreLine, *, width: float) -> Bilingual:
    """The kind of a stroke, by its direction and shape. width: of a common stroke, rms radii."""
    s, (right, down) = NAMING, line.chord
    straight, length = float(np.hypot(right, down)), line.length
    if straight < s.ring * length and length > s.ring_length * width:
        return RING
    if length < s.dot * width:
        return DOT if any(line.free) or length < s.corner * width else _kind_by_direction(right, down)
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


def name_strokes(lines: Sequence[CentreLine], character: CanonicalCharacter | None) -> tuple[Bilingual, ...]:
    """What to call each line: as a canonical stroke, or a part of one; without one, by where it stands.

    character: whose strokes the lines' numbers count.
    """
    points = np.concatenate([line.points for line in lines])
    low, high = points.min(axis=0), points.max(axis=0)
    names = []
    for line in lines:
        if line.number and character is not None:
            legs = [other for other in lines if other.number == line.number]
            names.append(_name_leg(line, legs, character.strokes[line.number - 1].name))
        else:
            zh, en = place_of((line.points.mean(axis=0) - low) / np.maximum(high - low, 1e-9))
            names.append(Bilingual(f"{zh}的一筆", f"the stroke at the {en}"))
    return tuple(names)


def canonical_kind(
    line: CentreLine, lines: Sequence[CentreLine], character: CanonicalCharacter
) -> Bilingual | None:
    """The kind of a canonical stroke, or of a part of one that bends; None where it is none.

    lines: all of the character. What to do depends on it: a part that slants and goes on into a hook has no
    tip as a left-falling stroke has one, and no foot as a right-falling one.
    """
    if not line.number:
        return None
    name = character.strokes[line.number - 1].name
    plain = next((kind for kind in PLAIN_KINDS if kind.zh == name.zh), None)
    legs = [other for other in lines if other.number == line.number]
    if plain is not None or name.zh in _SLANTED_HOOKS or _is_whole(line, legs, name):
        return plain or (_FIRST_LEGS.get(name.zh[:1], name) if name.zh[1:] in ("鉤", "提") else name)
    return _leg_kind(line, legs, name)


def _leg_kind(line: CentreLine, legs: Sequence[CentreLine], name: Bilingual) -> Bilingual:
    """What a part of a stroke that bends is: the first as the name says, the others by their direction."""
    if line is legs[0]:
        return _FIRST_LEGS.get(name.zh[:1], _kind_by_direction(*line.chord.tolist()))
    seen = _kind_by_direction(*line.chord.tolist())
    if seen not in (LEFT_FALLING, RIGHT_FALLING):
        return seen
    if line is legs[-1] and name.zh[-1:] in (LEFT_FALLING.zh, DOT.zh):
        return LEFT_FALLING if name.zh[-1:] == LEFT_FALLING.zh else DOT
    return FOLD if "折" in name.zh else SLANTED


def hook_of(legs: Sequence[CentreLine], name: Bilingual) -> CentreLine | None:
    """The last of a stroke's legs, where it is a hook by its name and its length."""
    if "鉤" not in name.zh or len(legs) < 2:
        return None
    return legs[-1] if legs[-1].length < NAMING.hook_share * max(leg.length for leg in legs) else None


def _is_whole(line: CentreLine, legs: Sequence[CentreLine], name: Bilingual) -> bool:
    """Whether a leg is all of its stroke but for a hook and a little."""
    hook = hook_of(legs, name)
    others = [leg for leg in legs if leg is not hook]
    return line is not hook and line.length >= NAMING.whole_share * sum(leg.length for leg in others)


def stroke_title(number: int, name: Bilingual) -> Bilingual:
    """A canonical stroke by its number in the order of writing, from 1, and its name."""
    zh, en = number_words(number)
    return Bilingual(f"第{zh}筆「{name.zh}」", f"the {en} stroke ({name.en})")


def strokes_title(numbers: Sequence[int]) -> Bilingual:
    """Two canonical strokes or more by their numbers in the order of writing, from 1, rising."""
    words = [number_words(number) for number in numbers]
    *first, last = (word.en for word in words)
    return Bilingual(
        f"第{'、'.join(word.zh for word in words)}筆",
        f"the {', '.join(first)} and {last} strokes",
    )


def _name_leg(line: CentreLine, legs: Sequence[CentreLine], name: Bilingual) -> Bilingual:
    """The name of a line of a stroke that is made of `legs`, which may be this one alone."""
    title = stroke_title(line.number, name)
    if line is hook_of(legs, name):
        return Bilingual(f"{title.zh}的鉤", f"the hook of {title.en}")
    if _is_whole(line, legs, name):
        return title
    part = _LEGS[_leg_kind(line, legs, name)]
    return Bilingual(f"{title.zh}的{part.zh}", f"the {part.en} part of {title.en}")


def number_words(n: int) -> Bilingual:
    """The number n, from 1 to 99, in Chinese and the ordinal in English."""
    if n <= 10:
        return Bilingual(_NUMBERS[n - 1], _ORDINALS[n - 1])
    tens, ones = divmod(n, 10)
    zh = f"{_NUMBERS[tens - 1] if tens > 1 else ''}十{_NUMBERS[ones - 1] if ones else ''}"
    ending = "th" if tens == 1 else {1: "st", 2: "nd", 3: "rd"}.get(ones, "th")
    return Bilingual(zh, f"{n}{ending}")


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
