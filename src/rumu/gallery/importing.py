"""Many works at once: a folder of pictures with labels.csv, or a folder that `export` wrote.

Works go in by batches: first the files, then their rows in one transaction. Whatever ends the import between
two batches, what was confirmed stays and nothing is there by half; a second run goes on where the first
ended, since a picture under its label is kept once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Work
from rumu.errors import GalleryError, ImageError
from rumu.gallery.adding import suffix_of
from rumu.gallery.archive import BATCH, MANIFEST, ImportResult, Progress, import_archive, split
from rumu.gallery.entries import Kept, Room, digest_of, put_collection, put_works, work_row
from rumu.gallery.gallery import Gallery
from rumu.gallery.labels import Row, Told, collection_of, read_description, read_rows
from rumu.gallery.masters import LABELS
from rumu.gallery.originals import picture_key

_BATCH_BYTES = 64_000_000  # or fewer works, when their pictures are large
_THREADS = 4  # read and decode; both leave the interpreter free
_GROUP = 32  # pictures in memory that wait to join a batch


def import_folder(
    gallery: Gallery, folder: str | Path, *, told: Told | None = None, progress: Progress | None = None
) -> ImportResult:
    """Put in every work of a folder; those that are there already are counted and left as they are.

    folder: with a labels.csv (see rumu.gallery.labels), or written by `export_gallery`. told: what holds for
        all works that the labels say nothing of, and goes before collection.json; of an export its id alone
        is heeded: where the works go instead of into their own collections. progress: called with
        (done, total) when a batch is safe in the gallery.
    A picture that is missing or broken is left out with the reason and stops nothing.
    Raises GalleryError when there is nothing to import, or not one picture of it could be read.
    """
    place = Path(folder)
    if (place / MANIFEST).is_file():
        room = collection_of(place, told) if told is not None and told.text("id") else None
        return import_archive(gallery, place, room=room, progress=progress)
    if not (place / LABELS).is_file():
        raise GalleryError(
            f"{place}: expected a folder with {LABELS}, or one that `rumu gallery export` wrote; "
            "one picture or one capture folder is for `rumu gallery add`"
        )
    said = (told or Told()).over(read_description(place))
    rows = read_rows(place, said)
    done = ImportResult((collection_of(place, said).id,))
    for batch in _batches(place, rows):
        done = done.and_then(_put_batch(gallery, batch, room=collection_of(place, said)))
        if progress is not None:
            progress(done.total, len(rows))
    if rows and len(done.left_out) == len(rows):
        first = done.left_out[0][1]
        raise GalleryError(f"{place}: none of {len(rows)} pictures can be read; the first: {first}")
    return done


@dataclass(frozen=True, slots=True)
class _Picture:
    """A row with its picture, or with the reason why it has none."""

    row: Row
    data: bytes = field(default=b"", repr=False)
    size: tuple[int, int] = (0, 0)
    reason: str = ""

    @property
    def digest(self) -> str:
        entry = self.row.entry
        return digest_of(
            self.data, entry.character, entry.script, entry.hand.zh, entry.hand.en, entry.title.zh
        )

    @property
    def key(self) -> str:
        return picture_key(self.data, suffix=suffix_of(Path(self.row.file)))


def _batches(folder: Path, rows: Sequence[Row]) -> Iterator[list[_Picture]]:
    waiting: list[_Picture] = []
    with ThreadPoolExecutor(_THREADS) as threads:
        for group in split(rows, _GROUP):
            for picture in threads.map(lambda row: _read(folder, row), group):
                waiting.append(picture)
                if len(waiting) == BATCH or sum(len(one.data) for one in waiting) > _BATCH_BYTES:
                    yield waiting
                    waiting = []
    if waiting:
        yield waiting


def _read(folder: Path, row: Row) -> _Picture:
    from rumu.capture.formats import decode

    path = folder / row.file
    try:
        if not path.resolve().is_relative_to(folder.resolve()):
            raise ImageError(f"{row.file}: expected a picture within the folder")
        height, width = decode(path).values.shape[:2]
        return _Picture(row, path.read_bytes(), (width, height))
    except (ImageError, OSError, ValueError) as error:
        return _Picture(row, reason=" ".join(str(error).split()))


def _put_batch(gallery: Gallery, batch: Sequence[_Picture], *, room: Room) -> ImportResult:
    fine = {picture.digest: picture for picture in batch if not picture.reason}
    left_out = tuple((picture.row.file, picture.reason) for picture in batch if picture.reason)
    new = {digest: fine[digest] for digest in set(fine) - known_digests(gallery, fine)}
    with ThreadPoolExecutor(_THREADS) as threads:
        list(threads.map(lambda picture: gallery.store.write(picture.key, picture.data), new.values()))
    rows = [_row(picture, digest, room) for digest, picture in new.items()]
    with gallery.database.writing() as session:
        put_collection(session, room)
        added = len(put_works(session, rows))
    return ImportResult((room.id,), added, len(batch) - len(left_out) - added, left_out)


def known_digests(gallery: Gallery, digests: Iterable[str]) -> set[str]:
    """Those of the digests that are a work's."""
    with gallery.database.reading() as session:
        return set(session.scalars(select(Work.digest).where(Work.digest.in_(list(digests)))))


def _row(picture: _Picture, digest: str, room: Room) -> dict[str, Any]:
    kept = Kept(picture=picture.key, digest=digest, width=picture.size[0], height=picture.size[1])
    work_id = f"{room.id}-{digest[:12]}"
    return work_row(picture.row.entry, kept, work_id=work_id, room=room, position=picture.row.number)
