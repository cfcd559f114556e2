"""What the words of a search mean, and the works that they find, the nearest first.

A word may be the character of a work, its reading, a name of the writer or of the work, a script, a dynasty,
or stand elsewhere in the catalogue. Each meaning is a condition in SQL and has a rank; works must match every
word, and come in the order of the sum of their best ranks.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, and_, case, false, literal, or_, select
from sqlalchemy.orm import Session

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.names import calligraphers, famous_works, latin_words
from rumu.gallery.pinyin import is_han, split_pinyin, text_readings, unfinished_pinyin, without_tones
from rumu.gallery.search_text import Word, split_words
from rumu.gallery.vocabulary import variants, words_of_dynasties, words_of_scripts

MEANINGS = (
    "character", "form", "reading", "other_reading", "hand", "title", "hand", "title", "script", "dynasty",
    "other",
)  # fmt: skip
"""What a word is, by its rank; the first 'hand' and 'title' are whole names, the second parts of them."""

_LAST_OF_CHARACTER = 3
_WHOLE_HAND, _PART_OF_HAND, _PART_OF_TITLE = 4, 6, 7
MAX_QUERY = 200  # characters
_MOST_WORDS = 24
_MOST_JOINED = 6  # words of one name
_STOP_LIST = "a an the of by in on to and s character calligraphy 的 字 书法 作品 书 写"
_STOP_WORDS = frozenset(_STOP_LIST.split())


@dataclass(frozen=True, slots=True)
class Found:
    """What a word was understood as. works: how many of those found have this as their best match."""

    word: str
    meaning: str
    works: int


@dataclass(frozen=True, slots=True, eq=False)
class SearchWord:
    """A word of a search, or words that are one name. shown: as they were typed. texts: folded."""

    shown: str
    texts: tuple[str, ...]
    latin: bool
    typed: str
    alone: bool = False

    def meanings(self, columns: Any) -> list[tuple[int, ColumnElement[bool]]]:
        """(rank, condition) of each meaning, the best first."""
        made = self._latin(columns) if self.latin else self._chinese(columns)
        joined = "".join(self.texts)
        script = words_of_scripts().get(joined)
        if script and (len(joined) > 1 or not self.alone):  # 行 alone is the character
            made.append((8, columns.script == script))
        dynasty = words_of_dynasties().get(joined)
        if dynasty:
            made.append((9, (literal("/") + columns.dynasty + "/").contains(f"/{dynasty}/")))
        return sorted(made, key=lambda one: one[0])

    def broadest(self, columns: Any) -> list[ColumnElement[bool]]:
        """The conditions that no other one includes: a part of a name includes the whole."""
        meanings = self.meanings(columns)
        parts = {rank for rank, _ in meanings} & {_PART_OF_HAND, _PART_OF_TITLE}
        return [condition for rank, condition in meanings if rank + _PART_OF_HAND - _WHOLE_HAND not in parts]

    def _chinese(self, columns: Any) -> list[tuple[int, ColumnElement[bool]]]:
        text = "".join(self.texts)
        title, hand = columns.search_title, columns.search_hand
        if len(text) == 1:
            return [
                (0, columns.character == self.typed),
                (1, columns.character.in_(variants(self.typed))),
                (4, _holds(hand, f"\n{text}\n")),
                (7, _holds(title, *(f"={form}" for form in variants(self.typed)))),
            ]
        return [
            (0, columns.character == self.typed),
            (1, _holds(columns.search_character, f"\n{text}\n")),
            (4, _holds(hand, f"\n{text}\n")),
            (5, _holds(title, f"\n{text}\n")),
            (6, _holds(hand, text)),
            (7, _holds(title, text)),
            (10, _holds(columns.search_more, text)),
        ]

    def _latin(self, columns: Any) -> list[tuple[int, ColumnElement[bool]]]:
        words = " ".join(self.texts)
        ways = split_pinyin(self.typed)
        begun = [f"'{chr(39).join(way)}" for way in unfinished_pinyin(self.typed)] if not ways else []
        read = [f"'{chr(39).join(without_tones(way))}'" for way in ways]
        other = f"\n~{''.join(self.texts)}\n"
        begins = f" {words}" if len(words) > 1 else f" {words} "  # 'a' shall not find all that begins so
        pieces = [begins, *read, *begun, other]
        wholes = [f"\n {words} \n", other, *(f"\n{text}\n" for text in read)]
        surnames = [f"^{''.join(without_tones(way))}\n" for way in ways]
        longer = [text for text, way in zip(read, ways, strict=True) if len(way) > 1]  # not 智永 for 'yong'
        made = [
            (4, _holds(columns.search_hand, *wholes)),
            (5, _holds(columns.search_title, *wholes)),
            (6, _holds(columns.search_hand, begins, *longer, *begun, other, *wholes, *surnames)),
            (7, _holds(columns.search_title, *pieces)),
            (10, _holds(columns.search_more, *pieces)),
        ]
        if ways:
            spoken = ["".join(way) for way in ways]
            made.append((2, _holds(columns.search_character, *(f"\n1{one}\n" for one in spoken))))
            made.append((3, _holds(columns.search_character, *(f"\n2{one}\n" for one in spoken))))
        return made


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """The words of a search. `nothing`: it consists of signs that no text holds, so it finds nothing."""

    words: tuple[SearchWord, ...] = ()
    nothing: bool = False

    def condition(self, columns: Any) -> ColumnElement[bool] | None:
        """Whether a work matches every word; None when nothing is searched."""
        if self.nothing:
            return false()
        if not self.words:
            return None
        return and_(*(or_(*word.broadest(columns)) for word in self.words))

    def names_character(self, columns: Any) -> ColumnElement[bool] | None:
        """Whether a word is the character of a work, by its form or its reading; None where none can be."""
        found = [
            condition
            for word in self.words
            for rank, condition in word.meanings(columns)
            if rank <= _LAST_OF_CHARACTER
        ]
        return or_(*found) if found else None

    def ranks(self, columns: Any) -> list[ColumnElement[int]]:
        """The best rank of a work for each word."""
        last = len(MEANINGS) - 1
        return [
            case(*((condition, rank) for rank, condition in word.meanings(columns)), else_=last)
            for word in self.words
        ]


def _holds(column: Any, *pieces: str) -> ColumnElement[bool]:
    return or_(*(column.contains(piece, autoescape=True) for piece in dict.fromkeys(pieces)))


# --- understanding ---------------------------------------------------------------------------------


def understand(session: Session, text: str | None) -> Search:
    """The words of a search; several that are one name, such as 'wang xi zhi', are one word.

    A run of Chinese characters that stands nowhere is parted into the names in it: 王羲之蘭亭序.
    Raises GalleryError for a text of more than MAX_QUERY characters.
    """
    if not text or not text.strip():
        return Search()
    if len(text) > MAX_QUERY:
        raise GalleryError(
            f"expected a search of at most {MAX_QUERY} characters, got {len(text)}",
            zh=f"搜尋文字最多 {MAX_QUERY} 字，這裡有 {len(text)} 字。",
        )
    words = list(dict.fromkeys(split_words(text)))
    if len(words) > 1:
        words = [word for word in words if word.text not in _STOP_WORDS or _is_character(word)] or words
    if not words:
        return Search(nothing=True)
    names = _known_names() | _hands_of(session) if len(words) > 1 or len(words[0].text) > 1 else frozenset()
    found: list[SearchWord] = []
    for word in _join_names(words[:_MOST_WORDS], names):
        found.extend(_parts(session, word, names))
    alone = len(found) == 1
    return Search(tuple(SearchWord(w.shown, w.texts, w.latin, w.typed, alone) for w in found))


def _is_character(word: Word) -> bool:
    """Whether a stop word may be what is searched: 書, but not 的 or 'the'."""
    return word.text == "书"


def _join_names(words: Sequence[Word], names: frozenset[str]) -> list[SearchWord]:
    """Latin words that are one name together, the longest first, and all other words alone."""
    joined: list[SearchWord] = []
    at = 0
    while at < len(words):
        end = at + 1
        for last in range(min(len(words), at + _MOST_JOINED), at + 1, -1):
            some = words[at:last]
            if all(word.latin for word in some) and "".join(word.text for word in some) in names:
                end = last
                break
        some = words[at:end]
        shown, typed = " ".join(word.typed for word in some), "".join(word.typed for word in some)
        joined.append(SearchWord(shown, tuple(word.text for word in some), words[at].latin, typed))
        at = end
    return joined


def _parts(session: Session, word: SearchWord, names: frozenset[str]) -> list[SearchWord]:
    """The word, or the names that it is made of where it stands nowhere as a whole."""
    text = "".join(word.texts)
    if word.latin or len(text) < 2 or text in names or len(text) != len(word.typed):
        return [word]
    pieces = _cut(text, names)
    if len(pieces) < 2:
        return [word]
    condition = Search((word,)).condition(Work.__table__.c)
    if condition is not None and session.scalar(select(Work.id).where(condition).limit(1)) is not None:
        return [word]
    made, at = [], 0
    for piece in pieces:
        typed = word.typed[at : at + len(piece)]
        at += len(piece)
        if piece not in _STOP_WORDS:
            made.append(SearchWord(typed, (piece,), False, typed))
    return made or [word]


def _cut(text: str, names: frozenset[str]) -> list[str]:
    """A text cut into known names, the longest first, and what is left between them; 永字 is 永 and 字."""
    pieces, rest, at = [], "", 0
    while at < len(text):
        ends = range(min(len(text), at + 12), at, -1)
        end = next((end for end in ends if text[at:end] in names), None)
        if end is None:
            rest, at = rest + text[at], at + 1
            continue
        pieces += ([rest] if rest else []) + [text[at:end]]
        rest, at = "", end
    if len(rest) > 1 and rest[-1] == "字":
        pieces, rest = [*pieces, rest[:-1]], "字"
    return [*pieces, rest] if rest else pieces


@functools.cache
def _known_names() -> frozenset[str]:
    """All names of the vocabulary, folded and without spaces; those in Latin letters in either order."""
    names = {*words_of_scripts(), *words_of_dynasties()}
    for one in (*calligraphers(), *famous_works()):
        names.update(one.chinese)
        for latin in one.latin:
            words = latin_words(latin).split()
            names.update(("".join(words), "".join((*words[1:], words[0]))))
    return frozenset(names)


def _hands_of(session: Session) -> frozenset[str]:
    """The names of the gallery's writers, folded and without spaces, and the readings of Chinese ones."""
    rows = session.execute(select(Work.hand_zh, Work.hand_en).distinct())
    return frozenset(name for row in rows for text in row if text for name in _names_of(text))


@functools.lru_cache(maxsize=8192)
def _names_of(text: str) -> tuple[str, ...]:
    words = split_words(text)
    latin = [word.text for word in words if word.latin]
    runs = [word for word in words if not word.latin]
    spoken = [
        way
        for run in runs
        if is_han(run.text)
        for way in text_readings(run.typed, run.text, surname=True, most=2)
    ]
    orders = [tuple(latin), *spoken]
    names = [*(run.text for run in runs), *("".join(order) for order in orders)]
    names += ["".join((*order[1:], order[0])) for order in orders if order]
    return tuple(name for name in names if len(name) > 1)


# --- results ---------------------------------------------------------------------------------------


def find_works(
    session: Session, search: Search, where: Sequence[ColumnElement[bool]], order: Sequence[Any]
) -> list[tuple[str, tuple[int, ...]]]:
    """The works that match, the nearest first: the id of each, and the rank of its meaning for each word.

    where: all conditions. order: of works that are equally near. One statement looks through the texts once.
    """
    ranks = search.ranks(Work.__table__.c)
    rows = session.execute(select(Work.id, *ranks).where(*where).order_by(*order))
    return sorted(((name, tuple(of_words)) for name, *of_words in rows), key=lambda one: sum(one[1]))


def count_meanings(search: Search, found: Sequence[tuple[str, tuple[int, ...]]]) -> tuple[Found, ...]:
    """For each word, how many of the works found have each meaning as their best, in order of rank."""
    counts = Counter((number, rank) for _, ranks in found for number, rank in enumerate(ranks))
    merged: dict[tuple[int, str], int] = {}
    for (number, rank), works in sorted(counts.items()):
        key = (number, MEANINGS[rank])
        merged[key] = merged.get(key, 0) + works
    return tuple(
        Found(search.words[number].shown, meaning, works) for (number, meaning), works in merged.items()
    )
