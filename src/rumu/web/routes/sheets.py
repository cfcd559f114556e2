"""Routes of photographs of practice sheets: they come back as marks, each cell an attempt."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import PurePosixPath
from typing import Annotated, Any, BinaryIO, Literal

from anyio.to_thread import run_sync
from fastapi import APIRouter, File, Path, Response, UploadFile

from rumu.database.tables import SchoolClass, new_id
from rumu.studio import classes, sheet_uploads, worker_tasks
from rumu.studio.attempts import MarkedCopy
from rumu.studio.class_sheets import MAX_PHOTOS
from rumu.studio.job_handlers import upload_folder
from rumu.studio.people import Identity
from rumu.studio.pictures import check_picture
from rumu.studio.sheet_cells import MAX_BYTES, MAX_PIXELS, ReadSheet
from rumu.studio.sheet_marks import by_character
from rumu.studio.sheet_uploads import UploadDetails
from rumu.web.dependencies import CurrentUser, Limit, Offset, PathId, QueryId, ServiceDep, TeacherUser
from rumu.web.responses import download_response
from rumu.web.service import Service
from rumu.web.sheet_schemas import SheetUploadPage, SheetUploadRead
from rumu.web.studio_schemas import JobStarted

router = APIRouter(tags=["sheets"])

FileName = Literal["marks.csv", "teacher.pdf", "marks.zip"]
_MEDIA_TYPES: dict[str, str] = {
    "marks.csv": "text/csv; charset=utf-8",
    "teacher.pdf": "application/pdf",
    "marks.zip": "application/zip",
}


@router.post("/api/sheets", response_model=SheetUploadRead, status_code=201)
async def add_sheet(
    service: ServiceDep,
    user: CurrentUser,
    picture: Annotated[UploadFile, File(description="Photograph of one sheet, 30 MB and 64 MP at most.")],
) -> UploadDetails:
    """Mark all cells of a photographed sheet, and keep them in the practice of whoever sends it.

    Whom its code names is told, and changes nothing: it writes into nobody else's practice. Refused are
    photographs without a sheet (`no_sheet`), with two (`two_sheets`), of a part (`cut_off`), those that are
    `dark` or `blurred`, and those whose code cannot be read (`unreadable`).
    """
    service.rate_limiter.hit(service.settings.rate_limits.photos, "photos", user.id)
    name = picture.filename or ""
    return await run_sync(_add_sheet, service, user, picture.file, name, limiter=service.marking_limiter)


@router.get("/api/sheets", response_model=SheetUploadPage)
def list_sheets(
    service: ServiceDep,
    user: CurrentUser,
    school_class: QueryId = None,
    offset: Offset = 0,
    limit: Limit = 30,
) -> dict[str, Any]:
    """The sheets that the user sent, or those of a class, newest first."""
    with service.gallery.database.reading() as session:
        items, total = sheet_uploads.list_uploads(
            session, user, class_id=school_class, offset=offset, limit=limit
        )
    return {"total": total, "items": items}


@router.get("/api/sheets/{upload_id}", response_model=SheetUploadRead)
def get_sheet(service: ServiceDep, user: CurrentUser, upload_id: PathId) -> UploadDetails:
    """One upload: its photographs, and in each the cells with writing."""
    with service.gallery.database.reading() as session:
        row = sheet_uploads.find_upload(session, upload_id, user=user)
        return sheet_uploads.upload_details(session, row, user=user)


@router.delete("/api/sheets/{upload_id}", status_code=204)
def delete_sheet(service: ServiceDep, user: CurrentUser, upload_id: PathId) -> None:
    """Forget an upload with its tables and PDFs; the copies stay. Its sender may, and an owner."""
    sheet_uploads.delete_upload(service.gallery, upload_id, user=user)


@router.get("/api/sheets/{upload_id}/{name}", response_class=Response)
def get_sheet_file(service: ServiceDep, user: CurrentUser, upload_id: PathId, name: FileName) -> Response:
    """A class's marks as `rumu page` writes them: a table, the teacher's PDF, or all files as a zip."""
    data = sheet_uploads.read_file(service.gallery, upload_id, name, user=user)
    return download_response(data, media_type=_MEDIA_TYPES[name], filename=name)


@router.get("/api/sheets/{upload_id}/cells/{photo}/{row}/{column}", response_class=Response)
def get_sheet_cell(
    *,
    service: ServiceDep,
    user: CurrentUser,
    upload_id: PathId,
    photo: Annotated[int, Path(ge=0, le=MAX_PHOTOS)],
    row: Annotated[int, Path(ge=0, le=99)],
    column: Annotated[int, Path(ge=0, le=99)],
) -> Response:
    """What was written in a cell that belongs to no account."""
    data = sheet_uploads.read_cell(service.gallery, upload_id, (photo, row, column), user=user)
    return Response(data, media_type="image/png")


@router.post("/api/classes/{class_id}/sheets", response_model=JobStarted, status_code=202)
def add_class_sheets(
    service: ServiceDep,
    user: TeacherUser,
    class_id: PathId,
    photos: Annotated[
        list[UploadFile], File(max_length=MAX_PHOTOS, description="Photographs, zips, PDFs; 1 GB at most.")
    ],
) -> dict[str, Any]:
    """Mark the sheets of a class in the background; `upload` of the job's result is their id.

    Cells are kept in the practice of the pupil of the class whom the sheet's code names, and for a task of
    the class if it has that master; sheets that name nobody of the class are marked, and kept for nobody.
    """
    service.rate_limiter.hit(service.settings.rate_limits.uploads, "uploads", user.id)
    with service.gallery.database.reading() as session:
        classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
    job_id = new_id()
    folder = upload_folder(job_id)
    names = [PurePosixPath(photo.filename or "").name[:200] or f"{k + 1}" for k, photo in enumerate(photos)]
    payload = {"upload": folder, "names": names, "sheet_upload": new_id(), "class_id": class_id}
    payload |= {"person": user.id}
    store = service.gallery.store
    with store.whole_folder(folder):
        for k, photo in enumerate(photos):
            store.write(f"{folder}/{k:04d}", photo.file)
        return {"job": service.start_job("sheets", payload, person_id=user.id, job_id=job_id)}


def _add_sheet(service: Service, user: Identity, picture: BinaryIO, name: str) -> UploadDetails:
    data = picture.read(MAX_BYTES + 1)
    check_picture(data, max_bytes=MAX_BYTES, max_pixels=MAX_PIXELS)  # before a worker is occupied
    read = service.workers.call(worker_tasks.read_sheet, data=data)
    copies = _mark_cells(service, read)
    kept = sheet_uploads.keep_sheet(service.gallery, read, copies, person_id=user.id, photo=name[:200])
    upload_id = sheet_uploads.add_upload(service.gallery, [kept], person_id=user.id)
    return get_sheet(service, user, upload_id)


def _mark_cells(service: Service, read: ReadSheet) -> list[MarkedCopy]:
    """The cells of a sheet as marked copies, in their order; all workers share the work."""
    processes = service.workers.processes
    groups = by_character([cell.character for cell in read.cells], processes=processes)

    def mark(group: list[int]) -> Iterator[tuple[int, MarkedCopy]]:
        copies = service.workers.call(
            worker_tasks.mark_sheet_cells,
            masters=read.facts["master"],
            character=read.cells[group[0]].character,
            pictures=[read.cells[k].picture for k in group],
        )
        return zip(group, copies, strict=True)

    if not groups:
        return []
    with ThreadPoolExecutor(min(processes, len(groups))) as threads:
        marked = dict(pair for pairs in threads.map(mark, groups) for pair in pairs)
    return [marked[k] for k in range(len(read.cells))]
