"""Add a page or a scroll with its text: the whole as a work, and each character on it as a work within it.

The page is read by `rumu.read_page`. It is stored as it came where it lies flat already, else as it was laid
flat, since places are told on the flat page. Each character's picture is a part of the page's pixels. All
rows appear in one transaction, so that a page is there with all of its characters or not at all.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import case, func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Collection, Work
from rumu.errors import GalleryError, RefusedImage
from rumu.gallery.add_work import OWN_WORKS, store_suffix
from rumu.gallery.assets import decode_picture, picture_key
from rumu.gallery.metadata import (
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_rows,
    insert_works,
    next_position,
    work_digest,
    work_row,
)
from rumu.gallery.store import Gallery
from rumu.gallery.tile_maps import SLOW, make_large_tiles
from rumu.gallery.whole_works import INHERITED, occurrences, title_within
from rumu.values import Bilingual

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

    from rumu.pages.page import Page, PageCharacter

MAX_TEXT = 20_000  # characters of a page's text
_MARGIN = 0.06  # around a character that is cut out, as a share of its longer side
_LEAST_SIDE = 32  # pixels of a character's picture: 一 is cut with what is above and below it
_PACKING = 3  # zlib's level: files are 4 % larger than by its own choice, packed in half the time
_THREADS = 4  # pack and store pictures; both release the interpreter's lock


@dataclass(frozen=True, slots=True)
class AddedPage:
    """A page that was added. new: False when it was there before, with its characters.

    characters: how many works it has within it; named: how many of those have a name.
    """

    id: str
    new: bool
    characters: int
    named: int


@dataclass(frozen=True, eq=False)
class _ReadPage:
    """A page as it is stored. data: its file; None where its flat picture becomes one."""

    page: Page
    data: bytes | None
    suffix: str

    @cached_property
    def whole(self) -> Picture:
        """The picture that is stored."""
        from PIL import Image

        return Image.fromarray(self.page.picture) if self.data is None else decode_picture(self.data)

    def file(self) -> bytes:
        """The file that is stored."""
        return _png(self.whole) if self.data is None else self.data


def add_page(
    gallery: Gallery,
    path: str | Path,
    *,
    text: str,
    metadata: WorkMetadata,
    collection: CollectionMetadata = OWN_WORKS,
    spacing: float | None = None,
    position: int | None = None,
) -> AddedPage:
    """Add a page, and each character on it as a work within it.

    text: what is written on it, in reading order; see `rumu.read_page`. spacing: millimetres per pixel, None
    if unknown. position: in its collection; the last by default.
    A picture that is there already is cut only where it has no characters yet. Raises ImageError for a file
    that is no picture, RefusedImage where nothing on it is writing, GalleryError for a text that is empty or
    too long.
    """
    path, text = Path(path), check_text(text)
    original = path.read_bytes()
    metadata = replace(metadata, character="", origin=metadata.origin or path.name)
    digest = metadata.digest(original)
    there = _existing(gallery, digest)
    if there is not None and there.characters:
        return there
    read = _read(path, original, text)
    key, cut = _store_pictures(gallery, read)
    width, height = read.whole.size
    files = StoredFiles(picture=key, digest=digest, width=width, height=height, spacing=spacing)
    with gallery.database.writing() as session:
        row = _insert_page(session, metadata, files, text, collection=collection, position=position)
        title = session.get_one(Collection, row["collection_id"]).title
        home = replace(collection, id=row["collection_id"], title=title)
        rows = list(_character_rows(row, read, cut, home))
        insert_rows(session, Work, rows)
    make_large_tiles(gallery, row["id"], maps_above=SLOW)
    named = sum(row["character"] != "" for row in rows)
    return AddedPage(row["id"], there is None, len(rows), named)


def check_text(text: str) -> str:
    """The text of a page without what surrounds it. Raises GalleryError when it is empty or too long."""
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\ufeff", "").strip()
    if not text:
        raise GalleryError("expected the text of the page, got none", zh="沒有這一頁的釋文。")
    if len(text) > MAX_TEXT:
        raise GalleryError(
            f"expected a text of at most {MAX_TEXT} characters, got {len(text)}",
            zh=f"釋文最多 {MAX_TEXT} 字，這裡有 {len(text)} 字。",
        )
    return text


def _existing(gallery: Gallery, digest: str) -> AddedPage | None:
    with gallery.database.reading() as session:
        work_id = session.scalar(select(Work.id).where(Work.digest == digest))
        if work_id is None:
            return None
        with_name = func.count(case((Work.character != "", 1)))
        count, named = session.execute(select(func.count(), with_name).where(Work.parent_id == work_id)).one()
    return AddedPage(work_id, False, count, named)


def _read(path: Path, original: bytes, text: str) -> _ReadPage:
    """Read a page; where it lies flat its file is kept, else the flat picture becomes one."""
    from rumu.capture.formats import decode
    from rumu.capture.image import colours_of
    from rumu.pages.reading import READ_SIZE, find_characters

    stored = decode(path, reduction=READ_SIZE)
    samples = colours_of(stored, name=path)
    page = find_characters(samples, text=text)
    if not page.characters:
        raise RefusedImage(
            "expected a page with writing, found no characters on it",
            reason="blank",
            name=path.name,
            zh="這張圖上找不到字。",
        )
    if page.picture.shape == samples.shape and np.array_equal(page.picture, samples):
        return _ReadPage(page, original, store_suffix(path))
    return _ReadPage(page, None, ".png")


def _store_pictures(gallery: Gallery, read: _ReadPage) -> tuple[str, list[tuple[str, str, tuple[int, int]]]]:
    """The key of the page's picture, and of each character's in reading order, its digest and its size."""

    def store_page() -> str:
        data = read.file()
        key = picture_key(data, suffix=read.suffix)
        gallery.store.write(key, data)
        return key

    def store(one: PageCharacter) -> tuple[str, str, tuple[int, int]]:
        part = _cut(whole, one, read)
        data = _png(part)
        key = picture_key(data, suffix=".png")
        gallery.store.write(key, data)
        return key, hashlib.sha256(data).hexdigest(), part.size

    whole = read.whole  # made before the threads ask for it
    with ThreadPoolExecutor(_THREADS) as threads:
        page = threads.submit(store_page)
        cut = list(threads.map(store, read.page.characters))
        return page.result(), cut


def _png(picture: Picture) -> bytes:
    """A picture as a PNG."""
    packed = io.BytesIO()
    picture.save(packed, "PNG", compress_level=_PACKING)
    return packed.getvalue()


def _cut(whole: Picture, one: PageCharacter, read: _ReadPage) -> Picture:
    """The part of the page around a character, with a margin."""
    scale = np.array(whole.size) / read.page.picture.shape[1::-1]
    left, top, right, bottom = np.array(one.box) * np.tile(scale, 2)
    size = np.array(whole.size)
    margin = _MARGIN * max(right - left, bottom - top)
    middle = np.array([left + right, top + bottom]) / 2
    sides = np.maximum([right - left + 2 * margin, bottom - top + 2 * margin], np.minimum(_LEAST_SIDE, size))
    first = np.clip((middle - sides / 2).round(), 0, np.maximum(size - sides.round(), 0)).astype(int)
    last = np.clip(first + sides.round().astype(int), first + 1, size)
    return whole.crop((*first.tolist(), *last.tolist()))


def _insert_page(
    session: Session,
    metadata: WorkMetadata,
    files: StoredFiles,
    text: str,
    *,
    collection: CollectionMetadata,
    position: int | None,
) -> Mapping[str, Any]:
    """The row of the page: a new one, or the one that was there without characters, with its text."""
    insert_works(session, collection, [])
    existing = session.scalar(select(Work).where(Work.digest == files.digest))
    if existing is not None:
        existing.text, existing.picture = text, files.picture
        existing.width, existing.height = files.width, files.height
        session.flush()
        return {column.name: getattr(existing, column.name) for column in Work.__table__.columns}
    if position is None:
        position = next_position(session, collection.id)
    row = work_row(metadata, files, collection=collection, position=position, text=text)
    insert_works(session, collection, [row])
    return row


def _character_rows(
    parent: Mapping[str, Any],
    read: _ReadPage,
    cut: list[tuple[str, str, tuple[int, int]]],
    collection: CollectionMetadata,
) -> Iterator[dict[str, Any]]:
    found = read.page.characters
    numbers = occurrences(one.character or "" for one in found)
    title = Bilingual(parent["title_zh"], parent["title_en"])
    for position, (one, (key, content, size)) in enumerate(zip(found, cut, strict=True)):
        character = one.character or ""
        files = StoredFiles(
            picture=key,
            digest=work_digest(content, "within", parent["digest"], str(position)),
            width=size[0],
            height=size[1],
            height_source=parent["height_source"],
            spacing=parent["spacing"],
        )
        metadata = WorkMetadata(
            title=title_within(title, character), character=character, origin=parent["origin"]
        )
        yield work_row(
            metadata,
            files,
            collection=collection,
            position=position,
            work_id=f"{parent['id'][:58]}-{position + 1:04d}",
            parent_id=parent["id"],
            occurrence=numbers[position],
            place=_place(one, read.page),
            **{name: parent[name] for name in INHERITED if name != "spacing"},
        )


def _place(one: PageCharacter, page: Page) -> dict[str, Any]:
    height, width = page.picture.shape[:2]
    polygon = np.clip(one.polygon / [width, height], 0, 1).round(5)
    return {
        "polygon": polygon.tolist(),
        "register": one.register,
        "column": one.column,
        "row": one.row,
        "small": one.small,
        "certainty": round(float(one.certainty), 3),
        "direction": page.direction,
    }
