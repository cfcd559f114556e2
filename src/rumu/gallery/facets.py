"""By what works can be chosen, and how many each choice would leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import func, literal, select, union_all

from rumu.database.tables import Collection, Work
from rumu.gallery.filters import NONE, Filters, conditions
from rumu.gallery.terms import UNKNOWN, dynasty_name, script_name

FACETS = ("script", "dynasty", "hand", "character", "collection")
MOST_VALUES = 500  # of one facet: a list longer than this helps nobody to choose


if TYPE_CHECKING:
    from rumu.gallery.catalog import Gallery


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
