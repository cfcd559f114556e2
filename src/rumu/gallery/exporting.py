"""The gallery, or collections of it, as a folder that holds all of it and can be put in again.

    gallery.json   what it is, the collections and the tours
    works.jsonl    one work a line: every fact, its annotations, the files it has
    labels.csv     the works for other programs, and for `rumu find`
    files/         pictures, photographs and surfaces under the keys of the store

What can be made again (thumbnails, maps, meshes) is not in it. `import` of such a folder gives the same ids,
facts, annotations, tours and bytes.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.database.tables import Annotation, Collection, Tour, Work
from rumu.errors import GalleryError, OutputError
from rumu.gallery.catalog import Gallery
from rumu.gallery.catalog import collection as find_collection
from rumu.gallery.importing import EXPORTED, Progress
from rumu.gallery.masters import LABELS
from rumu.outputs import whole_folder

KIND, FORMAT = "rumu gallery", 1
WORKS = "works.jsonl"
FILES = "files"
_AT_ONCE = 500  # works in memory
_UNSAID = {"author_id", "search"}  # people do not travel with works; what a search looks through is made anew


def export_gallery(
    gallery: Gallery,
    folder: str | Path,
    *,
    collections: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> int:
    """Write the works of the gallery, or of some collections, as a folder; it appears whole or not at all.

    collections: ids; None for all. A tour goes along when every work of it does. progress: called with (done,
    total). Returns the number of works. Raises GalleryError for no such collection or a file that is gone,
    OutputError when the folder cannot be written or holds other things.
    """
    for name in collections or ():
        find_collection(gallery, name)
    with gallery.database.reading() as session:
        chosen = [] if collections is None else [Work.collection_id.in_(collections)]
        order = (Work.collection_id, Work.position, Work.id)
        ids = list(session.scalars(select(Work.id).where(*chosen).order_by(*order)))
        facts = _facts(session, collections=collections, ids=set(ids))
        with whole_folder(folder, marker=EXPORTED) as part:
            try:
                _write_works(gallery, session, ids, part, progress)
                text = json.dumps(facts, ensure_ascii=False, indent=1)
                (part / EXPORTED).write_text(text + "\n", encoding="utf-8")
            except OSError as error:
                raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from error
    return len(ids)


def _facts(session: Session, *, collections: Sequence[str] | None, ids: set[str]) -> dict[str, Any]:
    rooms = select(Collection).order_by(Collection.id)
    if collections is not None:
        rooms = rooms.where(Collection.id.in_(collections))
    tours = session.scalars(select(Tour).order_by(Tour.position, Tour.id))
    return {
        "kind": KIND,
        "format": FORMAT,
        "works": len(ids),
        "collections": [_columns(room) for room in session.scalars(rooms)],
        "tours": [_columns(tour) for tour in tours if {step["work"] for step in tour.steps} <= ids],
    }


def _write_works(
    gallery: Gallery, session: Session, ids: Sequence[str], folder: Path, progress: Progress | None
) -> None:
    with (
        (folder / WORKS).open("w", encoding="utf-8") as lines,
        (folder / LABELS).open("w", encoding="utf-8", newline="") as labels,
    ):
        table = _labels(labels)
        for done, (work, said) in enumerate(_works(session, ids), start=1):
            files = list(dict.fromkeys(_files(gallery, work)))
            for key in files:
                target = folder / FILES / key
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(gallery.store.read(key))
            entry = _columns(work) | {"annotations": [_columns(one) for one in said], "files": files}
            lines.write(json.dumps(entry, ensure_ascii=False) + "\n")
            table.writerow(_label(work))
            if progress is not None:
                progress(done, len(ids))


def _works(session: Session, ids: Sequence[str]) -> Iterator[tuple[Work, list[Annotation]]]:
    """Each work with its annotations, in order."""
    for at in range(0, len(ids), _AT_ONCE):
        some = ids[at : at + _AT_ONCE]
        works = {work.id: work for work in session.scalars(select(Work).where(Work.id.in_(some)))}
        said: dict[str, list[Annotation]] = {}
        found = select(Annotation).where(Annotation.work_id.in_(some))
        for one in session.scalars(found.order_by(Annotation.position, Annotation.id)):
            said.setdefault(one.work_id, []).append(one)
        yield from ((works[name], said.get(name, [])) for name in some)
        session.expunge_all()


def _files(gallery: Gallery, work: Work) -> Iterator[str]:
    yield work.picture
    for folder in filter(None, (work.surface, work.capture)):
        keys = list(gallery.store.keys(folder))
        if not keys:
            raise GalleryError(f"{work.id}: its files {folder} are gone from the store")
        yield from keys


def _columns(row: Any) -> dict[str, Any]:
    """The columns of a row as JSON holds them."""
    values = {column.name: getattr(row, column.name) for column in row.__table__.columns}
    return {
        name: value.isoformat() if isinstance(value, datetime) else value
        for name, value in values.items()
        if name not in _UNSAID
    }


_LABELS = ("file", "id", "character", "script", "hand_zh", "hand_en", "title_zh", "title_en", "dynasty")
_MORE_LABELS = ("period", "medium", "source", "licence", "attribution", "calligrapher_zh", "work")


def _labels(stream: TextIO) -> csv.DictWriter[str]:
    table = csv.DictWriter(stream, (*_LABELS, *_MORE_LABELS))
    table.writeheader()
    return table


def _label(work: Work) -> dict[str, str]:
    row = {name: str(getattr(work, name)) for name in (*_LABELS[1:], "source", "licence", "attribution")}
    return row | {
        "file": f"{FILES}/{work.picture}",
        "period": work.period_zh,
        "medium": work.material_zh,
        "calligrapher_zh": work.hand_zh,
        "work": work.title_zh,
    }
