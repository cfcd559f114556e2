"""What each kind of job does: (gallery, payload, progress, storage) -> result. Each can be run again."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Attempt, Job, Person, Work, now
from rumu.errors import DatabaseBusy, RumuError
from rumu.gallery import catalog
from rumu.gallery.assets import assets_of
from rumu.gallery.cover import cover_work
from rumu.gallery.derived import derived_file
from rumu.gallery.starter import Sample, starter_samples
from rumu.gallery.store import Gallery
from rumu.studio.attempts import add_attempt
from rumu.studio.job_queue import CancelledError, Progress, failure_values, update_running
from rumu.studio.storage import Storage
from rumu.studio.uploads import add_page_upload, import_from_museum, import_zip

Handler = Callable[[Gallery, Mapping[str, Any], Progress, Storage], dict[str, Any]]

THUMBNAILS = ("thumb", "thumb-normals")
_OF_COVER = ("cover", "cover-normals")
_MAPS = ("picture", "albedo", "normals", "heights", "mask", "facts")
_PREPARED_WORKS = 200  # works whose maps are made ahead; those of further ones are made on request
_log = logging.getLogger(__name__)


def run_job(gallery: Gallery, job_id: str, *, storage: Storage) -> None:
    """Run a job that was taken and record how it ended. Raises nothing that a handler raises."""
    database = gallery.database
    with database.reading() as session:
        job = session.get(Job, job_id)
    if job is None:
        return
    try:
        result = HANDLERS[job.kind](gallery, job.payload, Progress(database, job_id), storage)
    except DatabaseBusy:
        raise  # the runner has it run again
    except CancelledError:
        values: dict[str, Any] = {"state": "cancelled"}
    except Exception as error:  # a job that fails must not take the queue with it
        if not isinstance(error, RumuError):
            _log.exception("job %s of kind %s failed", job_id, job.kind)
        values = failure_values(error)
    else:
        values = {"state": "done", "result": result, "done": Job.total}
    update_running(database, job_id, values | {"changed": now()})
    gallery.store.delete(upload_folder(job_id))


def upload_key(job_id: str, ending: str) -> str:
    """Return the key under which a job's upload is stored until the job ends."""
    return f"{upload_folder(job_id)}/sent{ending}"


def upload_folder(job_id: str) -> str:
    """Return the key of the folder of a job's upload."""
    return f"uploads/{job_id}"


def make_first_files(gallery: Gallery, advance: Callable[[int, int], object]) -> list[str]:
    """Make what the first pages show and is missing, and return the ids of the first works.

    The home page's files come first, then the thumbnails of the first works.
    """
    shown, _ = cover_work(gallery)
    if shown is not None:
        for kind in _OF_COVER:
            derived_file(gallery, shown.id, kind)
    ids = [work.id for work in catalog.works(gallery, limit=_PREPARED_WORKS).items]
    for done, work_id in enumerate(ids, start=1):
        for kind in THUMBNAILS:
            derived_file(gallery, work_id, kind)
        advance(done, len(ids))
    return ids


def prepare(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, storage: Storage
) -> dict[str, Any]:
    """Make what the first pages show and the simulated samples, at the first start.

    The first pages' files come first, then the maps of the work on the home page, the samples, and all maps.
    """
    ids = make_first_files(gallery, lambda done, total: progress(done, 2 * total, "縮圖 Thumbnails"))
    shown, _ = cover_work(gallery)
    if shown is not None:
        for kind in _MAPS:
            derived_file(gallery, shown.id, kind)
    samples = add_samples(gallery, storage=storage)
    for done, work_id in enumerate(ids):
        progress(len(ids) + done, 2 * len(ids), "圖層 Maps")
        for kind in _MAPS:
            derived_file(gallery, work_id, kind)
    return {"works": len(ids), "samples": samples}


def import_upload(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, storage: Storage
) -> dict[str, Any]:
    """Import an uploaded zip; payload: upload (its key), facts, name (that of the zip), person (their id)."""
    with gallery.database.reading() as session:
        person = session.get(Person, payload.get("person", ""))
    owner = person is not None and person.active and person.role == "owner"
    with gallery.store.local(payload["upload"]) as packed:
        return import_zip(
            gallery,
            packed,
            payload["facts"],
            name=payload.get("name", "collection"),
            owner=owner,
            progress=progress,
        )


def add_page(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, storage: Storage
) -> dict[str, Any]:
    """Add an uploaded page with its characters; payload: upload (its key), facts, text, spacing."""
    progress(0, 0, "讀字 Reading the page")
    with gallery.store.local(payload["upload"]) as picture:
        return add_page_upload(
            gallery, picture, payload["facts"], text=payload["text"], spacing=payload["spacing"]
        )


def import_museum(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, storage: Storage
) -> dict[str, Any]:
    """Import a museum's manifest; payload: url, collection (its name, '' for that of the museum)."""
    progress(0, 0, "讀取清單 Reading the manifest")
    return import_from_museum(gallery, payload["url"], payload.get("collection", ""), progress)


def mark_sheets(
    gallery: Gallery, payload: Mapping[str, Any], progress: Progress, storage: Storage
) -> dict[str, Any]:
    """Mark the sheets of a class.

    payload: upload (key of their folder), names (of its files, for people), sheet_upload, class_id, person.
    """
    from rumu.studio.class_sheets import ClassSheets, mark_class_sheets
    from rumu.studio.marking import load_calibration_of

    sheets = ClassSheets(payload["sheet_upload"], payload["class_id"], payload["person"])
    with gallery.store.local(payload["upload"]) as folder:
        return mark_class_sheets(
            gallery,
            sorted(folder.iterdir()),
            payload["names"],
            sheets,
            calibration=load_calibration_of(storage),
            progress=progress,
        )


HANDLERS: dict[str, Handler] = {
    "prepare": prepare,
    "import": import_upload,
    "page": add_page,
    "museum": import_museum,
    "sheets": mark_sheets,
}


def missing_samples(gallery: Gallery) -> list[tuple[Sample, Work]]:
    """Return the simulated samples that are not attempts yet and whose work is in the gallery."""
    with gallery.database.reading() as session:
        present = set(session.scalars(select(Attempt.id).where(Attempt.kind == "simulated")))
        works = {work.id: work for work in session.scalars(select(Work))}
    return [
        (sample, works[sample.work])
        for sample in starter_samples()
        if f"simulated-{sample.id}" not in present and sample.work in works
    ]


def add_samples(gallery: Gallery, *, storage: Storage) -> int:
    """Mark the simulated samples that are missing and store them as attempts, labelled as simulated.

    Returns how many were missing; a second call changes nothing.
    """
    from rumu import pipeline
    from rumu.studio.marking import load_calibration_of, mark_copy

    missing = missing_samples(gallery)
    calibration = load_calibration_of(storage)
    for sample, work in missing:
        surface = assets_of(gallery.store, work).surface()
        master = pipeline.prepare_master(surface, character=work.character, script=work.script)
        copy = mark_copy(
            sample.path.read_bytes(),
            master,
            script=work.script,
            calibration=calibration,
            framed=True,  # as large as its master's picture
        )
        add_attempt(
            gallery,
            copy,
            work_id=work.id,
            person_id=None,
            kind="simulated",
            attempt_id=f"simulated-{sample.id}",
        )
    return len(missing)
