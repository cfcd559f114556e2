"""Import of many works: a folder with pictures and labels.csv, pages with texts, or an exported archive.

Works are added in batches: first their files, then their rows in one transaction. If an import is interrupted
between two batches, the works that were confirmed stay, and none is incomplete. A second run continues,
because a picture with its label is stored once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import select

from rumu.containment import FolderFiles
from rumu.database.tables import Work
from rumu.errors import GalleryError, ImageError
from rumu.gallery.add_work import store_suffix
from rumu.gallery.archive import BATCH, MANIFEST, ImportResult, Progress, split
from rumu.gallery.archive_import import import_archive
from rumu.gallery.assets import picture_key
from rumu.gallery.labels import LabelledPicture, SharedMetadata, collection_of, read_description, read_labels
from rumu.gallery.masters import LABELS, read_label_table
from rumu.gallery.metadata import CollectionMetadata, StoredFiles, insert_works, work_row
from rumu.gallery.page_import import LabelledPage, find_pages, import_pages, part_pages
from rumu.gallery.store import Gallery
from rumu.gallery.vocabulary import file_in_other_characters
from rumu.values import Bilingual

_BATCH_BYTES = 64_000_000  # or fewer works, when their pictures are large
_THREADS = 4  # read and decode; both release the interpreter's lock
_READ_AHEAD = 32  # pictures that threads read at a time


def import_folder(
    gallery: Gallery,
    folder: str | Path,
    *,
    shared: SharedMetadata | None = None,
    only_add: bool = False,
    progress: Progress | None = None,
) -> ImportResult:
    """Add all works of a folder; those that exist are counted and left as they are.

    folder: with a labels.csv (see rumu.gallery.labels), with pages and their texts (see
        rumu.gallery.page_import), or written by `export_gallery`. shared: metadata for
        all works, which take effect where the labels say nothing and before those of collection.json; for an
        archive only the id counts: the collection that works are added to, instead of their own. only_add: of
        an archive, see `import_archive`. progress: called with (done, total) when a batch is stored.
    A picture that is missing or broken is left out with the reason, and the import goes on.
    Raises GalleryError when there is nothing to import, or none of the pictures can be read.
    """
    folder = Path(folder)
    if (folder / MANIFEST).is_file():
        collection = collection_of(folder, shared) if shared is not None and shared.text("id") else None
        return import_archive(gallery, folder, collection=collection, only_add=only_add, progress=progress)
    shared = (shared or SharedMetadata()).with_defaults(read_description(folder))
    labels, pages, read_as = _find_works(folder, shared)
    collection = collection_of(folder, shared)
    collection.row()  # refused before a file is stored, if it is
    result, done, total = ImportResult((collection.id,), read_as=read_as), 0, len(labels) + len(pages)
    for batch in _read_batches(folder, labels):
        result = result.and_then(_import_batch(gallery, batch, collection))
        done += len(batch)
        if progress is not None:
            progress(done, total)

    def advance(pages_done: int, _: int) -> None:
        if progress is not None:
            progress(len(labels) + pages_done, total)

    result = result.and_then(import_pages(gallery, folder, pages, collection, progress=advance))
    if total and len(result.left_out) == total:
        first = result.left_out[0][1]
        raise GalleryError(
            f"{folder}: none of {total} pictures can be read; the first: {first.en}",
            zh=f"{total} 張圖片都讀不出來；第一張：{first.zh}",
        )
    return result


def _find_works(
    folder: Path, shared: SharedMetadata
) -> tuple[list[LabelledPicture], list[LabelledPage], Bilingual | None]:
    """The single pictures and the pages of a folder, and how its labels.csv was read, if it has one.

    Raises GalleryError when there is neither.
    """
    if (folder / LABELS).is_file():
        read_as = read_label_table(folder / LABELS).description
        return *part_pages(folder, read_labels(folder, shared)), read_as
    pages = find_pages(folder, shared)
    if not pages:
        raise GalleryError(
            f"{folder}: expected a folder with {LABELS}, with pages and a text beside each (a.jpg, a.txt), "
            "or one that `rumu gallery export` wrote; one picture or one capture folder is for "
            "`rumu gallery add`"
        )
    return [], pages, None


@dataclass(frozen=True, slots=True)
class _Picture:
    """A labelled picture with its data and key in the store, or the reason why it cannot be read."""

    label: LabelledPicture
    data: bytes = field(default=b"", repr=False)
    size: tuple[int, int] = (0, 0)
    key: str = ""
    reason: Bilingual | None = None


def _read_batches(folder: Path, labels: Sequence[LabelledPicture]) -> Iterator[list[_Picture]]:
    batch: list[_Picture] = []
    files = FolderFiles(folder)
    with ThreadPoolExecutor(_THREADS) as threads:
        for some in split(labels, _READ_AHEAD):
            for picture in threads.map(lambda label: _read_picture(folder, files, label), some):
                batch.append(picture)
                if len(batch) == BATCH or sum(len(one.data) for one in batch) > _BATCH_BYTES:
                    yield batch
                    batch = []
    if batch:
        yield batch


def _read_picture(folder: Path, files: FolderFiles, label: LabelledPicture) -> _Picture:
    from rumu.capture.formats import decode

    path = files.find(label.file) or file_in_other_characters(folder, label.file)
    if path is None:
        return _Picture(
            label,
            reason=Bilingual(
                zh=f"{label.file}：資料夾裡沒有這個檔案。",
                en=f"{label.file}: expected a picture within the folder, there is none",
            ),
        )
    try:
        height, width = decode(path).values.shape[:2]
        data = path.read_bytes()
        return _Picture(label, data, (width, height), picture_key(data, suffix=store_suffix(path)))
    except OSError as error:
        why = error.strerror
        return _Picture(label, reason=Bilingual(f"讀不到（{why}）。", f"cannot be read ({why})"))
    except (ImageError, ValueError) as error:
        text = " ".join(str(error).split())
        return _Picture(label, reason=Bilingual(getattr(error, "zh", None) or f"無法使用：{text}", text))


def _import_batch(
    gallery: Gallery, batch: Sequence[_Picture], collection: CollectionMetadata
) -> ImportResult:
    by_digest = {one.label.metadata.digest(one.data): one for one in batch if one.reason is None}
    left_out = [(one.label.file, one.reason) for one in batch if one.reason is not None]
    with gallery.database.reading() as session:
        existing = set(session.scalars(select(Work.digest).where(Work.digest.in_(list(by_digest)))))
    rows, pictures = [], []
    for digest, picture in by_digest.items():
        label, (width, height) = picture.label, picture.size
        files = StoredFiles(picture=picture.key, digest=digest, width=width, height=height)
        if digest in existing:
            continue
        try:
            rows.append(work_row(label.metadata, files, collection=collection, position=label.number))
            pictures.append(picture)
        except GalleryError as error:
            left_out.append((label.file, Bilingual(error.zh or f"無法使用：{error}", str(error))))
    with ThreadPoolExecutor(_THREADS) as threads:
        list(threads.map(lambda picture: gallery.store.write(picture.key, picture.data), pictures))
    added = 0
    if rows:
        with gallery.database.writing() as session:
            added = len(insert_works(session, collection, rows))
    return ImportResult((collection.id,), added, len(batch) - len(left_out) - added, tuple(left_out))
