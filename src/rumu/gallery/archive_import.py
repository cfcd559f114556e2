"""Import of a folder that `export_gallery` wrote, whole or not at all.

An export may have been written by anyone: each row is checked by the schema of `rumu.gallery.rows`, and each
file by `rumu.gallery.archive_files`. Files are stored first; then all rows appear in one transaction.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from sqlalchemy import select, update
from sqlalchemy.orm import Session

from rumu.database.tables import Annotation, Collection, Tour, Work, now
from rumu.errors import GalleryError
from rumu.gallery.archive import BATCH, FORMAT, MANIFEST, WORKS, ImportResult, Progress, split
from rumu.gallery.archive_files import ArchiveFiles
from rumu.gallery.catalog import CHANGEABLE
from rumu.gallery.metadata import CollectionMetadata, insert_rows, next_position
from rumu.gallery.rows import ExportedWork, ExportManifest, TourRow, read_row
from rumu.gallery.search_text import search_columns
from rumu.gallery.store import Gallery
from rumu.values import Bilingual

_FOLLOWING = ("collection_id", "occurrence", "text", "record")
_MAX_LINE = 8 * 2**20  # bytes of a work with its annotations
_MAX_MANIFEST = 64 * 2**20  # bytes
_THREADS = 4  # read and decode; both release the interpreter's lock
_TAKEN = Bilingual("別的作品已用這個編號。", "another work has this id")
_WITHOUT_PAGE = Bilingual("它所在的整頁作品不在這裡。", "the page that it stands on is not in the gallery")
_OWNERS_ONLY = Bilingual("導覽只有館主能收入。", "only an owner can add tours")
_TOUR_WITHOUT_WORKS = Bilingual("導覽所經的作品不全。", "works of this tour are not in the gallery")


@dataclass(frozen=True, slots=True)
class _Existing:
    """What the gallery knows of a work. unchanged: since it was added."""

    digest: str
    picture: str
    unchanged: bool


def import_archive(
    gallery: Gallery,
    folder: Path,
    *,
    collection: CollectionMetadata | None = None,
    only_add: bool = False,
    progress: Progress | None = None,
) -> ImportResult:
    """Import an exported folder, whole or not at all.

    collection: for new works, instead of their own; existing works stay as they are.
    only_add: nothing but new works is added, with their annotations, and with their collections where those
        are new. Without it, as for an owner who restores a gallery, works that nobody has changed here take
        the exported metadata and annotations, and tours are added.
    A work whose id another work has is left out with the reason; one that is there already is counted.
    Raises GalleryError when the folder is not complete, or anything in it is not as `export_gallery` writes
    it: a row, a missing file, or one whose content does not match its name.
    """
    manifest = _read_manifest(folder)
    works = list(_read_works(folder))
    if len(works) != manifest.works:
        raise GalleryError(
            f"{WORKS}: expected {manifest.works} works as {MANIFEST} says, got {len(works)}",
            zh=f"{MANIFEST} 說有 {manifest.works} 件作品，{WORKS} 裡卻有 {len(works)} 件。",
        )
    _check_ids(manifest, works, any_collection=collection is not None)
    if collection is not None:
        works = [work.model_copy(update={"collection_id": collection.id}) for work in works]
    existing = _existing_works(gallery, works)
    digests = _existing_digests(gallery, works)
    new = [work for work in works if work.id not in existing and work.digest not in digests]
    files = ArchiveFiles(gallery, folder, only_add=only_add)
    try:
        rows = files.store_all(new, progress)
        return _insert(
            gallery, manifest, works, rows, existing=existing, collection=collection, only_add=only_add
        )
    except BaseException:
        files.delete_unused()
        raise


# --- reading and checking --------------------------------------------------------------------------


def _read_manifest(folder: Path) -> ExportManifest:
    path = folder / MANIFEST
    try:
        with path.open("rb") as stream:
            text = stream.read(_MAX_MANIFEST + 1)
        manifest = ExportManifest.model_validate_json(text[: _MAX_MANIFEST + 1])
    except OSError as error:
        raise GalleryError(
            f"{MANIFEST}: cannot be read ({error.strerror})", zh=f"{MANIFEST} 讀不到（{error.strerror}）。"
        ) from error
    except ValidationError as error:
        if any(one["loc"][:1] in (("kind",), ("format",)) for one in error.errors()):
            raise GalleryError(
                f"{MANIFEST}: expected a gallery of format {FORMAT}, got something else",
                zh=f"{MANIFEST} 不是格式 {FORMAT} 的匯出檔。",
            ) from error
        return read_row(ExportManifest, text, where=Bilingual(MANIFEST, MANIFEST))
    return manifest


def _read_works(folder: Path) -> Iterator[ExportedWork]:
    try:
        with (folder / WORKS).open("rb") as stream:
            number = 0
            while line := stream.readline(_MAX_LINE + 1):
                number += 1
                if len(line) > _MAX_LINE:
                    raise GalleryError(
                        f"{WORKS} line {number}: expected at most {_MAX_LINE} bytes",
                        zh=f"{WORKS} 第 {number} 行太長。",
                    )
                where = Bilingual(f"{WORKS} 第 {number} 行", f"{WORKS} line {number}")
                yield read_row(ExportedWork, line, where=where)
    except OSError as error:
        raise GalleryError(
            f"{WORKS}: cannot be read ({error.strerror})", zh=f"{WORKS} 讀不到（{error.strerror}）。"
        ) from error


def _check_ids(manifest: ExportManifest, works: Sequence[ExportedWork], *, any_collection: bool) -> None:
    """Raise GalleryError for an id that stands twice, and for a collection that the export does not bring."""
    annotations = [one.id for work in works for one in work.annotations]
    for ids in ([work.id for work in works], [one.id for one in manifest.collections], annotations):
        twice = (
            next((name for name in ids if ids.count(name) > 1), None) if len(set(ids)) < len(ids) else None
        )
        if twice is not None:
            raise GalleryError(
                f"{WORKS}: expected each id once, got {twice!r} twice", zh=f"{WORKS} 有兩個編號 {twice}。"
            )
    known = {one.id for one in manifest.collections}
    for work in works:
        if not any_collection and work.collection_id not in known:
            raise GalleryError(
                f"{work.id}: expected a collection of {MANIFEST}, got {work.collection_id!r}",
                zh=f"{work.id}：{MANIFEST} 裡沒有專題 {work.collection_id}。",
            )
    pages = {work.id: work for work in works if work.parent_id is None}
    for work in works:
        page = pages.get(work.parent_id) if work.parent_id is not None else None
        if work.parent_id is not None and (page is None or page.collection_id != work.collection_id):
            raise GalleryError(
                f"{work.id}: expected a page of the same collection in {WORKS} that it stands on, "
                f"got {work.parent_id!r}",
                zh=f"{work.id}：{WORKS} 裡沒有它所在的整頁作品 {work.parent_id}。",
            )


def _existing_works(gallery: Gallery, works: Sequence[ExportedWork]) -> dict[str, _Existing]:
    columns = select(Work.id, Work.digest, Work.picture, Work.changed == Work.created)
    found: dict[str, _Existing] = {}
    with gallery.database.reading() as session:
        for some in split(works, BATCH):
            rows = session.execute(columns.where(Work.id.in_([work.id for work in some])))
            found |= {row[0]: _Existing(row[1], row[2], bool(row[3])) for row in rows}
    return found


def _existing_digests(gallery: Gallery, works: Sequence[ExportedWork]) -> set[str]:
    found: set[str] = set()
    with gallery.database.reading() as session:
        for some in split(works, BATCH):
            digests = select(Work.digest).where(Work.digest.in_([work.digest for work in some]))
            found.update(session.scalars(digests))
    return found


# --- rows ------------------------------------------------------------------------------------------


def _insert(
    gallery: Gallery,
    manifest: ExportManifest,
    works: Sequence[ExportedWork],
    rows: dict[str, dict[str, Any]],
    *,
    existing: dict[str, _Existing],
    collection: CollectionMetadata | None,
    only_add: bool,
) -> ImportResult:
    """Insert all rows in one transaction."""
    conflicts = {
        work.id
        for work in works
        if (there := existing.get(work.id)) is not None
        and there.digest != work.digest
        and not (only_add and there.picture == work.picture)  # its digest was made anew, see ArchiveFiles
    }
    with gallery.database.writing() as session:
        used = {work.collection_id for work in works if work.id in rows}
        collections = [one.model_dump() for one in manifest.collections if not only_add or one.id in used]
        insert_rows(session, Collection, collections if collection is None else [collection.row()])
        titles = {one.id: one.title for one in session.scalars(select(Collection))}
        if only_add:
            _move_to_end(session, rows.values())
        complete = [
            row | search_columns(row, collection=titles[row["collection_id"]]) for row in rows.values()
        ]
        added = insert_rows(session, Work, [row for row in complete if row["parent_id"] is None])
        pages = added if only_add else added | (set(existing) - conflicts)
        within = [row for row in complete if row["parent_id"] is not None]
        added |= insert_rows(session, Work, [row for row in within if row["parent_id"] in pages])
        of_added = [work for work in works if work.id in added]
        if not only_add:
            if collection is None:
                _update_unchanged(session, works, existing, titles)
            of_added += [work for work in works if work.id in existing and work.id not in conflicts]
        annotations = [one.model_dump() for work in of_added for one in work.annotations]
        if only_add:
            annotations = [row | {"created": now()} for row in annotations]
        insert_rows(session, Annotation, annotations)
        left_out = [(work.id, _TAKEN) for work in works if work.id in conflicts]
        left_out += [(row["id"], _WITHOUT_PAGE) for row in within if row["parent_id"] not in pages]
        tours_left_out = _insert_tours(session, manifest.tours, only_add=only_add)
        named = [collection.id] if collection is not None else [one["id"] for one in collections]
        number_there = len(works) - len(added) - len(left_out)
    return ImportResult(tuple(named), len(added), number_there, (*left_out, *tours_left_out))


def _move_to_end(session: Session, rows: Any) -> None:
    """Let the rows follow the works that their collections have, in the order of the export.

    Characters keep their places on their pages.
    """
    following: dict[str, int] = {}
    for row in sorted(rows, key=lambda row: (row["collection_id"], row["position"], row["id"])):
        name = row["collection_id"]
        if row["parent_id"] is not None:
            continue
        if name not in following:
            following[name] = next_position(session, name)
        row["position"] = following[name]
        following[name] += 1


def _update_unchanged(
    session: Session,
    works: Sequence[ExportedWork],
    existing: dict[str, _Existing],
    titles: dict[str, Bilingual],
) -> None:
    """Give works that nobody has changed here the exported metadata, never other files."""
    for work in works:
        there = existing.get(work.id)
        if there is None or not there.unchanged or there.digest != work.digest:
            continue
        row = work.columns()
        values = {name: row[name] for name in (*CHANGEABLE, *_FOLLOWING, "created", "changed")}
        values |= search_columns(row, collection=titles[work.collection_id])
        session.execute(update(Work).where(Work.id == work.id).values(values))


def _insert_tours(
    session: Session, tours: Sequence[TourRow], *, only_add: bool
) -> list[tuple[str, Bilingual]]:
    """Insert tours through works that are there; (id, reason) of the others."""
    if only_add:
        known = set(session.scalars(select(Tour.id)))
        return [
            (tour.title_zh or tour.title_en or tour.id, _OWNERS_ONLY)
            for tour in tours
            if tour.id not in known
        ]
    ids = {step.work for tour in tours for step in tour.steps}
    there: set[str] = set()
    for some in split(sorted(ids), BATCH):
        there.update(session.scalars(select(Work.id).where(Work.id.in_(some))))
    whole = [tour for tour in tours if {step.work for step in tour.steps} <= there]
    insert_rows(session, Tour, [tour.model_dump() for tour in whole])
    return [(tour.id, _TOUR_WITHOUT_WORKS) for tour in tours if tour not in whole]


def holds_starter(folder: Path) -> bool:
    """Whether an export holds the starter gallery; an empty gallery then need not begin with it."""
    if not (folder / MANIFEST).is_file():
        return False
    return any(one.id == "starter" for one in _read_manifest(folder).collections)
