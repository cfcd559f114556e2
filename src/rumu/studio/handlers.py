"""What each kind of job does: (gallery, payload, progress, place) -> result. Each can be begun again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rumu.gallery import catalog
from rumu.gallery.derived import derived
from rumu.gallery.gallery import Gallery
from rumu.studio.additions import import_zip
from rumu.studio.jobs import Progress
from rumu.studio.place import Place
from rumu.studio.samples import put_samples

Handler = Callable[[Gallery, Mapping[str, Any], Progress, Place], dict[str, Any]]

THUMBS = ("thumb", "thumb-normals")
_SHOWN = ("picture", "albedo", "normals", "heights", "mask", "facts")
_WARMED = 200  # works whose maps are made ahead; further ones are made when they are asked for


def upload_key(job_id: str, ending: str) -> str:
    """Where what was sent for a job lies until it is done."""
    return f"uploads/{job_id}/sent{ending}"


def clear(gallery: Gallery, job_id: str) -> None:
    """Forget what was sent for a job that has ended."""
    gallery.store.delete(f"uploads/{job_id}")


def make_thumbnails(gallery: Gallery, advance: Callable[[int, int], object]) -> list[str]:
    """Of the first works, where they are not there yet; the works' ids."""
    ids = [work.id for work in catalog.works(gallery, limit=_WARMED).items]
    for done, work_id in enumerate(ids, start=1):
        for kind in THUMBS:
            derived(gallery, work_id, kind)
        advance(done, len(ids))
    return ids


def prepare(gallery: Gallery, payload: Mapping[str, Any], progress: Progress, place: Place) -> dict[str, Any]:
    """On the first start: thumbnails of every work, the maps of the first ones, the simulated samples."""
    ids = make_thumbnails(gallery, lambda done, total: progress(done, 2 * total, "縮圖 Thumbnails"))
    samples = put_samples(gallery, place=place, advance=lambda done, total: None)
    for done, work_id in enumerate(ids):
        progress(len(ids) + done, 2 * len(ids), "圖層 Maps")
        for kind in _SHOWN:
            derived(gallery, work_id, kind)
    return {"works": len(ids), "samples": samples}


def import_sent(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, place: Place
) -> dict[str, Any]:
    """Put in the zip that was sent; payload: upload (its key), facts, name (that of the zip)."""
    with gallery.store.local(payload["upload"]) as packed:
        return import_zip(
            gallery, packed, payload["facts"], name=payload.get("name", "collection"), progress=progress
        )


HANDLERS: dict[str, Handler] = {"prepare": prepare, "import": import_sent}
