"""The gallery, or collections of it, exported as a folder; `archive_import` imports it again.

    gallery.json   what the folder is, the collections and the tours
    works.jsonl    one work a line: its metadata, its annotations, its files
    labels.csv     the works for other programs, and for `rumu find`
    files/         pictures, photographs and surfaces under the keys of the store

Files that can be computed again (thumbnails, maps, meshes) are not exported. Importing the folder gives the
same ids, metadata, annotations, tours and bytes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.csv_tables import TableWriter
from rumu.database.tables import Annotation, Base, Collection, Tour, Work
from rumu.errors import GalleryError, OutputError
from rumu.gallery.assets import surface_files
from rumu.gallery.catalog import collection as find_collection
from rumu.gallery.masters import LABELS
from rumu.gallery.search_text import COLUMNS
from rumu.gallery.store import Gallery
from rumu.outputs import whole_folder
from rumu.values import Bilingual

Progress = Callable[[int, int], None]
Item = TypeVar("Item")

MANIFEST, WORKS, FILES = "gallery.json", "works.jsonl", "files"
KIND, FORMAT = "rumu gallery", 2  # since 2 works may stand within others
BATCH = 250  # works of one transaction
_FOLDERS = ("pictures", "captures", "surfaces")
NOT_EXPORTED = {"author_id", "search_version", *COLUMNS}  # users; texts for searches, which are made again
_LABELS = ("file", "id", "character", "script", "hand_zh", "hand_en", "title_zh", "title_en", "dynasty")
_MORE_LABELS = ("period", "medium", "source", "licence", "attribution", "calligrapher_zh", "work")


@dataclass(frozen=True, slots=True)
class ImportResult:
    """What an import did.

    collections: their ids. added: number of new works. existing: number of works that were there before.
    left_out: (file, reason) of each picture that was not imported. read_as: encoding and separator of the
    labels.csv, None if there is none.
    """

    collections: tuple[str, ...]
    added: int = 0
    existing: int = 0
    left_out: tuple[tuple[str, Bilingual], ...] = ()
    read_as: Bilingual | None = None

    def and_then(self, other: ImportResult) -> ImportResult:
        """The result of both batches."""
        return replace(
            self,
            added=self.added + other.added,
            existing=self.existing + other.existing,
            left_out=self.left_out + other.left_out,
        )


def split(items: Sequence[Item], size: int) -> Iterator[Sequence[Item]]:
    """Consecutive parts of at most `size` items."""
    return (items[at : at + size] for at in range(0, len(items), size))


# --- export ----------------------------------------------------------------------------------------


def export_gallery(
    gallery: Gallery,
    folder: str | Path,
    *,
    collections: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> int:
    """Write the works of the gallery, or of some collections, as a folder, completely or not at all.

    collections: ids; None for all. A tour is exported when all of its works are. progress: called with (done,
    total). Returns the number of works. Raises GalleryError for an unknown collection or a missing file,
    OutputError when the folder cannot be written or holds other files.
    """
    for name in collections or ():
        find_collection(gallery, name)
    with gallery.database.reading() as session:
        chosen = [] if collections is None else [Work.collection_id.in_(collections)]
        order = (Work.collection_id, Work.position, Work.id)
        ids = list(session.scalars(select(Work.id).where(*chosen).order_by(*order)))
        manifest = _manifest(session, collections=collections, ids=set(ids))
        with whole_folder(folder, marker=MANIFEST) as part:
            try:
                _write_works(gallery, session, ids, part, progress)
                text = json.dumps(manifest, ensure_ascii=False, indent=1)
                (part / MANIFEST).write_text(text + "\n", encoding="utf-8")
            except OSError as error:
                raise OutputError(f"{folder}: cannot be written ({error.strerror or error})") from error
    return len(ids)


def _manifest(session: Session, *, collections: Sequence[str] | None, ids: set[str]) -> dict[str, Any]:
    chosen = select(Collection).order_by(Collection.id)
    if collections is not None:
        chosen = chosen.where(Collection.id.in_(collections))
    tours = session.scalars(select(Tour).order_by(Tour.position, Tour.id))
    return {
        "kind": KIND,
        "format": FORMAT,
        "works": len(ids),
        "collections": [_to_json(one) for one in session.scalars(chosen)],
        "tours": [_to_json(tour) for tour in tours if {step["work"] for step in tour.steps} <= ids],
    }


def _write_works(
    gallery: Gallery, session: Session, ids: Sequence[str], folder: Path, progress: Progress | None
) -> None:
    with (
        (folder / WORKS).open("w", encoding="utf-8") as lines,
        (folder / LABELS).open("w", encoding="utf-8", newline="") as labels,
    ):
        table = TableWriter(labels, (*_LABELS, *_MORE_LABELS))
        for done, (work, annotations) in enumerate(_read_works(session, ids), start=1):
            files = list(dict.fromkeys(_store_keys(gallery, work)))
            for key in files:
                target = folder / FILES / key
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(gallery.store.read(key))
            entry = _to_json(work) | {"annotations": [_to_json(one) for one in annotations], "files": files}
            lines.write(json.dumps(entry, ensure_ascii=False) + "\n")
            table.write_row(_label(work))
            if progress is not None:
                progress(done, len(ids))


def _read_works(session: Session, ids: Sequence[str]) -> Iterator[tuple[Work, list[Annotation]]]:
    """Each work with its annotations, in order."""
    for some in split(ids, BATCH):
        works = {work.id: work for work in session.scalars(select(Work).where(Work.id.in_(some)))}
        annotations: dict[str, list[Annotation]] = {}
        of_works = select(Annotation).where(Annotation.work_id.in_(some))
        for one in session.scalars(of_works.order_by(Annotation.position, Annotation.id)):
            annotations.setdefault(one.work_id, []).append(one)
        yield from ((works[name], annotations.get(name, [])) for name in some)
        session.expunge_all()


def _store_keys(gallery: Gallery, work: Work) -> Iterator[str]:
    yield work.picture
    if work.capture is None:
        return
    keys = list(gallery.store.keys(work.capture))
    if not keys:
        raise GalleryError(f"{work.id}: its files {work.capture} are missing from the store")
    yield from keys
    yield from surface_files(gallery.store, work)


def _to_json(row: Base) -> dict[str, Any]:
    """The columns of a row as JSON values."""
    values = {column.name: getattr(row, column.name) for column in row.__table__.columns}
    return {
        name: value.isoformat() if isinstance(value, datetime) else value
        for name, value in values.items()
        if name not in NOT_EXPORTED
    }


def _label(work: Work) -> dict[str, str]:
    row = {name: str(getattr(work, name)) for name in (*_LABELS[1:], "source", "licence", "attribution")}
    return row | {
        "file": f"{FILES}/{work.picture}",
        "period": work.period_zh,
        "medium": work.material_zh,
        "calligrapher_zh": work.hand_zh,
        "work": work.title_zh,
    }
