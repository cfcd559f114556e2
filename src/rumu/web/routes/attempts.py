"""Routes of the attempts that were kept."""

from __future__ import annotations

import hashlib
from pathlib import PurePosixPath
from typing import Any

from fastapi import APIRouter, Request, Response

from rumu.database.tables import Attempt
from rumu.gallery.assets import picture_assets
from rumu.gallery.derived import viewer_facts_of
from rumu.studio import attempts
from rumu.studio.access import find_visible_attempt
from rumu.studio.errors import Missing
from rumu.studio.people import Identity
from rumu.studio.pictures import MEDIA_TYPES
from rumu.studio.progress import progress_of
from rumu.web.addresses import service_url
from rumu.web.dependencies import CurrentUser, Limit, Offset, PathId, QueryId, ServiceDep, TeacherUser
from rumu.web.files import FileContent
from rumu.web.responses import file_response, requested_etags
from rumu.web.routes.works import FileKind
from rumu.web.schemas import Extended, SurfaceRead
from rumu.web.service import Service
from rumu.web.studio_schemas import AttemptPage, AttemptRead, TeacherMarkCreate, TeacherMarkRead

router = APIRouter(tags=["attempts"])


@router.get("/api/attempts", response_model=AttemptPage, response_model_by_alias=True)
def list_attempts(
    *,
    service: ServiceDep,
    user: CurrentUser,
    work: QueryId = None,
    person: QueryId = None,
    task: QueryId = None,
    offset: Offset = 0,
    limit: Limit = 60,
) -> dict[str, Any]:
    """The newest first: a pupil's own; for a teacher their pupils'; for an owner all."""
    with service.gallery.database.reading() as session:
        items, total = attempts.list_attempts(
            session, user, work_id=work, person_id=person, task_id=task, offset=offset, limit=limit
        )
    return {"total": total, "items": items}


@router.get("/api/attempts/{attempt_id}", response_model=AttemptRead, response_model_by_alias=True)
def get_attempt(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> Response:
    """One attempt, with its residual points and what changed against the attempt before."""
    with service.gallery.database.reading() as session:
        row = find_visible_attempt(session, attempt_id, user=user)
        (shown,) = attempts.attempt_details(session, [row])
        changed = progress_of(session, row, person_id=row.person_id, work=shown.work)
    residual = attempts.read_residual(service.gallery.store, row)
    return attempt_response(Extended(shown, progress=changed), residual)


def attempt_response(shown: Extended, residual: bytes | None, *, status: int = 200) -> Response:
    """An attempt with its residual points, which are encoded already.

    To decode, check and encode thousands of numbers anew would hold up the answers to everybody else.
    """
    body = AttemptRead.model_validate(shown).model_dump_json(by_alias=True).encode()
    if residual is not None:  # in a text the quotes would be escaped
        body = body.replace(b'"residual":null', b'"residual":' + residual)
    return Response(body, status, media_type="application/json")


@router.delete("/api/attempts/{attempt_id}", status_code=204)
def delete_attempt(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> None:
    """Delete an attempt; its writer may, and an owner."""
    attempts.delete(service.gallery, attempt_id, user=user)


@router.get("/api/attempts/{attempt_id}/picture", response_class=Response)
def get_picture(request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> Response:
    """The copy as it was kept."""
    return _stored_file(request, service, _find_attempt(service, user, attempt_id).picture)


@router.get("/api/attempts/{attempt_id}/strokes", response_class=Response)
def get_strokes(request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> Response:
    """The path of the pen."""
    key = _find_attempt(service, user, attempt_id).strokes
    if key is None:
        raise Missing(zh="這張臨作沒有筆跡記錄。", en="This copy was not written with a pen here.")
    return _stored_file(request, service, key)


@router.get("/api/attempts/{attempt_id}/viewer", response_model=SurfaceRead)
def get_surface(service: ServiceDep, user: CurrentUser, attempt_id: PathId) -> dict[str, Any]:
    """The copy as a surface, as the viewer reads it."""
    key = _find_attempt(service, user, attempt_id).picture
    service.files.get(key, "facts")
    return viewer_facts_of(
        service.gallery.store,
        picture_assets(service.gallery.store, key),
        url=lambda kind, tag: service_url(f"/api/attempts/{attempt_id}/files/{kind}?v={tag}"),
    )


@router.get("/api/attempts/{attempt_id}/files/{kind}", response_class=Response)
def get_file(
    request: Request, service: ServiceDep, user: CurrentUser, attempt_id: PathId, kind: FileKind
) -> Response:
    """A map or mesh of the copy."""
    key = _find_attempt(service, user, attempt_id).picture
    content = service.files.get(key, kind, client_etags=requested_etags(request.headers))
    return file_response(request, content, private=True)


@router.put("/api/attempts/{attempt_id}/mark", response_model=TeacherMarkRead)
def set_teacher_mark(
    service: ServiceDep, user: TeacherUser, attempt_id: PathId, mark: TeacherMarkCreate
) -> Extended:
    """The teacher's own mark."""
    with service.gallery.database.writing() as session:
        row = attempts.set_teacher_mark(session, attempt_id, user=user, mark=mark.mark, note=mark.note)
    return Extended(row, teacher=user.name)


def _find_attempt(service: Service, user: Identity, attempt_id: str) -> Attempt:
    with service.gallery.database.reading() as session:
        return find_visible_attempt(session, attempt_id, user=user)


def _stored_file(request: Request, service: Service, key: str) -> Response:
    data = service.gallery.store.read(key)
    ending = PurePosixPath(key).suffix.removeprefix(".")
    kind = "application/json" if ending == "json" else MEDIA_TYPES[ending]
    content = FileContent(data, None, kind, hashlib.sha256(data).hexdigest()[:20])
    return file_response(request, content, private=True)
