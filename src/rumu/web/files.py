"""Contents of derived files: made in a worker process, and kept in memory while they are requested."""

from __future__ import annotations

import gzip
import threading
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from cachetools import LRUCache, cachedmethod

from rumu.database.tables import Work
from rumu.gallery.assets import Assets, assets_of, picture_assets
from rumu.gallery.derived import PLAIN, MeshShape, etag, stored_file
from rumu.gallery.store import Gallery
from rumu.studio import worker_tasks
from rumu.studio.worker_pool import WorkerPool

_MAX_MEMORY = 96 * 2**20  # bytes of all contents
_MAX_FILE = 8 * 2**20  # bytes of one content that is kept in memory
_COMPRESSED_TYPES = ("image/", "application/zip")


@dataclass(frozen=True, slots=True)
class FileContent:
    """What a file's response holds. gzipped: None if compression gains nothing. etag: unquoted."""

    data: bytes
    gzipped: bytes | None
    media_type: str
    etag: str


class DerivedFiles:
    """The derived files of a gallery's works and of attempts."""

    def __init__(self, gallery: Gallery, workers: WorkerPool) -> None:
        self._gallery, self._workers = gallery, workers
        self._contents: LRUCache[str, FileContent] = LRUCache(_MAX_MEMORY, getsizeof=_bytes_in_memory)
        self._contents_changed = threading.Condition()

    def get(
        self,
        source: Work | str,
        kind: str,
        *,
        shape: MeshShape = PLAIN,
        client_etags: Collection[str] = (),
        before_making: Callable[[], None] = lambda: None,
    ) -> FileContent:
        """A file derived from a work, or from a picture by its key in the store.

        client_etags: if the file's is among them, the data are left empty.
        before_making: called when the file is not there yet; what it raises ends the request.
        Raises GalleryError as `rumu.gallery.derived.derived_file` does.
        """
        of: dict[str, Any]
        if isinstance(source, Work):
            assets, of = assets_of(self._gallery.store, source), {"work_id": source.id}
        else:
            assets, of = picture_assets(self._gallery.store, source), {"picture": source}
        tag = etag(assets, kind, shape=shape)
        if tag in client_etags:
            return FileContent(b"", None, "", tag)
        return self._load(tag, assets, kind, shape, of, before_making=before_making)

    @cachedmethod(
        lambda self: self._contents,
        key=lambda self, tag, *_, **__: tag,
        condition=lambda self: self._contents_changed,
    )
    def _load(
        self,
        tag: str,
        assets: Assets,
        kind: str,
        shape: MeshShape,
        source: dict[str, Any],
        *,
        before_making: Callable[[], None],
    ) -> FileContent:
        """A content from the store or a worker process; once, however many requests wait for it."""
        file = stored_file(self._gallery.store, assets, kind, shape=shape)
        if file is None:
            before_making()
            file = self._workers.call(worker_tasks.derived_file, kind=kind, shape=shape, **source)
        return FileContent(file.data, _compress(file.data, file.media_type), file.media_type, tag)


def _bytes_in_memory(content: FileContent) -> int:
    """The content's size; for one that is too large to be kept, more than the cache holds."""
    size = len(content.data) + len(content.gzipped or b"")
    return size if size <= _MAX_FILE else _MAX_MEMORY + 1


def _compress(data: bytes, media_type: str) -> bytes | None:
    if media_type.startswith(_COMPRESSED_TYPES) or len(data) < 1000:
        return None
    gzipped = gzip.compress(data, 5)
    return gzipped if len(gzipped) < 0.9 * len(data) else None
