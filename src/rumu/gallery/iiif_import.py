"""Works of a museum by their IIIF manifest: each canvas becomes a work, with what the museum says of it.

A canvas is fetched, stored and entered before the next one is asked for, and one that is there already is
passed over; so an import that was ended, even by `kill -9`, goes on when it is run again, and nothing is lost
or doubled.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

from sqlalchemy import select

from rumu.database.tables import Work
from rumu.errors import GalleryError, ImageError, RumuError
from rumu.gallery.add_work import add_stored_work
from rumu.gallery.archive import ImportResult, Progress
from rumu.gallery.assets import picture_key
from rumu.gallery.iiif_pictures import MAX_PIXELS, FetchedPicture, fetch_picture
from rumu.gallery.iiif_reading import (
    CanvasPicture,
    MuseumCollection,
    MuseumManifest,
    NotAManifest,
    in_both,
    read_presentation,
)
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.metadata import CollectionMetadata, StoredFiles, WorkMetadata, slug, work_digest
from rumu.gallery.museum_web import FetchSettings, MuseumWeb, NotThere
from rumu.gallery.public_addresses import RefusedAddress, UnknownHost
from rumu.gallery.rights import licence_of
from rumu.gallery.store import Gallery
from rumu.homes import user_home
from rumu.inputs import read_file
from rumu.values import Bilingual

MOST_MANIFESTS = 1000  # of one collection and those within it
_DEEPEST = 5  # collections within collections
_MAX_FILE = 32 * 2**20  # bytes of a manifest in a file


@dataclass(frozen=True, slots=True)
class MuseumImport:
    """What is imported. canvases: with the address of the manifest that names each, and the manifest."""

    collection: CollectionMetadata
    canvases: tuple[tuple[str, MuseumManifest, CanvasPicture], ...]
    left_out: tuple[tuple[str, Bilingual], ...]


def import_manifest(
    gallery: Gallery,
    source: str | Path,
    *,
    shared: SharedMetadata | None = None,
    settings: FetchSettings | None = None,
    max_pixels: int = MAX_PIXELS,
    progress: Progress | None = None,
    web: MuseumWeb | None = None,
) -> ImportResult:
    """Import a manifest, or the manifests of a collection, of the IIIF Presentation API 2 or 3.

    source: its address, or a file. shared: metadata of all works where the museum's say nothing (script,
    hand, dynasty, material), and the id and title of the collection. settings: how the museum is asked.
    max_pixels: of one picture; a larger one comes reduced. progress: called with (done, total) after each
    canvas.
    web: what fetches; by default from the net, with what was fetched kept in RUMU_HOME.
    A canvas whose picture cannot be had is left out with the reason. Raises GalleryError for what is no
    manifest and for an address that is not public, NotNow when the server cannot be reached now.
    """
    web = web or MuseumWeb(user_home() / "museums", settings or FetchSettings())
    try:
        plan = _plan(web, source, shared or SharedMetadata())
        plan.collection.row()  # refused before a file is stored, if it is
        return _import(
            gallery, web, plan, shared=shared or SharedMetadata(), max_pixels=max_pixels, progress=progress
        )
    finally:
        web.close()


def is_web_address(text: str) -> bool:
    """Whether a text is an address of the web, and no file."""
    return text.lower().startswith(("http://", "https://"))


# --- what there is ---------------------------------------------------------------------------------


def _plan(web: MuseumWeb, source: str | Path, shared: SharedMetadata) -> MuseumImport:
    url = str(source)
    if is_web_address(url):
        data = web.json_bytes(url)
    else:
        data = read_file(Path(source), error_type=GalleryError, expected="a manifest", most=_MAX_FILE)
        url = ""
    first = read_presentation(data, url=url or str(source))
    left_out: list[tuple[str, Bilingual]] = []
    if isinstance(first, MuseumManifest):
        manifests = [(url or first.id, first)]
    else:
        manifests = list(_manifests_of(web, first, url or first.id, left_out))
    canvases = [(near, manifest, canvas) for near, manifest in manifests for canvas in manifest.canvases]
    for _, manifest in manifests:
        if manifest.without_picture:
            count = manifest.without_picture
            reason = Bilingual(f"有 {count} 頁沒有圖片。", f"{count} canvases without a picture")
            left_out.append((in_both(manifest.label).en or manifest.id, reason))
    if not canvases and not left_out:
        raise GalleryError(f"{source}: names no pictures", zh="這份清單裡沒有圖片。")
    return MuseumImport(_collection(first, shared), tuple(canvases), tuple(left_out))


def _manifests_of(
    web: MuseumWeb, collection: MuseumCollection, url: str, left_out: list[tuple[str, Bilingual]]
) -> Iterator[tuple[str, MuseumManifest]]:
    """The manifests of a collection and of those within it, each once; (address, manifest)."""
    waiting = [(urljoin(url, address), 1, url) for address in collection.members]
    seen = {url}
    count = 0
    while waiting:
        address, depth, near = waiting.pop(0)
        if address in seen:
            continue
        seen.add(address)
        try:
            found = read_presentation(web.json_bytes(address, near=near), url=address)
        except (NotThere, NotAManifest, RefusedAddress, UnknownHost) as error:
            left_out.append((address, _reason(error)))
            continue
        if isinstance(found, MuseumManifest):
            count += 1
            if count > MOST_MANIFESTS:
                left_out.append((address, Bilingual("清單太多。", f"more than {MOST_MANIFESTS} manifests")))
                return
            yield address, found
        elif depth < _DEEPEST:
            within = [(urljoin(address, member), depth + 1, address) for member in found.members]
            waiting = within + waiting


def _collection(first: MuseumManifest | MuseumCollection, shared: SharedMetadata) -> CollectionMetadata:
    """The collection of the gallery that a manifest or a collection becomes."""
    title = in_both(first.label)
    given = shared.both("title")
    name = slug(title.en, default="museum")[:31].strip("-")
    record = first.record if isinstance(first, MuseumManifest) else {}
    return CollectionMetadata(
        id=shared.text("id") or f"{name}-{hashlib.sha256(first.id.encode()).hexdigest()[:8]}",
        title=given if given.zh else Bilingual(title.zh or first.id, title.en or first.id),
        source=record.get("homepage") or first.id,
        licence=licence_of(record.get("rights", "")) or "none stated",
    )


# --- canvases --------------------------------------------------------------------------------------


def _import(
    gallery: Gallery,
    web: MuseumWeb,
    plan: MuseumImport,
    *,
    shared: SharedMetadata,
    max_pixels: int,
    progress: Progress | None,
) -> ImportResult:
    result = ImportResult((plan.collection.id,), left_out=plan.left_out)
    there = _origins(gallery, plan.collection.id)
    total = len(plan.canvases)
    for number, (near, manifest, canvas) in enumerate(plan.canvases, start=1):
        origin = _origin(manifest, canvas, number)
        if origin in there:
            result = replace(result, existing=result.existing + 1)
        else:
            try:
                picture = fetch_picture(web, canvas, near=near, max_pixels=max_pixels)
                metadata = _metadata(manifest, canvas, number, total=total, shared=shared)
                _store(
                    gallery, plan.collection, picture, replace(metadata, origin=origin), (manifest, canvas)
                )
            except (NotThere, RefusedAddress, UnknownHost, ImageError) as error:
                result = replace(result, left_out=(*result.left_out, (origin, _reason(error))))
            else:
                there.add(origin)
                result = replace(result, added=result.added + 1)
                for url in picture.urls:
                    web.forget(url, near=near)
        if progress is not None:
            progress(number, total)
    return result


def _origins(gallery: Gallery, collection_id: str) -> set[str]:
    with gallery.database.reading() as session:
        return set(session.scalars(select(Work.origin).where(Work.collection_id == collection_id)))


def _origin(manifest: MuseumManifest, canvas: CanvasPicture, number: int) -> str:
    """What a picture is known by within its collection: its canvas's id, a digest of it where it is long.

    Further pictures of a canvas have their number behind it.
    """
    name = canvas.id or f"{manifest.id}#{number}"
    name = name if canvas.number == 1 else f"{name}#{canvas.number}"
    return name if len(name) <= 500 else f"{name[:400]}#{hashlib.sha256(name.encode()).hexdigest()}"


def _reason(error: RumuError) -> Bilingual:
    text = " ".join(str(error).split())
    return Bilingual(error.zh or f"無法使用：{text}", text)


def _metadata(
    manifest: MuseumManifest, canvas: CanvasPicture, number: int, *, total: int, shared: SharedMetadata
) -> WorkMetadata:
    title, leaf = in_both(manifest.label), in_both(canvas.label)
    if total > 1 and leaf != title:
        leaf = leaf if leaf.zh else Bilingual(str(number), str(number))
        title = Bilingual(
            "　".join(filter(None, (title.zh, leaf.zh))), ", ".join(filter(None, (title.en, leaf.en)))
        )
    if canvas.number > 1:
        title = Bilingual(f"{title.zh} ({canvas.number})", f"{title.en} ({canvas.number})")
    record = manifest.record
    provider = "; ".join(in_both(one).en for one in record["provider"])
    statement = in_both(record["statement"]["value"]).en if record["statement"] else ""
    return replace(
        shared.work_metadata(title=title if title.zh else Bilingual(manifest.id, manifest.id)),
        source=record["homepage"] or record["manifest"],
        licence=licence_of(record["rights"]) or shared.text("licence") or "none stated",
        attribution="; ".join(dict.fromkeys(filter(None, (statement, provider)))),
    )


def _store(
    gallery: Gallery,
    collection: CollectionMetadata,
    picture: FetchedPicture,
    metadata: WorkMetadata,
    told: tuple[MuseumManifest, CanvasPicture],
) -> None:
    key = picture_key(picture.data, suffix=picture.suffix)
    gallery.store.write(key, picture.data)
    manifest, canvas = told
    files = StoredFiles(
        picture=key,
        # two leaves may be alike, such as empty ones: each is a work
        digest=work_digest(picture.data, "canvas", collection.id, metadata.origin),
        width=picture.width,
        height=picture.height,
    )
    record: dict[str, Any] = manifest.record | {"canvas": canvas.id, "canvas_label": canvas.label}
    add_stored_work(gallery, metadata, files, collection=collection, record=record)
