"""One character by all hands that wrote it, by script and time: what calligraphers call 集字."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from sqlalchemy import func, select

from rumu.database.tables import Work
from rumu.gallery.store import Gallery
from rumu.gallery.vocabulary import DYNASTIES, UNKNOWN, dynasty_name, fold, variants
from rumu.values import SCRIPTS, Bilingual

MOST_WORKS = 1000  # of one character on one page
_SCRIPTS, _TIMES = list(SCRIPTS), list(DYNASTIES)


@dataclass(frozen=True, slots=True)
class Hand:
    """A writer, in one script, with all works of the character by this hand. time: the dynasty's name."""

    hand: Bilingual
    time: Bilingual
    works: tuple[Work, ...]


@dataclass(frozen=True, slots=True)
class ScriptHands:
    """The hands of one script, the earliest first. script: '' where it is not known."""

    script: str
    hands: tuple[Hand, ...]


@dataclass(frozen=True, slots=True)
class CharacterHands:
    """A character by all hands. total: of its works, of which at most MOST_WORKS are listed."""

    character: str
    total: int
    scripts: tuple[ScriptHands, ...]

    @property
    def hands(self) -> int:
        """How many writers there are."""
        return len({hand.hand for one in self.scripts for hand in one.hands})


def hands_of(gallery: Gallery, character: str) -> CharacterHands:
    """All works of a character in any of its forms: by script as it arose, then by time, then by hand."""
    forms = variants(character)
    with gallery.database.reading() as session:
        total = session.scalar(select(func.count()).select_from(Work).where(Work.character.in_(forms))) or 0
        rows = select(Work).where(Work.character.in_(forms))
        order = (Work.parent_id.is_not(None), Work.collection_id, Work.parent_id, Work.position, Work.id)
        found = session.scalars(rows.order_by(*order).limit(MOST_WORKS)).all()
    ordered = sorted(found, key=_place)
    return CharacterHands(
        character,
        total,
        tuple(
            ScriptHands(script, tuple(_hands(members)))
            for script, members in groupby(ordered, lambda work: work.script)
        ),
    )


def _hands(works: Iterable[Work]) -> Iterable[Hand]:
    for (zh, en), members in groupby(works, _name):
        of_hand = tuple(members)
        dynasty = Counter(work.dynasty for work in of_hand).most_common(1)[0][0]
        yield Hand(
            Bilingual(zh or en or UNKNOWN.zh, en or zh or UNKNOWN.en),
            dynasty_name(dynasty) if dynasty else Bilingual("", ""),
            of_hand,
        )


def _place(work: Work) -> tuple[int, int, str, str]:
    """Script, time and hand, as they are ordered; what is not known comes last."""
    script = _SCRIPTS.index(work.script) if work.script in _SCRIPTS else len(_SCRIPTS)
    first = work.dynasty.partition("/")[0]
    time = _TIMES.index(first) if first in _TIMES else len(_TIMES)
    return script, time, fold(work.hand_zh), work.hand_en


def _name(work: Work) -> tuple[str, str]:
    return work.hand_zh, work.hand_en
