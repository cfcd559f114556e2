"""Attempts that were kept."""

from __future__ import annotations

import hashlib
from pathlib import PurePosixPath
from typing import Any

from fastapi import APIRouter, Request, Response

from rumu.database.tables import Attempt
from rumu.gallery.derived import viewer_facts_of
from rumu.gallery.originals import picture_original
from rumu.studio import attempts
from rumu.studio.access import seen_attempt
from rumu.studio.errors import Missing
from rumu.studio.people import Identity
from rumu.studio.pictures import media_type
from rumu.web.caching import file_response, requested_etags
from rumu.web.cards import attempt_facts
from rumu.web.dependencies import CurrentUser, Limit, Offset, PathId, QueryId, ServiceDep, TeacherUser
from rumu.web.files import FileContent
from rumu.web.routes.works import Kind, viewer_shape
from rumu.web.schemas import SurfaceRead
from rumu.web.service import Service
from rumu.web.studio_schemas import AttemptPage, AttemptRead, TeacherMarkCreate, TeacherMarkRead

router = APIRouter(tags=["attempts"])


@router.get("/api/attempts", response_model=AttemptPage, response_model_by_alias=True)
def listed(
    *,
    service: ServiceDep,
    user: CurrentUser,
    work: QueryId = None,
    person: QueryId = None,
    task: QueryId = None,
    offset: Offset = 0,
    limit: Limit = 60,
) -> dict[str, Any]:
    """The newest first: a pupil's own, a teacher's pupils', to an owner all."""
    with service.gallery.database.reading() as session:
        shown, total = attempts.listed(
            session, user, work_id=work, person_id=person, task_id=task, offset=offset, limit=limit
        )
    return {"total": total, "items": [attempt_facts(one) for one in shown]}


@router.get("/api/attempts/{attempt_id}", response_model=AttemptRead, response_model_by_alias=True)
def attempt(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> dict[str, Any]:
    """One attempt, with its residual points."""
    with service.gallery.database.reading() as session:
        row = seen_attempt(session, attempt_id, who=user)
        (shown,) = attempts.shown(session, [row])
    return attempt_facts(shown, residual=attempts.residual(service.gallery.store, row))


@router.delete("/api/attempts/{attempt_id}", status_code=204)
def delete(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> None:
    """By its writer, or an owner."""
    attempts.delete(service.gallery, attempt_id, who=user)


@router.get("/api/attempts/{attempt_id}/picture", response_class=Response)
def picture(request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> Response:
    """The copy as it was kept."""
    return _own_file(request, service, _seen(service, user, attempt_id).picture)


@router.get("/api/attempts/{attempt_id}/strokes", response_class=Response)
def strokes(request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> Response:
    """The path of the pen."""
    key = _seen(service, user, attempt_id).strokes
    if key is None:
        raise Missing("這張臨作沒有筆跡記錄。", "This copy was not written with a pen here.")
    return _own_file(request, service, key)


@router.get("/api/attempts/{attempt_id}/viewer", response_model=SurfaceRead)
def viewer(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> dict[str, Any]:
    """The copy as a surface, as the viewer reads it."""
    key = _seen(service, user, attempt_id).picture
    service.files.of_picture(key, "facts")
    return viewer_shape(
        viewer_facts_of(
            service.gallery.store,
            picture_original(service.gallery.store, key),
            url=lambda kind, tag: f"/api/attempts/{attempt_id}/files/{kind}?v={tag}",
        )
    )


@router.get("/api/attempts/{attempt_id}/files/{kind}", response_class=Response)
def file(
    request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId, kind: Kind
) -> Response:
    """A map or mesh of the copy."""
    key = _seen(service, user, attempt_id).picture
    return file_response(
        request,
        service.files.of_picture(key, kind, client_etags=requested_etags(request.headers)),
        private=True,
    )


@router.put("/api/attempts/{attempt_id}/mark", response_model=TeacherMarkRead)
def mark(
    service: ServiceDep, user: TeacherUser, attempt_id: PathId, told: TeacherMarkCreate
) -> dict[str, Any]:
    """The teacher's own mark."""
    with service.gallery.database.writing() as session:
        row = attempts.mark_by_teacher(session, attempt_id, who=user, mark=told.mark, note=told.note)
    return {"teacher": user.name, "mark": row.mark, "note": row.note}


def _seen(service: Service, user: Identity, attempt_id: str) -> Attempt:
    with service.gallery.database.reading() as session:
        return seen_attempt(session, attempt_id, who=user)


def _own_file(request: Request, service: Service, key: str) -> Response:
    data = service.gallery.store.read(key)
    ending = PurePosixPath(key).suffix.removeprefix(".")
    kind = "application/json" if ending == "json" else media_type(ending)
    sent = FileContent(data, None, kind, hashlib.sha256(data).hexdigest()[:20])
    return file_response(request, sent, private=True)
