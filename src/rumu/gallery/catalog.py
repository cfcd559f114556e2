"""The catalogue of a gallery: list, change and delete works and collections.

All functions may be called from many threads, and from several processes on one database.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from sqlalchemy import ColumnElement, and_, delete, func, or_, select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import flag_modified

from rumu.database.engine import open_database
from rumu.database.tables import Collection, Tour, Work
from rumu.errors import GalleryError
from rumu.gallery.assets import delete_files
from rumu.gallery.filters import Filters, check_script, conditions, level
from rumu.gallery.query import MEANINGS, Found, count_meanings, find_works, understand
from rumu.gallery.search_text import SEARCH_VERSION, search_columns
from rumu.gallery.seed import add_starter_works
from rumu.gallery.starter import suggest
from rumu.gallery.store import Gallery, Store
from rumu.gallery.whole_works import INHERITED, delete_with_characters, pass_on, recount
from rumu.homes import database_place, files_place
from rumu.values import Bilingual

Item = TypeVar("Item")

_BATCH = 500  # works whose texts are made in one transaction


@dataclass(frozen=True, slots=True)
class ListPage(Generic[Item]):
    """A page of a list. items: those of the page, in order. total: the number on all pages.

    Of a search: understood: what its words mean, with numbers of works; meanings: of each word, for each item
    by its id.
    """

    items: tuple[Item, ...]
    total: int
    understood: tuple[Found, ...] = ()
    meanings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def open_gallery(
    *,
    database: str | Path | None = None,
    files: str | Path | None = None,
    starter: bool = True,
    wait: float = 30.0,
) -> Gallery:
    """Open the gallery of this user; without works yet, it is filled with the starter gallery.

    database: a file of SQLite or a URL; else RUMU_DATABASE, else rumu.sqlite in RUMU_HOME.
    files: a folder or a URL of fsspec; else RUMU_FILES, else files/ in RUMU_HOME.
    starter: False leaves an empty gallery empty. wait: seconds that a writer waits for another on SQLite.
    Raises GalleryError when either cannot be opened.
    """
    gallery = Gallery(
        open_database(database_place(database), wait=wait),
        Store.open(files_place(files)),
    )
    if starter:
        add_starter_works(gallery)
    update_search(gallery)
    return gallery


def update_search(gallery: Gallery) -> int:
    """Make the texts that searches look through again where their rules are of another version; how many."""
    outdated = select(Work).where(Work.search_version != SEARCH_VERSION).limit(_BATCH)
    count = 0
    while True:
        with gallery.database.reading() as session:
            if session.scalar(select(Work.id).where(Work.search_version != SEARCH_VERSION).limit(1)) is None:
                return count
        with gallery.database.writing() as session:
            titles = {row.id: row.title for row in session.scalars(select(Collection))}
            for row in session.scalars(outdated):
                for name, value in _search_columns(row, titles[row.collection_id]).items():
                    setattr(row, name, value)
                flag_modified(row, "changed")  # the work itself stays as it was
                count += 1


def _search_columns(row: Work, collection: Bilingual) -> dict[str, Any]:
    columns = {column.name: getattr(row, column.name) for column in Work.__table__.columns}
    return search_columns(columns, collection=collection)


# --- reading ---------------------------------------------------------------------------------------


def works(gallery: Gallery, *, offset: int = 0, limit: int = 60, **filters: Any) -> ListPage[Work]:
    """The works that match all filters: those that a search means most nearly first, else by collection.

    The starter gallery is the first collection. filters: the fields of Filters. Raises GalleryError for an
    unknown script, a query that is too long, or a negative offset or limit.
    """
    if offset < 0 or limit < 0:
        raise GalleryError(f"expected offset and limit of 0 or more, got {offset} and {limit}")
    asked, columns = Filters(**filters), Work.__table__.c
    with gallery.database.reading() as session:
        search = understand(session, asked.query)
        where = (*conditions(asked, columns, search).values(), level(asked, columns, search))
        found: list[tuple[str, tuple[int, ...]]] = []
        if search.words:
            found = find_works(session, search, where, ORDER)
            total, on_page = len(found), dict(found[offset : offset + limit])
        else:
            total = session.scalar(select(func.count()).select_from(Work).where(*where)) or 0
            # Only ids are sorted, because sorting whole rows takes longer.
            ids = select(Work.id).where(*where).order_by(*ORDER).offset(offset).limit(limit)
            on_page = dict.fromkeys(session.scalars(ids), ())
        rows = {row.id: row for row in session.scalars(select(Work).where(Work.id.in_(on_page)))}
        return ListPage(
            tuple(rows[name] for name in on_page if name in rows),
            total,
            count_meanings(search, found),
            {name: tuple(MEANINGS[rank] for rank in ranks) for name, ranks in on_page.items()},
        )


def work(gallery: Gallery, work_id: str) -> Work:
    """The work with this id. Raises GalleryError that names the closest ids when there is none."""
    with gallery.database.reading() as session:
        return _find(session, work_id)


def neighbours(gallery: Gallery, work_id: str) -> tuple[str | None, str | None]:
    """The ids of the works before and after one in its collection, or of a character on its page."""
    row = work(gallery, work_id)
    siblings = (Work.collection_id == row.collection_id, Work.parent_id == row.parent_id)
    ids = select(Work.id).where(*siblings).limit(1)
    same_position = Work.position == row.position
    before = ids.where(or_(Work.position < row.position, and_(same_position, Work.id < row.id)))
    after = ids.where(or_(Work.position > row.position, and_(same_position, Work.id > row.id)))
    with gallery.database.reading() as session:
        return (
            session.scalar(before.order_by(Work.position.desc(), Work.id.desc())),
            session.scalar(after.order_by(Work.position, Work.id)),
        )


def collections(gallery: Gallery) -> tuple[tuple[Collection, int], ...]:
    """All collections with their numbers of works, the starter gallery first.

    The characters within a page are not counted.
    """
    count = func.count(Work.id)
    with gallery.database.reading() as session:
        rows = session.execute(
            select(Collection, count)
            .outerjoin(Work, and_(Work.collection_id == Collection.id, Work.parent_id.is_(None)))
            .group_by(Collection.id)
            .order_by(Collection.id != "starter", Collection.id)
        )
        return tuple((row[0], row[1]) for row in rows)


def collection(gallery: Gallery, collection_id: str) -> Collection:
    """The collection with this id. Raises GalleryError that names the existing ones when there is none."""
    with gallery.database.reading() as session:
        row = session.get(Collection, collection_id)
        if row is None:
            known = ", ".join(session.scalars(select(Collection.id).order_by(Collection.id).limit(10)))
            raise GalleryError(f"no collection {collection_id!r} in the gallery; there are {known}")
        return row


# --- changing --------------------------------------------------------------------------------------

CHANGEABLE = frozenset(
    {"character", "script", "dynasty", "source", "licence", "attribution", "position", "spacing"}
    | {f"{name}_{language}" for name in ("title", "hand", "period", "material") for language in ("zh", "en")}
)


def change_work(gallery: Gallery, work_id: str, changes: Mapping[str, Any]) -> Work:
    """Change columns of a work, those of CHANGEABLE; the characters within it follow, see `pass_on`.

    Raises GalleryError for others, or an unknown work.
    """
    unknown = sorted(set(changes) - CHANGEABLE)
    if unknown:
        raise GalleryError(f"expected facts among {', '.join(sorted(CHANGEABLE))}, got {', '.join(unknown)}")
    check_script(changes.get("script"))
    with gallery.database.writing() as session:
        row = _find(session, work_id)
        before = {name: getattr(row, name) for name in (*INHERITED, "title_zh", "title_en", "character")}
        for name, value in changes.items():
            setattr(row, name, value)
        if row.parent_id is not None and row.character != before["character"]:
            recount(session, row.parent_id)
        collection = session.get_one(Collection, row.collection_id)
        for one in (row, *pass_on(session, row, before)):
            for name, value in _search_columns(one, collection.title).items():
                setattr(one, name, value)
        return row


COLLECTION_CHANGEABLE = frozenset(
    {"source", "licence", "cover_id", "tour_id"}
    | {f"{name}_{language}" for name in ("title", "note") for language in ("zh", "en")}
)


def change_collection(gallery: Gallery, collection_id: str, changes: Mapping[str, Any]) -> Collection:
    """Change columns of a collection, those of COLLECTION_CHANGEABLE; searches find its works by a new title.

    cover_id: a work of the collection, tour_id: a tour; '' is none. Raises GalleryError for others, for other
    columns, a title that is empty in both languages, or an unknown collection.
    """
    unknown = sorted(set(changes) - COLLECTION_CHANGEABLE)
    if unknown:
        expected = ", ".join(sorted(COLLECTION_CHANGEABLE))
        raise GalleryError(f"expected facts among {expected}, got {', '.join(unknown)}")
    before = collection(gallery, collection_id).title
    with gallery.database.writing() as session:
        row = session.get_one(Collection, collection_id)
        _check_choices(session, collection_id, changes)
        for name, value in changes.items():
            setattr(row, name, value)
        if not (row.title_zh.strip() or row.title_en.strip()):
            raise GalleryError(
                f"expected a title of the collection {collection_id!r} in one language at least, got none",
                zh="專題總要有個標題，中文或英文都好。",
            )
        title = Bilingual(zh=row.title_zh, en=row.title_en)
        if title != before:
            for of_it in session.scalars(select(Work).where(Work.collection_id == collection_id)):
                for name, value in _search_columns(of_it, title).items():
                    setattr(of_it, name, value)
        return row


def _check_choices(session: Session, collection_id: str, changes: Mapping[str, Any]) -> None:
    """Raises GalleryError for a cover that is no work of the collection, and for a tour that there is not."""
    cover, tour = changes.get("cover_id"), changes.get("tour_id")
    of_collection = select(Work.id).where(Work.id == cover, Work.collection_id == collection_id)
    if cover and session.scalar(of_collection) is None:
        raise GalleryError(
            f"expected a work of the collection {collection_id!r} as its cover, got {cover!r}",
            zh="封面要用這個專題裡的作品。",
        )
    if tour and session.get(Tour, tour) is None:
        raise GalleryError(f"there is no tour {tour!r} to belong to a collection", zh="沒有這條導覽。")


def delete_work(gallery: Gallery, work_id: str) -> None:
    """Delete a work with its annotations and attempts, the characters within it, and their files.

    Files that another work shares stay.

    Raises GalleryError when there is no such work.
    """
    row = work(gallery, work_id)
    with gallery.database.writing() as session:
        deleted = delete_with_characters(session, row)
    delete_files(gallery, deleted)


def delete_collection(gallery: Gallery, collection_id: str) -> int:
    """Delete a collection and its works; the number of works, without the characters within them.

    Raises GalleryError when there is none.
    """
    collection(gallery, collection_id)
    with gallery.database.writing() as session:
        rows = session.scalars(select(Work).where(Work.collection_id == collection_id)).all()
        session.execute(delete(Work).where(Work.collection_id == collection_id))
        session.execute(delete(Collection).where(Collection.id == collection_id))
    delete_files(gallery, rows)
    return sum(row.parent_id is None for row in rows)


ORDER: Sequence[ColumnElement[Any]] = (
    Work.collection_id != "starter",
    Work.collection_id.expression,
    Work.parent_id.is_not(None),
    Work.parent_id.expression,
    Work.position.expression,
    Work.id.expression,
)


def _find(session: Session, work_id: str) -> Work:
    row = session.get(Work, work_id)
    if row is None:
        known = session.scalars(select(Work.id)).all()
        of_character = session.scalars(
            select(Work.id).where(Work.character == work_id).order_by(*ORDER).limit(5)
        ).all()
        hint = suggest(work_id, known, of_character)
        raise GalleryError(f"no work {work_id!r} in the gallery{hint}")
    return row
