"""Filters of a search as SQL conditions, and facets: the values to filter by, with their numbers of works."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from sqlalchemy import ColumnElement, and_, func, literal, or_, select, union_all

from rumu.database.tables import Collection, Work
from rumu.errors import GalleryError
from rumu.gallery.query import Search, understand
from rumu.gallery.search_text import COLUMNS
from rumu.gallery.store import Gallery
from rumu.gallery.vocabulary import UNKNOWN, dynasty_name, script_name, variants
from rumu.values import SCRIPTS

FACETS = ("script", "dynasty", "hand", "character", "collection")
MOST_VALUES = 500  # of one facet: nobody reads a longer list
ANY = "*"  # stands for any character
NONE = "none"  # asks for works whose script, dynasty or hand is unknown


@dataclass(frozen=True, slots=True, kw_only=True)
class Filters:
    """What a search asks for; None does not filter.

    script, dynasty, hand: 'none' asks for works where it is unknown. hand: as a facet gives it, in Chinese or
    English. character: in any of its variants, traditional or simplified. query: words that must all be met,
    see `gallery.query`. masters: only works that are a character to copy. within: only the characters of
    this page or scroll.
    """

    script: str | None = None
    dynasty: str | None = None
    hand: str | None = None
    character: str | None = None
    collection: str | None = None
    query: str | None = None
    masters: bool = False
    within: str | None = None


@dataclass(frozen=True, slots=True)
class FacetValue:
    """A value of a facet: the filter's value, its name in both languages, its number of works."""

    value: str
    zh: str
    en: str
    count: int


def check_script(script: str | None) -> None:
    """Raise GalleryError unless it is one of the five scripts, or stands for an unknown or for any script."""
    if script not in (None, "", NONE, *SCRIPTS):
        raise GalleryError(f"expected a script among {', '.join(SCRIPTS)}, got {script!r}")


def conditions(filters: Filters, columns: Any, search: Search) -> dict[str, ColumnElement[bool]]:
    """The SQL condition of each filter that is set, by its name.

    columns: of works, or of a query with the same columns. search: the query, understood. Raises GalleryError
    for an unknown script.
    """
    check_script(filters.script)
    script, dynasty, hand = (
        "" if value == NONE else value for value in (filters.script, filters.dynasty, filters.hand)
    )
    found: dict[str, ColumnElement[bool]] = {}
    if filters.script:
        found["script"] = columns.script == script
    if filters.dynasty:
        found["dynasty"] = columns.dynasty == dynasty
    if filters.hand:
        found["hand"] = or_(columns.hand_zh == hand, and_(columns.hand_en == hand, columns.hand_en != ""))
    if filters.character:
        found["character"] = columns.character.in_(variants(filters.character))
    if filters.masters:
        found["masters"] = func.trim(columns.character) != ""
    if filters.collection:
        found["collection"] = columns.collection_id == filters.collection
    searched = search.condition(columns)
    if searched is not None:
        found["query"] = searched
    return found


def level(filters: Filters, columns: Any, search: Search) -> ColumnElement[bool]:
    """The SQL condition by which a whole work is not drowned beneath its characters.

    Characters within a page appear where characters are asked for: by a word of the search that is one, by
    the filter `character`, as masters, or within their page. Outside their page the first of each is enough.
    """
    if filters.within:
        return cast("ColumnElement[bool]", columns.parent_id == filters.within)
    whole, first = columns.parent_id.is_(None), columns.occurrence == 0
    if filters.character or filters.masters:
        return or_(whole, first)
    named = search.names_character(columns)
    return whole if named is None else or_(whole, and_(first, named))


def count_facets(gallery: Gallery, filters: Filters) -> dict[str, tuple[FacetValue, ...]]:
    """The values of each of FACETS, those with most works first, at most MOST_VALUES.

    The counts of a facet follow all filters except its own, so that another value of it can be chosen.
    Raises GalleryError for an unknown script, or a query that is too long.
    """
    rows: dict[str, list[Any]] = {name: [] for name in FACETS}
    with gallery.database.reading() as session:
        for name, *values in session.execute(_facet_query(filters, understand(session, filters.query))):
            rows[name].append(values)
        collections = select(Collection.id, Collection.title_zh, Collection.title_en)
        titles = {row[0]: (row[1], row[2]) for row in session.execute(collections)}
    return {name: tuple(_facet_value(name, row, titles) for row in of_name) for name, of_name in rows.items()}


def _facet_query(filters: Filters, search: Search) -> Any:
    """One statement for all facets, so that the words of a query are searched only once."""
    columns: Any = Work.__table__.c
    searched = search.condition(columns)
    if searched is not None:
        names = ("script", "dynasty", "hand_zh", "hand_en", "character", "collection_id", *COLUMNS)
        found = select(*(columns[name] for name in names))
        columns = found.where(searched, level(filters, columns, search)).cte("found").c
    others = conditions(filters, columns, Search())
    levels = {name: None if searched is not None else level(filters, columns, search) for name in FACETS}
    if searched is None:  # a character that stands only within pages can be chosen, too
        levels["character"] = level(replace(filters, character=ANY), columns, search)
    group_by = {
        "script": (columns.script,),
        "dynasty": (columns.dynasty,),
        "hand": (columns.hand_zh, columns.hand_en),
        "character": (columns.character,),
        "collection": (columns.collection_id,),
    }
    counts = (_count_by(name, group_by[name], others, levels[name]) for name in FACETS)
    return union_all(*(select(one.subquery()) for one in counts))


def _count_by(
    name: str, columns: Sequence[Any], filters: dict[str, Any], level_of: ColumnElement[bool] | None
) -> Any:
    count = func.count().label("works")
    others = [condition for of, condition in filters.items() if of != name]
    if level_of is not None:
        others.append(level_of)
    if name == "character":  # a sheet of several characters is no value to choose
        others.append(columns[0] != "")
    second = columns[1] if len(columns) > 1 else literal("")
    return (
        select(literal(name).label("facet"), columns[0].label("first"), second.label("second"), count)
        .where(*others)
        .group_by(*columns)
        .order_by(count.desc(), *columns)
        .limit(MOST_VALUES)
    )


def _facet_value(name: str, row: Sequence[Any], titles: dict[str, tuple[str, str]]) -> FacetValue:
    first, second, count = row
    if name in ("script", "dynasty"):
        label = (script_name if name == "script" else dynasty_name)(first)
        return FacetValue(first or NONE, label.zh, label.en, count)
    if name == "hand":
        zh, en = first or second, second or first
        return FacetValue(zh or NONE, zh or UNKNOWN.zh, en or UNKNOWN.en, count)
    zh, en = titles.get(first, (first, first)) if name == "collection" else (first, first)
    return FacetValue(first, zh, en, count)
