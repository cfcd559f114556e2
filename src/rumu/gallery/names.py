"""Names of calligraphers and of famous works, in Chinese and in Latin letters.

names.txt lists them: facts that every handbook has. So a work whose Chinese title alone is known is found by
its English name, and a copy of a famous work by the name of whom it goes back to.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources

from rumu.gallery.vocabulary import fold, words_of_dynasties, words_of_scripts


@dataclass(frozen=True, slots=True)
class Names:
    """The names of a person or a work: in Chinese, folded, and in Latin letters. author: of a work."""

    chinese: tuple[str, ...]
    latin: tuple[str, ...]
    author: Names | None = None


@functools.cache
def calligraphers() -> tuple[Names, ...]:
    """The known calligraphers."""
    return _read_names()[0]


@functools.cache
def famous_works() -> tuple[Names, ...]:
    """The known works."""
    return _read_names()[1]


@functools.cache
def _read_names() -> tuple[tuple[Names, ...], tuple[Names, ...]]:
    text = resources.files("rumu.gallery").joinpath("names.txt").read_text(encoding="utf-8")
    people, works = (
        [line.split("\t") for line in part.splitlines() if "\t" in line] for part in text.split("\n\n")
    )
    hands = tuple(_names(*fields) for fields in people)
    by_name = {one.chinese[0]: one for one in hands}
    titles = tuple(
        Names(*_split(*fields[:2]), by_name[fold(fields[2])] if len(fields) > 2 else None) for fields in works
    )
    return hands, titles


def _names(chinese: str, latin: str) -> Names:
    return Names(*_split(chinese, latin))


def _split(chinese: str, latin: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    return tuple(dict.fromkeys(fold(name) for name in chinese.split("|"))), tuple(latin.split("|"))


def people_named(runs: Iterable[str], words: str) -> tuple[Names, ...]:
    """The known calligraphers whom a text names.

    runs: of Chinese characters, folded. words: in Latin letters, ' wang xizhi '. A run names a person when it
    is the name, alone or after a dynasty or before 書, 傳 and the like: 張旭東 is not 張旭.
    """
    pattern, by_name = _people_pattern()
    found = [by_name[match[1]] for run in runs if (match := pattern.fullmatch(run))]
    found += [one for one in calligraphers() if any(f" {latin_words(name)} " in words for name in one.latin)]
    return tuple(dict.fromkeys(found))


def works_named(text: str, words: str) -> tuple[Names, ...]:
    """The famous works that a text names. text: Chinese, folded; words: in Latin letters, with spaces."""
    return tuple(
        one
        for one in famous_works()
        if any(name in text for name in one.chinese)
        or any(f" {latin_words(name)} " in words for name in one.latin)
    )


@functools.cache
def latin_words(name: str) -> str:
    """A name in Latin letters as a text is searched: 'Huang T'ing-chien' is 'huang ting chien'."""
    return " ".join(re.sub("[^a-z0-9]+", " ", fold(name).replace("'", "")).split())


@functools.cache
def _people_pattern() -> tuple[re.Pattern[str], dict[str, Names]]:
    by_name = {name: one for one in calligraphers() for name in one.chinese}

    def any_of(names: Iterable[str]) -> str:
        return "|".join(sorted(map(re.escape, names), key=len, reverse=True))

    before = any_of(word for word in words_of_dynasties() if not word.isascii())
    after = any_of(
        [*(word for word in words_of_scripts() if not word.isascii()), *"书传款临摹写", "传为", "法书"]
    )
    return re.compile(f"(?:{before})?({any_of(by_name)})(?:{after})?"), by_name
