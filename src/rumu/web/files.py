"""Contents of derived files: made in a worker process, and kept in memory while they are requested."""

from __future__ import annotations

import gzip
import threading
from collections import OrderedDict
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from rumu.gallery.assets import Assets, assets_of, picture_assets
from rumu.gallery.catalog import work
from rumu.gallery.derived import etag, stored_file
from rumu.gallery.gallery import Gallery
from rumu.studio import worker
from rumu.studio.workers import Workers

_MAX_MEMORY = 96 * 2**20  # bytes of all contents
_MAX_FILE = 8 * 2**20  # bytes of one content that is kept in memory
_MAX_ADDRESSES = 20_000
_COMPRESSED_TYPES = ("image/", "application/zip")

FileAddress = tuple[str, str, float, str]
"""Work, kind, exaggeration and version of a file, as its URL gives them."""


@dataclass(frozen=True, slots=True)
class FileContent:
    """What a file's response holds. gzipped: None if compression gains nothing. etag: unquoted."""

    data: bytes
    gzipped: bytes | None
    media_type: str
    etag: str

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return len(self.data) + len(self.gzipped or b"")


class DerivedFiles:
    """The derived files of a gallery's works and of attempts."""

    def __init__(self, gallery: Gallery, workers: Workers) -> None:
        self._gallery, self._workers = gallery, workers
        self._lock = threading.Lock()
        self._contents: OrderedDict[str, FileContent] = OrderedDict()
        self._bytes = 0
        self._etags: dict[FileAddress, str] = {}
        self._being_made = tuple(threading.Lock() for _ in range(64))

    def of_work(
        self, work_id: str, kind: str, *, exaggeration: float = 1.0, client_etags: Collection[str] = ()
    ) -> FileContent:
        """A file of a work. client_etags: if the file's is among them, the data are left empty.

        Raises GalleryError as `rumu.gallery.derived.derived` does.
        """
        assets = assets_of(self._gallery.store, work(self._gallery, work_id))
        return self._content(assets, kind, exaggeration, client_etags, {"work_id": work_id})

    def of_picture(self, key: str, kind: str, *, client_etags: Collection[str] = ()) -> FileContent:
        """A file of a picture in the store, such as an attempt's."""
        assets = picture_assets(self._gallery.store, key)
        return self._content(assets, kind, 1.0, client_etags, {"picture": key})

    def at_address(self, address: FileAddress) -> FileContent | None:
        """What was sent from this address, while it is in memory. It needs no query of the database."""
        etag_there = self._etags.get(address)
        return None if etag_there is None else self._in_memory(etag_there)

    def set_address(self, address: FileAddress, content: FileContent) -> None:
        """Remember the content of an address; only for versions that are the work's present one."""
        if len(self._etags) >= _MAX_ADDRESSES:
            self._etags.clear()
        self._etags[address] = content.etag

    def forget_addresses(self) -> None:
        """Forget all addresses, because a work has changed or is deleted."""
        self._etags.clear()

    def _content(
        self,
        assets: Assets,
        kind: str,
        exaggeration: float,
        client_etags: Collection[str],
        source: dict[str, Any],
    ) -> FileContent:
        tag = etag(assets, kind, exaggeration=exaggeration)
        if tag in client_etags:
            return FileContent(b"", None, "", tag)
        content = self._in_memory(tag)
        if content is not None:
            return content
        with self._being_made[hash(tag) % len(self._being_made)]:  # once, however many requests wait for it
            content = self._in_memory(tag)
            if content is not None:
                return content
            file = stored_file(self._gallery.store, assets, kind, exaggeration=exaggeration)
            if file is None:
                file = self._workers.ask(worker.derived_file, kind=kind, exaggeration=exaggeration, **source)
            content = FileContent(file.data, _compress(file.data, file.media_type), file.media_type, tag)
            self._store(content)
            return content

    def _in_memory(self, tag: str) -> FileContent | None:
        with self._lock:
            content = self._contents.get(tag)
            if content is not None:
                self._contents.move_to_end(tag)
            return content

    def _store(self, content: FileContent) -> None:
        if content.size > _MAX_FILE:
            return
        with self._lock:
            if content.etag not in self._contents:
                self._contents[content.etag] = content
                self._bytes += content.size
            while self._bytes > _MAX_MEMORY:
                _, oldest = self._contents.popitem(last=False)
                self._bytes -= oldest.size


def _compress(data: bytes, media_type: str) -> bytes | None:
    if media_type.startswith(_COMPRESSED_TYPES) or len(data) < 1000:
        return None
    gzipped = gzip.compress(data, 5)
    return gzipped if len(gzipped) < 0.9 * len(data) else None
