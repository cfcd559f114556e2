"""Routes that add works: one picture, or a zip of many."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, File, Form, UploadFile
from pydantic import Field, StringConstraints

from rumu.database.tables import new_id
from rumu.gallery.add_page import MAX_TEXT, check_text
from rumu.studio import worker_tasks
from rumu.studio.job_handlers import upload_folder, upload_key
from rumu.studio.pictures import format_of
from rumu.studio.unpacking import HEAD, check_zip, folder_name
from rumu.studio.uploads import check_capture
from rumu.web.dependencies import CleanText, OwnerUser, ServiceDep, ShortText, TeacherUser
from rumu.web.routes.works import get_work
from rumu.web.schemas import Extended, Schema, ScriptName, Spacing, WorkRead
from rumu.web.studio_schemas import JobStarted

router = APIRouter(tags=["imports"])

FormText = Annotated[ShortText, Form()]
LongFormText = Annotated[CleanText, Form(max_length=4000)]


def work_facts(
    *,
    title_zh: FormText = "",
    title_en: FormText = "",
    character: Annotated[ShortText, Form(max_length=16)] = "",
    script: Annotated[ScriptName, Form()] = "",
    hand_zh: FormText = "",
    hand_en: FormText = "",
    dynasty: Annotated[ShortText, Form(max_length=40)] = "",
    period_zh: FormText = "",
    period_en: FormText = "",
    material_zh: FormText = "",
    material_en: FormText = "",
    source: LongFormText = "",
    licence: FormText = "",
    attribution: LongFormText = "",
    collection: Annotated[ShortText, Form(max_length=100)] = "",
    method: Annotated[Literal["inflation", "density"], Form()] = "inflation",
    lamps: Annotated[Literal["auto", "card"], Form()] = "auto",
) -> dict[str, str]:
    """What is known of the works in an upload.

    collection: its name; empty for works that are added here, and for a zip that names its own. lamps: of a
    capture: 'card' where the printed card in its photographs tells them, 'auto' to find out what does.
    """
    return dict(locals())


WorkFacts = Annotated[dict[str, str], Depends(work_facts)]


@router.post("/api/works", response_model=WorkRead, status_code=201)
def add_work(
    service: ServiceDep,
    user: TeacherUser,
    facts: WorkFacts,
    picture: Annotated[UploadFile, File(description="JPEG, PNG, TIFF, WebP, HEIC, AVIF, EXR, ...")],
    spacing: Annotated[Spacing | None, Form()] = None,
) -> Extended:
    """Add one picture as a work. spacing: millimetres for each pixel, when known."""
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    data = picture.file.read()
    format_of(data)
    work_id = service.workers.call(worker_tasks.add_work, data=data, facts=facts, spacing=spacing)
    return get_work(service, work_id)


@router.post("/api/pages", response_model=JobStarted, status_code=202)
def add_page(
    *,
    service: ServiceDep,
    user: TeacherUser,
    facts: WorkFacts,
    picture: Annotated[UploadFile, File(description="A page or scroll: JPEG, PNG, TIFF, WebP, HEIC, ...")],
    text: Annotated[CleanText, Form(min_length=1, max_length=MAX_TEXT)],
    spacing: Annotated[Spacing | None, Form()] = None,
) -> dict[str, Any]:
    """Add a page or scroll with its text: the whole as a work, and each character on it as a work within it.

    text: what is written on it, in reading order. The page is read as a job.
    """
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    ending = format_of(picture.file.read())
    check_text(text)
    picture.file.seek(0)
    job_id = new_id()
    key = upload_key(job_id, f".{ending}")
    payload = {"upload": key, "facts": facts, "text": text, "spacing": spacing, "person": user.id}
    with service.gallery.store.whole_folder(upload_folder(job_id)):
        service.gallery.store.write(key, picture.file)
        return {"job": service.start_job("page", payload, person_id=user.id, job_id=job_id)}


class MuseumImportCreate(Schema):
    """url: of a IIIF manifest or collection. collection: where its works go; '' for one of its own."""

    url: Annotated[CleanText, StringConstraints(max_length=2000, pattern=r"^https?://")] = Field(
        examples=["https://example.org/manifest.json"]
    )
    collection: Annotated[ShortText, Field(max_length=100)] = ""


@router.post("/api/museums", response_model=JobStarted, status_code=202)
def import_museum(service: ServiceDep, user: OwnerUser, wanted: MuseumImportCreate) -> dict[str, Any]:
    """Import the works of a museum from the address of a IIIF manifest or collection, as a job.

    Each canvas becomes a work, with what the museum says of it. Only public machines are asked. One that
    ended early goes on when it is sent again.
    """
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    return {"job": service.start_job("museum", wanted.model_dump(), person_id=user.id)}


@router.post("/api/imports", response_model=JobStarted, status_code=202)
def import_zip(
    service: ServiceDep,
    user: TeacherUser,
    facts: WorkFacts,
    archive: Annotated[UploadFile, File(alias="zip", description="A zip, 1 GB at most.")],
) -> dict[str, Any]:
    """Import a zip: a folder with labels.csv, pages with texts, an export of `rumu`, or a capture.

    collection: where the works go, by its name; else where collection.json, the export or the name of the zip
    say. The other facts are those of a capture. The zip is stored before the response, so that a restart
    loses nothing. A capture whose lamps do not match the names of its photographs is refused at once.
    """
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    check_zip(archive.file.read(HEAD))
    archive.file.seek(0)
    job_id = new_id()
    key = upload_key(job_id, ".zip")
    name = folder_name(archive.filename or "")
    payload = {"upload": key, "facts": facts, "name": name, "person": user.id}
    store = service.gallery.store
    with store.whole_folder(upload_folder(job_id)):
        store.write(key, archive.file)
        with store.local(key) as packed:
            check_capture(packed)
        return {"job": service.start_job("import", payload, person_id=user.id, job_id=job_id)}
