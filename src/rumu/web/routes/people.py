"""People with a login, as an owner manages them."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from rumu.studio import people
from rumu.web.cards import person_facts
from rumu.web.dependencies import OwnerUser, PathId, ServiceDep
from rumu.web.schemas import PersonRead, PersonUpdate

router = APIRouter(tags=["people"])


@router.get("/api/people", response_model=list[PersonRead])
def everybody(service: ServiceDep, user: OwnerUser) -> list[dict[str, Any]]:
    """Everybody with a login."""
    with service.gallery.database.reading() as session:
        return [person_facts(person) for person in people.everybody(session)]


@router.patch("/api/people/{person_id}", response_model=PersonRead)
def change(service: ServiceDep, user: OwnerUser, person_id: PathId, told: PersonUpdate) -> dict[str, Any]:
    """Change name, role, language or password, or put somebody out (active: false)."""
    changes = told.model_dump(exclude_none=True)
    new = changes.pop("password", None)
    with service.gallery.database.writing() as session:
        person = people.change_person(session, person_id, changes)
        if new is not None:
            people.set_password(session, person_id, new=new)
        return person_facts(person)
