"""Traditional and simplified characters that a search takes for the same, whichever a person types.

variants.txt holds pairs, the traditional character before the simplified one; it was made from
TSCharacters.txt of OpenCC (Apache-2.0), of each character the first of its simplified forms.
"""

from __future__ import annotations

import functools
import unicodedata
from importlib import resources


def folded(text: str) -> str:
    """Text as searches compare it: compatible forms made one, lower case, simplified."""
    return unicodedata.normalize("NFKC", text).lower().translate(_simplified())


def forms(character: str) -> tuple[str, ...]:
    """A character in every form that is taken for the same, itself first."""
    simple = character.translate(_simplified())
    return tuple(dict.fromkeys((character, simple, *_traditional().get(simple, ()))))


@functools.cache
def _pairs() -> tuple[tuple[str, str], ...]:
    text = resources.files("rumu.gallery").joinpath("variants.txt").read_text(encoding="utf-8")
    packed = text.replace("\n", "")
    return tuple(zip(packed[::2], packed[1::2], strict=True))


@functools.cache
def _simplified() -> dict[int, str]:
    return {ord(traditional): simple for traditional, simple in _pairs()}


@functools.cache
def _traditional() -> dict[str, tuple[str, ...]]:
    found: dict[str, list[str]] = {}
    for traditional, simple in _pairs():
        found.setdefault(simple, []).append(traditional)
    return {simple: tuple(ones) for simple, ones in found.items()}
