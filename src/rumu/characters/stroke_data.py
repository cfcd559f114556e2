"""Strokes of 9,574 characters: outlines and centre lines in the order of writing, names, structure.

strokes.bin is compiled by frontend/characters/compile.mjs when the package is built, from hanzi-writer-data
(Arphic Public License, see ARPHICPL.TXT) and cnchar (MIT). It holds, one after another,

    the magic word; uint32, little endian: number of characters, characters in a block, the code points in
    rising order, the length of each block; the blocks, each compressed by Brotli.

A block holds five runs of numbers of 7 bits a byte, the lowest bits first, the sign in the lowest bit: the
lengths in bytes of the other four; heads (for each character its structure, where its radical ends or begins
and its number of strokes, for each stroke its name, the points of its centre line and the commands of its
outline); centre lines; commands; outlines. Points are steps from the one before; a control point is counted
from the middle of its curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from itertools import accumulate, pairwise
from typing import Literal, get_args

import brotli
import numpy as np
import numpy.typing as npt

from rumu.errors import RumuError
from rumu.values import Bilingual, FloatArray, IntArray, Script

Structure = Literal[
    "left-right",
    "top-bottom",
    "single",
    "half-enclosed",
    "enclosed",
    "three alike",
    "top-middle-bottom",
    "left-middle-right",
]

_MAGIC = b"rumu characters 2"
_SQUARE = 1024.0  # units of the source along each side of its square
_LINE_GRID, _OUTLINE_GRID = 6.0, 7.0  # units to which points are rounded, as in compile.mjs
_COMMANDS = {"M": 1, "L": 1, "Q": 2, "C": 3, "Z": 0}  # and how many points each takes
_CURVE_STEPS = 6  # straight pieces for each curve of an outline

STROKE_SCRIPTS: tuple[Script | None, ...] = (None, "regular", "running")
"""Scripts whose strokes are those of copybooks, or nearly; None where it is not known."""
STROKE_NAMES = {
    "a": Bilingual("橫折折撇", "horizontal with two bends, falling left"),
    "b": Bilingual("豎彎", "vertical with a bend"),
    "c": Bilingual("橫折", "horizontal with a bend"),
    "d": Bilingual("點", "dot"),
    "e": Bilingual("橫撇", "horizontal, falling left"),
    "f": Bilingual("豎", "vertical"),
    "g": Bilingual("豎鉤", "vertical with a hook"),
    "h": Bilingual("豎提", "vertical with a rise"),
    "i": Bilingual("提", "rising stroke"),
    "j": Bilingual("橫", "horizontal"),
    "k": Bilingual("點", "dot"),
    "l": Bilingual("捺", "right-falling stroke"),
    "m": Bilingual("撇點", "left-falling stroke with a dot"),
    "n": Bilingual("撇折", "left-falling stroke with a bend"),
    "o": Bilingual("橫斜鉤", "horizontal with a slanted hook"),
    "p": Bilingual("橫折提", "horizontal with a bend and a rise"),
    "q": Bilingual("橫折折折", "horizontal with three bends"),
    "r": Bilingual("橫折鉤", "horizontal with a bend and a hook"),
    "s": Bilingual("撇", "left-falling stroke"),
    "t": Bilingual("彎鉤", "curved hook"),
    "u": Bilingual("豎彎鉤", "vertical with a bend and a hook"),
    "v": Bilingual("橫折彎", "horizontal with two bends"),
    "w": Bilingual("橫折折折鉤", "horizontal with three bends and a hook"),
    "x": Bilingual("豎折折", "vertical with two bends"),
    "y": Bilingual("斜鉤", "slanted hook"),
    "z": Bilingual("豎折折鉤", "vertical with two bends and a hook"),
}
"""Names of strokes by the letters of cnchar; a letter may stand for two, see `stroke_name`."""

_SECOND_NAMES = {
    "b": Bilingual("豎折", "vertical with a sharp bend"),
    "e": Bilingual("橫鉤", "horizontal with a hook"),
    "o": Bilingual("橫折彎鉤", "horizontal with two bends and a hook"),
    "w": Bilingual("橫撇彎鉤", "horizontal, falling left, with a curved hook"),
    "x": Bilingual("豎折撇", "vertical with a bend, falling left"),
    "y": Bilingual("臥鉤", "lying hook"),
}
"""The other stroke that a letter may stand for."""

_STRAIGHT = 0.9
"""Chord over length from which a line does not bend."""
_LEVEL, _UPRIGHT, _RISING = (-35.0, 20.0), (70.0, 110.0), -9.5
"""Degrees, y downward, of a straight line that is a horizontal, or a vertical, and from which none rises."""
_DOTS, _SLANTING = "kdl", "is"
"""Letters of dots and right-falling strokes, which may lie in any way; and of others that may be upright."""
_AROUND_BOX, _TOUCHING = "cr", 0.09
"""Letters of strokes around a box; and from where two do not begin together, in sides of the square."""


def stroke_name(letter: str, centre_line: FloatArray) -> Bilingual:
    """The name of a stroke: what a letter of cnchar stands for, unless its line shows another.

    centre_line: (n, 2), x right, y down. Of the two strokes that a letter may stand for, the one that the
    line shows. cnchar counts the strokes of some characters in another order than hanzi-writer, and those
    it does not know were named like others of that shape, wrong ones among them (in 傳 the vertical through
    the middle was a horizontal): a straight line that plainly lies level, or stands upright, is named by
    itself.
    """
    plain = _plain_letter(letter, centre_line)
    if plain != letter:
        return STROKE_NAMES[plain]
    if letter not in _SECOND_NAMES:
        return STROKE_NAMES[letter]
    line = evenly_spaced(centre_line, 64)
    x, y = line.T
    right, down = np.ptp(x), np.ptp(y)
    after_turn, after_foot = int(np.argmax((x - y)[:40])), int(np.argmax(y - x))  # the farthest corners
    body = line[after_turn : max(int(np.argmax(x + y)), after_turn) + 1]  # down to the lower right
    flat = body[body[:, 1] > body[-1, 1] - 0.2 * down]
    is_second = {
        "b": np.ptp(x[after_foot:]) > 0.8 * down,
        "e": np.hypot(*(line[-1] - line[after_turn])) < 0.45 * right,
        "o": np.ptp(flat[:, 0]) > 0.385 * right,
        "w": right < 0.55 * down,
        "x": x[-1] < x.max() - 0.5 * right and y[-1] > y.min() + 0.6 * down,
        "y": right > down,
    }
    return (_SECOND_NAMES if is_second[letter] else STROKE_NAMES)[letter]


def _is_side_of_box(letter: str, line: FloatArray, next_letter: str, next_line: FloatArray) -> bool:
    """Whether a stroke that is called a dot is the left side of 口 or the like, as in 銘.

    It stands upright, and the stroke that bends around the box begins where it begins.
    """
    if letter not in _DOTS or next_letter not in _AROUND_BOX:
        return False
    right, down = line[-1] - line[0]
    apart = float(np.hypot(*(next_line[0] - line[0]))) * (_LINE_GRID / _SQUARE)
    return apart < _TOUCHING and bool(_UPRIGHT[0] <= np.degrees(np.arctan2(down, right)) <= _UPRIGHT[1])


def _plain_letter(letter: str, centre_line: FloatArray) -> str:
    """The letter, or that of the horizontal or the vertical that the line plainly is."""
    right, down = centre_line[-1] - centre_line[0]
    chord, length = np.hypot(right, down), np.hypot(*np.diff(centre_line, axis=0).T).sum()
    if chord < _STRAIGHT * length or letter in _DOTS:
        return letter
    angle = float(np.degrees(np.arctan2(down, right)))
    if _LEVEL[0] <= angle <= _LEVEL[1] and (letter != "i" or angle > _RISING):
        return "j"
    return "f" if _UPRIGHT[0] <= angle <= _UPRIGHT[1] and letter not in _SLANTING else letter


def evenly_spaced(line: FloatArray, count: int) -> FloatArray:
    """(count, 2): points at equal distances along the line through (n, 2) points, both ends among them."""
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0.0, arc[-1], count)
    return np.column_stack([np.interp(at, arc, line[:, k]) for k in (0, 1)])


@dataclass(frozen=True, slots=True, eq=False)
class CanonicalStroke:
    """One stroke as copybooks print it, in fractions of the square, x right, y down.

    name: in both languages. centre_line: (n, 2) float64, in the direction of writing. outline: commands of an
    SVG path with their points, (k, 2) each: M, L, Q, C and Z.
    """

    name: Bilingual
    centre_line: FloatArray
    outline: tuple[tuple[str, FloatArray], ...]

    def svg_path(self, *, side: float = 1.0) -> str:
        """The outline as the `d` of an SVG path in a square of this side."""
        return " ".join(
            " ".join([command, *(f"{side * x:.4g} {side * y:.4g}" for x, y in points)])
            for command, points in self.outline
        )

    def polygon(self) -> FloatArray:
        """(n, 2): the outline with its curves made of straight pieces."""
        at, pieces = np.zeros(2), []
        s = np.linspace(0.0, 1.0, _CURVE_STEPS + 1)[1:, None]
        for command, points in self.outline:
            if command == "Q":
                a, b = points
                pieces.append((1 - s) ** 2 * at + 2 * s * (1 - s) * a + s**2 * b)
            elif command == "C":
                a, b, c = points
                start, end = (1 - s) ** 3 * at + 3 * s * (1 - s) ** 2 * a, 3 * s**2 * (1 - s) * b + s**3 * c
                pieces.append(start + end)
            else:
                pieces.append(points)
            at = points[-1] if len(points) else at
        return np.concatenate(pieces)


@dataclass(frozen=True, slots=True, eq=False)
class CanonicalCharacter:
    """A character as copybooks print it.

    structure: None where it is not known. radical_border: after how many strokes its radical ends, when that
    is written first, or begins, when it is written last; None where it is neither, or the whole character.
    """

    character: str
    strokes: tuple[CanonicalStroke, ...]
    structure: Structure | None
    radical_border: int | None = None


def find_character(character: str) -> CanonicalCharacter | None:
    """Strokes and structure of a character; None for one that is not known, and for other text.

    Raises RumuError when the package was built without its data.
    """
    if len(character) != 1:
        return None
    index = _read_index()
    at = int(np.searchsorted(index.code_points, ord(character)))
    if at == len(index.code_points) or index.code_points[at] != ord(character):
        return None
    block, k = divmod(at, index.per_block)
    return _read_block(block).character(k, character)


def known_characters() -> str:
    """All characters whose strokes are known, in the order of their code points."""
    return "".join(map(chr, _read_index().code_points.tolist()))


@dataclass(frozen=True, slots=True, eq=False)
class _Index:
    """code_points: (n,) rising. per_block: characters in a block. starts: first byte of each, and the end."""

    code_points: IntArray
    per_block: int
    starts: IntArray


@lru_cache(maxsize=1)
def _read_index() -> _Index:
    path = files("rumu.characters") / "strokes.bin"
    try:
        with path.open("rb") as stream:
            if stream.read(len(_MAGIC)) != _MAGIC:
                raise RumuError(
                    "rumu/characters/strokes.bin: expected strokes as this version packs them, got another "
                    "file; run scripts/install"
                )
            count, per_block = np.frombuffer(stream.read(8), "<u4").tolist()
            blocks = -(-count // per_block)
            numbers = np.frombuffer(stream.read(4 * (count + blocks)), "<u4").astype(np.intp)
            first = stream.tell()
    except FileNotFoundError as error:
        raise RumuError(
            "rumu/characters/strokes.bin is missing: expected a package that was built, got bare sources; "
            "run scripts/install"
        ) from error
    starts = np.concatenate([[0], np.cumsum(numbers[count:])]) + first
    return _Index(numbers[:count], per_block, starts)


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """Some characters: heads as numbers, points of lines and outlines as grid steps, commands as indices."""

    heads: IntArray
    lines: IntArray
    commands: IntArray
    outlines: IntArray

    def character(self, wanted: int, character: str) -> CanonicalCharacter:
        """The one of this number within the block."""
        heads, line, command = iter(self.heads.tolist()), 0, 0
        for _ in range(wanted):
            _, _, count = next(heads), next(heads), next(heads)
            for _, points, commands in [(next(heads), next(heads), next(heads)) for _ in range(count)]:
                line, command = line + 2 * points, command + commands
        points_of = np.array(list(_COMMANDS.values()))
        steps = iter(self.outlines[2 * int(points_of[self.commands[:command]].sum()) :].tolist())
        names, begin, strokes = list(_COMMANDS), (0, 0), list[CanonicalStroke]()
        structure, border, count = next(heads), next(heads), next(heads)
        before: tuple[str, FloatArray] | None = None
        for number, points, commands in [(next(heads), next(heads), next(heads)) for _ in range(count)]:
            centre = np.cumsum(self.lines[line : line + 2 * points].reshape(-1, 2), axis=0).astype(float)
            own = [names[c] for c in self.commands[command : command + commands]]
            outline, begin = _draw(own, steps, begin)
            letter = chr(ord("a") + number)
            if before and _is_side_of_box(*before, letter, centre):
                strokes[-1] = replace(strokes[-1], name=STROKE_NAMES["f"])
            before = letter, centre
            name = stroke_name(letter, centre)
            strokes.append(CanonicalStroke(name, centre * (_LINE_GRID / _SQUARE), outline))
            line, command = line + 2 * points, command + commands
        told = (None, *get_args(Structure))[structure]
        return CanonicalCharacter(character, tuple(strokes), told, border or None)


def _draw(
    commands: list[str], steps: Iterator[int], begin: tuple[int, int]
) -> tuple[tuple[tuple[str, FloatArray], ...], tuple[int, int]]:
    """The outline of one stroke, and where it begins; begin: where the one before began."""
    x, y = begin
    outline = []
    for command in commands:
        points: list[tuple[int, int]] = []
        if _COMMANDS[command]:
            right, down = x + next(steps), y + next(steps)
            middle = ((x + right) >> 1, (y + down) >> 1)
            for _ in range(_COMMANDS[command] - 1):
                points.append((middle[0] + next(steps), middle[1] + next(steps)))
            points.append((right, down))
            x, y = right, down
        if command == "M":
            begin = (x, y)
        outline.append((command, np.array(points, float).reshape(-1, 2) * (_OUTLINE_GRID / _SQUARE)))
    return tuple(outline), begin


@lru_cache(maxsize=16)
def _read_block(number: int) -> _Block:
    first, end = _read_index().starts[number : number + 2].tolist()
    with (files("rumu.characters") / "strokes.bin").open("rb") as stream:
        stream.seek(first)
        data = np.frombuffer(brotli.decompress(stream.read(end - first)), np.uint8)
    after_sizes = int(np.flatnonzero(data < 128)[3]) + 1
    ends = list(accumulate(_read_numbers(data[:after_sizes]).tolist(), initial=after_sizes))
    return _Block(*(_read_numbers(data[a:b]) for a, b in pairwise(ends)))


def _read_numbers(data: npt.NDArray[np.uint8]) -> IntArray:
    """Numbers of 7 bits a byte, the lowest bits first; a set top bit says that more bytes follow."""
    last = np.flatnonzero(data < 128)
    first = np.concatenate([[0], last[:-1] + 1])
    place = np.arange(len(data)) - np.repeat(first, last - first + 1)
    plain = np.add.reduceat((data & 127).astype(np.intp) << (7 * place), first)
    return np.where(plain & 1, -((plain + 1) >> 1), plain >> 1)
