"""A text laid onto the characters of a page: alignment that survives omissions on either side."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from rumu.errors import RumuError
from rumu.values import BoolArray, FloatArray, IntArray

Row = npt.NDArray[np.float32]
Ways = npt.NDArray[np.int8]

LONGEST_TEXT = 50_000
"""Most characters of a text that is laid onto one page."""


@dataclass(frozen=True, slots=True)
class AlignmentSettings:
    """What each step of the alignment gains or costs.

    A character of the text that fits a found one by `likeness` z gains steep * (z - even), between worst and
    best; one whose strokes are not known gains `unknown`.

    skip, skip_more: a character left out on either side, and each further one after it. beyond: each
    character of the text before the page begins or after it ends. skip_small: a small character left out.
    merge: two found characters that are one of the text; halves: where they stand beside each other. split: a
    found character that is two of the text; tall: what it gains for each pace by which it is higher than
    `usual` paces. line: a column and a line of the text that begin together.
    """

    steep: float = 3.0
    even: float = 1.15
    worst: float = -0.5
    best: float = 2.5
    unknown: float = 0.8
    skip: float = 1.4
    skip_more: float = 0.3
    beyond: float = 0.02
    skip_small: float = 0.3
    merge: float = 1.5
    halves: float = 0.0
    split: float = 2.0
    tall: float = 4.0
    usual: float = 1.2
    line: float = 0.6


class Step(IntEnum):
    """How a found character and the text go together."""

    MATCH = 0
    SKIP_FOUND = 1
    SKIP_TEXT = 2
    MERGE = 3
    SPLIT = 4


@dataclass(frozen=True, slots=True, eq=False)
class GivenText:
    """A text without its punctuation. characters: what is left. starts: (m,) bool, where a line begins."""

    characters: str
    starts: BoolArray


def read_text(text: str) -> GivenText:
    """The characters of a text: letters and signs that stand for characters, no punctuation and no spaces.

    Raises RumuError for a text without any, or one that is too long.
    """
    kept, starts, new_line = [], [], True
    for sign in unicodedata.normalize("NFC", text):
        if sign in "\r\n":
            new_line = True
        elif unicodedata.category(sign)[0] in "LN" or sign in "〇々〻":
            kept.append(sign)
            starts.append(new_line)
            new_line = False
    if not kept:
        raise RumuError(
            "expected a text with characters, got none",
            zh="這份釋文裡沒有字。",
        )
    if len(kept) > LONGEST_TEXT:
        raise RumuError(
            f"expected the text of one page, at most {LONGEST_TEXT} characters, got {len(kept)}",
            zh=f"釋文太長：一頁最多 {LONGEST_TEXT} 字，這份有 {len(kept)} 字；請只留這一頁的文字。",
        )
    return GivenText("".join(kept), np.array(starts))


@dataclass(frozen=True, slots=True, eq=False)
class FoundCharacters:
    """What the alignment knows of n found characters in reading order.

    z: (n, u) how well each of the u different characters of the text fits each. z_merged: (n, u) the same of
    each together with the one after it. mergeable: (n,) bool, whether those two may be one; beside: (n,)
    bool, whether they stand beside each other and not one below the other. small: (n,) bool. height: (n,) in
    paces of the column. first: (n,) bool, the first of a column. known: (u,) bool, whether the strokes of a
    character of the text are known.
    """

    z: FloatArray
    z_merged: FloatArray
    mergeable: BoolArray
    beside: BoolArray
    small: BoolArray
    height: FloatArray
    first: BoolArray
    known: BoolArray


@dataclass(frozen=True, slots=True)
class Aligned:
    """One step: the first found character and the first one of the text that it is about."""

    step: Step
    found: int
    text: int


def align(
    found: FoundCharacters,
    text: IntArray,
    starts: BoolArray,
    *,
    settings: AlignmentSettings | None = None,
) -> list[Aligned]:
    """The way through found characters and text that gains most.

    text: (m,) for each character of the text, which of the u different ones it is. starts: (m,) bool, where
    a line of the text begins.
    """
    settings = settings or AlignmentSettings()
    n, m = len(found.z), len(text)
    place = np.arange(m + 1, dtype=np.float32)
    step = np.zeros((n + 1, m + 1), dtype=np.int8)
    jump = np.zeros((n + 1, m + 1), dtype=np.int32)  # where a run of skipped text begins
    gain = _gains(found.z, found.known, settings)
    price = np.where(found.beside, settings.halves, settings.merge).astype(np.float32)
    merged = _gains(found.z_merged, found.known, settings) - price[:, None]
    rows = [(-settings.beyond * place).astype(np.float32)]
    step[0] = Step.SKIP_TEXT
    falling = np.full(m + 1, -np.inf, dtype=np.float32)  # the best that ends in skipped found characters
    for i in range(1, n + 1):
        before = rows[-1]
        k = i - 1
        best = np.full(m + 1, -np.inf, dtype=np.float32)
        best[1:] = before[:-1] + gain[k][text] + settings.line * (found.first[k] & starts)
        way = np.full(m + 1, Step.MATCH, dtype=np.int8)
        tall = settings.tall * (float(found.height[k]) - settings.usual)
        doubled = before[:-2] + (min(tall, 2.0) - settings.split)
        _take(best[2:], way[2:], doubled, Step.SPLIT)
        if i > 1 and found.mergeable[k - 1]:
            _take(best[1:], way[1:], rows[-2][:-1] + merged[k - 1][text], Step.MERGE)
        first, more = (settings.skip_small,) * 2 if found.small[k] else (settings.skip, settings.skip_more)
        falling = np.maximum(before - first, falling - more)
        _take(best, way, falling, Step.SKIP_FOUND)
        more_text = settings.beyond if i == n else settings.skip_more
        first_text = settings.beyond if i == n else settings.skip
        ahead = best + more_text * place
        record = np.maximum.accumulate(ahead)
        at = np.maximum.accumulate(np.where(ahead >= record, np.arange(m + 1), 0))
        skipped = np.full(m + 1, -np.inf, dtype=np.float32)
        skipped[1:] = record[:-1] - more_text * place[1:] - (first_text - more_text)
        jump[i, 1:] = at[:-1]
        _take(best, way, skipped, Step.SKIP_TEXT)
        step[i] = way
        rows.append(best)
    return _way_back(step, jump, n, m)


def _gains(z: FloatArray, known: BoolArray, settings: AlignmentSettings) -> Row:
    gain = np.clip(settings.steep * (z - settings.even), settings.worst, settings.best)
    return np.where(known[None, :], gain, settings.unknown).astype(np.float32)


def _take(best: Row, way: Ways, other: Row, step: Step) -> None:
    """Write `other` over `best` where it is better, and the step into `way`."""
    better = other > best
    best[better] = other[better]
    way[better] = step


def _way_back(step: Ways, jump: npt.NDArray[np.int32], n: int, m: int) -> list[Aligned]:
    taken: list[Aligned] = []
    i, j = n, m
    while i > 0 or j > 0:
        kind = Step(int(step[i, j]))
        if kind == Step.SKIP_TEXT:
            begin = int(jump[i, j]) if i else 0
            taken += [Aligned(kind, i, k) for k in range(j - 1, begin - 1, -1)]
            j = begin
            continue
        back_i, back_j = {
            Step.MATCH: (1, 1), Step.SKIP_FOUND: (1, 0), Step.MERGE: (2, 1), Step.SPLIT: (1, 2)
        }[kind]  # fmt: skip
        i, j = i - back_i, j - back_j
        taken.append(Aligned(kind, i, j))
    return taken[::-1]


def distinct_characters(text: str) -> tuple[list[str], IntArray]:
    """The different characters of a text in order, and which of them each one is."""
    different = sorted(set(text))
    number = {character: k for k, character in enumerate(different)}
    return different, np.array([number[character] for character in text], dtype=np.intp)
