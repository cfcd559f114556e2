"""Filters of a search as SQL conditions, and facets: the values to filter by with their numbers of works."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, and_, func, literal, or_, select, union_all

from rumu.assessment.scripts import SCRIPTS
from rumu.database.tables import Collection, Work
from rumu.errors import GalleryError
from rumu.gallery.gallery import Gallery
from rumu.gallery.terms import UNKNOWN, dynasty_name, script_name
from rumu.gallery.variants import folded, forms

FACETS = ("script", "dynasty", "hand", "character", "collection")
MOST_VALUES = 500  # of one facet: nobody reads a longer list
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


@dataclass(frozen=True, slots=True)
class FacetValue:
    """One choice of a facet: what to ask for, its name in both languages, how many works it leaves."""

    value: str
    zh: str
    en: str
    count: int


def count_facets(gallery: Gallery, filters: Filters) -> dict[str, tuple[FacetValue, ...]]:
    """For each of FACETS its values, most works first, at most MOST_VALUES.

    The counts of a facet heed every other choice but its own, so that another value of it can be chosen.
    Raises GalleryError for an unknown script.
    """
    found: dict[str, list[Any]] = {name: [] for name in FACETS}
    with gallery.database.reading() as session:
        for name, *values in session.execute(_counts(filters)):
            found[name].append(values)
        rooms = select(Collection.id, Collection.title_zh, Collection.title_en)
        titles = {row[0]: (row[1], row[2]) for row in session.execute(rooms)}
    return {name: tuple(_value(name, values, titles) for values in rows) for name, rows in found.items()}


def _counts(filters: Filters) -> Any:
    """One statement for all facets, so that the words of a query are looked for in every work but once."""
    columns: Any = Work.__table__.c
    words = conditions(Filters(query=filters.query), columns)
    if words:
        names = ("script", "dynasty", "hand_zh", "hand_en", "character", "collection_id", "search")
        columns = select(*(columns[name] for name in names)).where(*words.values()).cte("found").c
    asked = {name: one for name, one in conditions(filters, columns).items() if name != "query"}
    grouped = {
        "script": (columns.script,),
        "dynasty": (columns.dynasty,),
        "hand": (columns.hand_zh, columns.hand_en),
        "character": (columns.character,),
        "collection": (columns.collection_id,),
    }
    return union_all(*(select(_counted(name, grouped[name], asked).subquery()) for name in FACETS))


def _counted(name: str, by: Sequence[Any], asked: dict[str, Any]) -> Any:
    count = func.count().label("works")
    others = [condition for of, condition in asked.items() if of != name]
    if name == "character":  # a sheet of many characters is no choice among them
        others.append(by[0] != "")
    second = by[1] if len(by) > 1 else literal("")
    return (
        select(literal(name).label("facet"), by[0].label("first"), second.label("second"), count)
        .where(*others)
        .group_by(*by)
        .order_by(count.desc(), *by)
        .limit(MOST_VALUES)
    )


def _value(name: str, values: Sequence[Any], titles: dict[str, tuple[str, str]]) -> FacetValue:
    first, second, count = values
    if name in ("script", "dynasty"):
        label = (script_name if name == "script" else dynasty_name)(first)
        return FacetValue(first or NONE, label.zh, label.en, count)
    if name == "hand":
        zh, en = first or second, second or first
        return FacetValue(zh or NONE, zh or UNKNOWN.zh, en or UNKNOWN.en, count)
    zh, en = titles.get(first, (first, first)) if name == "collection" else (first, first)
    return FacetValue(first, zh, en, count)
