"""Guided walks through the gallery."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from rumu.database.tables import Tour
from rumu.errors import GalleryError
from rumu.gallery import tours
from rumu.studio.errors import Missing
from rumu.web.cards import tour_facts
from rumu.web.dependencies import OwnerUser, PathId, ServiceDep
from rumu.web.routes.works import columns
from rumu.web.schemas import TourCreate, TourRead, TourUpdate
from rumu.web.service import Service

router = APIRouter(tags=["tours"])


@router.get("/api/tours", response_model=list[TourRead])
def listed(service: ServiceDep) -> list[dict[str, Any]]:
    """In order."""
    return [tour_facts(row) for row in tours.tours(service.gallery)]


@router.get("/api/tours/{tour_id}", response_model=TourRead)
def tour(service: ServiceDep, tour_id: PathId) -> dict[str, Any]:
    """One tour."""
    return tour_facts(_found(service, tour_id))


@router.post("/api/tours", response_model=TourRead, status_code=201)
def add(service: ServiceDep, user: OwnerUser, told: TourCreate) -> dict[str, Any]:
    """Make a tour."""
    return tour_facts(tours.add_tour(service.gallery, _facts(told), author=user.id))


@router.patch("/api/tours/{tour_id}", response_model=TourRead)
def change(service: ServiceDep, user: OwnerUser, tour_id: PathId, told: TourUpdate) -> dict[str, Any]:
    """Change it."""
    _found(service, tour_id)
    return tour_facts(tours.change_tour(service.gallery, tour_id, _facts(told)))


@router.delete("/api/tours/{tour_id}", status_code=204)
def delete(service: ServiceDep, user: OwnerUser, tour_id: PathId) -> None:
    """Forget it."""
    _found(service, tour_id)
    tours.delete_tour(service.gallery, tour_id)


def _found(service: Service, tour_id: str) -> Tour:
    try:
        return tours.tour(service.gallery, tour_id)
    except GalleryError as error:
        raise Missing("沒有這條導覽。", "There is no such tour.") from error


def _facts(told: TourCreate | TourUpdate) -> dict[str, Any]:
    held = told.model_dump()
    steps = held.pop("steps")
    return columns(held) | ({} if steps is None else {"steps": [columns(step) for step in steps]})
