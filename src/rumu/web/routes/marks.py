"""The route that marks a copy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, BinaryIO, Literal

from anyio.to_thread import run_sync
from fastapi import APIRouter, File, Form, HTTPException, Request, Response, UploadFile

from rumu.database.tables import Attempt, Person, now
from rumu.studio import attempts, worker_tasks
from rumu.studio.classes import check_master
from rumu.studio.people import Identity
from rumu.studio.pictures import MAX_BYTES, check_picture
from rumu.studio.progress import progress_of
from rumu.web.addresses import client_address
from rumu.web.dependencies import Id, OptionalUser, ServiceDep
from rumu.web.routes.attempts import attempt_response
from rumu.web.routes.works import find_work
from rumu.web.schemas import Extended
from rumu.web.service import Service
from rumu.web.studio_schemas import AttemptRead

router = APIRouter(tags=["marks"])


@dataclass(frozen=True, slots=True)
class MarkRequest:
    """The fields of a request, as `add_mark` names them.

    keep_unmarked: keep it even if it is refused. framed: whether the picture is the cell that was written in.
    """

    work: str
    picture: BinaryIO
    kind: str
    grid: str
    strokes: str | None
    task: str | None
    keep: bool
    keep_unmarked: bool
    framed: bool


@router.post("/api/marks", response_model=AttemptRead, response_model_by_alias=True, status_code=201)
async def add_mark(
    *,
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    work: Annotated[Id, Form(examples=["regular-shui"])],
    picture: Annotated[UploadFile, File(description="Picture of the cell, 10 MB and 24 MP at most.")],
    kind: Annotated[Literal["pen", "photo"], Form()] = "photo",
    grid: Annotated[Literal["mi", "jiu", "tian", ""], Form()] = "",
    strokes: Annotated[str | None, Form(max_length=attempts.MAX_STROKES)] = None,
    task: Annotated[Id | None, Form()] = None,
    keep: Annotated[bool, Form()] = True,
    keep_unmarked: Annotated[bool, Form(description="Keep a copy even if it cannot be marked.")] = True,
    framed: Annotated[
        bool,
        Form(
            description="Whether the picture is the printed cell, so that size, place and lean are the "
            "writer's; what is written with the pen always is."
        ),
    ] = False,
) -> Response:
    """Mark a copy against a work. Without a login only with keep=false, and then nothing is kept."""
    if user is None and keep:
        raise HTTPException(401, "login")
    limits = service.settings.rate_limits
    if user is None:
        service.rate_limiter.hit(limits.tries, "tries", client_address(request))
    else:
        service.rate_limiter.hit(limits.marks, "marks", user.id)
    in_cell = framed or kind == "pen"
    copy = MarkRequest(work, picture.file, kind, grid, strokes, task, keep, keep_unmarked, in_cell)
    # it waits for a worker in a thread of its own, not in those that answer readers
    return await run_sync(_mark, service, user, copy, limiter=service.marking_limiter)


def _mark(service: Service, user: Identity | None, copy: MarkRequest) -> Response:
    master = find_work(service, copy.work)
    check_master(master)
    if copy.task is not None and user is not None:
        with service.gallery.database.reading() as session:
            attempts.task_for(session, copy.task, user=user, work_id=master.id)
    strokes = attempts.check_strokes(copy.strokes) if copy.strokes and copy.kind == "pen" else None
    data = copy.picture.read(MAX_BYTES + 1)
    check_picture(data)  # the worker checks too; this refuses before one is occupied
    marked = service.workers.call(
        worker_tasks.mark,
        data=data,
        work_id=master.id,
        digest=master.digest,
        script=master.script,
        framed=copy.framed,
    )
    kept = copy.keep and (copy.keep_unmarked or marked.facts["refused"] is None)
    if not kept or user is None:  # shown only: this attempt has no id and is never stored
        attempt = Attempt(kind=copy.kind, grid=copy.grid, created=now(), mark=marked.facts)
        person = None if user is None else Person(id=user.id, name=user.name)
        details = attempts.AttemptDetails(attempt, master, person, ())
        with service.gallery.database.reading() as session:
            changed = progress_of(session, attempt, person_id=user.id if user else None, work=master)
        return attempt_response(Extended(details, progress=changed), marked.residual, status=201)
    attempt = attempts.add_attempt(
        service.gallery,
        marked,
        work_id=master.id,
        person_id=user.id,
        kind=copy.kind,
        grid=copy.grid,
        strokes=strokes,
        task_id=copy.task,
    )
    with service.gallery.database.reading() as session:
        (shown,) = attempts.attempt_details(session, [attempt])
        changed = progress_of(session, attempt, person_id=user.id, work=master)
    return attempt_response(Extended(shown, progress=changed), marked.residual, status=201)
