"""Whole works and the characters within them: pages, scrolls and steles whose characters are works too.

A character within a page is a row of its own, with its own picture cut from the page, so that it is searched,
opened and copied as every other work is. What it takes from its page (writer, dynasty, licence) follows when
that is changed on the page.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import flag_modified

from rumu.database.tables import Work
from rumu.gallery.store import Gallery
from rumu.values import Bilingual

INHERITED = (
    "script", "hand_zh", "hand_en", "dynasty", "period_zh", "period_en", "material_zh", "material_en",
    "source", "licence", "attribution", "spacing",
)  # fmt: skip
"""Columns that a character has from its page until it is given its own."""
UNKNOWN_CHARACTER = "〓"


@dataclass(frozen=True, slots=True)
class CharacterWithin:
    """A character of a page, in reading order.

    id: of its work. character: '' where it is unknown. place: as rows.PlaceRow.
    """

    id: str
    character: str
    place: Mapping[str, Any]

    @property
    def line(self) -> tuple[int, int]:
        """Register and column."""
        return self.place["register"], self.place["column"]


def characters_within(gallery: Gallery, work_id: str) -> tuple[CharacterWithin, ...]:
    """The characters of a page or scroll in reading order; none of a work that is no such page."""
    rows = select(Work.id, Work.character, Work.place).where(Work.parent_id == work_id)
    with gallery.database.reading() as session:
        found = session.execute(rows.order_by(Work.position, Work.id))
        return tuple(CharacterWithin(*row) for row in found if row[2])


def count_characters(session: Session, work_ids: Iterable[str]) -> dict[str, int]:
    """How many characters each of these works has; works without any are left out."""
    ids = list(work_ids)
    counts = select(Work.parent_id, func.count()).where(Work.parent_id.in_(ids)).group_by(Work.parent_id)
    return {str(name): count for name, count in session.execute(counts)} if ids else {}


def text_lines(characters: Sequence[CharacterWithin]) -> tuple[tuple[CharacterWithin, ...], ...]:
    """The columns of a page, in reading order."""
    return tuple(tuple(members) for _, members in groupby(characters, lambda one: one.line))


def title_within(title: Bilingual, character: str) -> Bilingual:
    """The title of a character within a work of this title."""
    shown = character or UNKNOWN_CHARACTER
    zh, en = title.zh[:180], title.en[:180]
    return Bilingual(f"{zh}「{shown}」" if zh else shown, f"{shown}, {en}" if en else shown)


# --- keeping them with their page ------------------------------------------------------------------


def occurrences(characters: Iterable[str]) -> list[int]:
    """How many times the same character stands before each."""
    before: Counter[str] = Counter()
    counted = []
    for character in characters:
        counted.append(before[character])
        before[character] += 1
    return counted


def recount(session: Session, parent_id: str) -> None:
    """Count the occurrences on a page anew, after one of its characters was renamed or deleted."""
    session.flush()
    of_page = select(Work).where(Work.parent_id == parent_id).order_by(Work.position, Work.id)
    rows = session.scalars(of_page).all()
    for row, number in zip(rows, occurrences(row.character for row in rows), strict=True):
        if row.occurrence != number:
            row.occurrence = number
            flag_modified(row, "changed")  # the work itself stays as it was


def pass_on(session: Session, row: Work, before: Mapping[str, Any]) -> list[Work]:
    """Give the characters of a page what was changed on it, unless they have their own.

    before: INHERITED, title_zh and title_en of the page as they were. Returns the characters that changed.
    """
    was, title = Bilingual(before["title_zh"], before["title_en"]), Bilingual(row.title_zh, row.title_en)
    changed = {name: getattr(row, name) for name in INHERITED if getattr(row, name) != before[name]}
    if not changed and title == was:
        return []
    touched = []
    for child in session.scalars(select(Work).where(Work.parent_id == row.id)):
        values = {name: value for name, value in changed.items() if getattr(child, name) == before[name]}
        old, new = (title_within(one, child.character) for one in (was, title))
        if new != old and (child.title_zh, child.title_en) == old:
            values |= {"title_zh": new.zh, "title_en": new.en}
        for name, value in values.items():
            setattr(child, name, value)
        if values:
            touched.append(child)
    return touched


def delete_with_characters(session: Session, row: Work) -> list[Work]:
    """Delete a work, and first the characters within it; all of them, for their files."""
    children = list(session.scalars(select(Work).where(Work.parent_id == row.id)))
    session.execute(delete(Work).where(Work.parent_id == row.id))
    session.execute(delete(Work).where(Work.id == row.id))
    if row.parent_id is not None:
        recount(session, row.parent_id)
    return [row, *children]
