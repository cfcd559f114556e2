"""Works that teachers and owners send in."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, File, Form, UploadFile

from rumu.database.tables import new_id
from rumu.studio import jobs, worker
from rumu.studio.errors import Unusable
from rumu.studio.handlers import upload_key
from rumu.studio.pictures import format_of
from rumu.studio.unpacking import folder_name
from rumu.web.cards import job_facts
from rumu.web.dependencies import CleanText, ServiceDep, ShortText, TeacherUser
from rumu.web.routes.works import found_work, told
from rumu.web.schemas import WorkRead
from rumu.web.studio_schemas import JobStarted

router = APIRouter(tags=["imports"])

Word = Annotated[ShortText, Form()]
Long = Annotated[CleanText, Form(max_length=4000)]


def facts(
    *,
    title_zh: Word = "",
    title_en: Word = "",
    character: Annotated[ShortText, Form(max_length=16)] = "",
    script: Annotated[Literal["", "seal", "clerical", "regular", "running", "cursive"], Form()] = "",
    hand_zh: Word = "",
    hand_en: Word = "",
    dynasty: Annotated[ShortText, Form(max_length=40)] = "",
    period_zh: Word = "",
    period_en: Word = "",
    material_zh: Word = "",
    material_en: Word = "",
    source: Long = "",
    licence: Word = "",
    attribution: Long = "",
    collection: Annotated[ShortText, Form(max_length=100)] = "",
    method: Annotated[Literal["inflation", "density"], Form()] = "inflation",
) -> dict[str, str]:
    """What is known of what is sent. collection: its name; empty for works added here, and for a
    zip that names its own."""
    return dict(locals())


Facts = Annotated[dict[str, str], Depends(facts)]
Spacing = Annotated[float | None, Form(gt=0, le=1000, allow_inf_nan=False)]


@router.post("/api/works", response_model=WorkRead, status_code=201)
def add(
    service: ServiceDep,
    user: TeacherUser,
    told_of_it: Facts,
    picture: Annotated[UploadFile, File(description="PNG, JPEG, TIFF or WebP.")],
    spacing: Spacing = None,
) -> dict[str, Any]:
    """Add one picture as a work. spacing: millimetres for each pixel, when known."""
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    data = picture.file.read()
    format_of(data)
    work_id = service.workers.ask(worker.add_work, data=data, facts=told_of_it, spacing=spacing)
    return told(service, found_work(service, work_id))


@router.post("/api/imports", response_model=JobStarted, status_code=202)
def send(
    service: ServiceDep,
    user: TeacherUser,
    told_of_it: Facts,
    archive: Annotated[UploadFile, File(alias="zip", description="A zip, 1 GB at most.")],
) -> dict[str, Any]:
    """Put in a zip of a folder with labels.csv, of one that `rumu gallery export` wrote, or of one capture
    folder. collection: where the works go, by its name; else where collection.json, the export or the name
    of the zip say. The other facts are those of a capture. It is kept before it is answered for: a restart
    loses nothing."""
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    if archive.file.read(2) != b"PK":
        raise Unusable("no_zip", zh="這不是 zip 檔。", en="Expected a zip file.")
    archive.file.seek(0)
    job_id = new_id()
    key = upload_key(job_id, ".zip")
    service.gallery.store.write(key, archive.file)
    payload = {"upload": key, "facts": told_of_it, "name": folder_name(archive.filename or "")}
    with service.gallery.database.writing() as session:
        job = jobs.add(session, "import", payload, person_id=user.id, job_id=job_id)
        started = job_facts(job)
    service.runner.wake()
    return {"job": started}
