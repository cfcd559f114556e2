"""Derived files on their way out: made in a worker process, then kept in memory while they are asked for."""

from __future__ import annotations

import gzip
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

from rumu.gallery.catalog import Gallery
from rumu.gallery.derived import etag, kept
from rumu.gallery.originals import Original, original_of, picture_original
from rumu.studio import worker
from rumu.studio.workers import Workers

_MOST = 96 * 2**20  # bytes in memory
_LARGEST = 8 * 2**20  # of one file that is kept there
_ADDRESSES = 20_000
_PACKED_ALREADY = ("image/", "application/zip")


@dataclass(frozen=True, slots=True)
class Sent:
    """A file as it goes out. packed: with gzip, None where that gains nothing. tag: names its content."""

    data: bytes
    packed: bytes | None
    media_type: str
    tag: str


class Files:
    """The derived files of a gallery's works and of attempts."""

    def __init__(self, gallery: Gallery, workers: Workers) -> None:
        self._gallery, self._workers = gallery, workers
        self._lock = threading.Lock()
        self._held: OrderedDict[str, Sent] = OrderedDict()
        self._bytes = 0
        self._tags: dict[tuple[str, str, float, str], str] = {}
        self._making = tuple(threading.Lock() for _ in range(64))

    def of_work(
        self, work_id: str, kind: str, *, exaggeration: float = 1.0, known: str | None = None
    ) -> Sent:
        """A file of a work. known: the tag that the asker has; then the data may be left empty.

        Raises GalleryError as `rumu.gallery.derived.derived` does.
        """
        original = original_of(self._gallery, work_id)
        return self._sent(original, kind, exaggeration, known, {"work_id": work_id})

    def quick(self, address: tuple[str, str, float, str]) -> Sent | None:
        """What was sent from this address before, while it is in memory; asks nothing of the database.

        address: work, kind, exaggeration and version, see `remember`.
        """
        tag = self._tags.get(address)
        return None if tag is None else self._remembered(tag)

    def remember(self, address: tuple[str, str, float, str], sent: Sent) -> None:
        """That this address means this content; only for versions that are the work's own."""
        if len(self._tags) >= _ADDRESSES:
            self._tags.clear()
        self._tags[address] = sent.tag

    def forget(self) -> None:
        """All addresses: a work has changed or gone."""
        self._tags.clear()

    def of_picture(self, key: str, kind: str, *, known: str | None = None) -> Sent:
        """The same of a picture of the store, such as an attempt's."""
        original = picture_original(self._gallery.store, key)
        return self._sent(original, kind, 1.0, known, {"picture": key})

    def original(self, key: str) -> Original:
        return picture_original(self._gallery.store, key)

    def _sent(
        self, original: Original, kind: str, exaggeration: float, known: str | None, source: dict[str, Any]
    ) -> Sent:
        tag = etag(original, kind, exaggeration=exaggeration)
        if known == tag:
            return Sent(b"", None, "", tag)
        held = self._remembered(tag)
        if held is not None:
            return held
        with self._making[hash(tag) % len(self._making)]:  # once, however many ask at a time
            held = self._remembered(tag)
            if held is not None:
                return held
            made = kept(self._gallery.store, original, kind, exaggeration=exaggeration)
            if made is None:
                made = self._workers.ask(worker.derived_file, kind=kind, exaggeration=exaggeration, **source)
            return self._kept(Sent(made.data, _packed(made.data, made.media_type), made.media_type, tag))

    def _remembered(self, tag: str) -> Sent | None:
        with self._lock:
            held = self._held.get(tag)
            if held is not None:
                self._held.move_to_end(tag)
            return held

    def _kept(self, sent: Sent) -> Sent:
        size = _size(sent)
        if size > _LARGEST:
            return sent
        with self._lock:
            if sent.tag not in self._held:
                self._held[sent.tag] = sent
                self._bytes += size
            while self._bytes > _MOST:
                _, gone = self._held.popitem(last=False)
                self._bytes -= _size(gone)
        return sent


def _size(sent: Sent) -> int:
    return len(sent.data) + len(sent.packed or b"")


def _packed(data: bytes, media_type: str) -> bytes | None:
    if media_type.startswith(_PACKED_ALREADY) or len(data) < 1000:
        return None
    packed = gzip.compress(data, 5)
    return packed if len(packed) < 0.9 * len(data) else None
