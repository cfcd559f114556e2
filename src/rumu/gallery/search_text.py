"""The texts of a work that searches look through: four columns, by what a word would mean there.

A column holds lines. Chinese text stands folded and without spaces, and its readings as 'lan'ting'xu'. Text
in Latin letters stands as words with a space around each. A single character of a title stands behind '=',
the reading of another name behind '~', that of a surname behind '^', the names of the author of a copied
work behind '@', and the readings of a work's character behind 1, the usual one, or 2. So each question is
whether a column contains a piece of text, which SQLite and PostgreSQL answer alike.
"""

from __future__ import annotations

import functools
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rumu.gallery.names import Names, people_named, works_named
from rumu.gallery.pinyin import character_readings, is_han, split_pinyin, text_readings, without_tones
from rumu.gallery.vocabulary import dynasty_name, fold
from rumu.values import Bilingual

SEARCH_VERSION = 2
"""Increase it when the texts of the same work would come out differently; they are then made again."""

COLUMNS = ("search_character", "search_title", "search_hand", "search_more")

_SCRIPT_WORD = re.compile("[篆隶楷行草真正][书楷体草]|书法|[大小]楷|[大小章狂今]草|八分")
_COMPOUND = re.compile(
    "欧阳|司马|诸葛|上官|尉迟|长孙|皇甫|鲜于|宇文|公孙|慕容|端木|东方|独孤|令狐|夏侯|完颜|康里"
)
_LONGEST_RUN = 40  # characters of a run whose readings are searched
_JOINED = re.compile("(?<=[A-Za-zÀ-ɏ])['’‘`ʼ](?=[A-Za-zÀ-ɏ])")


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a text. text: folded; in Latin letters without accents. typed: as it stood, for its tones."""

    text: str
    latin: bool
    typed: str


def split_words(text: str) -> tuple[Word, ...]:
    """The words of a text: of Latin letters and digits, and of any other letters and symbols.

    Spaces and punctuation part words, and so does the change between the two kinds; an apostrophe within
    'xi'an' does not.
    """
    words: list[tuple[bool, str]] = []
    parted = True
    for char in _JOINED.sub("'", unicodedata.normalize("NFKC", text).lower().replace("u:", "ü")):
        kind = unicodedata.category(char)
        if kind == "Cf" or "\ufe00" <= char <= "\ufe0f":  # joiners and selectors are no text
            continue
        base = unicodedata.normalize("NFD", char)[0]
        latin = base.isascii() and base.isalnum()
        if kind[0] == "M" or (char == "'" and not parted and words[-1][0]):
            if not parted:
                words[-1] = (words[-1][0], words[-1][1] + char)
        elif kind[0] in "LN" or kind == "So":
            if parted or words[-1][0] != latin:
                words.append((latin, ""))
            words[-1] = (latin, words[-1][1] + char)
            parted = False
        else:
            parted = True
    return tuple(_word(typed.rstrip("'"), latin) for latin, typed in words)


def _word(typed: str, latin: bool) -> Word:
    if not latin:
        return Word(fold(typed), False, typed)
    plain = "".join(char for char in unicodedata.normalize("NFD", typed) if char.isascii() and char.isalnum())
    return Word(plain, True, typed)


def search_columns(row: Mapping[str, Any], *, collection: Bilingual) -> dict[str, Any]:
    """The columns that searches look through, of a row of tables.Work."""
    title = _Text(row["title_zh"], row["title_en"])
    works = works_named(title.chinese, title.words)
    hand, people, hand_lines = _hand(row["hand_zh"], row["hand_en"])
    authors = dict.fromkeys(one.author for one in works if one.author and one.author not in people)
    names = (line for one in works for line in _name_lines(one))
    makers = (line for one in authors for line in _name_lines(one, surname=True))
    return {
        "search_character": _column(_character_lines(row["character"])),
        "search_title": _column([*title.lines(), *names, _single_characters(title, hand, row["character"])]),
        "search_hand": _column([*hand_lines, *(line if line[0] == "~" else f"@{line}" for line in makers)]),
        "search_more": _column(
            [
                *_more_lines(row["period_zh"], row["period_en"], row["dynasty"], collection),
                *_Text(row["id"]).plain_lines(),
                *_Text(row.get("text") or "").joined,
            ]
        ),
        "search_version": SEARCH_VERSION,
    }


class _Text:
    """Texts about one thing, parted into Chinese and Latin.

    runs: of characters that are not Latin, folded; forms: the same as they stood. chinese: each text's runs
    joined. words: the Latin ones, ' wang xizhi '.
    """

    def __init__(self, *texts: str) -> None:
        parts = [split_words(text) for text in dict.fromkeys(texts) if text]
        others = [[word for word in words if not word.latin] for words in parts]
        self.latin = [[word for word in words if word.latin] for words in parts]
        self.runs = [word.text for words in others for word in words]
        self.forms = {word.text: word.typed for words in others for word in words}
        self.joined = ["".join(word.text for word in words) for words in others if words]
        self.forms |= {
            "".join(word.text for word in words): "".join(word.typed for word in words) for words in others
        }
        self.chinese = "\n".join(self.joined)
        self.words = "\n".join(f" {' '.join(word.text for word in words)} " for words in self.latin if words)

    def plain_lines(self) -> Iterable[str]:
        """The texts as they are, without readings."""
        yield from (*self.joined, *self.runs, *self.words.splitlines())

    def lines(self, *, surname: bool = False) -> Iterable[str]:
        """All lines of a column. surname: it names a person."""
        yield from self.plain_lines()
        for run in dict.fromkeys((*self.joined, *self.runs)):
            form, at = self.forms.get(run, run), 0
            for word in [*_SCRIPT_WORD.finditer(run), None]:  # 'shu' shall not find every 楷書
                end = word.start() if word else len(run)
                yield from _reading_lines(run[at:end], form[at:end], surname=surname)
                at = word.end() if word else end
        for words in self.latin:
            yield from _pinyin_lines(words, surname=surname)


def _reading_lines(run: str, form: str, *, surname: bool = False) -> Iterable[str]:
    if not run or not is_han(run) or len(run) > _LONGEST_RUN or len(run) != len(form):
        return
    for way in text_readings(form, run, surname=surname, most=8 if len(run) <= 8 else 3):
        yield _syllables(way)
        if surname and len(way) > 1:
            first = 2 if _COMPOUND.match(run) and len(way) > 2 else 1
            yield _syllables((*way[first:], *way[:first]))
            yield f"^{''.join(way[:first])}"


def _pinyin_lines(words: list[Word], *, surname: bool) -> Iterable[str]:
    """The readings that Latin words are, where they are pinyin: 'Lanting Xu' is 'lan'ting'xu'."""
    run: list[tuple[str, ...]] = []
    for word in (*words, Word("", True, "")):
        ways = split_pinyin(word.typed)
        if ways:
            run.append(without_tones(ways[0]))
        elif run:
            yield _syllables(sum(run, ()))
            if surname and len(run) > 1:
                yield _syllables(sum((*run[1:], run[0]), ()))
            run = []
        if "ü" in word.typed:
            yield f" {word.typed.replace('ü', 'v')} "


# What many works have in common is made once.


@functools.lru_cache(maxsize=4096)
def _hand(zh: str, en: str) -> tuple[_Text, tuple[Names, ...], tuple[str, ...]]:
    """The name of a writer, the known people whom it names, and its lines."""
    hand = _Text(zh, en)
    people = people_named(hand.runs, hand.words)
    known = (line for one in people for line in _name_lines(one, surname=True))
    return hand, people, (*hand.lines(surname=True), *known)


@functools.lru_cache(maxsize=4096)
def _more_lines(period_zh: str, period_en: str, dynasty: str, collection: Bilingual) -> tuple[str, ...]:
    name = dynasty_name(dynasty) if dynasty else Bilingual("", "")
    return tuple(_Text(period_zh, period_en, *name, *collection).lines())


@functools.lru_cache(maxsize=4096)
def _name_lines(one: Names, *, surname: bool = False) -> tuple[str, ...]:
    """The lines of a known person (surname) or work."""
    lines = [line for latin in one.latin for line in _Text(latin).lines(surname=surname)]
    lines += one.chinese
    if not any(split_pinyin(name.replace(" ", "")) for name in one.latin):
        lines += _reading_lines(one.chinese[0], one.chinese[0], surname=surname)
    for other in one.chinese[1:]:  # only whole: 'yong' shall not find 虞世南, who is 虞永興 too
        lines += (f"~{''.join(way)}" for way in text_readings(other, surname=surname, most=1))
    return tuple(lines)


def _single_characters(title: _Text, hand: _Text, character: str) -> str:
    """The characters of a title that one is searched by; not 書 of 楷書, nor its writer's name."""
    told = list(character if len(character) > 1 else "")
    for run in title.joined:
        rest = run
        for name in hand.runs:
            rest = rest.replace(name, " " * len(name))
        rest = _SCRIPT_WORD.sub(lambda match: " " * len(match[0]), rest)
        told += [form for form, kept in zip(title.forms[run], rest, strict=False) if kept != " "]
    return "".join(f"={one}" for one in dict.fromkeys(told))


def _character_lines(character: str) -> Iterable[str]:
    if not character:
        return
    yield fold(character)
    if len(character) > 1:
        if is_han(character):
            yield from (f"1{''.join(way)}" for way in text_readings(character, fold(character)))
        return
    readings = character_readings(character) or character_readings(fold(character))
    for number, reading in enumerate(readings):
        rank = "1" if number == 0 else "2"
        yield from (rank + reading, rank + reading.rstrip("12345"))


def _syllables(way: Iterable[str]) -> str:
    return f"'{chr(39).join(way)}'"


def _column(lines: Iterable[str]) -> str:
    text = "\n".join(dict.fromkeys(line for line in lines if line))
    return f"\n{text}\n" if text else ""
