"""What works are asked for, as conditions on rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, and_, or_

from rumu.assessment.scripts import SCRIPTS
from rumu.errors import GalleryError
from rumu.gallery.variants import folded, forms

NONE = "none"  # stands for works of which a script, dynasty or hand is not known


@dataclass(frozen=True, slots=True, kw_only=True)
class Filters:
    """What works are asked for; None asks nothing. 'none' as script, dynasty or hand: those of whom it is not
    known.

    character: in any of its forms, traditional or simplified. hand: as a facet names it, in Chinese or
    English. query: words that all must occur in title, character, hand, collection, dynasty or script.
    """

    script: str | None = None
    dynasty: str | None = None
    hand: str | None = None
    character: str | None = None
    collection: str | None = None
    query: str | None = None


def check_script(script: str | None) -> None:
    """Raise GalleryError unless it is one of the five, or says that none is known or asked for."""
    if script not in (None, "", NONE, *SCRIPTS):
        raise GalleryError(f"expected a script among {', '.join(SCRIPTS)}, got {script!r}")


def conditions(filters: Filters, columns: Any) -> dict[str, ColumnElement[bool]]:
    """What each choice asks of a row, by the name of its facet.

    columns: of works, or of a query that has the same. Raises GalleryError for an unknown script.
    """
    check_script(filters.script)
    asked: dict[str, ColumnElement[bool]] = {}
    if filters.script:
        asked["script"] = columns.script == _known(filters.script)
    if filters.dynasty:
        asked["dynasty"] = columns.dynasty == _known(filters.dynasty)
    if filters.hand:
        hand = _known(filters.hand)
        asked["hand"] = or_(columns.hand_zh == hand, and_(columns.hand_en == hand, columns.hand_en != ""))
    if filters.character:
        asked["character"] = columns.character.in_(forms(filters.character))
    if filters.collection:
        asked["collection"] = columns.collection_id == filters.collection
    if filters.query and filters.query.split():
        words = folded(filters.query).split()
        asked["query"] = and_(*(columns.search.contains(word, autoescape=True) for word in words))
    return asked


def _known(value: str) -> str:
    return "" if value == NONE else value
