"""Uploaded works: one picture at once; a zip of many, or of photographs under lamps, as a job."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rumu.gallery.add_work import add_capture, add_picture, named_collection
from rumu.gallery.archive import MANIFEST
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import collections
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.masters import LABELS
from rumu.gallery.metadata import NO_LICENCE, CollectionMetadata, WorkMetadata
from rumu.gallery.store import Gallery
from rumu.studio.errors import Unusable
from rumu.studio.job_queue import Progress
from rumu.studio.pictures import format_of
from rumu.studio.unpacking import unpack
from rumu.values import Bilingual

TEXTS = ("title", "hand", "period", "material")
WORDS = ("character", "script", "dynasty", "source", "licence", "attribution")
_MAX_LISTED = 20  # skipped pictures that are listed one by one


def metadata_of(facts: Mapping[str, str]) -> WorkMetadata:
    """Return the metadata of uploaded facts: title_zh, title_en, hand_zh, ... and WORDS.

    Where one language is empty the other stands for both.
    """
    texts: dict[str, Any] = {}
    for name in TEXTS:
        zh, en = facts.get(f"{name}_zh", ""), facts.get(f"{name}_en", "")
        texts[name] = Bilingual(zh or en, en or zh)
    words: dict[str, Any] = {name: facts.get(name, "") for name in WORDS}
    words["licence"] = words["licence"] or NO_LICENCE
    if not texts["title"].zh:
        texts["title"] = Bilingual(words["character"] or "無題", words["character"] or "Untitled")
    return WorkMetadata(**texts, **words)


def add_work(gallery: Gallery, data: bytes, facts: Mapping[str, str], *, spacing: float | None) -> str:
    """Add a picture as a work and return its id.

    Raises Unusable, ImageError or RefusedImage when it is no writing.
    """
    method = facts.get("method") or "inflation"
    with tempfile.TemporaryDirectory(prefix="rumu-") as folder:
        path = Path(folder) / f"picture.{format_of(data)}"
        path.write_bytes(data)
        collection = find_or_name_collection(gallery, facts.get("collection", ""))
        return add_picture(
            gallery, path, metadata=metadata_of(facts), collection=collection, method=method, spacing=spacing
        ).id


def find_or_name_collection(gallery: Gallery, name: str) -> CollectionMetadata:
    """Return the collection of this id or title, a new one if there is none, the default one for no name."""
    for row, _ in collections(gallery):
        if name and name in (row.id, row.title_zh, row.title_en):
            return CollectionMetadata(id=row.id, title=Bilingual(row.title_zh, row.title_en))
    return named_collection(name or None)


def import_zip(
    gallery: Gallery, packed: Path, facts: Mapping[str, str], *, name: str = "collection", progress: Progress
) -> dict[str, Any]:
    """Import a zip: a folder with labels.csv, an export of `rumu gallery export`, or one capture.

    facts: the collection that its works go into, and the metadata of a capture. name: of the collection when
    nothing else names one, fit for a folder. Works that exist already are counted and left unchanged, so that
    an import can be repeated.
    """
    with tempfile.TemporaryDirectory(prefix="rumu-") as temporary:
        progress(0, 0, "解開 Unpacking")
        folder = unpack(packed, Path(temporary) / name)
        if (folder / LABELS).is_file() or (folder / MANIFEST).is_file():
            progress(0, 0, "收入 Putting in")
            done = import_folder(gallery, folder, shared=_shared_metadata(gallery, facts), progress=progress)
            return {
                "collections": list(done.collections),
                "added": done.added,
                "there": done.existing,
                "left_out": [list(one) for one in done.left_out[:_MAX_LISTED]],
                "left_out_count": len(done.left_out),
            }
        if not any(path.is_file() for path in folder.iterdir()):
            raise Unusable("no_works", zh="zip 檔是空的。", en="The zip file is empty.")
        progress(0, 0, "重建表面 Reconstructing")
        collection = find_or_name_collection(gallery, facts.get("collection", ""))
        added = add_capture(gallery, folder, metadata=metadata_of(facts), collection=collection)
        return {"work": added.id, "added": int(added.new), "there": int(not added.new)}


def _shared_metadata(gallery: Gallery, facts: Mapping[str, str]) -> SharedMetadata | None:
    if not facts.get("collection"):
        return None
    collection = find_or_name_collection(gallery, facts["collection"])
    return SharedMetadata({"id": collection.id}, {"title": collection.title})
