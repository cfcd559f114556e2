"""What is said of points of a work."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from rumu.database.tables import Annotation
from rumu.gallery import annotations as said
from rumu.studio.errors import Missing
from rumu.web.cards import annotation_facts
from rumu.web.dependencies import OwnerUser, PathId, ServiceDep
from rumu.web.routes.works import columns, found_work
from rumu.web.schemas import AnnotationCreate, AnnotationRead, AnnotationUpdate
from rumu.web.service import Service

router = APIRouter(tags=["annotations"])


@router.get("/api/works/{work_id}/annotations", response_model=list[AnnotationRead])
def listed(service: ServiceDep, work_id: PathId) -> list[dict[str, Any]]:
    """In order."""
    found_work(service, work_id)
    return [annotation_facts(row) for row in said.said_of(service.gallery, work_id)]


@router.post("/api/works/{work_id}/annotations", response_model=AnnotationRead, status_code=201)
def add(service: ServiceDep, user: OwnerUser, work_id: PathId, told: AnnotationCreate) -> dict[str, Any]:
    """Say something of a point."""
    found_work(service, work_id)
    facts = columns(told.model_dump())
    return annotation_facts(said.add_annotation(service.gallery, work_id, facts, author=user.id))


@router.patch("/api/works/{work_id}/annotations/{annotation_id}", response_model=AnnotationRead)
def change(
    service: ServiceDep, user: OwnerUser, work_id: PathId, annotation_id: PathId, told: AnnotationUpdate
) -> dict[str, Any]:
    """Change it."""
    _found(service, work_id, annotation_id)
    facts = columns(told.model_dump())
    row = said.change_annotation(service.gallery, annotation_id, facts, of=work_id)
    return annotation_facts(row)


@router.delete("/api/works/{work_id}/annotations/{annotation_id}", status_code=204)
def delete(service: ServiceDep, user: OwnerUser, work_id: PathId, annotation_id: PathId) -> None:
    """Take it back."""
    _found(service, work_id, annotation_id)
    said.delete_annotation(service.gallery, annotation_id, of=work_id)


def _found(service: Service, work_id: str, annotation_id: str) -> None:
    with service.gallery.database.reading() as session:
        row = session.get(Annotation, annotation_id)
    if row is None or row.work_id != work_id:
        raise Missing("沒有這條註解。", "There is no such annotation.")
