"""Files that no work names: what an interrupted import or a half-written file left behind."""

from __future__ import annotations

from sqlalchemy import select

from rumu.database.tables import Work
from rumu.gallery.gallery import Gallery

DAY = 86_400.0
_OF_WORKS = ("pictures", "captures", "surfaces")


def sweep(gallery: Gallery, *, older_than: float = DAY) -> int:
    """Delete the files of works that no work names, and parts of files; how many there were.

    older_than: seconds. Younger files may belong to a work that another process is just putting in: files are
    written before rows.
    """
    with gallery.database.reading() as session:
        rows = session.execute(select(Work.picture, Work.surface, Work.capture)).all()
    named = {key for row in rows for key in row if key}
    gone = 0
    for place in (*_OF_WORKS, "derived"):
        for key in list(gallery.store.keys(place, older_than=older_than)):
            if _is_part(key) or (place in _OF_WORKS and not _is_named(key, named)):
                gallery.store.drop(key)
                gone += 1
    return gone


def _is_part(key: str) -> bool:
    return key.endswith(".part")


def _is_named(key: str, named: set[str]) -> bool:
    """A picture by itself; a file of a capture or surface by its folder."""
    return key in named or key.rpartition("/")[0] in named
