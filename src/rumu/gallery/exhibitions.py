"""A collection as an exhibition: its cover, its tour, and its works in the order that its owner gave them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import func, select, update

from rumu.database.tables import Collection, Tour, Work
from rumu.errors import GalleryError
from rumu.gallery.catalog import collection
from rumu.gallery.metadata import is_whole_of
from rumu.gallery.store import Gallery


@dataclass(frozen=True, slots=True)
class Exhibition:
    """What the page of a collection shows.

    works: how many, without the characters within pages. cover: the work that its owner chose, or else its
    first; None when it has none. tour: None when none was chosen, or it is gone.
    """

    collection: Collection
    works: int
    cover: Work | None
    chosen: bool
    tour: Tour | None


def exhibition(gallery: Gallery, collection_id: str) -> Exhibition:
    """The exhibition of a collection. Raises GalleryError when there is none with this id."""
    row = collection(gallery, collection_id)
    whole = is_whole_of(collection_id)
    with gallery.database.reading() as session:
        works = session.execute(select(func.count(Work.id)).where(whole)).scalar_one()
        chosen = session.scalar(select(Work).where(Work.id == row.cover_id, Work.collection_id == row.id))
        first = select(Work).where(whole).order_by(Work.position, Work.id).limit(1)
        tour = session.get(Tour, row.tour_id) if row.tour_id else None
        return Exhibition(row, works, chosen or session.scalar(first), chosen is not None, tour)


def order_works(gallery: Gallery, collection_id: str, first: Sequence[str]) -> None:
    """Let works of a collection come first, in this order; its other works follow in the order they have.

    Characters keep their places on their pages. Raises GalleryError for an unknown collection, works that are
    not of it or stand on a page, and a work that is named twice.
    """
    collection(gallery, collection_id)
    with gallery.database.writing() as session:
        whole = is_whole_of(collection_id)
        order = select(Work.id, Work.position).where(whole).order_by(Work.position, Work.id)
        there = {name: position for name, position in session.execute(order)}
        foreign = sorted(set(first) - set(there))
        if foreign or len(set(first)) < len(first):
            wrong = ", ".join(foreign[:5]) or "one of them twice"
            raise GalleryError(
                f"expected works of the collection {collection_id!r}, each once, got {wrong}",
                zh="排序的每一件都要是這個專題裡的作品，而且只能出現一次。",
            )
        wanted = enumerate(dict.fromkeys([*first, *there]))
        moved = [{"id": name, "position": at} for at, name in wanted if there[name] != at]
        if moved:
            session.execute(update(Work), moved)
