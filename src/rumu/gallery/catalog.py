"""The catalogue: which works there are, found by what is known of them, and changed.

A Gallery is a database for what is known and a store for the files. Every function is safe to call from many
threads, and from several processes on one database.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from sqlalchemy import ColumnElement, and_, delete, func, or_, select
from sqlalchemy.orm import Session

from rumu.database.engine import open_database
from rumu.database.tables import Collection, Work
from rumu.errors import GalleryError
from rumu.gallery.assets import delete_files
from rumu.gallery.filters import Filters, check_script, conditions
from rumu.gallery.gallery import Gallery, user_home
from rumu.gallery.metadata import search_text
from rumu.gallery.seed import add_starter_works
from rumu.gallery.store import Store
from rumu.values import Bilingual

Row = TypeVar("Row")


@dataclass(frozen=True, slots=True)
class Page(Generic[Row]):
    """items: a part of all that match, in order. total: how many match."""

    items: tuple[Row, ...]
    total: int


def open_gallery(
    *, database: str | Path | None = None, files: str | Path | None = None, starter: bool = True
) -> Gallery:
    """The gallery of this person; where there are no works yet, with the starter gallery in it.

    database: a file of SQLite or a URL; else RUMU_DATABASE, else rumu.sqlite in RUMU_HOME.
    files: a folder or a URL of fsspec; else RUMU_FILES, else files/ in RUMU_HOME.
    starter: False leaves an empty gallery empty.
    Raises GalleryError when either cannot be opened.
    """
    gallery = Gallery(
        open_database(database or os.environ.get("RUMU_DATABASE") or user_home() / "rumu.sqlite"),
        Store.open(files or os.environ.get("RUMU_FILES") or user_home() / "files"),
    )
    if starter:
        add_starter_works(gallery)
    return gallery


# --- looking ---------------------------------------------------------------------------------------


def works(gallery: Gallery, *, offset: int = 0, limit: int = 60, **asked: str | None) -> Page[Work]:
    """The works that match all that is asked, by collection, the starter gallery first.

    asked: the fields of Filters.
    Raises GalleryError for an unknown script, or a page that cannot be.
    """
    if offset < 0 or limit < 0:
        raise GalleryError(f"expected offset and limit of 0 or more, got {offset} and {limit}")
    wanted = conditions(Filters(**asked), Work.__table__.c).values()
    # Ids are sorted alone: whole rows would be dragged along through the sort.
    ids = select(Work.id).where(*wanted).order_by(*_ORDER).offset(offset).limit(limit)
    with gallery.database.reading() as session:
        total = session.scalar(select(func.count()).select_from(Work).where(*wanted)) or 0
        chosen = list(session.scalars(ids))
        rows = {row.id: row for row in session.scalars(select(Work).where(Work.id.in_(chosen)))}
        return Page(tuple(rows[name] for name in chosen if name in rows), total)


def work(gallery: Gallery, work_id: str) -> Work:
    """The work with this id. Raises GalleryError that names the closest ids when there is none."""
    with gallery.database.reading() as session:
        found = session.get(Work, work_id)
        if found is not None:
            return found
        raise GalleryError(f"no work {work_id!r} in the gallery{_hint(session, work_id)}")


def neighbours(gallery: Gallery, work_id: str) -> tuple[str | None, str | None]:
    """The ids of the works before and after one in its collection."""
    here = work(gallery, work_id)
    place = (here.position, here.id)
    same = Work.collection_id == here.collection_id
    before = or_(Work.position < place[0], and_(Work.position == place[0], Work.id < place[1]))
    after = or_(Work.position > place[0], and_(Work.position == place[0], Work.id > place[1]))
    down, up = (Work.position.desc(), Work.id.desc()), (Work.position, Work.id)
    with gallery.database.reading() as session:
        return (
            session.scalar(select(Work.id).where(same, before).order_by(*down).limit(1)),
            session.scalar(select(Work.id).where(same, after).order_by(*up).limit(1)),
        )


def collections(gallery: Gallery) -> tuple[tuple[Collection, int], ...]:
    """Every collection with the number of its works, the starter gallery first."""
    count = func.count(Work.id)
    with gallery.database.reading() as session:
        found = session.execute(
            select(Collection, count)
            .outerjoin(Work, Work.collection_id == Collection.id)
            .group_by(Collection.id)
            .order_by(Collection.id != "starter", Collection.id)
        )
        return tuple((row[0], row[1]) for row in found)


def collection(gallery: Gallery, collection_id: str) -> Collection:
    """The collection with this id. Raises GalleryError that names those there are."""
    with gallery.database.reading() as session:
        found = session.get(Collection, collection_id)
        if found is not None:
            return found
        known = ", ".join(session.scalars(select(Collection.id).order_by(Collection.id).limit(10)))
        raise GalleryError(f"no collection {collection_id!r} in the gallery; there are {known}")


# --- changing --------------------------------------------------------------------------------------

CHANGEABLE = frozenset(
    {
        *(
            f"{name}_{language}"
            for name in ("title", "hand", "period", "material")
            for language in ("zh", "en")
        ),
        *("character", "script", "dynasty", "source", "licence", "attribution", "position", "spacing"),
    }
)


def change_work(gallery: Gallery, work_id: str, changes: Mapping[str, Any]) -> Work:
    """Change what is known of a work: columns of CHANGEABLE. Raises GalleryError for others, or no such
    work."""
    stray = sorted(set(changes) - CHANGEABLE)
    if stray:
        raise GalleryError(f"expected facts among {', '.join(sorted(CHANGEABLE))}, got {', '.join(stray)}")
    check_script(changes.get("script"))
    with gallery.database.writing() as session:
        found = session.get(Work, work_id)
        if found is None:
            raise GalleryError(f"no work {work_id!r} in the gallery{_hint(session, work_id)}")
        for name, value in changes.items():
            setattr(found, name, value)
        _index_again(session, [found])
        return found


def change_collection(gallery: Gallery, collection_id: str, changes: Mapping[str, str]) -> Collection:
    """Change title_zh, title_en, note_zh, note_en, source or licence. Raises GalleryError for others, or
    none."""
    known = {"title_zh", "title_en", "note_zh", "note_en", "source", "licence"}
    if not set(changes) <= known:
        raise GalleryError(
            f"expected facts among {', '.join(sorted(known))}, got {', '.join(sorted(changes))}"
        )
    collection(gallery, collection_id)
    with gallery.database.writing() as session:
        found = session.get_one(Collection, collection_id)
        for name, value in changes.items():
            setattr(found, name, value)
        _index_again(session, session.scalars(select(Work).where(Work.collection_id == collection_id)).all())
        return found


def delete_work(gallery: Gallery, work_id: str) -> None:
    """Forget a work with all that hangs on it, and the files that no other work shares.

    Raises GalleryError when there is no such work.
    """
    gone = work(gallery, work_id)
    with gallery.database.writing() as session:
        session.execute(delete(Work).where(Work.id == work_id))
    delete_files(gallery, gone)


def delete_collection(gallery: Gallery, collection_id: str) -> int:
    """Forget a collection and its works; how many works there were. Raises GalleryError when there is
    none."""
    collection(gallery, collection_id)
    with gallery.database.writing() as session:
        gone = session.scalars(select(Work).where(Work.collection_id == collection_id)).all()
        session.execute(delete(Work).where(Work.collection_id == collection_id))
        session.execute(delete(Collection).where(Collection.id == collection_id))
    for row in gone:
        delete_files(gallery, row)
    return len(gone)


# --- within ----------------------------------------------------------------------------------------

_ORDER: Sequence[ColumnElement[Any]] = (
    Work.collection_id != "starter",
    Work.collection_id.expression,
    Work.position.expression,
    Work.id.expression,
)


def _index_again(session: Session, rows: Sequence[Work]) -> None:
    """The text that searches look through follows the facts it was made of."""
    titles: dict[str, Bilingual] = {}
    for row in rows:
        if row.collection_id not in titles:
            of = session.get_one(Collection, row.collection_id)
            titles[row.collection_id] = Bilingual(zh=of.title_zh, en=of.title_en)
        columns = {column.name: getattr(row, column.name) for column in Work.__table__.columns}
        row.search = search_text(columns, collection=titles[row.collection_id])


def _hint(session: Session, asked: str) -> str:
    known = list(session.scalars(select(Work.id)))
    close = difflib.get_close_matches(asked, known, n=3, cutoff=0.5)
    if not close:  # an id seldom holds the character itself, but a person may well type it
        close = list(
            session.scalars(select(Work.id).where(Work.character == asked).order_by(*_ORDER).limit(5))
        )
    return f"; did you mean {', '.join(close)}?" if close else f"; there are {', '.join(known[:5])}, ..."
