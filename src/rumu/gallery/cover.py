"""The work that stands on the home page: the owner's choice, or one that shows best what light does."""

from __future__ import annotations

from sqlalchemy import delete, select

from rumu.database.tables import Setting, Work
from rumu.gallery.catalog import ORDER, work
from rumu.gallery.store import Gallery

_NAME = "cover"  # of the setting with the id of the work


def cover_work(gallery: Gallery) -> tuple[Work | None, bool]:
    """The work on the home page, and whether somebody chose it.

    Otherwise, or when the chosen work is deleted: the first measured one, else the first; None in an empty
    gallery.
    """
    with gallery.database.reading() as session:
        chosen = session.scalar(
            select(Work).join(Setting, (Setting.name == _NAME) & (Setting.value == Work.id))
        )
        if chosen is not None:
            return chosen, True
        computed_last = Work.height_source != "photometric"
        return session.scalar(select(Work).order_by(computed_last, *ORDER).limit(1)), False


def choose_cover(gallery: Gallery, work_id: str | None) -> None:
    """Put a work on the home page; None leaves the choice to `cover_work`.

    Raises GalleryError when there is no such work.
    """
    if work_id is not None:
        work(gallery, work_id)
    with gallery.database.writing() as session:
        session.execute(delete(Setting).where(Setting.name == _NAME))
        if work_id is not None:
            session.add(Setting(name=_NAME, value=work_id))
