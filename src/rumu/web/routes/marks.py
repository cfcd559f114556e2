"""A copy comes in, a mark goes out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, BinaryIO, Literal

from anyio.to_thread import run_sync
from fastapi import APIRouter, File, Form, Request, UploadFile

from rumu.database.tables import Attempt, Work, now
from rumu.studio import attempts, worker
from rumu.studio.people import Identity
from rumu.studio.pictures import MOST_BYTES, looked_at
from rumu.studio.worker import Marked
from rumu.web.cards import attempt_facts, work_card
from rumu.web.dependencies import Id, OptionalUser, ServiceDep
from rumu.web.error_handlers import LoginNeededError
from rumu.web.routes.works import found_work
from rumu.web.security import client_address
from rumu.web.service import Service
from rumu.web.studio_schemas import AttemptRead

router = APIRouter(tags=["marks"])


@router.post("/api/marks", response_model=AttemptRead, response_model_by_alias=True, status_code=201)
async def mark(
    *,
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    work: Annotated[Id, Form(examples=["regular-shui"])],
    picture: Annotated[UploadFile, File(description="PNG or JPEG of the cell, 10 MB and 24 MP at most.")],
    kind: Annotated[Literal["pen", "photo"], Form()] = "photo",
    grid: Annotated[Literal["mi", "jiu", "tian", ""], Form()] = "",
    strokes: Annotated[str | None, Form(max_length=attempts.MOST_STROKES)] = None,
    task: Annotated[Id | None, Form()] = None,
    keep: Annotated[bool, Form()] = True,
) -> dict[str, Any]:
    """Mark a copy against a work. Without a login only with keep=false, and then nothing is kept."""
    if user is None and keep:
        raise LoginNeededError
    rates = service.settings.rate_limits
    service.rate_limiter.hit(
        *((rates.marks, "marks", user.id) if user else (rates.tries, "tries", client_address(request)))
    )
    sent = MarkRequest(work, picture.file, kind, grid, strokes, task, keep)
    return await run_sync(_answer, service, user, sent, limiter=service.marking_limiter)


@dataclass(frozen=True, slots=True)
class MarkRequest:
    """What came in, as `mark` names it."""

    work: str
    picture: BinaryIO
    kind: str
    grid: str
    strokes: str | None
    task: str | None
    keep: bool


def _answer(service: Service, user: Identity | None, sent: MarkRequest) -> dict[str, Any]:
    """Waits for a process in a thread beside those that answer readers."""
    master = found_work(service, sent.work)
    if sent.task is not None and user is not None:
        with service.gallery.database.reading() as session:
            attempts.task_for(session, sent.task, who=user, work_id=master.id)
    path = attempts.checked_strokes(sent.strokes) if sent.strokes and sent.kind == "pen" else None
    data = sent.picture.read(MOST_BYTES + 1)
    looked_at(data)
    marked = service.workers.ask(
        worker.mark, data=data, work_id=master.id, digest=master.digest, script=master.script
    )
    if not sent.keep or user is None:
        return _tried(marked, master, user, sent.kind, sent.grid)
    kept = attempts.keep(
        service.gallery,
        marked,
        work_id=master.id,
        person_id=user.id,
        kind=sent.kind,
        grid=sent.grid,
        strokes=path,
        task_id=sent.task,
    )
    return _told(service, kept, marked)


def _told(service: Service, kept: Attempt, marked: Marked) -> dict[str, Any]:
    with service.gallery.database.reading() as session:
        (shown,) = attempts.shown(session, [kept])
    return attempt_facts(shown, residual=marked.residual)


def _tried(marked: Marked, master: Work, user: Identity | None, kind: str, grid: str) -> dict[str, Any]:
    """As an attempt that was kept, but for what only such a one has."""
    return {
        "id": None,
        "work": work_card(master),
        "person": user and {"id": user.id, "name": user.name},
        "kind": kind,
        "grid": grid,
        "created": now(),
        "task": None,
        "picture": None,
        "strokes": None,
        "mark": marked.facts | {"residual": marked.residual},
        "teacher_marks": [],
        "simulated": False,
    }
